/* SPDX-License-Identifier: Apache-2.0
 *
 * What the commands share: the options for threads and memory, one context with its messages and progress on stderr, and
 * the signals. The first SIGINT or SIGTERM asks the running task to stop between blocks; a second one kills. */
#ifndef NPH_CLI_SESSION_H
#define NPH_CLI_SESSION_H

#include "cli/options.h"
#include "cli/progress.h"

typedef struct Session {
    int64_t threads;             /* 0: all usable */
    uint64_t memory_limit_bytes; /* 0: none */
    int quiet;
    int mute;                    /* set by the command: messages of the library are not told */
    NphContext *context;
    Progress progress;
} Session;

/* --threads, --memory-limit, --quiet. */
void session_add_options(OptionTable *table, Session *session);

/* Refuses a NEPHOS_ISA that is no level. After NPH_OK session_close is owed. */
NphStatus session_open(Session *session, const char *command);

/* Closes and returns the status, NPH_INTERRUPTED's signal having been told. */
NphStatus session_close(Session *session, NphStatus status);

/* Can a file of that name be made? Checked before hours of work: NPH_BAD_OUTPUT and a message. */
NphStatus check_writable(Session *session, const char *path);

#endif
