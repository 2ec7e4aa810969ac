/* SPDX-License-Identifier: Apache-2.0
 *
 * A comparison as lines for people and as JSON for programs; what `nephos compare` prints. */
#ifndef NPH_ORACLE_COMPARE_REPORT_H
#define NPH_ORACLE_COMPARE_REPORT_H

#include "core/json.h"
#include "nephos/compare.h"

/* One line without its newline, valid during the call. */
typedef void (*NphLineFn)(void *user, const char *line);

/* About a dozen lines, the verdict first. */
void nph_comparison_text(const NphComparison *comparison, NphLineFn line, void *user);

/* One object (key NULL at the top or in an array) with the fields of NphComparison under their names; differences are
 * fractions, not percent; a histogram that was not tested has p null and says why. */
void nph_comparison_json(const NphComparison *comparison, NphJson *json, const char *key);

#endif
