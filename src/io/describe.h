/* SPDX-License-Identifier: Apache-2.0
 *
 * What a file is, told from its first bytes, never from its name. */
#ifndef NPH_IO_DESCRIBE_H
#define NPH_IO_DESCRIBE_H

#include <stddef.h>

#include "nephos/context.h"

/* The first eight bytes of a part file (nephos/film.h). */
#define NPH_PART_MAGIC "NPHPART1"

typedef enum NphFileKind {
    NPH_FILE_UNKNOWN,
    NPH_FILE_EMPTY,
    NPH_FILE_EXR,
    NPH_FILE_PNG,
    NPH_FILE_NVDB,
    NPH_FILE_VDB,
    NPH_FILE_NPY,
    NPH_FILE_VOL,   /* Mitsuba grid volume */
    NPH_FILE_PBRT,  /* text: a directive of pbrt comes first */
    NPH_FILE_LES,   /* text: comments, then a line of three sizes */
    NPH_FILE_PHASE, /* text: comments, then a line of two numbers */
    NPH_FILE_SCENE, /* text: YAML or JSON whose first item is a mapping */
    NPH_FILE_PART,
    NPH_FILE_HDR,   /* Radiance picture and portable float map: not read, named so that messages can */
    NPH_FILE_PFM,
    NPH_FILE_KINDS
} NphFileKind;

enum { NPH_FILE_KIND_BYTES = 4096 }; /* bytes that are looked at */

/* From the first bytes of a file (fewer or more than NPH_FILE_KIND_BYTES). */
NphFileKind nph_file_kind_of_bytes(const void *bytes, size_t size);

/* Reads no more than the first bytes. NPH_BAD_INPUT with path and reason for what is not a readable regular file; what
 * is readable but not known is NPH_FILE_UNKNOWN. */
NphStatus nph_file_kind(NphContext *context, const char *path, NphFileKind *kind);

/* For messages: "an OpenEXR image", "an unknown kind of file". */
const char *nph_file_kind_name(NphFileKind kind);

#endif
