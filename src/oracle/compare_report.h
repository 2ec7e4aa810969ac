/* SPDX-License-Identifier: Apache-2.0
 *
 * A comparison as lines for people, as JSON for programs and as JUnit XML for build servers; what
 * `nephos compare` prints and writes. */
#ifndef NPH_ORACLE_COMPARE_REPORT_H
#define NPH_ORACLE_COMPARE_REPORT_H

#include "core/json.h"
#include "nephos/compare.h"
#include "nephos/flip.h"

/* What is reported. */
typedef struct NphReport {
    const NphComparison *comparison;
    const NphFlip *flip; /* NULL: not asked for */
} NphReport;

/* One line without its newline, valid during the call. */
typedef void (*NphLineFn)(void *user, const char *line);

/* About a dozen lines, the verdict first. */
void nph_comparison_text(NphReport report, NphLineFn line, void *user);

/* One object (key NULL at the top or in an array) with the fields of NphComparison under their names; differences are
 * fractions, not percent; a histogram that was not tested has p null and says why. FLIP is an object of its own. */
void nph_comparison_json(NphReport report, NphJson *json, const char *key);

enum { NPH_LEVEL_WORDS = 320 };
/* "1 of 1 regions different, 0 shown same, largest |z| 6.9: G at (16, 0), ..."; returns text. */
const char *nph_level_words(const NphCompareLevel *level, char text[NPH_LEVEL_WORDS]);

/* A test suite named `suite`: a case for the verdict and one for each level, a failure where it is not `same`; FLIP as
 * properties; the text as its output. Bytes that XML cannot hold become U+FFFD. */
void nph_comparison_junit(NphReport report, const char *suite, NphTextFn write, void *user);

#endif
