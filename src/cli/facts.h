/* SPDX-License-Identifier: Apache-2.0
 *
 * Named values, told either as JSON or as indented text: what a file holds is gathered once for both. In text a row
 * stands on one line. Nothing is printed before the end, so that a file which turns
 * out to be damaged leaves a message and no half truth. */
#ifndef NPH_CLI_FACTS_H
#define NPH_CLI_FACTS_H

#include <stdio.h>

#include "core/json.h"
#include "nephos/status.h"

typedef struct Facts {
    NphJson json;
    int as_json, depth, in_row;
    FILE *out; /* memory until the end */
    char *bytes;
    size_t size;
} Facts;

NphStatus facts_begin(Facts *facts, int as_json); /* NPH_NO_MEMORY, nothing to finish then */
/* Prints to standard output what was gathered when the status is NPH_OK; returns the status. */
NphStatus facts_finish(Facts *facts, NphStatus status);

void facts_group(Facts *facts, const char *key);
void facts_list(Facts *facts, const char *key);
void facts_item(Facts *facts, const char *name); /* an element of a list, with a heading; ended by facts_end too */
void facts_row(Facts *facts);                    /* an element of a list on one line; likewise */
void facts_end(Facts *facts);

void facts_text(Facts *facts, const char *key, const char *value);
void facts_number(Facts *facts, const char *key, double value);
void facts_integer(Facts *facts, const char *key, int64_t value);
void facts_numbers(Facts *facts, const char *key, int count, const double *values);
void facts_integers(Facts *facts, const char *key, int count, const int32_t *values);

#endif
