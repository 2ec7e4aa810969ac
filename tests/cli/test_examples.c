/* SPDX-License-Identifier: Apache-2.0
 *
 * The programs of examples/: they do what their comments say. */
#include "cli/program.h"

static const char scene_text[] = "nephos: 1\n"
                                 "camera: {resolution: [20, 12], position: [0, -3, 0], look_at: [0, 0, 0], fov: 40}\n"
                                 "media:\n"
                                 "  - {box: [[-1, -1, -0.6], [1, 1, 0.6]], extinction: [2, 3, 4], albedo: 0.9}\n"
                                 "lights:\n"
                                 "  - {type: sun, direction: [1, -1, 2], irradiance: 3}\n"
                                 "render: {samples: 16}\n";

static const char *scene(void) {
    const char *path = file_of("scene.yaml");
    if (!exists(path)) write_text(path, scene_text);
    return path;
}

static const Ran *run_example(const char *name, const char *a, const char *b, const char *c) {
    char path[1024];
    const char *root = getenv("NEPHOS_PROGRAM_ROOT");
    snprintf(path, sizeof path, "%s/examples/example_%s", root ? root : "build", name);
    return program_finish(program_start_at(path, (const char *const[]){a, b, c, NULL}));
}

START_TEST(example_render_writes_the_file_that_the_program_writes) {
    RUN_EXPECT(0, "render", scene(), "-q", "--spp", "32", "-o", file_of("program.exr"));
    const Ran *run = run_example("render", scene(), file_of("example.exr"), "32");
    ck_assert_msg(run->status == 0, "%s%s", run->out, run->err);
    ck_assert_ptr_nonnull(strstr(run->out, "32 samples per pixel"));
    ck_assert(same_files(file_of("program.exr"), file_of("example.exr")));
    ck_assert_int_eq(run_example("render", scene(), file_of("own.exr"), NULL)->status, 0);
    ck_assert_msg(!same_files(file_of("own.exr"), file_of("example.exr")), "other samples gave the same file");
}
END_TEST

START_TEST(example_render_says_what_is_wrong_and_where) {
    write_text(file_of("wrong.yaml"), "nephos: 1\ncamera: {resolution: [20, 12], fov: 400}\n");
    const Ran *run = run_example("render", file_of("wrong.yaml"), file_of("none.exr"), NULL);
    ck_assert_int_eq(run->status, 3);
    ck_assert_ptr_nonnull(strstr(run->err, "wrong.yaml:2:"));
    ck_assert(!exists(file_of("none.exr")));
    ck_assert_int_eq(run_example("render", scene(), NULL, NULL)->status, 2);
    ck_assert_int_eq(run_example("render", scene(), file_of("none.exr"), "many")->status, 2);
}
END_TEST

START_TEST(example_compare_tells_same_from_different) {
    RUN_EXPECT(0, "render", scene(), "-q", "-o", file_of("a.exr"));
    const Ran *run = run_example("compare", file_of("a.exr"), file_of("a.exr"), NULL);
    ck_assert_msg(run->status == 0 && strstr(run->out, "same: ") == run->out, "%d %s%s", run->status, run->out, run->err);
    write_text(file_of("dark.yaml"), "nephos: 1\ncamera: {resolution: [20, 12], position: [0, -3, 0], look_at: [0, 0, 0], fov: 40}\n");
    RUN_EXPECT(0, "render", file_of("dark.yaml"), "-q", "-o", file_of("dark.exr"));
    run = run_example("compare", file_of("a.exr"), file_of("dark.exr"), NULL);
    ck_assert_msg(run->status == 1 && strstr(run->out, "different: ") == run->out, "%d %s%s", run->status, run->out, run->err);
    run = run_example("compare", file_of("a.exr"), file_of("none.exr"), NULL);
    ck_assert_int_eq(run->status, 4);
    ck_assert_ptr_nonnull(strstr(run->err, "none.exr"));
}
END_TEST

START_TEST(example_hybrid_puts_its_own_kernel_into_a_run) {
    const char *root = getenv("NEPHOS_SOURCE_ROOT");
    char cube[1024];
    snprintf(cube, sizeof cube, "%s/reference/scenes/cube_g070.yaml", root ? root : ".");
    const Ran *run = run_example("hybrid", cube, file_of("hybrid.exr"), "16");
    ck_assert_msg(run->status == 0 && strstr(run->out, "same: ") == run->out, "%d %s%s", run->status, run->out, run->err);
    char path[1024];
    root = getenv("NEPHOS_PROGRAM_ROOT");
    snprintf(path, sizeof path, "%s/examples/example_hybrid", root ? root : "build");
    run = program_finish(program_start_at(path, (const char *const[]){cube, file_of("hybrid.exr"), "16", "--mistake", NULL}));
    ck_assert_msg(run->status == 1, "%d %s%s", run->status, run->out, run->err);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, example_hybrid_puts_its_own_kernel_into_a_run);
    tcase_add_test(cases, example_render_writes_the_file_that_the_program_writes);
    tcase_add_test(cases, example_render_says_what_is_wrong_and_where);
    tcase_add_test(cases, example_compare_tells_same_from_different);
}

int main(void) { return nph_test_main("examples", fill); }
