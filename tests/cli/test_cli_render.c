/* SPDX-License-Identifier: Apache-2.0
 *
 * The program end to end on a scene small enough to be rendered many times. */
#include <signal.h>
#include <time.h>

#include "cli/program.h"

static const char scene_text[] = "nephos: 1\n"
                                 "camera: {type: perspective, resolution: [40, 24], position: [0, -3, 0], "
                                 "look_at: [0, 0, 0], fov: 40}\n"
                                 "media:\n"
                                 "  - box: [[-1, -1, -0.6], [1, 1, 0.6]]\n"
                                 "    extinction: [2, 3, 4]\n"
                                 "    albedo: 0.9\n"
                                 "    phase: {type: hg, g: 0.6}\n"
                                 "lights:\n"
                                 "  - {type: sun, direction: [1, -1, 2], irradiance: 3}\n"
                                 "  - {type: constant, radiance: [0.1, 0.2, 0.4]}\n"
                                 "render: {samples: 32}\n";

static const char *scene(void) {
    const char *path = file_of("scene.yaml");
    if (!exists(path)) write_text(path, scene_text);
    return path;
}

/* Renders with some more arguments to a file of the temporary folder. */
static const char *picture(const char *name, const char *a, const char *b, const char *c, const char *d) {
    const char *path = file_of(name);
    const char *words[] = {"render", scene(), "--quiet", "-o", path, a, b, c, d, NULL};
    const Ran *run = program_run(words);
    ck_assert_msg(run->status == 0 && !*run->out && !*run->err, "%s: status %d\n%s%s", name, run->status, run->out, run->err);
    return path;
}

START_TEST(any_number_of_threads_gives_the_same_file) {
    picture("t1.exr", "--threads", "1", NULL, NULL);
    static const char *const counts[] = {"2", "3", "7"};
    for (int i = 0; i < 3; i++)
        ck_assert(same_files(file_of("t1.exr"), picture("tn.exr", "--threads", counts[i], NULL, NULL)));
    ck_assert_msg(!same_files(file_of("t1.exr"), picture("seed.exr", "--seed", "9", NULL, NULL)),
                  "another seed gave the same file: the comparison sees nothing");
}
END_TEST

START_TEST(sample_ranges_merge_to_the_file_of_one_run) {
    picture("whole.exr", "--spp", "64", NULL, NULL);
    const char *first = picture("1.part", "--part", "--samples", "0:32", NULL);
    const char *second = picture("2.part", "--part", "--samples", "32:64", NULL);
    const char *merged = file_of("merged.exr");
    RUN_EXPECT(0, "merge", second, first, "-o", merged);
    ck_assert(same_files(file_of("whole.exr"), merged));
    RUN_EXPECT(4, "merge", first, first, "-o", file_of("twice.exr"));
    ck_assert(!exists(file_of("twice.exr")));
}
END_TEST

START_TEST(crops_merge_to_the_file_of_one_run) {
    picture("all.exr", NULL, NULL, NULL, NULL);
    const char *left = picture("left.part", "--part", "--crop", "0,0,19,24", NULL);
    const char *right = picture("right.part", "--part", "--crop", "19,0,40,24", NULL);
    const char *merged = file_of("crops.exr");
    RUN_EXPECT(0, "merge", left, right, "-o", merged, "--png");
    ck_assert(same_files(file_of("all.exr"), merged));
    ck_assert(exists(file_of("crops.png")));
    RUN_EXPECT(4, "merge", left, picture("seed.part", "--part", "--crop=19,0,40,24", "--seed", "3"), "-o", merged);
}
END_TEST

START_TEST(a_picture_is_the_same_as_itself_and_different_from_a_brighter_one) {
    const char *path = picture("self.exr", "--spp", "16", NULL, NULL);
    RUN_EXPECT(0, "compare", path, path);
    const Ran *run = RUN("compare", path, path, "--json");
    ck_assert_int_eq(run->status, 0);
    ck_assert_ptr_nonnull(strstr(run->out, "\"verdict\": \"same\""));

    char bright[sizeof scene_text];
    memcpy(bright, scene_text, sizeof bright);
    *strstr(bright, "irradiance: 3") = ' ';
    char *value = strstr(bright, "rradiance: 3");
    memcpy(value - 1, "irradiance: 6", 13);
    const char *bright_scene = file_of("bright.yaml"), *other = file_of("bright.exr");
    write_text(bright_scene, bright);
    RUN_EXPECT(0, "render", bright_scene, "-o", other, "--spp", "16", "--quiet");
    run = RUN("compare", path, other, "--z-map", file_of("z.exr"));
    ck_assert_int_eq(run->status, 1);
    ck_assert_ptr_nonnull(strstr(run->out, "different: "));
    RUN_EXPECT(0, "info", file_of("z.exr"));
}
END_TEST

