/* SPDX-License-Identifier: Apache-2.0
 *
 * Command lines from a table: each command lists its options once, and parsing, help text and "did you mean" come from
 * that list. `--name value`, `--name=value`, `-o value`, `-ovalue`; `--` ends the options. */
#ifndef NPH_CLI_OPTIONS_H
#define NPH_CLI_OPTIONS_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "nephos/status.h"

typedef enum OptionKind {
    OPTION_FLAG,     /* int *: becomes 1 */
    OPTION_TEXT,     /* const char ** */
    OPTION_SUFFIXED, /* const char **: the value may be left out (then ""); as a word of its own it must end in `suffix` */
    OPTION_INT,      /* int64_t * within [min, max] */
    OPTION_NUMBER,   /* double * within [min, max] */
    OPTION_BYTES,    /* uint64_t *: 2G, 512M, 100k or plain bytes */
    OPTION_INTS,     /* int64_t[count], separated by `separator` */
    OPTION_LIST      /* TextList *: may be given several times */
} OptionKind;

enum { MAX_LIST = 64, MAX_OPTIONS = 40 };

typedef struct TextList {
    int count;
    const char *items[MAX_LIST];
} TextList;

typedef struct Option {
    const char *name;       /* without dashes */
    char letter;            /* short form or 0 */
    OptionKind kind;
    void *target;
    const char *value_name; /* "FILE"; NULL for flags */
    const char *meaning;
    double min, max;        /* INT, NUMBER */
    int count;              /* INTS */
    char separator;         /* INTS */
    const char *suffix;     /* SUFFIXED */
    int *given;             /* may be NULL; becomes 1 */
} Option;

typedef struct OptionTable {
    int count;
    Option options[MAX_OPTIONS];
} OptionTable;

void option_add(OptionTable *table, Option option);

/* Reads argv[1 .. argc-1]; what is no option goes to files. NPH_BAD_USAGE after a message on stderr. */
NphStatus options_parse(const OptionTable *table, const char *command, int argc, char **argv, TextList *files);

/* "  -o, --output FILE   meaning" for each option, meanings wrapped. */
void options_print(const OptionTable *table, FILE *out);

/* The word of `words` closest to `word`, or NULL when none is close. */
const char *closest_word(const char *word, const char *const *words, int count);

/* Prints "nephos COMMAND: message" and the way to help; returns NPH_BAD_USAGE. */
NphStatus usage_error(const char *command, const char *format, ...);

#endif
