/* SPDX-License-Identifier: Apache-2.0
 *
 * Rendering in passes. A pass doubles the samples: [0,16) [16,32) [32,64) ..., so a target error is checked at powers of
 * two only and equal samples are equal bytes; a time budget cuts the last pass short at a multiple of 16. */
#define _POSIX_C_SOURCE 200809L
#include <string.h>
#include <time.h>

#include "core/message.h"
#include "core/pool.h"
#include "method/job.h"

enum { NPH_TARGET_FIRST_CHECK = 64, NPH_TARGET_BLACK = 4096 };


static double cpu_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* True when the picture's standard error is below the target. A black picture is believed after many samples only. */
static int target_reached(const NphFilm *film, double target, int64_t samples) {
    NphFilmNoise noise;
    nph_film_noise(film, &noise);
    if (samples < NPH_TARGET_FIRST_CHECK) return 0;
    if (!(noise.mean_luminance > 0.0)) return samples >= NPH_TARGET_BLACK;
    return noise.relative_error <= target;
}

/* End of the next pass: as many samples again, fewer when the time left does not allow them. */
static int64_t next_end(const NphJob *job, int64_t at, double elapsed, double budget) {
    int64_t done = at - job->sample_begin, count = done > 0 ? done : NPH_CHUNK;
    if (count > job->sample_end - at) count = job->sample_end - at;
    if (budget > 0.0 && done > 0) {
        double affordable = (budget - elapsed) / (elapsed / (double)done);
        if (affordable < (double)count) count = affordable > 0.0 ? (int64_t)affordable / NPH_CHUNK * NPH_CHUNK : 0;
    }
    return at + count;
}

static NphStatus run_passes(const NphMethod *method, void *state, const NphJob *job, const NphRenderOptions *options,
                            NphFilm *film, int *reached) {
    double start = nph_seconds();
    int64_t total = job->sample_end - job->sample_begin, at = job->sample_begin;
    while (at < job->sample_end) {
        int64_t end = next_end(job, at, nph_seconds() - start, options->time_budget_s);
        if (end == at) break;
        NPH_TRY(method->run(state, film, at, end, at - job->sample_begin, total));
        at = end;
        if (options->target_error > 0.0 && target_reached(film, options->target_error, at)) {
            *reached = 1;
            break;
        }
    }
    return NPH_OK;
}

static NphStatus check_numbers(NphContext *context, const NphFilm *film, const NphRenderStatistics *s) {
    NphNonfinite bad;
    nph_film_nonfinite(film, &bad);
    if (bad.count)
        return nph_error(context, NPH_BAD_NUMBER,
                         "%lld samples are not finite; the first: pixel %d,%d sample %lld (see it with --only FRAME,%d,%d,%lld)",
                         (long long)bad.count, bad.x, bad.y, (long long)bad.sample, bad.x, bad.y, (long long)bad.sample);
    if (s->majorant_violations)
        return nph_error(context, NPH_BAD_NUMBER, "%lld densities were above their majorant: the picture is biased",
                         (long long)s->majorant_violations);
    if (s->exhausted)
        return nph_error(context, NPH_BAD_NUMBER,
                         "%lld flights used up their random numbers (4194304 virtual collisions), or passed 1048576 periods "
                         "of sides that repeat and may never leave: the picture is biased",
                         (long long)s->exhausted);
    return NPH_OK;
}

/* A limit on memory is kept before anything is allocated. */
static NphStatus check_memory(const NphMethod *method, const NphJob *job) {
    uint64_t limit = nph_context_memory_limit(job->context);
    if (!limit) return NPH_OK;
    NphPlan plan = {0};
    NphStatus status = method->plan(job, &plan);
    uint64_t bytes = plan.bytes;
    nph_plan_free(job->context, &plan);
    NPH_TRY(status);
    if (bytes <= limit) return NPH_OK;
    return nph_error(job->context, NPH_NO_MEMORY, "the run needs %.1f MiB, the limit is %.1f MiB", (double)bytes / 1048576.0,
                     (double)limit / 1048576.0);
}

static void fill_statistics(const NphMethod *method, const void *state, const NphFilm *film, NphRenderStatistics *s) {
    method->statistics(state, s);
    nph_film_noise(film, &s->noise);
    NphNonfinite bad;
    nph_film_nonfinite(film, &bad);
    s->nonfinite = bad.count;
    s->samples_per_pixel = s->noise.samples_max;
    s->samples = 0;
    for (int64_t tile = 0; tile < nph_film_tile_count(film); tile++) {
        int origin[2], in[4];
        nph_film_tile_rect(film, tile, origin, in);
        s->samples += nph_film_tile_samples(film, tile) * (in[2] - in[0]) * (in[3] - in[1]);
    }
}

