/* SPDX-License-Identifier: Apache-2.0
 *
 * See render_case.h. */
#include "render_case.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "harness.h"

#ifdef NPH_ALTERED
#include "altered/altered.h"
#endif

NphRenderOptions render_options(int64_t samples, int precision) {
    NphRenderOptions options;
    nph_render_options_default(&options);
    options.samples = samples;
    options.precision = precision;
    return options;
}

const char *render_text(const char *format, ...) {
    static char buffers[128][4096];
    static int next;
    char *buffer = buffers[next++ % 128];
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(buffer, sizeof buffers[0], format, arguments);
    va_end(arguments);
    ck_assert_int_lt(length, (int)sizeof buffers[0]);
    return buffer;
}

NphStatus render_try(RenderCase *render, const char *yaml, const NphRenderOptions *options, int threads) {
    memset(render, 0, sizeof *render);
    render->context = nph_test_context(threads);
    NphStatus status = nph_scene_parse(render->context, yaml, strlen(yaml), "test.yaml", nph_test_path("reference/scenes"),
                                       &render->scene);
#ifdef NPH_ALTERED
    if (status == NPH_OK) altered_change_scene(render->scene);
#endif
    if (status == NPH_OK)
        status = nph_render(render->context, render->scene, options, &render->film, &render->statistics);
    if (status == NPH_OK) status = nph_film_image(render->context, render->film, &render->image);
    return status;
}

void render_case(RenderCase *render, const char *yaml, const NphRenderOptions *options, int threads) {
    NphStatus status = render_try(render, yaml, options, threads);
    ck_assert_msg(status == NPH_OK, "%s: %s\n%s", nph_status_name(status), nph_test_messages(), yaml);
}

void render_free(RenderCase *render) {
    nph_image_free(render->context, &render->image);
    if (render->film) nph_film_free(render->context, render->film);
    if (render->scene) nph_scene_free(render->context, render->scene);
    nph_test_context_close(render->context);
}

static const NphChannel *channel_of(const RenderCase *render, const char *name) {
    const NphChannel *channel = nph_image_channel(&render->image, name);
    ck_assert_msg(channel != NULL, "no channel %s", name);
    return channel;
}

double render_mean(const RenderCase *render, const char *name) {
    const NphChannel *channel = channel_of(render, name);
    double sum = 0.0;
    int count = render->image.width * render->image.height;
    for (int i = 0; i < count; i++) sum += (double)channel->pixels[i];
    return sum / count;
}

double render_error(const RenderCase *render, const char *name) {
    const NphChannel *own = nph_image_channel(&render->image, render_text("VarianceImage.%s", name));
    if (own) return sqrt((double)own->pixels[0]);
    const NphChannel *channel = channel_of(render, render_text("Variance.%s", name));
    double sum = 0.0;
    int count = render->image.width * render->image.height;
    for (int i = 0; i < count; i++) sum += (double)channel->pixels[i];
    return sqrt(sum) / count;
}

NphVerdict render_verdict(const RenderCase *render, double value, double margin, NphComparison *comparison) {
    static const char *const names[] = {"R", "G", "B", "Variance.R", "Variance.G", "Variance.B", "N"};
    NphImage flat;
    ck_assert_int_eq(nph_image_new(render->context, render->image.width, render->image.height, &flat), NPH_OK);
    for (int c = 0; c < 7; c++) {
        float *pixels = NULL;
        ck_assert_int_eq(nph_image_add_channel(render->context, &flat, names[c], &pixels), NPH_OK);
        for (int i = 0; i < flat.width * flat.height; i++) pixels[i] = c < 3 ? (float)value : c < 6 ? 0.0f : 1e6f;
    }
    NphCompareOptions options;
    nph_compare_options_default(&options);
    options.margin_image = margin;
    options.margin_tile = 10.0 * margin;
    NphStatus status = nph_compare(render->context, &render->image, &flat, &options, comparison, NULL);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    nph_image_free(render->context, &flat);
    return comparison->verdict;
}

static NphScene *parse(NphContext *context, const char *yaml) {
    NphScene *scene = NULL;
    NphStatus status = nph_scene_parse(context, yaml, strlen(yaml), "test.yaml", nph_test_path("reference/scenes"), &scene);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    return scene;
}

void render_without_memory(const char *yaml, const NphRenderOptions *options) {
    NphContext *counter = nph_test_context(2);
    NphScene *scene = parse(counter, yaml);
    NphFilm *film = NULL;
    uint64_t before = nph_context_allocations(counter);
    ck_assert_int_eq(nph_render(counter, scene, options, &film, NULL), NPH_OK);
    uint64_t count = nph_context_allocations(counter) - before;
    nph_film_free(counter, film);
    nph_scene_free(counter, scene);
    nph_test_context_close(counter);
    ck_assert_uint_gt(count, 10);
    for (uint64_t n = 1; n <= count; n++) {
        NphSettings settings;
        NphContext *context = NULL;
        nph_settings_default(&settings);
        settings.threads = 2;
        settings.fail_allocation = before + n;
        film = NULL;
        ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
        scene = parse(context, yaml);
        ck_assert_int_eq(nph_render(context, scene, options, &film, NULL), NPH_NO_MEMORY);
        ck_assert_ptr_null(film);
        nph_scene_free(context, scene);
        ck_assert_uint_eq(nph_context_bytes(context), 0);
        nph_context_close(context);
    }
}

void render_as_planned(const char *yaml, const NphRenderOptions *options) {
    NphContext *context = nph_test_context(3);
    NphScene *scene = parse(context, yaml);
    NphPlan plan;
    NphFilm *film = NULL;
    ck_assert_int_eq(nph_plan_make(context, scene, options, &plan), NPH_OK);
    ck_assert_int_eq(nph_render(context, scene, options, &film, NULL), NPH_OK);
    double planned = (double)plan.bytes, used = (double)nph_context_peak_bytes(context);
    printf("    planned %.0f, used %.0f\n", planned, used);
    ck_assert_double_gt(planned, 0.9 * used);
    ck_assert_double_lt(planned, 1.1 * used);
    nph_plan_free(context, &plan);
    nph_film_free(context, film);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
