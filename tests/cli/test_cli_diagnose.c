/* SPDX-License-Identifier: Apache-2.0
 *
 * nephos diagnose: bugs planted by --show with one seed are named first by a search with another; scripts/diagnose_matrix does
 * the same for all bugs in cloud, lamp and cumulus of this folder, docs/diagnose.md holds its table. */
#include <math.h>
#include <signal.h>

#include "cli/program.h"
#include "nephos/image.h"

static char scene[600], picture[600];

/* The text with every `from` replaced. */
static void replace(char *text, size_t size, const char *from, const char *to) {
    static char made[PROGRAM_OUTPUT];
    made[0] = 0;
    const char *at = text, *found;
    while ((found = strstr(at, from)) != NULL) {
        ck_assert_uint_lt(strlen(made) + (size_t)(found - at) + strlen(to) + strlen(at), sizeof made);
        strncat(made, at, (size_t)(found - at));
        strcat(made, to);
        at = found + strlen(from);
    }
    ck_assert_msg(at != text, "no '%s' in the scene", from);
    strcat(made, at);
    ck_assert_uint_lt(strlen(made), size);
    strcpy(text, made);
}

/* A scene of tests/cli/diagnose in a folder where its files are found, and one thing of it changed. */
static void take_scene(const char *name, const char *from, const char *to) {
    static char text[PROGRAM_OUTPUT], root[600];
    char path[100];
    snprintf(path, sizeof path, "tests/cli/diagnose/%s.yaml", name);
    program_read(nph_test_path(path), text);
    snprintf(root, sizeof root, "%s", nph_test_path("reference"));
    if (strstr(text, "../../../reference")) replace(text, sizeof text, "../../../reference", root);
    if (from) replace(text, sizeof text, from, to);
    snprintf(path, sizeof path, "%s.yaml", name);
    snprintf(scene, sizeof scene, "%s", file_of(path));
    snprintf(picture, sizeof picture, "%s", file_of("a.exr"));
    write_text(scene, text);
}

static void plant(const char *bug, const char *samples) {
    RUN_EXPECT(0, "diagnose", "--show", bug, scene, "-o", picture, "--spp", samples, "--seed", "5", "-q");
}

/* The headline of a wrong picture's diagnosis. */
static void expect_first(const char *bug) {
    char line[200];
    const Ran *run = RUN("diagnose", picture, scene);
    snprintf(line, sizeof line, " looks like %s\n", bug);
    ck_assert_msg(run->status == 1 && strncmp(run->out, "wrong: ", 7) == 0 && strstr(run->out, line), "%d, not %s, but:\n%s%s",
                  run->status, bug, run->out, run->err);
}

/* Plants each and has it found, in a scene that is made smaller. */
static void expect_each(const char *name, const char *from, const char *to, const char *const *bugs) {
    take_scene(name, from, to);
    for (; *bugs; bugs++) {
        plant(*bugs, "64");
        expect_first(*bugs);
    }
}

START_TEST(a_planted_bug_is_named_first) {
    if (!has_altered()) return;
    expect_each("cube", "[40, 40]", "[24, 24]",
                (const char *const[]){"one_over_4_pi", "albedo_twice", "albedo_never", "sigma_s_for_sigma_t", "upside_down", NULL});
}
END_TEST

START_TEST(bugs_are_named_first_in_each_of_the_three_scenes) {
    if (!has_altered() || !nph_test_statistics("bugs in grids")) return;
    expect_each("cloud", "[32, 32]", "[16, 16]", (const char *const[]){"axes_swapped", NULL});
    expect_each("lamp", "[32, 32]", "[16, 16]", (const char *const[]){"cosine_sign", NULL});
    expect_each("cumulus", "[32, 32]", "[16, 16]", (const char *const[]){"one_pdf_for_all", NULL});
}
END_TEST

START_TEST(a_right_picture_has_none) {
    if (!has_altered()) return;
    take_scene("cube", "[40, 40]", "[24, 24]");
    RUN_EXPECT(0, "render", scene, "-o", picture, "--spp", "128", "--seed", "5", "-q");
    const Ran *run = RUN("diagnose", picture, scene);
    ck_assert_msg(run->status == 0 && strncmp(run->out, "none: ", 6) == 0, "%d: %s", run->status, run->out);
    ck_assert_ptr_nonnull(strstr(run->out, "A's error bars: its own"));
    ck_assert_ptr_nonnull(strstr(run->out, "cannot show in this scene: virtual_weight, "));
    char one_thread[8192];
    run = RUN("diagnose", picture, scene, "--json", "-q", "-t", "1");
    ck_assert_ptr_nonnull(strstr(run->out, "\"verdict\": \"none\""));
    ck_assert_uint_lt(strlen(run->out), sizeof one_thread);
    strcpy(one_thread, run->out);
    ck_assert_str_eq(RUN("diagnose", picture, scene, "--json", "-q", "-t", "3")->out, one_thread);
    /* the seed of the search is another one when A has it */
    RUN_EXPECT(0, "render", scene, "-o", picture, "--spp", "32", "--seed", "1936946035", "-q");
    ck_assert_ptr_nonnull(strstr(RUN("diagnose", picture, scene)->out, "of seed 1936946036"));
}
END_TEST

