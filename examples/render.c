/* SPDX-License-Identifier: Apache-2.0
 *
 * The library in one page: a scene file becomes an OpenEXR picture with error bars.
 *
 *     cc render.c -o render $(pkg-config --cflags --libs nephos)
 *     ./render reference/scenes/cumulus.yaml cumulus.exr 64
 *
 * What comes out is, byte for byte, what `nephos render SCENE -o OUT.exr --spp 64` writes. */
#include <stdio.h>
#include <stdlib.h>

#include "nephos/nephos.h"

/* The library never prints. What it has to say arrives here, already worded: what is wrong, where, what would be right. */
static void on_message(void *user, NphMessageLevel level, const char *text) {
    static const char *const names[] = {"error", "warning", "info"};
    (void)user;
    fprintf(stderr, "%s: %s\n", names[level], text);
}

static void on_progress(void *user, const char *task, double done, double total, double seconds_left) {
    (void)user;
    fprintf(stderr, "%s: %.0f%%, %.0f s left\n", task, 100 * done / total, seconds_left < 0 ? 0 : seconds_left);
}

/* Every call that can fail returns a status, and leaves its out-parameters alone when it does. */
static NphStatus render(NphContext *context, const NphScene *scene, int64_t samples, const char *path) {
    NphRenderOptions options;
    NphRenderStatistics statistics;
    NphFilm *film = NULL;
    NphImage image;

    /* Defaults first, then what differs. 0 samples: as many as the scene says. */
    nph_render_options_default(&options);
    options.samples = samples;
    NphStatus status = nph_render(context, scene, &options, &film, &statistics);

    /* The film holds the moments of every pixel; the image is made of them: R G B A, Variance.*, and more
     * (docs/files.md). After an interruption or a numerical failure there is a film too: free it in any case. */
    if (status == NPH_OK) status = nph_film_image(context, film, &image);
    if (status == NPH_OK) {
        status = nph_exr_write(context, path, &image);
        nph_image_free(context, &image);
    }
    nph_film_free(context, film);
    if (status != NPH_OK) return status;

    printf("%s: %lld samples per pixel, noise %.3g%% of the mean\n", path, (long long)statistics.samples_per_pixel,
           100 * statistics.noise.relative_error);
    return NPH_OK;
}

int main(int argc, char **argv) {
    NphSettings settings;
    NphContext *context = NULL;
    NphScene *scene = NULL;
    char *rest = "";
    long long samples = argc > 3 ? strtoll(argv[3], &rest, 10) : 0;
    if (argc < 3 || argc > 4 || *rest) {
        fprintf(stderr, "usage: %s SCENE.yaml OUT.exr [SAMPLES]\n", argv[0]);
        return NPH_BAD_USAGE;
    }

    /* The context owns threads, memory and callbacks; there is no global state. */
    nph_settings_default(&settings);
    settings.message = on_message;
    settings.progress = on_progress;
    NphStatus status = nph_context_open(&context, &settings);
    if (status != NPH_OK) {
        fprintf(stderr, "no context: %s\n", nph_status_name(status));
        return (int)status;
    }

    /* A scene is checked as it is read and does not change afterwards: it may be rendered many times. */
    status = nph_scene_load(context, argv[1], &scene);
    if (status == NPH_OK) status = render(context, scene, samples, argv[2]);
    nph_scene_free(context, scene);
    nph_context_close(context);
    return (int)status; /* statuses are exit statuses */
}
