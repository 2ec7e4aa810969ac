/* SPDX-License-Identifier: Apache-2.0
 *
 * Renders scenes that need no files (made_scenes.h) by every method, in both precisions, and prints a line for each buffer of each
 * stage and each channel of the picture: what two builds of whatever kind must print alike. scripts/test_aarch64. */
#include <stdio.h>
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "made_scenes.h"
#include "pipeline/stage.h"
#include "stage_digests.h"

enum { WIDTH = 18, HEIGHT = 10 };

static void tell(void *user, NphMessageLevel level, const char *text) {
    (void)user;
    if (level == NPH_MESSAGE_ERROR) fprintf(stderr, "render_bytes: %s\n", text);
}

static NphStatus print_run(NphContext *context, const NphScene *scene, const char *method, int precision) {
    static const char *const photons[] = {"photonmap.photons=2000"}, *const frames[] = {"tpm.photons=2000", "tpm.generations=2", "tpm.cells=200"},
                             *const grids[] = {"shdom.cells=5", "shdom.bands=3"}, *const lobes[] = {"pop.ordinates=8", "pop.cells=8", "pop.iterations=5"};
    int maps = strcmp(method, "photonmap") == 0, temporal = strcmp(method, "temporal_photons") == 0, harmonics = strcmp(method, "shdom") == 0;
    int principal = strcmp(method, "principal_ordinates") == 0;
    NphRenderOptions options;
    DigestTable table;
    nph_render_options_default(&options);
    options.method = method;
    options.samples = 16;
    options.precision = precision;
    options.knob_count = maps ? 1 : temporal || principal ? 3 : harmonics ? 2 : 0;
    options.knobs = temporal ? frames : principal ? lobes : harmonics ? grids : photons;
    NPH_TRY(digests_take(context, scene, &options, &table));
    for (int r = 0; r < table.count; r++) {
        const DigestRow *row = &table.rows[r];
        printf("%s %s f%d %s %s %lld %lld %s\n", scene->name, method, precision, row->stage, row->buffer,
               (long long)row->launches, (long long)row->elements, row->digest);
    }
    nph_free(context, table.rows);
    return NPH_OK;
}

static NphStatus print_scene(NphContext *context, const MadeScene *made) {
    static const char *const methods[] = {"path", "light", "single", "photonmap", "temporal_photons", "principal_ordinates", "shdom"};
    NphScene *scene = NULL;
    NPH_TRY(made_scene(context, made, WIDTH, HEIGHT, &scene));
    NphStatus status = NPH_OK;
    for (int m = 0; m < 7; m++)
        for (int precision = 32; precision <= 64 && status == NPH_OK; precision += 32)
            if (nph_stage_lists(made->methods, methods[m])) status = print_run(context, scene, methods[m], precision);
    nph_scene_free(context, scene);
    return status;
}

int main(void) {
    NphContext *context = NULL;
    NphSettings settings;
    nph_settings_default(&settings);
    settings.message = tell;
    NphStatus status = nph_context_open(&context, &settings);
    for (int s = 0; s < made_scene_count && status == NPH_OK; s++) status = print_scene(context, &made_scenes[s]);
    nph_context_close(context);
    if (status != NPH_OK) fprintf(stderr, "render_bytes: %s\n", nph_status_name(status));
    return status == NPH_OK ? 0 : 1;
}