START_TEST(what_no_bug_explains_is_none_of_the_known_ones) {
    if (!has_altered()) return;
    take_scene("cube", "albedo: 0.6", "albedo: 0.7");
    RUN_EXPECT(0, "render", scene, "-o", picture, "--spp", "256", "--seed", "5", "-q");
    take_scene("cube", NULL, NULL);
    const Ran *run = RUN("diagnose", picture, scene);
    ck_assert_msg(run->status == 1 && strncmp(run->out, "none of the known ones: ", 24) == 0, "%d: %s", run->status, run->out);
    ck_assert_ptr_nonnull(strstr(run->out, "nearest: "));
}
END_TEST

/* A picture as another renderer writes it: R, G, B alone, times a factor. */
static void strip(double factor) {
    static const char *const names[3] = {"R", "G", "B"};
    NphContext *context = nph_test_context(1);
    NphImage image, bare;
    ck_assert_int_eq(nph_exr_read(context, picture, &image), NPH_OK);
    ck_assert_int_eq(nph_image_new(context, image.width, image.height, &bare), NPH_OK);
    for (int c = 0; c < 3; c++) {
        float *plane;
        ck_assert_int_eq(nph_image_add_channel(context, &bare, names[c], &plane), NPH_OK);
        for (int i = 0; i < image.width * image.height; i++) plane[i] = (float)(factor * (double)nph_image_channel(&image, names[c])->pixels[i]);
    }
    ck_assert_int_eq(nph_exr_write(context, picture, &bare), NPH_OK);
    nph_image_free(context, &image);
    nph_image_free(context, &bare);
    nph_test_context_close(context);
}

START_TEST(a_picture_without_error_bars_is_diagnosed_too) {
    if (!has_altered()) return;
    take_scene("cube", NULL, NULL);
    RUN_EXPECT(0, "render", scene, "-o", picture, "--spp", "64", "--seed", "5", "-q");
    strip(1.0);
    const Ran *run = RUN("diagnose", picture, scene, "--spp", "128");
    ck_assert_msg(run->status == 0 && strncmp(run->out, "none: ", 6) == 0, "%d: %s", run->status, run->out);
    ck_assert_ptr_nonnull(strstr(run->out, "A's error bars: none"));
    RUN_EXPECT(0, "diagnose", picture, scene, "--a-samples", "64");
    strip(3.14159265358979);
    run = RUN("diagnose", picture, scene);
    ck_assert_msg(run->status == 1 && strstr(run->out, "looks like a factor 3.1") && strstr(run->out, ": pi\n"), "%s", run->out);
    plant("albedo_twice", "64");
    strip(1.0);
    expect_first("albedo_twice");
}
END_TEST

START_TEST(what_cannot_be_diagnosed_is_refused) {
    if (!has_altered()) return;
    take_scene("cube", NULL, NULL);
    ck_assert_ptr_nonnull(strstr(RUN("diagnose", "--list")->out, "\n  31  forced_collision "));
    RUN_EXPECT(2, "diagnose");
    RUN_EXPECT(2, "diagnose", scene);
    RUN_EXPECT(2, "diagnose", "--show", "32", scene, "-o", picture);
    RUN_EXPECT(2, "diagnose", "--show", "four_pi", scene, "-o", picture);
    RUN_EXPECT(2, "diagnose", "--show", "4", scene);
    RUN_EXPECT(2, "diagnose", picture, scene, "-o", picture);
    RUN_EXPECT(4, "diagnose", file_of("there_is_none.exr"), scene);
    RUN_EXPECT(0, "render", scene, "-o", picture, "--spp", "16", "-q");
    RUN_EXPECT(3, "diagnose", picture, file_of("there_is_none.yaml"));
    RUN_EXPECT(5, "diagnose", "--show", "4", scene, "-o", "/dev/null/a.exr");
    take_scene("cube", "[40, 40]", "[40, 32]");
    const Ran *run = RUN("diagnose", picture, scene);
    ck_assert_msg(run->status == 4 && strstr(run->err, "40 x 40") && strstr(run->err, "renders 40 x 32"), "%d: %s", run->status, run->err);
}
END_TEST

START_TEST(an_interrupted_diagnosis_has_no_verdict) {
    if (!has_altered()) return;
    take_scene("cube", "[40, 40]", "[256, 256]");
    RUN_EXPECT(0, "render", scene, "-o", picture, "--spp", "16", "-q");
    pid_t child = program_start((const char *const[]){"diagnose", picture, scene, "--spp", "65536", NULL});
    sleep(1);
    ck_assert_int_eq(kill(child, SIGINT), 0);
    const Ran *run = program_finish(child);
    ck_assert_msg(run->status == 75 && run->out[0] == 0 && strstr(run->err, "interrupted: no verdict"), "%d: %s%s", run->status, run->out, run->err);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, a_planted_bug_is_named_first);
    tcase_add_test(cases, bugs_are_named_first_in_each_of_the_three_scenes);
    tcase_add_test(cases, a_right_picture_has_none);
    tcase_add_test(cases, what_no_bug_explains_is_none_of_the_known_ones);
    tcase_add_test(cases, a_picture_without_error_bars_is_diagnosed_too);
    tcase_add_test(cases, what_cannot_be_diagnosed_is_refused);
    tcase_add_test(cases, an_interrupted_diagnosis_has_no_verdict);
}

int main(void) { return nph_test_main("cli_diagnose", fill); }