static NphStatus render_job(const NphMethod *method, const NphJob *job, const NphRenderOptions *options, NphFilm *film,
                            NphRenderStatistics *statistics) {
    void *state = NULL;
    double start = nph_seconds(), cpu = cpu_seconds();
    NPH_TRY(method->open(job, &state));
    NphStatus status = run_passes(method, state, job, options, film, &statistics->reached);
    if (status == NPH_OK || status == NPH_INTERRUPTED) {
        fill_statistics(method, state, film, statistics);
        if (statistics->unconverged)
            nph_warn(job->context, "%lld of %lld integrals did not reach their tolerance; the largest estimate of an error "
                     "is %.2g of the integral", (long long)statistics->unconverged, (long long)statistics->integrals,
                     statistics->worst_residual);
        NphStatus numbers = check_numbers(job->context, film, statistics);
        if (numbers != NPH_OK) status = numbers;
    }
    method->close(state);
    statistics->seconds = nph_seconds() - start;
    statistics->cpu_seconds = cpu_seconds() - cpu;
    return status;
}

NphStatus nph_render(NphContext *context, const NphScene *scene, const NphRenderOptions *options, NphFilm **film,
                     NphRenderStatistics *statistics) {
    return nph_render_carried(context, scene, options, NULL, NULL, film, statistics);
}

NphStatus nph_render_tapped(NphContext *context, const NphScene *scene, const NphRenderOptions *options, const NphTap *tap,
                            NphFilm **film, NphRenderStatistics *statistics) {
    return nph_render_carried(context, scene, options, tap, NULL, film, statistics);
}

NphStatus nph_render_carried(NphContext *context, const NphScene *scene, const NphRenderOptions *options, const NphTap *tap, void **carry,
                             NphFilm **film, NphRenderStatistics *statistics) {
    const NphMethod *method = NULL;
    NphJob job;
    NphRenderStatistics counted;
    memset(&counted, 0, sizeof counted);
    NPH_TRY(nph_job_make(context, scene, options, &method, &job));
    job.tap = tap;
    job.carry = job.sequence ? carry : NULL;
    NPH_TRY(check_memory(method, &job));
    NphFilm *made = NULL;
    NPH_TRY(nph_film_new(context, scene->sensor.width, scene->sensor.height, job.crop, method->channels(&job),
                         job.sample_begin, job.sample_end, &made));
    NphStatus status = method->shares_samples ? nph_film_share_samples(context, made) : NPH_OK;
    if (status == NPH_OK) status = nph_job_describe(&job, method, made);
    if (status == NPH_OK) status = render_job(method, &job, options, made, &counted);
    if (status != NPH_OK && status != NPH_INTERRUPTED && status != NPH_BAD_NUMBER) {
        nph_film_free(context, made);
        return status;
    }
    *film = made;
    if (statistics) *statistics = counted;
    return status;
}

NphStatus nph_plan_make(NphContext *context, const NphScene *scene, const NphRenderOptions *options, NphPlan *plan) {
    const NphMethod *method = NULL;
    NphJob job;
    NPH_TRY(nph_job_make(context, scene, options, &method, &job));
    NphPlan made = {0};
    NphStatus status = method->plan(&job, &made);
    if (status != NPH_OK) {
        nph_plan_free(context, &made);
        return status;
    }
    *plan = made;
    return NPH_OK;
}

NphStatus nph_replay(NphContext *context, const NphScene *scene, const NphRenderOptions *options, int x, int y,
                     int64_t sample, NphLineFn line, void *user) {
    const NphMethod *method = NULL;
    NphJob job;
    NPH_TRY(nph_job_make(context, scene, options, &method, &job));
    if (x < 0 || y < 0 || x >= scene->sensor.width || y >= scene->sensor.height || sample < 0 || sample >= NPH_MAX_SAMPLES)
        return nph_error(context, NPH_BAD_USAGE, "pixel %d,%d sample %lld: the picture has %d x %d pixels", x, y,
                         (long long)sample, scene->sensor.width, scene->sensor.height);
    return method->replay(&job, x, y, sample, line, user);
}
