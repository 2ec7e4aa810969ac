/* SPDX-License-Identifier: Apache-2.0
 *
 * Plans are lists of lines; what they say is decided by the methods. */
#include "pipeline/plan.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "core/memory.h"

NphStatus nph_plan_add(NphContext *context, NphPlan *plan, const char *kind, const char *name, uint64_t bytes,
                       const char *format, ...) {
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    void *lines = plan->lines;
    NPH_TRY(nph_realloc(context, (size_t)plan->line_count + 1, sizeof *plan->lines, "plan", &lines));
    plan->lines = lines;
    NphPlanLine *line = &plan->lines[plan->line_count];
    snprintf(line->kind, sizeof line->kind, "%s", kind);
    line->bytes = bytes;
    NPH_TRY(nph_strdup(context, name, &line->name));
    NphStatus status = nph_strdup(context, text, &line->text);
    if (status != NPH_OK) {
        nph_free(context, line->name);
        return status;
    }
    plan->line_count++;
    plan->bytes += bytes;
    return NPH_OK;
}

void nph_plan_free(NphContext *context, NphPlan *plan) {
    for (int i = 0; i < plan->line_count; i++) {
        nph_free(context, plan->lines[i].name);
        nph_free(context, plan->lines[i].text);
    }
    nph_free(context, plan->lines);
    memset(plan, 0, sizeof *plan);
}