START_TEST(info_reads_what_render_wrote) {
    const char *path = picture("info.exr", "--png", "--seed", "77", NULL);
    ck_assert(exists(file_of("info.png")));
    const Ran *run = RUN("info", path, "--json");
    ck_assert_int_eq(run->status, 0);
    ck_assert_ptr_nonnull(strstr(run->out, "\"size\": [40, 24]"));
    ck_assert_ptr_nonnull(strstr(run->out, "\"name\": \"Variance.G\""));
    ck_assert_ptr_nonnull(strstr(run->out, "\"relative_error\""));
    ck_assert_ptr_nonnull(strstr(run->out, "77"));
    RUN_EXPECT(0, "info", scene());
    ck_assert_ptr_nonnull(strstr(RUN("info", scene(), "--json")->out, "\"perspective\""));
    run = RUN("info", picture("info.part", "--part", "--samples", "16:48", NULL), "--json");
    ck_assert_int_eq(run->status, 0);
    ck_assert_ptr_nonnull(strstr(run->out, "\"samples_max\": 32"));
}
END_TEST

START_TEST(statistics_go_to_their_own_file_and_never_into_the_picture) {
    const char *stats = file_of("stats.json");
    static char text[PROGRAM_OUTPUT];
    picture("stats.exr", "--stats", stats, "--threads", "2");
    program_read(stats, text);
    static const char *const members[] = {"\"seconds\"", "\"cpu_seconds\"", "\"stages\"", "\"threads\": 2", "\"date\"",
                                          "\"samples_per_pixel\": 32", "\"relative_error\""};
    for (size_t i = 0; i < sizeof members / sizeof *members; i++)
        ck_assert_msg(strstr(text, members[i]) != NULL, "no %s in\n%s", members[i], text);
    const Ran *run = RUN("render", scene(), "-o", file_of("json.exr"), "--json");
    ck_assert_int_eq(run->status, 0);
    ck_assert_int_eq(run->out[0], '{');
    ck_assert(same_files(file_of("stats.exr"), file_of("json.exr")));
}
END_TEST

START_TEST(plan_and_knobs_are_told) {
    const Ran *run = RUN("plan", scene());
    ck_assert_int_eq(run->status, 0);
    ck_assert_ptr_nonnull(strstr(run->out, "stage"));
    ck_assert_ptr_nonnull(strstr(run->out, "left out"));
    ck_assert_ptr_nonnull(strstr(run->out, "all memory"));
    run = RUN("plan", scene(), "--json", "--plan", "full");
    ck_assert_int_eq(run->status, 0);
    ck_assert_int_eq(run->out[0], '{');
    run = RUN("plan", "--knobs");
    ck_assert_int_eq(run->status, 0);
    ck_assert_ptr_nonnull(strstr(run->out, "path."));
}
END_TEST

START_TEST(one_path_is_followed_event_by_event) {
    const Ran *run = RUN("render", scene(), "--only", "0,20,12,5");
    ck_assert_int_eq(run->status, 0);
    ck_assert_int_gt((int)strlen(run->out), 20);
    static char first[PROGRAM_OUTPUT];
    memcpy(first, run->out, sizeof first);
    ck_assert_str_eq(RUN("render", scene(), "--only=0,20,12,5")->out, first);
    ck_assert_str_ne(RUN("render", scene(), "--only", "0,20,12,6")->out, first);
    ck_assert_int_eq(RUN("render", scene(), "--only", "0,40,12,5")->status, 2); /* beyond the picture */
}
END_TEST

START_TEST(a_bad_scene_is_named_by_line_and_leaves_no_file) {
    const char *bad = file_of("bad.yaml"), *out = file_of("bad.exr");
    write_text(bad, "nephos: 1\ncamera: {type: perspective, resolution: [8, 8], position: [0, 0, 0], look_at: [0, 1, 0], "
                    "fov: 30}\nmedai: []\n");
    const Ran *run = RUN("render", bad, "-o", out, "--png");
    ck_assert_int_eq(run->status, 3);
    ck_assert_ptr_nonnull(strstr(run->err, "bad.yaml:3:1"));
    ck_assert_ptr_nonnull(strstr(run->err, "media"));
    ck_assert(!exists(out));
    ck_assert(!exists(file_of("bad.png")));
    run = RUN("render", file_of("none.yaml"), "-o", out);
    ck_assert_msg(run->status == 3 || run->status == 4, "status %d\n%s", run->status, run->err);
    ck_assert_int_eq(RUN("plan", bad)->status, 3);
}
END_TEST

