/* SPDX-License-Identifier: Apache-2.0
 *
 * Scenes that change over frames: what stands between keys, files by number, the same scene at another frame. Most cases hold a
 * frame of an animated scene against a still scene with the values written out; numbers are such that both are exact. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "harness.h"
#include "io/volume.h"
#include "scene/model.h"

#define EYE "nephos: 1\ncamera: {resolution: [4, 3], "
#define HEAD EYE "position: [0, -4, 0], look_at: [0, 0, 0], fov: 35}\n"
#define BOX HEAD "media:\n- {box: [[0, 0, 0], [1, 1, 1]], extinction: 1, "
#define LIGHT HEAD "lights:\n- {"

static NphScene *parse_in(NphContext *context, const char *text, const char *folder) {
    NphScene *scene = NULL;
    NphStatus status = nph_scene_parse(context, text, strlen(text), "folder/name.yaml", folder, &scene);
    ck_assert_msg(status == NPH_OK, "%s\n%s", nph_test_messages(), text);
    return scene;
}

static NphScene *parse(NphContext *context, const char *text) { return parse_in(context, text, NULL); }

static NphScene *at_frame(NphContext *context, const NphScene *scene, uint32_t frame) {
    NphScene *other = NULL;
    NphStatus status = nph_scene_at_frame(context, scene, frame, &other);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    ck_assert_uint_eq(other->frame, frame);
    return other;
}

static int same(const NphScene *a, const NphScene *b) { return memcmp(a->digest, b->digest, sizeof a->digest) == 0; }

typedef struct Pair {
    const char *before, *animated, *still, *after; /* before + animated + after at the frame is before + still + after */
    uint32_t frame;
} Pair;

