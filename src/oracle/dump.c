/* SPDX-License-Identifier: Apache-2.0
 *
 * Dumps: a run with a tap that writes what launches leave behind (dump_parts.h), its limits and its folder. */
#define _POSIX_C_SOURCE 200809L
#include <dirent.h>
#include <errno.h>
#include <string.h>
#include <sys/stat.h>

#include "core/memory.h"
#include "core/message.h"
#include "oracle/dump_parts.h"

void nph_dump_options_default(NphDumpOptions *options) {
    *options = (NphDumpOptions){.launch = -1, .batch = -1, .limit_bytes = (uint64_t)4 << 30};
}

/* Which buffers each stage reads and writes. */
static void mark_buffers(NphDump *dump) {
    for (int s = 0; s < dump->method->stage_count; s++)
        for (int b = 0; b < dump->method->buffer_count; b++) {
            const char *name = dump->method->buffers[b].name;
            dump->reads[s][b] = nph_stage_lists(dump->method->stages[s].reads, name) != 0;
            dump->writes[s][b] = nph_stage_lists(dump->method->stages[s].writes, name) != 0;
        }
}

static NphStatus open_dump(NphDump *dump, const NphJob *job, const NphDumpOptions *options) {
    const int *crop = job->crop;
    dump->context = job->context;
    dump->options = options;
    dump->stage = options->stage ? nph_stage_find(dump->method, options->stage) : -1;
    dump->tile = -1;
    dump->digest = nph_digest_pick(nph_context_isa(job->context));
    mark_buffers(dump);
    if (options->stage && dump->stage < 0)
        return nph_error(job->context, NPH_BAD_USAGE, "method %s has no stage %s", dump->method->name, options->stage);
    if (options->pixel_given) {
        const int *p = options->pixel;
        if (dump->method->shares_samples)
            return nph_error(job->context, NPH_BAD_USAGE, "launches of method %s are not of single pixels: select a stage, a launch or a "
                             "batch", dump->method->name);
        if (p[0] < crop[0] || p[1] < crop[1] || p[0] >= crop[2] || p[1] >= crop[3])
            return nph_error(job->context, NPH_BAD_USAGE, "pixel %d,%d is not in the picture (%d,%d to %d,%d)", p[0], p[1], crop[0],
                             crop[1], crop[2] - 1, crop[3] - 1);
        int first = crop[0] / NPH_TILE, across = (crop[2] - 1) / NPH_TILE - first + 1;
        dump->tile = (int64_t)(p[1] / NPH_TILE - crop[1] / NPH_TILE) * across + p[0] / NPH_TILE - first;
    }
    dump->worker_count = nph_context_threads(job->context);
    if (pthread_mutex_init(&dump->lock, NULL) != 0) return nph_error(job->context, NPH_NO_MEMORY, "no lock for a dump");
    NPH_TRY(NPH_NEW(job->context, dump->worker_count, "workers of a dump", &dump->workers));
    for (int w = 0; w < dump->worker_count; w++) dump->workers[w].context = job->context;
    return NPH_OK;
}

static void close_dump(NphDump *dump) {
    nph_dump_free_workers(dump);
    pthread_mutex_destroy(&dump->lock);
}

/* An empty folder, made if it is not there. */
static NphStatus check_folder(NphContext *context, const char *path) {
    if (mkdir(path, 0777) == 0) return NPH_OK;
    DIR *folder = errno == EEXIST ? opendir(path) : NULL;
    int error = errno, entries = 0;
    if (!folder) return nph_error(context, NPH_BAD_OUTPUT, "%s: cannot be made: %s", path, strerror(error == EEXIST ? ENOTDIR : error));
    for (struct dirent *entry; (entry = readdir(folder)) != NULL;)
        entries += strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
    closedir(folder);
    return entries == 0 ? NPH_OK : nph_error(context, NPH_BAD_OUTPUT, "%s: holds files already: a dump needs an empty folder", path);
}

static int tiles_of(const int crop[4]) {
    return ((crop[2] - 1) / NPH_TILE - crop[0] / NPH_TILE + 1) * ((crop[3] - 1) / NPH_TILE - crop[1] / NPH_TILE + 1);
}

/* The first samples of the tile in the middle and of those around it, `around` on each side at most; of all tiles where pixels
 * share their samples. */
static NphRenderOptions first_samples(const NphRenderOptions *options, const NphDumpOptions *what, const NphJob *job, int shared, int around) {
    NphRenderOptions few = *options;
    few.samples = few.sample_begin = few.sample_end = 0;
    few.target_error = few.time_budget_s = 0.0;
    few.sample_end = NPH_CHUNK;
    few.crop_given = 1;
    for (int a = 0; a < 2; a++) {
        int middle = what->pixel_given ? what->pixel[a] : (job->crop[a] + job->crop[a + 2]) / 2, at = middle / NPH_TILE * NPH_TILE;
        int reach = what->pixel_given ? 0 : shared ? job->crop[a + 2] : around * NPH_TILE; /* photons are the whole picture's */
        few.crop[a] = at - reach > job->crop[a] ? at - reach : job->crop[a];
        few.crop[a + 2] = at + reach + NPH_TILE < job->crop[a + 2] ? at + reach + NPH_TILE : job->crop[a + 2];
    }
    return few;
}