START_TEST(outputs_that_cannot_be_written_are_refused_before_the_work) {
    ck_assert_int_eq(RUN("render", scene(), "--spp", "1000000000", "-o", "/nowhere/at/all.exr")->status, 5);
    ck_assert_int_eq(RUN("render", scene(), "--spp", "1000000000", "-o", file_of("x.exr"), "--stats",
                         "/nowhere/s.json")->status, 5);
    ck_assert(!exists(file_of("x.exr")));
}
END_TEST

START_TEST(a_memory_limit_is_kept_to_by_refusing) {
    const Ran *run = RUN("render", scene(), "--memory-limit", "20k", "-o", file_of("m.exr"));
    ck_assert_msg(run->status == 6, "status %d\n%s", run->status, run->err);
    ck_assert(!exists(file_of("m.exr")));
}
END_TEST

START_TEST(an_unknown_knob_or_method_is_refused) {
    ck_assert_int_eq(RUN("render", scene(), "-o", file_of("k.exr"), "-D", "path.nothing=1")->status, 2);
    ck_assert_int_eq(RUN("render", scene(), "-o", file_of("k.exr"), "-Dpath")->status, 2);
    ck_assert_int_eq(RUN("render", scene(), "-o", file_of("k.exr"), "--method", "magic")->status, 2);
    ck_assert(!exists(file_of("k.exr")));
}
END_TEST

START_TEST(the_target_error_is_reached_with_a_power_of_two_of_samples) {
    const Ran *run = RUN("render", scene(), "-o", file_of("e.exr"), "--target-error", "0.01", "--json");
    ck_assert_int_eq(run->status, 0);
    ck_assert_ptr_nonnull(strstr(run->out, "\"target_error_reached\": true"));
    const char *samples = strstr(run->out, "\"samples_per_pixel\": ");
    long count = strtol(samples + 21, NULL, 10);
    ck_assert_msg(count >= 16 && (count & (count - 1)) == 0, "%ld samples", count);
    char text[32];
    snprintf(text, sizeof text, "%ld", count);
    ck_assert(same_files(file_of("e.exr"), picture("n.exr", "--spp", text, NULL, NULL)));
}
END_TEST

START_TEST(an_interrupted_run_writes_a_whole_picture_and_exits_with_75) {
    const char *out = file_of("stopped.exr");
    const Ran *run = NULL;
    /* a machine under load may take a while to the first samples; then it is tried again with more patience */
    for (int seconds = 1; seconds <= 32 && !exists(out); seconds *= 2) {
        struct timespec wait = {seconds, 0};
        pid_t child = program_start((const char *const[]){"render", scene(), "--spp", "100000000", "-o", out, NULL});
        nanosleep(&wait, NULL);
        kill(child, SIGINT);
        run = program_finish(child);
        ck_assert_msg(run->status == 75, "status %d\n%s%s", run->status, run->out, run->err);
        ck_assert_ptr_nonnull(strstr(run->err, "interrupted"));
    }
    run = RUN("info", out, "--json");
    ck_assert_msg(run->status == 0 && strstr(run->out, "\"N\""), "%s%s", run->out, run->err);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, any_number_of_threads_gives_the_same_file);
    tcase_add_test(cases, sample_ranges_merge_to_the_file_of_one_run);
    tcase_add_test(cases, crops_merge_to_the_file_of_one_run);
    tcase_add_test(cases, a_picture_is_the_same_as_itself_and_different_from_a_brighter_one);
    tcase_add_test(cases, info_reads_what_render_wrote);
    tcase_add_test(cases, statistics_go_to_their_own_file_and_never_into_the_picture);
    tcase_add_test(cases, plan_and_knobs_are_told);
    tcase_add_test(cases, one_path_is_followed_event_by_event);
    tcase_add_test(cases, a_bad_scene_is_named_by_line_and_leaves_no_file);
    tcase_add_test(cases, outputs_that_cannot_be_written_are_refused_before_the_work);
    tcase_add_test(cases, a_memory_limit_is_kept_to_by_refusing);
    tcase_add_test(cases, an_unknown_knob_or_method_is_refused);
    tcase_add_test(cases, the_target_error_is_reached_with_a_power_of_two_of_samples);
    tcase_add_test(cases, an_interrupted_run_writes_a_whole_picture_and_exits_with_75);
}

int main(void) { return nph_test_main("cli_render", fill); }