static const Pair pairs[] = {
    /* before the first key, at keys, between them, after the last */
    {EYE "position: [0, -4, 0], look_at: [0, 0, 0], fov: ", "{frames: [8, 16, 32], values: [30, 40, 10]}", "30", "}\n", 0},
    {EYE "position: [0, -4, 0], look_at: [0, 0, 0], fov: ", "{frames: [8, 16, 32], values: [30, 40, 10]}", "30", "}\n", 8},
    {EYE "position: [0, -4, 0], look_at: [0, 0, 0], fov: ", "{frames: [8, 16, 32], values: [30, 40, 10]}", "37.5", "}\n", 14},
    {EYE "position: [0, -4, 0], look_at: [0, 0, 0], fov: ", "{frames: [8, 16, 32], values: [30, 40, 10]}", "40", "}\n", 16},
    {EYE "position: [0, -4, 0], look_at: [0, 0, 0], fov: ", "{frames: [8, 16, 32], values: [30, 40, 10]}", "32.5", "}\n", 20},
    {EYE "position: [0, -4, 0], look_at: [0, 0, 0], fov: ", "{values: [30, 40, 10], frames: [8, 16, 32]}", "10", "}\n", 32},
    {EYE "position: [0, -4, 0], look_at: [0, 0, 0], fov: ", "{frames: [8, 16, 32], values: [30, 40, 10]}", "10", "}\n", 16777215},
    {EYE "position: [0, -4, 0], look_at: [0, 0, 0], fov: ", "{frames: [8], values: [30]}", "30", "}\n", 9},
    /* every type */
    {EYE "look_at: [0, 0, 0], fov: 35, position: ", "{frames: [0, 4], values: [[0, -4, 8], [4, -8, 0]]}", "[1, -5, 6]", "}\n", 1},
    {EYE "position: [0, -4, 0], fov: 35, direction: ", "{frames: [0, 4], values: [[1, 0, 0], [0, 2, 0]]}", "[1, 2, 0]", "}\n", 2},
    {BOX "albedo: ", "{frames: [0, 4], values: [1, [0, 0.5, 1]]}", "[0.5, 0.75, 1]", "}\n", 2},
    {BOX "albedo: ", "{frames: [0, 4], values: [1, 0]}", "0.5", "}\n", 2},
    {"wavelengths: [400, 500, 600, 700]\n" BOX "albedo: ", "{frames: [0, 4], values: [1, [0, 0.5, 1, 0.5]]}", "[0.5, 0.75, 1, 0.75]", "}\n", 2},
    {BOX "transform: [{translate: [1, 2, 3]}, {scale: ", "{frames: [0, 4], values: [1, [3, 5, 9]]}", "[1.5, 2, 3]", "}]}\n", 1},
    {BOX "transform: [{translate: ", "{frames: [0, 4], values: [[0, 0, 8], [4, 8, 0]]}", "[3, 6, 2]", "}]}\n", 3},
    {BOX "transform: [{rotate: {axis: [0, 0, 1], angle: ", "{frames: [0, 4], values: [0, 180]}", "45", "}}]}\n", 1},
    {BOX "transform: [{rotate: {angle: 30, axis: ", "{frames: [0, 4], values: [[0, 0, 1], [1, 0, 0]]}", "[1, 0, 1]", "}}]}\n", 2},
    {BOX "transform: [{matrix: ", "{frames: [0, 4], values: [[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0], [3, 1, 0, 8, 0, 1, 0, 0, 0, 0, 5, 0]]}",
     "[1.5, 0.25, 0, 2, 0, 1, 0, 0, 0, 0, 2, 0]", "}]}\n", 1},
    {HEAD "media: [{extinction: 2, box: ", "{frames: [0, 2], values: [[[0, 0, 0], [1, 1, 1]], [[1, 2, 3], [5, 5, 5]]]}", "[[0.5, 1, 1.5], [3, 3, 3]]", "}]\n", 1},
    {HEAD "media: [{extinction: 2, layer: ", "{frames: [0, 2], values: [[0, 1], [2, 9]]}", "[1, 5]", "}]\n", 1},
    {HEAD "periodic: {x: ", "{frames: [0, 2], values: [[0, 1], [2, 9]]}", "[1, 5]", "}\n", 1},
    {LIGHT "type: sun, elevation: 30, irradiance: 2, azimuth: ", "{frames: [0, 24, 48], values: [120, 144, 120]}", "132", "}\n", 36},
    {LIGHT "type: sun, direction: [0, 0, 1], irradiance: ", "{frames: [0, 2], values: [0, [1e35, 0, 0]]}", "[5e34, 0, 0]", "}\n", 1},
    {HEAD "surfaces: [{plane: ", "{frames: [0, 2], values: [-1e12, 0.5e12]}", "-2.5e11", "}]\n", 1},
    /* two aliases of one list */
    {HEAD "surfaces: [{plane: 0, albedo: ", "&v {frames: [0, 2], values: [0.25, 0.75]}", "0.5", "}]\n", 1},
};

START_TEST(a_frame_of_an_animated_scene_is_the_still_scene_with_its_values_written_out) {
    NphContext *context = nph_test_context(1);
    for (size_t i = 0; i < sizeof pairs / sizeof pairs[0]; i++) {
        const Pair *p = &pairs[i];
        char animated[1000], still[1000];
        snprintf(animated, sizeof animated, "%s%s%s", p->before, p->animated, p->after);
        snprintf(still, sizeof still, "%s%s%s", p->before, p->still, p->after);
        NphScene *start = parse(context, animated), *moved = at_frame(context, start, p->frame), *written = parse(context, still);
        ck_assert_msg(same(moved, written), "frame %u of\n%s is not\n%s", (unsigned)p->frame, animated, still);
        if (p->frame == 0) ck_assert(same(start, written));
        ck_assert(nph_scene_is_animated(start) && nph_scene_is_animated(moved) && !nph_scene_is_animated(written));
        nph_scene_free(context, start);
        nph_scene_free(context, moved);
        nph_scene_free(context, written);
    }
    nph_test_context_close(context);
}
END_TEST

