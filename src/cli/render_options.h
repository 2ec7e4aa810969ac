/* SPDX-License-Identifier: Apache-2.0
 *
 * The options that say what a run is, shared by render, plan and bench. */
#ifndef NPH_CLI_RENDER_OPTIONS_H
#define NPH_CLI_RENDER_OPTIONS_H

#include "cli/options.h"
#include "cli/session.h"
#include "nephos/render.h"

typedef struct RunOptions {
    const char *method, *precision, *plan;
    TextList knobs;
    int64_t spp, samples[2], crop[4], seed, frame;
    double target_error, time_budget_s;
    int lock_noise;
    int spp_given, samples_given, crop_given, seed_given;
} RunOptions;

void run_options_add(OptionTable *table, RunOptions *run);

/* Turned into the library's; what contradicts itself is refused. */
NphStatus run_options_resolve(const char *command, const RunOptions *run, NphRenderOptions *options);

/* An option that says what a run is was given: not where a dump says it. */
int run_options_given(const RunOptions *run);

/* Every knob with its default and what it trades, one per line. */
void knobs_print(FILE *out);

#endif
