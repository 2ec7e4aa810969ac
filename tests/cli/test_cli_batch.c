/* SPDX-License-Identifier: Apache-2.0
 *
 * nephos batch: each frame is the picture that render gives it, under its own name; what is cut short has another. */
#include <signal.h>
#include <time.h>

#include "cli/program.h"

static const char text[] = "nephos: 1\n"
                           "camera: {resolution: [24, 16], position: {frames: [0, 9], values: [[0, -3, 0], [1, -3, 0.4]]}, look_at: [0, 0, 0], fov: 40}\n"
                           "media:\n- {box: [[-1, -1, -1], [1, 1, 1]], extinction: {frames: [0, 9], values: [2, 3]}, albedo: 0.9}\n"
                           "lights:\n- {type: sun, elevation: {frames: [0, 9], values: [30, 60]}, azimuth: 20, irradiance: 3}\n- {type: constant, radiance: 0.2}\n"
                           "render: {samples: 16}\n";

static const char *scene(void) {
    const char *path = file_of("moving.yaml");
    if (!exists(path)) write_text(path, text);
    return path;
}

START_TEST(each_frame_is_the_picture_that_render_gives_it) {
    static const char *const methods[][3] = {{"path", "path.roulette=0.1", NULL}, {"temporal_photons", "tpm.photons=400", "tpm.generations=3"}};
    for (int m = 0; m < 2; m++) {
        const char *const *with = methods[m], *generations = with[2] ? with[2] : with[1];
        const Ran *run = RUN("batch", scene(), "--frames", "2-8", "--step", "3", "-m", with[0], "-D", with[1], "-D", generations, "-o", file_of("a.###.exr"), "--png");
        ck_assert_msg(run->status == 0, "%s%s", run->out, run->err);
        for (int frame = 2; frame <= 8; frame += 3) {
            char name[32], number[8], line[64];
            snprintf(name, sizeof name, "a.%03d.exr", frame);
            snprintf(number, sizeof number, "%d", frame);
            snprintf(line, sizeof line, "frame %d  ", frame);
            ck_assert_ptr_nonnull(strstr(run->out, line));
            ck_assert(exists(file_of(name)));
        }
        for (int frame = 2; frame <= 8; frame += 3) {
            char name[32], number[8];
            snprintf(name, sizeof name, "a.%03d.exr", frame);
            snprintf(number, sizeof number, "%d", frame);
            RUN_EXPECT(0, "render", scene(), "--frame", number, "-m", with[0], "-D", with[1], "-D", generations, "-q", "-o", file_of("b.exr"));
            ck_assert_msg(same_files(file_of(name), file_of("b.exr")), "%s: frame %d differs", with[0], frame);
            ck_assert_int_eq(unlink(file_of(name)), 0);
            snprintf(name, sizeof name, "a.%03d.png", frame);
            ck_assert_int_eq(unlink(file_of(name)), 0);
        }
        ck_assert(!exists(file_of("a.003.exr")));
    }
}
END_TEST

START_TEST(names_and_frames_that_cannot_be_are_refused_before_the_work) {
    static const struct {
        const char *frames, *name, *says;
        int status;
    } wrong[] = {
        {NULL, "a.##.exr", "which frames? --frames A-B", 2},
        {"5-3", "a.##.exr", "--frames 5-3: expected A-B", 2},
        {"x", "a.##.exr", "--frames x: expected A-B", 2},
        {"-1-3", "a.##.exr", "--frames -1-3: expected A-B", 2},
        {"0-16777216", "a.##.exr", "expected A-B", 2},
        {"0-3", "a.exr", "expected one run of #", 2},
        {"0-3", "a#.##.exr", "expected one run of #", 2},
        {"0-3", "a.##.png", "the picture is OpenEXR", 2},
        {"0-3", "/no/such/folder/a.##.exr", "/no/such/folder/a.00.exr", 5},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        const char *name = wrong[i].name[0] == '/' ? wrong[i].name : file_of(wrong[i].name);
        const Ran *run = wrong[i].frames ? RUN("batch", scene(), "-o", name, "--frames", wrong[i].frames) : RUN("batch", scene(), "-o", name);
        ck_assert_msg(run->status == wrong[i].status && strstr(run->err, wrong[i].says), "%zu: %d %s", i, run->status, run->err);
    }
    const Ran *run = RUN("batch", scene(), "--frames", "0-3");
    ck_assert_msg(run->status == 2 && strstr(run->err, "where to? -o OUT.####.exr"), "%s", run->err);
    run = RUN("batch", scene(), "--frames", "0-3", "--frame", "2", "-o", file_of("a.#.exr"));
    ck_assert_msg(run->status == 2 && strstr(run->err, "a batch takes --frames"), "%s", run->err);
    run = RUN("batch", "/no/such/scene.yaml", "--frames", "0-3", "-o", file_of("a.#.exr"));
    ck_assert_int_ne(run->status, 0);
    ck_assert(!exists(file_of("a.0.exr")));
}
END_TEST

/* A frame that cannot be made ends the batch; those before it stay. */
START_TEST(a_frame_that_fails_ends_the_batch_and_is_named) {
    char bad[1024];
    snprintf(bad, sizeof bad, "%s", text);
    memcpy(strstr(bad, "values: [2, 3]"), "values: [0, 3]", 14);
    write_text(file_of("dark.yaml"), bad);
    const Ran *run = RUN("batch", file_of("dark.yaml"), "--frames", "0-3", "-m", "temporal_photons", "-D", "tpm.photons=400", "-D", "tpm.generations=2", "-q", "-o",
                         file_of("d.#.exr"));
    ck_assert_msg(run->status == 2 && strstr(run->err, "frame 0: no picture") && strstr(run->err, "tpm.reference"), "%d %s", run->status, run->err);
    run = RUN("batch", file_of("dark.yaml"), "--frames", "0-3", "-m", "temporal_photons", "-D", "tpm.photons=400", "-D", "tpm.reference=3", "-q", "-o", file_of("d.#.exr"));
    ck_assert_msg(run->status == 0, "%s", run->err);
    ck_assert(exists(file_of("d.3.exr")));
}
END_TEST

START_TEST(an_interrupted_frame_has_a_name_of_its_own) {
    const Ran *run = NULL;
    for (int seconds = 1; seconds <= 32 && !exists(file_of("s.5.partial.exr")); seconds *= 2) {
        struct timespec wait = {seconds, 0};
        pid_t child = program_start((const char *const[]){"batch", scene(), "--frames", "5-7", "--spp", "100000000", "-o", file_of("s.#.exr"), NULL});
        nanosleep(&wait, NULL);
        kill(child, SIGINT);
        run = program_finish(child);
        ck_assert_msg(run->status == 75, "status %d\n%s%s", run->status, run->out, run->err);
        ck_assert_ptr_nonnull(strstr(run->err, "interrupted in frame 5"));
    }
    ck_assert(exists(file_of("s.5.partial.exr")));
    ck_assert(!exists(file_of("s.5.exr")) && !exists(file_of("s.6.exr")));
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, each_frame_is_the_picture_that_render_gives_it);
    tcase_add_test(cases, names_and_frames_that_cannot_be_are_refused_before_the_work);
    tcase_add_test(cases, a_frame_that_fails_ends_the_batch_and_is_named);
    tcase_add_test(cases, an_interrupted_frame_has_a_name_of_its_own);
}

int main(void) { return nph_test_main("cli_batch", fill); }