/* 0.1 + (0.1 - 0.1) t is 0.1, whatever t is; so are values between which there is no exact middle. */
START_TEST(constant_values_give_the_still_scene_to_the_bit) {
    static const char animated[] = HEAD "media: [{layer: {frames: [3, 10], values: [[0.1, 0.7], [0.1, 0.7]]}, extinction: {frames: [1, 4, 9], "
                                        "values: [0.3, 0.3, 0.3]}}]\nlights: [{type: sun, elevation: {frames: [0], values: [1e-3]}, azimuth: "
                                        "{frames: [0, 16777215], values: [-123.4, -123.4]}, irradiance: 1e34}]\n";
    static const char still[] = HEAD "media: [{layer: [0.1, 0.7], extinction: 0.3}]\n"
                                     "lights: [{type: sun, elevation: 1e-3, azimuth: -123.4, irradiance: 1e34}]\n";
    NphContext *context = nph_test_context(1);
    NphScene *first = parse(context, animated), *written = parse(context, still);
    for (uint32_t frame = 0; frame < 12; frame++) {
        NphScene *other = at_frame(context, first, frame);
        ck_assert(same(other, written));
        nph_scene_free(context, other);
    }
    nph_scene_free(context, first);
    nph_scene_free(context, written);
    nph_test_context_close(context);
}
END_TEST

/* Rounding must not carry a number over a key, where it might not be allowed. */
START_TEST(numbers_between_keys_stay_between_them) {
    NphContext *context = nph_test_context(1);
    NphScene *first = parse(context, HEAD "surfaces: [{plane: 0, albedo: {frames: [0, 3, 16777215], values: [0.1, 1, 0.7]}}]\n");
    static const uint32_t frames[] = {1, 2, 4, 5, 16777213, 16777214};
    double before = 0.1;
    for (size_t i = 0; i < sizeof frames / sizeof frames[0]; i++) {
        NphScene *other = at_frame(context, first, frames[i]);
        double albedo = other->surfaces[0].albedo[0];
        if (i < 2) ck_assert(albedo > before && albedo < 1);
        else ck_assert(albedo < (i == 2 ? 1 : before) && albedo > 0.7);
        before = albedo;
        nph_scene_free(context, other);
    }
    nph_scene_free(context, first);
    nph_test_context_close(context);
}
END_TEST

static void refuse(NphContext *context, const NphScene *scene, uint32_t frame, NphStatus expected, const char *message) {
    NphScene *other = NULL;
    ck_assert_int_eq(nph_scene_at_frame(context, scene, frame, &other), expected);
    const char *said = nph_test_messages();
    ck_assert_msg(strcmp(said, message) == 0, "said: %s\nexpected: %s", said, message);
    ck_assert_ptr_null(other);
}

START_TEST(what_is_wrong_at_one_frame_is_said_with_its_number) {
    NphContext *context = nph_test_context(1);
    NphScene *scene = parse(context, LIGHT "type: sun, irradiance: 1, direction: {frames: [0, 10], values: [[1, 0, 0], [-1, 0, 0]]}}\n"
                                          "media:\n- box: [[0, 0, 0], [1, 1, 1]]\n  extinction: 1\n  transform:\n  - scale: {frames: "
                                          "[0, 2, 4, 10], values: [1, 1, -1, -1]}\n");
    refuse(context, scene, 5, NPH_BAD_SCENE, "folder/name.yaml:4:41: direction has length 0; it points towards the sun (at frame 5)\n");
    refuse(context, scene, 3, NPH_BAD_SCENE,
           "folder/name.yaml:9:12: scale has a factor 0, which flattens the medium (at frame 3)\n");
    refuse(context, scene, 16777216, NPH_BAD_USAGE, "frame: 16777216 is above 16777215\n");
    nph_scene_free(context, scene);
    /* as thin as doubles allow at both keys; in between rounding closes it */
    scene = parse(context, HEAD "media: [{extinction: 1, layer: {frames: [0, 10], values: [[1, 1.0000000000000002], [500000000000, "
                                "500000000000.00006]]}}]\n");
    refuse(context, scene, 9, NPH_BAD_SCENE, "folder/name.yaml:3:32: layer is flat: from 450000000000.10004 to 450000000000.10004; the first "
           "number is the lower one (at frame 9)\n");
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

/* ---- files by number ---- */

/* An array of 2 x 2 x 2 that says its number. */
static void write_volume(NphContext *context, const char *name, double number) {
    NphArray array = {0};
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 3, (int64_t[]){2, 2, 2}, "array", &array), NPH_OK);
    for (int i = 0; i < 8; i++) ((float *)array.data)[i] = (float)number;
    ck_assert_int_eq(nph_npy_write(context, nph_test_temporary(name), &array), NPH_OK);
    nph_array_free(context, &array);
}

