/* SPDX-License-Identifier: Apache-2.0
 *
 * A streaming JSON writer: objects and arrays are opened and closed in order, nothing is held in memory. Numbers are the
 * same in every locale and read back to the same double; what is not finite becomes null. Text is written as UTF-8,
 * bytes that are not UTF-8 (file names) as U+FFFD. Inside an object every value has a key; elsewhere key is NULL. */
#ifndef NPH_CORE_JSON_H
#define NPH_CORE_JSON_H

#include <stddef.h>
#include <stdint.h>

/* Receives the next piece of text, not terminated. */
typedef void (*NphTextFn)(void *user, const char *text, size_t length);

enum { NPH_JSON_DEPTH = 32 };

typedef struct NphJson {
    NphTextFn write;
    void *user;
    int depth, after_first; /* after_first: the open container holds a value already */
    int line;               /* all on one line, which is not ended: a value for nph_json_copy */
    struct {
        char close;  /* ] or } */
        int spread;  /* its last element began a line of its own, so does its closing bracket */
    } open[NPH_JSON_DEPTH];
} NphJson;

void nph_json_begin(NphJson *json, NphTextFn write, void *user);
/* The same on one line without its end. */
void nph_json_begin_line(NphJson *json, NphTextFn write, void *user);
/* NphTextFn with a FILE * as user; errors stay in the FILE for ferror. */
void nph_json_to_file(void *file, const char *text, size_t length);

void nph_json_object(NphJson *json, const char *key);
void nph_json_array(NphJson *json, const char *key);
/* Closes the container opened last; after the outermost one comes a newline. */
void nph_json_close(NphJson *json);

void nph_json_text(NphJson *json, const char *key, const char *value); /* NULL becomes null */
void nph_json_number(NphJson *json, const char *key, double value);
void nph_json_integer(NphJson *json, const char *key, int64_t value);
void nph_json_boolean(NphJson *json, const char *key, int value);
/* A value of that many bytes that was written by nph_json_begin_line; in an array it takes a line of its own. */
void nph_json_copy(NphJson *json, const char *key, const char *value, size_t length);
/* An array of numbers. */
void nph_json_numbers(NphJson *json, const char *key, int count, const double *values);

#endif
