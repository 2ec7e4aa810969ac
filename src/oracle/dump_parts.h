/* SPDX-License-Identifier: Apache-2.0
 *
 * The parts of a dump: the tap that writes what launches leave behind (dump_launch.c), the manifest (dump_manifest.c), and the run
 * with its limits (dump.c). Each worker writes the files of its batches, and keeps a line of the manifest for every launch; for
 * the batch under way it knows which file holds a buffer's present contents, so that the inputs of a launch are the files of
 * earlier ones. */
#ifndef NPH_ORACLE_DUMP_PARTS_H
#define NPH_ORACLE_DUMP_PARTS_H

#include <pthread.h>

#include "core/json.h"
#include "io/file.h"
#include "method/job.h"
#include "oracle/digest.h"
#include "oracle/stages.h"

enum { NPH_DUMP_NAME = 96, NPH_DUMP_PATH = 4096 };

/* An array in a file. */
typedef struct NphDumpArray {
    int rank;
    NphType type;
    int64_t shape[NPH_MAX_RANK];
    char file[NPH_DUMP_NAME], digest[NPH_DIGEST_TEXT]; /* file[0] 0: there is none */
} NphDumpArray;

typedef struct NphDumpRecord {
    int64_t batch, number;
    const char *line; /* of the manifest; in a block of its worker */
    size_t length;
} NphDumpRecord;

typedef struct NphDumpBlock {
    struct NphDumpBlock *before;
    char text[];
} NphDumpBlock;

typedef struct NphDumpWorker {
    NphContext *context;
    NphDumpRecord *records;
    size_t record_room, record_count;
    NphDumpBlock *block; /* holds the line under way */
    size_t block_room, block_used;
    NphStatus text_status; /* NPH_NO_MEMORY: no room for more text */
    NphJson json;          /* the line under way */
    NphDumpArray now[NPH_MAX_BUFFERS]; /* what holds each buffer */
    int is_open;
    int64_t batch, bytes;  /* of the file under way */
    char path[NPH_DUMP_PATH];
    NphAppender file;
} NphDumpWorker;

typedef struct NphDump {
    NphContext *context;
    const NphMethod *method;
    const NphDumpOptions *options;
    int stage, write; /* write: 0 only counts */
    int one_batch;    /* the run ends after batch 0 */
    int64_t tile;     /* of options.pixel */
    int worker_count;
    NphDigestFn digest;
    unsigned char reads[NPH_MAX_STAGES][NPH_MAX_BUFFERS], writes[NPH_MAX_STAGES][NPH_MAX_BUFFERS];
    pthread_mutex_t lock;
    uint64_t bytes;   /* of all workers, under the lock */
    uint64_t once;    /* of them, what is written once: NPH_BATCH_OF_SCENE */
    NphDumpWorker *workers;
} NphDump;

/* The tap: user is the NphDump. */
NphStatus nph_dump_before(void *user, void *state, int worker, const NphLaunch *launch);
NphStatus nph_dump_after(void *user, void *state, int worker, const NphLaunch *launch);
/* Of what is under way. */
NphStatus nph_dump_close_files(NphDump *dump);
void nph_dump_free_workers(NphDump *dump);

/* Joined and in order: the same for any number of threads. */
NphStatus nph_dump_write_manifest(const NphDump *dump, const NphJob *job, const char *scene_name);

#endif