/* Counts what these would take and scales it up. around 0: of one batch, which is an image where pixels share their samples; that its
 * tiles come on top is left out. */
static NphStatus forecast(const NphScene *scene, const NphRenderOptions *options, const NphDumpOptions *what, const NphJob *job,
                          const NphMethod *method, int around, double *bytes) {
    NphDump dump = {.method = method};
    NphDumpOptions all = *what;
    NphFilm *film = NULL;
    int one = what->batch >= 0, shared = method->shares_samples;
    NphRenderOptions few = first_samples(options, what, job, shared, around);
    int tiles = tiles_of(few.crop), whole = what->pixel_given ? 1 : tiles_of(job->crop);
    all.pixel_given = 0;
    all.batch = one && shared ? what->batch % (NPH_CHUNK + whole) : -1;
    int image = shared && !one && around == 0;
    dump.one_batch = image;
    NPH_TRY(open_dump(&dump, job, &all));
    NphTap tap = {&dump, nph_dump_before, nph_dump_after};
    NphStatus status = nph_render_tapped(job->context, scene, &few, &tap, &film, NULL);
    *bytes = (double)(dump.bytes - dump.once);
    *bytes *= one ? (shared ? 1.0 : 1.0 / tiles) : (double)whole / tiles * (double)(job->sample_end - job->sample_begin) / NPH_CHUNK;
    if (image) *bytes *= NPH_CHUNK;
    if (image && status == NPH_INTERRUPTED && !nph_interrupted(job->context)) status = NPH_OK;
    *bytes += (double)dump.once;
    close_dump(&dump);
    nph_film_free(job->context, film);
    return status;
}

/* Densities are made dense to be written: none that is too large already. */
static NphStatus check_densities(const NphScene *scene, const NphDumpOptions *what, const NphJob *job, const NphMethod *method) {
    int shown = 0;
    for (int s = 0; s < method->stage_count; s++) shown |= strstr(method->stages[s].name, ".majorant") != NULL;
    for (int m = 0; m < scene->medium_count && shown; m++) {
        const NphMedium *medium = &scene->media[m];
        double bytes = medium->shape == NPH_SHAPE_GRID ? 4.0 * (double)nph_grid_dense_count(&medium->grid) : 0.0;
        if (bytes > (double)what->limit_bytes)
            return nph_error(job->context, NPH_NO_MEMORY, "the density of %s takes %.1f MiB as a dense array, the dump's limit is %.1f MiB "
                             "(--dump-limit)", medium->name, bytes / 1048576.0, (double)what->limit_bytes / 1048576.0);
    }
    return NPH_OK;
}

/* One batch says enough where a multiple of it fits; the run stops at the limit in any case. */
static NphStatus check_size(const NphScene *scene, const NphRenderOptions *options, const NphDumpOptions *what, const NphJob *job,
                            const NphMethod *method) {
    enum { AMPLE = 8, AROUND = 2 };
    double bytes = 0.0;
    NPH_TRY(check_densities(scene, what, job, method));
    NPH_TRY(forecast(scene, options, what, job, method, 0, &bytes));
    if (AMPLE * bytes <= (double)what->limit_bytes) return NPH_OK;
    if (!what->pixel_given) NPH_TRY(forecast(scene, options, what, job, method, AROUND, &bytes));
    if (bytes <= (double)what->limit_bytes) return NPH_OK;
    return nph_error(job->context, NPH_NO_MEMORY, "the dump will take about %.1f MiB, its limit is %.1f MiB: write less "
                     "(--dump-select), or allow more (--dump-limit)%s", bytes / 1048576.0, (double)what->limit_bytes / 1048576.0,
                     options->target_error > 0.0 || options->time_budget_s > 0.0 ? "; without --spp it is that of a million samples" : "");
}

static NphStatus run(NphDump *dump, const NphJob *job, const char *scene_name, const NphRenderOptions *options, NphFilm **film,
                     NphRenderStatistics *statistics) {
    NphTap tap = {dump, nph_dump_before, nph_dump_after};
    NPH_TRY(check_size(job->scene, options, dump->options, job, dump->method));
    NPH_TRY(check_folder(job->context, dump->options->folder));
    NphStatus status = nph_render_tapped(job->context, job->scene, options, &tap, film, statistics);
    if (status != NPH_OK && status != NPH_INTERRUPTED) return status;
    NPH_TRY(nph_dump_close_files(dump)); /* what there is, is whole */
    NPH_TRY(nph_dump_write_manifest(dump, job, scene_name));
    return status;
}

NphStatus nph_dump(NphContext *context, const NphScene *scene, const char *scene_name, const NphRenderOptions *options,
                   const NphDumpOptions *what, NphFilm **film, NphRenderStatistics *statistics) {
    NphDump dump = {.write = 1};
    NphJob job;
    NPH_TRY(nph_job_make(context, scene, options, &dump.method, &job));
    NPH_TRY(nph_stages_supported(context, dump.method));
    NPH_TRY(open_dump(&dump, &job, what));
    NphStatus status = run(&dump, &job, scene_name, options, film, statistics);
    close_dump(&dump);
    return status;
}
