/* SPDX-License-Identifier: Apache-2.0
 *
 * Impostors of temporal photons: which frame's picture a frame shows, where it stands, and how far it is from one that is marched. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "method/temporal_photons/tpm_impostor.h"
#include "method/tpm_case.h"

#define VIEW "resolution: [48, 40], position: [-3, 0.5, 0.6], look_at: [0.5, 0.5, 0.5], fov: 30"
#define SUN_AND_SKY "  - {type: sun, direction: [-1, 0.4, 0.5], irradiance: 2}\n  - {type: constant, radiance: 0.3}\n"
#define BALL "density: {file: ../data/sphere/sphere.npy, box: [[0, 0, 0], [1, 1, 1]]}, extinction: 9, albedo: 0.9, phase: {type: hg, g: 0.5}"

/* Ages of the pictures that frames 0 to 11 show; generations 20: light alone gives a picture six frames. */
static void expect_ages(const char *yaml, const char *knob, const int ages[12]) {
    const NphMethod *method = NULL;
    NphRenderOptions options;
    NphScene *scene = NULL;
    NphContext *context = nph_test_context(1);
    const char *knobs[] = {"tpm.impostors=1", "tpm.generations=20", "tpm.light=0.25", knob};
    NphStatus status = nph_scene_parse(context, yaml, strlen(yaml), "test.yaml", nph_test_path("reference/scenes"), &scene);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    nph_render_options_default(&options);
    options.method = "temporal_photons";
    options.knob_count = knob ? 4 : 3;
    options.knobs = knobs;
    for (uint32_t frame = 0; frame < 12; frame++) {
        NphScene *at = NULL, *shown = NULL;
        NphJob job;
        int age = -1;
        options.frame = frame;
        if (nph_scene_is_animated(scene)) ck_assert_int_eq(nph_scene_at_frame(context, scene, frame, &at), NPH_OK);
        ck_assert_int_eq(nph_job_make(context, at ? at : scene, &options, &method, &job), NPH_OK);
        ck_assert_int_eq(nph_tpm_impostor(&job, 0, &age, &shown), NPH_OK);
        ck_assert_msg(age == ages[frame], "%s: frame %u shows a picture %d frames old, not %d", knob ? knob : "", (unsigned)frame, age, ages[frame]);
        if (shown) ck_assert_uint_eq(shown->frame, frame - (uint32_t)age);
        ck_assert(!at || (shown != NULL) == (age > 0));
        nph_scene_free(context, shown);
        nph_scene_free(context, at);
    }
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}

#define FROM(path) "resolution: [48, 40], position: {frames: [0, 10], values: " path "}, look_at: [0.5, 0.5, 0.5], fov: 40"