#define SMOKE(file, more) HEAD "media:\n- {extinction: 1, density: {file: " file ", box: [[0, 0, 0], [1, 1, 1]]" more "}}\n"

static void check_file(NphContext *context, const char *text, uint32_t frame, double number) {
    NphScene *start = parse_in(context, text, nph_test_temporary(".")), *other = at_frame(context, start, frame);
    ck_assert_msg((double)other->media[0].grid.max == number, "frame %u of %s", (unsigned)frame, text);
    ck_assert_int_eq(nph_scene_is_animated(start), strchr(text, '#') != NULL);
    nph_scene_free(context, start);
    nph_scene_free(context, other);
}

START_TEST(a_run_of_hashes_is_the_number_of_the_frame) {
    NphContext *context = nph_test_context(1);
    static const char *const names[] = {"s.0000.npy", "s.0007.npy", "s.0123.npy", "s.12345.npy", "s0.npy", "s7.npy", "s123.npy", "000_0.npy",
                                        "007_7.npy"};
    static const int numbers[] = {1000, 7, 123, 12345, 1000, 7, 123, 1000, 7};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) write_volume(context, names[i], numbers[i]);
    check_file(context, SMOKE("s.####.npy", ""), 0, 1000);
    check_file(context, SMOKE("s.####.npy", ""), 7, 7);
    check_file(context, SMOKE("s.####.npy", ""), 123, 123);
    check_file(context, SMOKE("s.####.npy", ""), 12345, 12345);
    check_file(context, SMOKE("s#.npy", ""), 7, 7);
    check_file(context, SMOKE("s#.npy", ""), 123, 123);
    check_file(context, SMOKE("'###_#.npy'", ""), 7, 7);
    check_file(context, SMOKE("s.0007.npy", ""), 123, 7);
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_frame_without_its_file_is_refused_with_file_and_frame) {
    NphContext *context = nph_test_context(1);
    char expected[1500], folder[600];
    snprintf(folder, sizeof folder, "%s", nph_test_temporary("."));
    write_volume(context, "m.0000.npy", 1);
    NphScene *scene = parse_in(context, SMOKE("m.####.npy", ""), folder);
    snprintf(expected, sizeof expected, "folder/name.yaml:4:35: volume 'm.####.npy' cannot be read: No such file or directory (looked up as "
             "%s/m.0001.npy) (at frame 1)\n", folder);
    refuse(context, scene, 1, NPH_BAD_INPUT, expected);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_sequence_sparser_than_frames_takes_the_last_file_not_ahead) {
    NphContext *context = nph_test_context(1);
    write_volume(context, "n.0008.npy", 8);
    write_volume(context, "n.0012.npy", 12);
    write_volume(context, "n.0016.npy", 16);
    static const int frames[][2] = {{0, 8}, {8, 8}, {9, 8}, {11, 8}, {12, 12}, {15, 12}, {16, 16}, {17, 16}, {16777215, 16}};
    for (size_t i = 0; i < sizeof frames / sizeof frames[0]; i++)
        check_file(context, SMOKE("n.####.npy", ", numbers: {first: 8, last: 16, step: 4}"), (uint32_t)frames[i][0], frames[i][1]);
    check_file(context, SMOKE("n.####.npy", ", numbers: {first: 12, last: 12}"), 99, 12);
    nph_test_context_close(context);
}
END_TEST

/* ---- the same scene at another frame ---- */

