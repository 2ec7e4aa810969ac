/* SPDX-License-Identifier: Apache-2.0
 *
 * What a run took, as JSON: --stats FILE.json and --json. Times, threads and host belong here, never into pictures. */
#ifndef NPH_CLI_STATS_H
#define NPH_CLI_STATS_H

#include "cli/session.h"
#include "core/json.h"
#include "nephos/render.h"

/* The members "program", "machine": who ran where. */
void stats_environment(NphJson *json, const Session *session);

/* The member `key`: samples, seconds, events, noise, stages of one run. */
void stats_run(NphJson *json, const char *key, const NphRenderStatistics *run);

/* A whole file, written atomically. */
NphStatus stats_write(Session *session, const char *path, const char *scene, NphStatus status,
                      const NphRenderStatistics *run);

#endif