START_TEST(each_criterion_ends_the_life_of_a_picture) {
    /* 2 degrees a frame around the middle; 8% a frame away from it; the light alone */
    static const char turning[] = SCENE(FROM("[[-3.5, 0.5, 0.5], [-3.5, 1.9, 0.5]]"), CUBE("4", "0.9", "0.5"), SUN_AND_SKY);
    static const char leaving[] = SCENE(FROM("[[-3.5, 0.5, 0.5], [-6.7, 0.5, 0.5]]"), CUBE("4", "0.9", "0.5"), SUN_AND_SKY);
    static const char denser[] = SCENE(VIEW, CUBE("{frames: [0, 10], values: [4, 6]}", "0.9", "0.5"), SUN_AND_SKY);
    static const char longer[] = SCENE(VIEW, "box: {frames: [0, 10], values: [[[0, 0, 0], [1, 1, 1]], [[0, 0, 0], [1, 1, 1.5]]]}, extinction: 4", SUN_AND_SKY);
    static const char near[] = SCENE("resolution: [48, 40], position: {frames: [0, 10], values: [[-0.9, 0.5, 0.5], [-0.9, 0.52, 0.5]]}, look_at: [0.5, 0.5, 0.5], fov: 40",
                                     CUBE("4", "0.9", "0.5"), SUN_AND_SKY);
    expect_ages(SCENE(VIEW, CUBE("4", "0.9", "0.5"), SUN_AND_SKY), NULL, (int[]){0, 1, 2, 3, 4, 5, 0, 1, 2, 3, 4, 5});
    expect_ages(SCENE(VIEW, CUBE("4", "0.9", "0.5"), SUN_AND_SKY), "tpm.light=0", (int[]){0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
    expect_ages(SCENE(VIEW, CUBE("4", "0.9", "0.5"), SUN_AND_SKY), "tpm.impostors=0", (int[]){0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
    expect_ages(turning, NULL, (int[]){0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2});
    expect_ages(turning, "tpm.angle=90", (int[]){0, 1, 2, 3, 4, 5, 0, 1, 2, 3, 4, 5});
    expect_ages(leaving, NULL, (int[]){0, 1, 2, 0, 1, 2, 0, 1, 2, 3, 0, 1});
    expect_ages(leaving, "tpm.distance=9", (int[]){0, 1, 2, 3, 4, 5, 0, 1, 2, 3, 4, 5});
    expect_ages(denser, "tpm.shape=0.08", (int[]){0, 1, 0, 1, 0, 1, 0, 1, 2, 0, 1, 2});
    expect_ages(denser, "tpm.shape=9", (int[]){0, 1, 2, 3, 4, 5, 0, 1, 2, 3, 4, 5});
    expect_ages(longer, "tpm.shape=9", (int[]){0, 1, 2, 3, 4, 5, 0, 1, 2, 3, 4, 5});
    expect_ages(near, NULL, (int[]){0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1}); /* not wholly in the picture, and seen otherwise */
}
END_TEST

enum { SHAPE = 3 };

/* Weight, and middle, of the picture's opacity. */
static void weigh(const NphImage *image, double out[SHAPE]) {
    const NphChannel *alpha = NULL;
    for (int c = 0; c < image->channel_count; c++)
        if (strcmp(image->channels[c].name, "A") == 0) alpha = &image->channels[c];
    ck_assert_ptr_nonnull(alpha);
    out[0] = out[1] = out[2] = 0.0;
    for (int y = 0; y < image->height; y++)
        for (int x = 0; x < image->width; x++) {
            double a = (double)alpha->pixels[y * image->width + x];
            out[0] += a;
            out[1] += a * x;
            out[2] += a * y;
        }
    out[1] /= out[0];
    out[2] /= out[0];
}

/* The camera goes by, up and away: the picture of four frames ago stands where the cloud is, and is as bright. */
START_TEST(an_old_picture_stands_where_the_cloud_is) {
    static const char yaml[] = SCENE("resolution: [48, 40], position: {frames: [0, 8], values: [[-3, 0.3, 0.6], [-3.3, 0.9, 0.9]]}, look_at: {frames: [0, 8], values: "
                                     "[[0.5, 0.5, 0.5], [0.5, 0.7, 0.4]]}, fov: 34",
                                     BALL, SUN_AND_SKY);
    static const char *const knobs[] = {"tpm.photons=8000", "tpm.generations=4", "tpm.cells=200", "tpm.half=0", "tpm.light=0.99", "tpm.angle=20", "tpm.impostors=1"};
    double shape[2][SHAPE], mean[2];
    if (!nph_test_statistics("place of impostors")) return;
    for (int impostors = 0; impostors < 2; impostors++) {
        Frames frames;
        NphImage image;
        frames_open(&frames, yaml, 32, 2, impostors ? 7 : 6, knobs);
        alone(&frames, 7, &image, NULL); /* of frame 4 */
        weigh(&image, shape[impostors]);
        mean[impostors] = mean_of(&image);
        nph_image_free(frames.context, &image);
        frames_close(&frames);
    }
    printf("    opacity %.1f and %.1f, middle %.3f %.3f and %.3f %.3f, mean %.4f and %.4f\n", shape[0][0], shape[1][0], shape[0][1], shape[0][2], shape[1][1],
           shape[1][2], mean[0], mean[1]);
    ck_assert_double_le(fabs(shape[1][0] / shape[0][0] - 1.0), 0.02);
    for (int a = 1; a < SHAPE; a++) ck_assert_double_le(fabs(shape[1][a] - shape[0][a]), 0.25);
    ck_assert_double_le(fabs(mean[1] / mean[0] - 1.0), 0.02);
    ck_assert_double_ne(mean[1], mean[0]);
}
END_TEST

START_TEST(frames_of_impostors_have_the_same_bytes_alone_and_within_a_sequence) {
    static const char *const scenes[] = {SCENE(VIEW, CUBE("4", "0.9", "0.5"), SUN_AND_SKY),
                                         SCENE(FROM("[[-3.5, 0.5, 0.5], [-3.5, 1.9, 0.5]]"), CUBE("{frames: [0, 10], values: [4, 4.4]}", "0.9", "0.5"), SUN_AND_SKY)};
    static const char *const knobs[] = {"tpm.photons=400", "tpm.generations=4", "tpm.cells=60", "tpm.impostors=1", "tpm.light=0.75", "tpm.noise=0.05"};
    static const uint32_t order[] = {3, 4, 5, 6, 9, 11, 8};
    for (int s = 0; s < 2; s++)
        for (int precision = 32; precision <= 64; precision += 32) {
            Frames frames;
            NphSequence *sequence = NULL;
            frames_open(&frames, scenes[s], precision, 2, 6, knobs);
            ck_assert_int_eq(nph_sequence_open(frames.context, frames.scene, &frames.options, &sequence), NPH_OK);
            for (int i = 0; i < 7; i++) {
                NphImage single, within;
                NphFilm *film = NULL;
                ck_assert_int_eq(nph_sequence_render(sequence, order[i], &film, NULL), NPH_OK);
                ck_assert_int_eq(nph_film_image(frames.context, film, &within), NPH_OK);
                alone(&frames, order[i], &single, NULL);
                same_image(&single, &within, order[i]);
                nph_image_free(frames.context, &within);
                nph_image_free(frames.context, &single);
                nph_film_free(frames.context, film);
            }
            nph_sequence_close(sequence);
            frames_close(&frames);
        }
}
END_TEST

/* Nothing moves: frames 4 to 7 show one picture, frame 8 the next. A crop shows the pixels of the whole. */
START_TEST(while_nothing_moves_frames_are_the_picture_that_they_show) {
    static const char *const knobs[] = {"tpm.photons=400", "tpm.generations=4", "tpm.cells=60", "tpm.impostors=1", "tpm.light=0.75"};
    Frames frames;
    NphImage image[3], crop;
    frames_open(&frames, SCENE(VIEW, CUBE("4", "0.9", "0.5"), SUN_AND_SKY), 32, 2, 5, knobs);
    for (uint32_t i = 0; i < 3; i++) alone(&frames, (uint32_t[]){4, 7, 8}[i], &image[i], NULL);
    same_image(&image[0], &image[1], 7);
    ck_assert_double_ne(mean_of(&image[2]), mean_of(&image[0]));
    frames.options.crop_given = 1;
    memcpy(frames.options.crop, (int[]){13, 9, 30, 31}, sizeof frames.options.crop);
    alone(&frames, 7, &crop, NULL);
    for (int y = 9; y < 31; y++)
        for (int x = 13; x < 30; x++) {
            float whole = image[1].channels[0].pixels[y * 48 + x], part = crop.channels[0].pixels[crop.width == 48 ? y * 48 + x : (y - 9) * 17 + x - 13];
            ck_assert_msg(!(whole < part || whole > part), "pixel %d,%d", x, y);
        }
    nph_image_free(frames.context, &crop);
    for (int i = 0; i < 3; i++) nph_image_free(frames.context, &image[i]);
    frames_close(&frames);
}
END_TEST

START_TEST(cameras_that_impostors_do_not_know_are_refused) {
    static const char *const knobs[] = {"tpm.impostors=1"};
    Frames frames;
    NphFilm *film = NULL;
    frames_open(&frames, SCENE("type: fisheye, resolution: [8, 8], position: [-3, 0.5, 0.6], look_at: [0.5, 0.5, 0.5], fov: 150", CUBE("4", "0.9", "0.5"), SUN_AND_SKY), 32, 1, 1,
                knobs);
    ck_assert_int_eq(nph_render(frames.context, frames.scene, &frames.options, &film, NULL), NPH_BAD_SCENE);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "impostors are seen by a perspective camera"));
    frames_close(&frames);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, each_criterion_ends_the_life_of_a_picture);
    tcase_add_test(cases, an_old_picture_stands_where_the_cloud_is);
    tcase_add_test(cases, frames_of_impostors_have_the_same_bytes_alone_and_within_a_sequence);
    tcase_add_test(cases, while_nothing_moves_frames_are_the_picture_that_they_show);
    tcase_add_test(cases, cameras_that_impostors_do_not_know_are_refused);
}

int main(void) { return nph_test_main("tpm_impostor", fill); }