START_TEST(another_frame_of_a_scene_is_what_loading_it_gives_and_needs_no_file) {
    NphContext *context = nph_test_context(1);
    char path[600];
    NphScene *first = NULL, *loaded = NULL;
    snprintf(path, sizeof path, "%s", nph_test_temporary("moving.yaml"));
    write_volume(context, "k.0.npy", 1);
    write_volume(context, "k.5.npy", 5);
    FILE *file = fopen(path, "wb");
    ck_assert_ptr_nonnull(file);
    fputs(SMOKE("k.#.npy", "") "surfaces: [{plane: {frames: [0, 10], values: [-1, -2]}}]\n", file);
    ck_assert_int_eq(fclose(file), 0);
    ck_assert_int_eq(nph_scene_load(context, path, &first), NPH_OK);
    ck_assert_int_eq(nph_scene_load_frame(context, path, 5, &loaded), NPH_OK);
    ck_assert_int_eq(remove(path), 0);
    ck_assert(first->frame == 0 && loaded->frame == 5 && !same(first, loaded));
    NphScene *moved = at_frame(context, first, 5), *back = at_frame(context, moved, 0);
    ck_assert(same(moved, loaded) && same(back, first));
    ck_assert_str_eq(moved->name, "moving.yaml");
    ck_assert(moved->surfaces[0].height_m == -1.5 && moved->media[0].grid.max == 5);
    NphScene *const all[] = {first, loaded, moved, back};
    for (int i = 0; i < 4; i++) nph_scene_free(context, all[i]);
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_scene_without_a_text_has_one_frame) {
    NphContext *context = nph_test_context(1);
    static NphScene made;
    NphScene *other = NULL;
    ck_assert_int_eq(nph_scene_is_animated(&made), 0);
    ck_assert_int_eq(nph_scene_at_frame(context, &made, 1, &other), NPH_BAD_USAGE);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "made without a text"));
    nph_test_context_close(context);
}
END_TEST

START_TEST(thousands_of_keys_are_read_at_once) {
    enum { KEYS = 4096 };
    static char text[1 << 19];
    NphContext *context = nph_test_context(1);
    int used = snprintf(text, sizeof text, HEAD "surfaces: [{plane: {frames: [0");
    for (int i = 1; i < KEYS; i++) used += snprintf(text + used, sizeof text - (size_t)used, ", %d", 2 * i);
    used += snprintf(text + used, sizeof text - (size_t)used, "], values: [0");
    for (int i = 1; i < KEYS; i++) used += snprintf(text + used, sizeof text - (size_t)used, ", %d", i % 7);
    snprintf(text + used, sizeof text - (size_t)used, "]}}]\n");
    NphScene *first = parse(context, text);
    for (uint32_t frame = 8000; frame < 8010; frame++) {
        NphScene *other = at_frame(context, first, frame);
        ck_assert(other->surfaces[0].height_m == ((frame / 2) % 7 + ((frame + 1) / 2) % 7) / 2.0);
        nph_scene_free(context, other);
    }
    nph_scene_free(context, first);
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, a_frame_of_an_animated_scene_is_the_still_scene_with_its_values_written_out);
    tcase_add_test(cases, constant_values_give_the_still_scene_to_the_bit);
    tcase_add_test(cases, numbers_between_keys_stay_between_them);
    tcase_add_test(cases, what_is_wrong_at_one_frame_is_said_with_its_number);
    tcase_add_test(cases, a_run_of_hashes_is_the_number_of_the_frame);
    tcase_add_test(cases, a_frame_without_its_file_is_refused_with_file_and_frame);
    tcase_add_test(cases, a_sequence_sparser_than_frames_takes_the_last_file_not_ahead);
    tcase_add_test(cases, another_frame_of_a_scene_is_what_loading_it_gives_and_needs_no_file);
    tcase_add_test(cases, a_scene_without_a_text_has_one_frame);
    tcase_add_test(cases, thousands_of_keys_are_read_at_once);
}

int main(void) { return nph_test_main("scene_animated", fill); }
