/* SPDX-License-Identifier: Apache-2.0
 *
 * A kernel of yours in the middle of a run: the distances of path.track in reference/scenes/cube_g070.yaml, written anew from
 * nephos/portable.h, take the place of the reference's after every launch of it. The picture must stay the same.
 *
 *     cc hybrid.c -o hybrid $(pkg-config --cflags --libs nephos) -lm
 *     ./hybrid reference/scenes/cube_g070.yaml hybrid.exr 16             same
 *     ./hybrid reference/scenes/cube_g070.yaml hybrid.exr 16 --mistake   different */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "nephos/nephos.h"
#include "nephos/portable.h"

enum { TILE, CHUNK, VERTEX, TRACK = 2 /* the stage's random stream: docs/path.md, Random numbers */ };
static const float half = 0.5f, sigma = 4.0f; /* the cube about its own middle, 1/m */

typedef struct Hybrid {
    NphContext *context;
    NphU32 seed, width, tiles_across;
    int wrong; /* the random words of the vertex before */
} Hybrid;

static void on_message(void *user, NphMessageLevel level, const char *text) {
    (void)user;
    (void)level;
    fprintf(stderr, "%s\n", text);
}

/* Where the ray is inside the cube; 0 where it is not. */
static int clip(const float *rays, int64_t count, int64_t k, float *near, float *far) {
    *near = 0.0f;
    *far = 1e30f;
    for (int a = 0; a < 3; a++) {
        float inverse = 1.0f / rays[(a + 3) * count + k];
        float t0 = (-half - rays[a * count + k]) * inverse, t1 = (half - rays[a * count + k]) * inverse;
        float first = t0 < t1 ? t0 : t1, last = t0 < t1 ? t1 : t0;
        if (first > *near) *near = first;
        if (last < *far) *far = last;
    }
    return *near < *far;
}

/* Your kernel, for one path. What it draws is named by pixel, sample and vertex, never by order. */
static void track(const Hybrid *hybrid, const NphWatchedLaunch *launch, const NphArray *id, const NphArray *ray, int64_t k, float *distance) {
    NphU32 tile = (NphU32)launch->arguments[TILE], lane = (NphU32)((const int32_t *)id->data)[k], pixel = lane >> 4;
    NphU32 x = tile % hybrid->tiles_across * 16 + pixel % 16, y = tile / hybrid->tiles_across * 16 + pixel / 16;
    NphU32 vertex = (NphU32)launch->arguments[VERTEX];
    NphWords words = nph_philox(hybrid->seed, (NphU32)TRACK << 24, y * hybrid->width + x, (NphU32)launch->arguments[CHUNK] * 16 + (lane & 15),
                                vertex - (NphU32)(hybrid->wrong && vertex > 0), 0);
    float near, far;
    int inside = clip(ray->data, id->shape[0], k, &near, &far);
    float t = near - nph_logf(1.0f - nph_uniformf(words.w0)) / sigma;
    *distance = inside && t < far ? t : 1e30f;
}

/* After path.track: reads what it had read, and puts your results where it put its own. */
static NphStatus after(void *user, NphWatched *watched) {
    Hybrid *hybrid = user;
    NphWatchedLaunch launch = nph_watched_launch(watched);
    NphArray id = {0}, ray = {0}, distance = {0};
    if (strcmp(launch.stage, "path.track") != 0) return NPH_OK;
    NphStatus status = nph_watched_read(watched, "path.id", &id);
    if (status == NPH_OK) status = nph_watched_read(watched, "path.ray", &ray);
    if (status == NPH_OK) status = nph_watched_read(watched, "path.distance", &distance);
    if (status == NPH_OK) {
        for (int64_t k = 0; k < id.shape[0]; k++) track(hybrid, &launch, &id, &ray, k, (float *)distance.data + k);
        status = nph_watched_write(watched, "path.distance", &distance);
    }
    nph_array_free(hybrid->context, &id);
    nph_array_free(hybrid->context, &ray);
    nph_array_free(hybrid->context, &distance);
    return status;
}

static NphStatus render(Hybrid *hybrid, const NphScene *scene, int64_t samples, const NphWatch *watch, NphImage *image) {
    NphRenderOptions options;
    NphFilm *film = NULL;
    nph_render_options_default(&options);
    options.samples = samples;
    NphStatus status = watch ? nph_render_watched(hybrid->context, scene, &options, watch, &film, NULL)
                             : nph_render(hybrid->context, scene, &options, &film, NULL);
    if (status == NPH_OK) status = nph_film_image(hybrid->context, film, image);
    nph_film_free(hybrid->context, film);
    return status;
}

/* The picture with your kernel against the one without. */
static NphStatus judge(Hybrid *hybrid, const NphScene *scene, int64_t samples, const char *path) {
    NphWatch watch = {hybrid, NULL, after};
    NphCompareOptions options;
    NphComparison comparison;
    NphImage theirs = {0}, ours = {0};
    nph_compare_options_default(&options);
    NphStatus status = render(hybrid, scene, samples, NULL, &theirs);
    if (status == NPH_OK) status = render(hybrid, scene, samples, &watch, &ours);
    if (status == NPH_OK) status = nph_exr_write(hybrid->context, path, &ours);
    if (status == NPH_OK) status = nph_compare(hybrid->context, &theirs, &ours, &options, &comparison, NULL);
    if (status == NPH_OK) {
        printf("%s: %s\n", nph_verdict_name(comparison.verdict), comparison.reason);
        status = comparison.verdict == NPH_SAME ? NPH_OK : NPH_DIFFERENT;
    }
    nph_image_free(hybrid->context, &theirs);
    nph_image_free(hybrid->context, &ours);
    return status;
}

int main(int argc, char **argv) {
    NphSettings settings;
    NphScene *scene = NULL;
    Hybrid hybrid = {.width = 256, .tiles_across = 16, .seed = 1, .wrong = argc == 5 && strcmp(argv[4], "--mistake") == 0};
    char *rest = "";
    long long samples = argc > 3 ? strtoll(argv[3], &rest, 10) : 0;
    if (argc < 4 || argc > 5 || *rest || (argc == 5 && !hybrid.wrong)) {
        fprintf(stderr, "usage: %s reference/scenes/cube_g070.yaml OUT.exr SAMPLES [--mistake]\n", argv[0]);
        return NPH_BAD_USAGE;
    }
    nph_settings_default(&settings);
    settings.message = on_message;
    NphStatus status = nph_context_open(&hybrid.context, &settings);
    if (status != NPH_OK) return (int)status;
    status = nph_scene_load(hybrid.context, argv[1], &scene);
    if (status == NPH_OK) status = judge(&hybrid, scene, samples, argv[2]);
    nph_scene_free(hybrid.context, scene);
    nph_context_close(hybrid.context);
    return (int)status;
}
