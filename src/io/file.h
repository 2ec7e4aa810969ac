/* SPDX-License-Identifier: Apache-2.0
 *
 * Whole files: reading with a size check, and writing through a temporary name in the same folder that is synced and
 * renamed, so that a reader never sees half a file and a full disk leaves the old one. And many small pieces at the end of an
 * open file. */
#ifndef NPH_IO_FILE_H
#define NPH_IO_FILE_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "nephos/context.h"

/* Reads a regular file whole; *bytes is NUL-terminated beyond *size, freed with nph_free. NPH_BAD_INPUT with the path
 * and the system's reason. */
NphStatus nph_file_read(NphContext *context, const char *path, char **bytes, size_t *size);

/* The same for what begins at `offset`, at most `most` bytes of it. */
NphStatus nph_file_read_stretch(NphContext *context, const char *path, int64_t offset, size_t most, char **bytes, size_t *size);

/* The first bytes alone, at most `room`; the same refusals. */
NphStatus nph_file_read_start(NphContext *context, const char *path, char *bytes, size_t room, size_t *size);

typedef struct NphWriter {
    char *path, *temporary;
    FILE *stream;
} NphWriter;

/* Opens PATH.XXXXXX.tmp beside the target. */
NphStatus nph_writer_open(NphContext *context, const char *path, NphWriter *writer);
/* Flushes, syncs, renames; on any failure the temporary is removed and NPH_BAD_OUTPUT reported. */
NphStatus nph_writer_commit(NphContext *context, NphWriter *writer);
/* The same without syncing, beside files that are not synced either: a power cut may tear it. */
NphStatus nph_writer_commit_unsynced(NphContext *context, NphWriter *writer);
/* Removes the temporary; safe after commit. */
void nph_writer_abandon(NphContext *context, NphWriter *writer);

/* Gathers what is appended to a file into large writes: the system's work for a write hardly depends on its size. */
typedef struct NphAppender {
    int file;         /* open, the caller's */
    const char *path; /* for messages */
    char *block;
    size_t used;
} NphAppender;

NphStatus nph_appender_open(NphContext *context, int file, const char *path, NphAppender *appender);
/* NPH_BAD_OUTPUT with the path and the system's reason, of these bytes or of earlier ones. */
NphStatus nph_appender_add(NphContext *context, NphAppender *appender, const void *bytes, size_t count);
/* Hands the file what is left. */
NphStatus nph_appender_flush(NphContext *context, NphAppender *appender);
/* Forgets what has not been flushed. */
void nph_appender_close(NphContext *context, NphAppender *appender);

#endif
