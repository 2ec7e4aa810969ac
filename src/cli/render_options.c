/* SPDX-License-Identifier: Apache-2.0
 *
 * See render_options.h. */
#include "cli/render_options.h"

#include <string.h>

#define LARGEST_COUNT 1099511627776.0 /* 2^40 */

static void add_sampling(OptionTable *table, RunOptions *run) {
    option_add(table, (Option){.name = "spp", .letter = 'n', .kind = OPTION_INT, .target = &run->spp, .value_name = "N",
                               .min = 1, .max = LARGEST_COUNT, .given = &run->spp_given,
                               .meaning = "samples per pixel, rounded up to 16; with --target-error the most"});
    option_add(table, (Option){.name = "samples", .kind = OPTION_INTS, .target = run->samples, .value_name = "A:B",
                               .count = 2, .separator = ':', .given = &run->samples_given,
                               .meaning = "samples A up to, not including, B instead: multiples of 16, for merge"});
    option_add(table, (Option){.name = "target-error", .kind = OPTION_NUMBER, .target = &run->target_error,
                               .value_name = "E", .min = 0, .max = 1,
                               .meaning = "double the samples until the standard error of the picture's mean is E times "
                                          "the mean"});
    option_add(table, (Option){.name = "time-budget", .kind = OPTION_NUMBER, .target = &run->time_budget_s,
                               .value_name = "S", .min = 0, .max = 1e9,
                               .meaning = "stop after about S seconds with what is done"});
    option_add(table, (Option){.name = "seed", .letter = 's', .kind = OPTION_INT, .target = &run->seed,
                               .value_name = "N", .min = 0, .max = 4294967295.0, .given = &run->seed_given,
                               .meaning = "another seed, another independent picture"});
}

void run_options_add(OptionTable *table, RunOptions *run) {
    run->method = "path";
    run->precision = "f32";
    option_add(table, (Option){.name = "method", .letter = 'm', .kind = OPTION_TEXT, .target = &run->method,
                               .value_name = "M", .meaning = "path, the unbiased path tracer (default); light, light tracing; single, light "
                                          "scattered at most once, by quadrature; photonmap, volumetric photon mapping; "
                                          "shdom, discrete ordinates on a grid, without noise; "
                                          "temporal_photons, photons in a coarse grid, refreshed in part by each frame; "
                                          "principal_ordinates, light in grids along its main directions"});
    option_add(table, (Option){.name = "define", .letter = 'D', .kind = OPTION_LIST, .target = &run->knobs,
                               .value_name = "K=V", .meaning = "turns a knob; `nephos plan --knobs` lists them"});
    add_sampling(table, run);
    option_add(table, (Option){.name = "precision", .letter = 'p', .kind = OPTION_TEXT, .target = &run->precision,
                               .value_name = "P", .meaning = "f32 (default, what GPUs do) or f64"});
    option_add(table, (Option){.name = "crop", .kind = OPTION_INTS, .target = run->crop, .value_name = "X0,Y0,X1,Y1",
                               .count = 4, .separator = ',', .given = &run->crop_given,
                               .meaning = "only the pixels from (X0, Y0), the upper left, up to, not including, (X1, Y1)"});
    option_add(table, (Option){.name = "frame", .letter = 'f', .kind = OPTION_INT, .target = &run->frame,
                               .value_name = "F", .min = 0, .max = 16777215.0,
                               .meaning = "number of the frame: the scene as of it, and other random numbers for each"});
    option_add(table, (Option){.name = "lock-noise", .kind = OPTION_FLAG, .target = &run->lock_noise,
                               .meaning = "the same random numbers for every frame of the scene"});
    option_add(table, (Option){.name = "plan", .kind = OPTION_TEXT, .target = &run->plan, .value_name = "full",
                               .meaning = "leave nothing out that this scene does not need"});
}

static NphStatus resolve_ranges(const char *command, const RunOptions *run, NphRenderOptions *options) {
    if (run->samples_given) {
        if (run->spp_given) return usage_error(command, "--spp and --samples exclude each other: N is the same as 0:N");
        if (run->target_error > 0)
            return usage_error(command, "--target-error and --samples exclude each other: bound it by --spp");
        if (run->samples[0] < 0 || run->samples[0] >= run->samples[1] || run->samples[0] % 16 || run->samples[1] % 16 ||
            (double)run->samples[1] > LARGEST_COUNT)
            return usage_error(command, "--samples %lld:%lld: expected 0 <= A < B, both multiples of 16",
                               (long long)run->samples[0], (long long)run->samples[1]);
        options->sample_begin = run->samples[0];
        options->sample_end = run->samples[1];
    }
    if (run->crop_given) {
        for (int i = 0; i < 4; i++)
            if (run->crop[i] < 0 || run->crop[i] > 1 << 20 || (i > 1 && run->crop[i] <= run->crop[i - 2]))
                return usage_error(command, "--crop: expected X0,Y0,X1,Y1 with 0 <= X0 < X1 and 0 <= Y0 < Y1");
        for (int i = 0; i < 4; i++) options->crop[i] = (int)run->crop[i];
        options->crop_given = 1;
    }
    return NPH_OK;
}

NphStatus run_options_resolve(const char *command, const RunOptions *run, NphRenderOptions *options) {
    nph_render_options_default(options);
    options->method = run->method;
    options->samples = run->spp;
    options->target_error = run->target_error;
    options->time_budget_s = run->time_budget_s;
    options->seed_given = run->seed_given;
    options->seed = (uint32_t)run->seed;
    options->frame = (uint32_t)run->frame;
    options->lock_noise = run->lock_noise;
    options->knob_count = run->knobs.count;
    options->knobs = run->knobs.items;
    if (strcmp(run->precision, "f32") == 0) options->precision = 32;
    else if (strcmp(run->precision, "f64") == 0) options->precision = 64;
    else return usage_error(command, "--precision %s: expected f32 or f64", run->precision);
    if (run->plan) {
        if (strcmp(run->plan, "full") != 0) return usage_error(command, "--plan %s: expected full", run->plan);
        options->plan_full = 1;
    }
    return resolve_ranges(command, run, options);
}

int run_options_given(const RunOptions *run) {
    return run->knobs.count || run->spp_given || run->samples_given || run->crop_given || run->seed_given || run->frame || run->lock_noise || run->plan ||
           run->target_error > 0 || run->time_budget_s > 0 || strcmp(run->method, "path") != 0 || strcmp(run->precision, "f32") != 0;
}

void knobs_print(FILE *out) {
    for (int i = 0; i < nph_knob_count(); i++) {
        const NphKnob *knob = nph_knob(i);
        fprintf(out, "  %-24s default %g, from %g to %g%s%s\n      %s; trades %s\n", knob->name, knob->value, knob->min,
                knob->max, strcmp(knob->unit, "1") != 0 ? " " : "",
                strcmp(knob->unit, "1") != 0 ? knob->unit : "", knob->meaning, knob->trades);
    }
}
