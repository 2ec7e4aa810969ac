/* SPDX-License-Identifier: Apache-2.0
 *
 * The header of a PLY file as a table: elements, and their properties in the order in which records hold them. */
#ifndef NPH_IO_PLY_HEADER_H
#define NPH_IO_PLY_HEADER_H

#include "core/message.h"
#include "nephos/array.h"

enum { NPH_PLY_NAME = 32, NPH_PLY_ELEMENTS = 16, NPH_PLY_PROPERTIES = 128 };

typedef enum NphPlyFormat { NPH_PLY_ASCII, NPH_PLY_LITTLE, NPH_PLY_BIG } NphPlyFormat;

typedef struct NphPlyProperty {
    char name[NPH_PLY_NAME];
    int is_list;
    NphType type, count_type; /* of a value, and of a list's length */
} NphPlyProperty;

typedef struct NphPlyElement {
    char name[NPH_PLY_NAME];
    int64_t count;
    int first, properties; /* in NphPlyFile.properties */
} NphPlyElement;

typedef struct NphPlyFile {
    NphContext *context;
    const char *path, *bytes, *at, *end; /* at: what is read next */
    long long line;                      /* of the header or of ascii; 0 in binary, where messages name the byte */
    NphPlyFormat format;
    int element_count, property_count;
    NphPlyElement elements[NPH_PLY_ELEMENTS];
    NphPlyProperty properties[NPH_PLY_PROPERTIES];
} NphPlyFile;

/* Reads the header; file->at is left at the first record. */
NphStatus nph_ply_header(NphPlyFile *file);

/* Reports NPH_BAD_INPUT at the current line or byte. */
NphStatus nph_ply_refuse(const NphPlyFile *file, const char *format, ...) NPH_PRINTF(2, 3);

/* The next word of the current line; 0 when the line has none left. Does not leave the line. */
int nph_ply_word(NphPlyFile *file, const char **begin, const char **end);

/* Leaves the current line, of which nothing but blanks may be left: 1, else 0. */
int nph_ply_line_ends(NphPlyFile *file);

#endif
