/* SPDX-License-Identifier: Apache-2.0
 *
 * See facts.h. */
#include "cli/facts.h"

#include <stdlib.h>
#include <string.h>

#include "core/text.h"

enum { DIGITS = 7, COLUMN = 30 };

NphStatus facts_begin(Facts *facts, int as_json) {
    memset(facts, 0, sizeof *facts);
    facts->as_json = as_json;
    facts->out = open_memstream(&facts->bytes, &facts->size);
    if (!facts->out) return NPH_NO_MEMORY;
    nph_json_begin(&facts->json, nph_json_to_file, facts->out);
    if (as_json) nph_json_object(&facts->json, NULL);
    return NPH_OK;
}

NphStatus facts_finish(Facts *facts, NphStatus status) {
    if (facts->as_json && status == NPH_OK) nph_json_close(&facts->json);
    if (fclose(facts->out) != 0 && status == NPH_OK) status = NPH_NO_MEMORY;
    if (status == NPH_OK) fwrite(facts->bytes, 1, facts->size, stdout);
    free(facts->bytes);
    return status;
}

/* Before a value: its name, in a row behind the last value, else on a line of its own. */
static void lead(Facts *facts, const char *key) {
    int indent = 2 * facts->depth, width = COLUMN - indent > 0 ? COLUMN - indent : 0;
    if (facts->in_row) fprintf(facts->out, "%s%s ", facts->in_row++ > 1 ? "  " : "", key);
    else fprintf(facts->out, "%*s%-*s ", indent, "", width, key);
}

static void trail(const Facts *facts) {
    if (!facts->in_row) fputc('\n', facts->out);
}

static void heading(Facts *facts, const char *key) {
    fprintf(facts->out, "%*s%s:\n", 2 * facts->depth, "", key);
    facts->depth++;
}

void facts_group(Facts *facts, const char *key) {
    if (facts->as_json) nph_json_object(&facts->json, key);
    else heading(facts, key);
}

void facts_list(Facts *facts, const char *key) {
    if (facts->as_json) nph_json_array(&facts->json, key);
    else heading(facts, key);
}

void facts_item(Facts *facts, const char *name) {
    if (facts->as_json) {
        nph_json_object(&facts->json, NULL);
        nph_json_text(&facts->json, "name", name);
    } else {
        heading(facts, name);
    }
}

void facts_row(Facts *facts) {
    if (facts->as_json) nph_json_object(&facts->json, NULL);
    else fprintf(facts->out, "%*s", 2 * facts->depth, "");
    facts->in_row = 1;
}

void facts_end(Facts *facts) {
    if (facts->as_json) nph_json_close(&facts->json);
    else if (facts->in_row) fputc('\n', facts->out);
    else facts->depth--;
    facts->in_row = 0;
}

void facts_text(Facts *facts, const char *key, const char *value) {
    if (facts->as_json) {
        nph_json_text(&facts->json, key, value);
        return;
    }
    lead(facts, key);
    fprintf(facts->out, "%s", value);
    trail(facts);
}

void facts_number(Facts *facts, const char *key, double value) {
    char text[NPH_DOUBLE_TEXT];
    if (facts->as_json) nph_json_number(&facts->json, key, value);
    else facts_text(facts, key, nph_format_rounded(value, DIGITS, text));
}

void facts_integer(Facts *facts, const char *key, int64_t value) {
    char text[NPH_DOUBLE_TEXT];
    snprintf(text, sizeof text, "%lld", (long long)value);
    if (facts->as_json) nph_json_integer(&facts->json, key, value);
    else facts_text(facts, key, text);
}

void facts_numbers(Facts *facts, const char *key, int count, const double *values) {
    if (facts->as_json) {
        nph_json_numbers(&facts->json, key, count, values);
        return;
    }
    char text[NPH_DOUBLE_TEXT];
    lead(facts, key);
    for (int i = 0; i < count; i++) fprintf(facts->out, "%s%s", i ? ", " : "(", nph_format_rounded(values[i], DIGITS, text));
    fputc(')', facts->out);
    trail(facts);
}

void facts_integers(Facts *facts, const char *key, int count, const int32_t *values) {
    double wide[16];
    if (count > 16) count = 16;
    for (int i = 0; i < count; i++) wide[i] = values[i];
    facts_numbers(facts, key, count, wide);
}
