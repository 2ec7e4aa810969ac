/* SPDX-License-Identifier: Apache-2.0
 *
 * Writing a plan line by line. */
#ifndef NPH_PIPELINE_PLAN_H
#define NPH_PIPELINE_PLAN_H

#include "core/message.h"
#include "nephos/render.h"

/* Appends a line; bytes are added to the plan's total. kind: stage, buffer, left out, modelled, warning, memory. */
NphStatus nph_plan_add(NphContext *context, NphPlan *plan, const char *kind, const char *name, uint64_t bytes,
                       const char *format, ...) NPH_PRINTF(6, 7);

#endif
