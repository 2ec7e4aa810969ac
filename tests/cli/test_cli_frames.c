/* SPDX-License-Identifier: Apache-2.0
 *
 * --frame: every command that reads a scene takes it as of that frame. */
#include "cli/program.h"
#include "io/volume.h"

#define SCENE(box, sun, extinction)                                                                                 \
    "nephos: 1\n"                                                                                                   \
    "camera: {resolution: [24, 16], position: [0, -3, 0], look_at: [0, 0, 0], fov: 40}\n"                           \
    "media:\n- {box: " box ", extinction: " extinction ", albedo: 0.9}\n"                                            \
    "lights:\n- {type: sun, elevation: 30, azimuth: " sun ", irradiance: 3}\n- {type: constant, radiance: 0.2}\n"    \
    "render: {samples: 16}\n"

static const char moving[] = SCENE("{frames: [3, 11], values: [[[-1, -1, -0.5], [1, 1, 0.5]], [[-1, -1, -1.5], [0, 1, 0.5]]]}",
                                   "{frames: [0, 14], values: [-90, 90]}", "{frames: [7, 8], values: [[2, 3, 4], 9]}");
static const char seventh[] = SCENE("[[-1, -1, -1], [0.5, 1, 0.5]]", "0", "[2, 3, 4]"); /* moving, at frame 7 */

static const char *scene(const char *name, const char *text) {
    const char *path = file_of(name);
    if (!exists(path)) write_text(path, text);
    return path;
}

static const char *picture(const char *name, const char *path, const char *frame, const char *lock) {
    const char *file = file_of(name), *const words[] = {"render", path, "-q", "-o", file, "--frame", frame, lock, NULL};
    const Ran *run = program_run(words);
    ck_assert_msg(run->status == 0, "%s", run->err);
    return file;
}

START_TEST(a_frame_is_the_picture_of_the_scene_written_out) {
    const char *animated = scene("moving.yaml", moving), *still = scene("seventh.yaml", seventh);
    const char *there = picture("there.exr", animated, "7", NULL);
    ck_assert(same_files(there, picture("written.exr", still, "7", NULL)));
    ck_assert_msg(!same_files(there, picture("noise.exr", still, "6", NULL)), "the frame's noise is missing");
    ck_assert_msg(!same_files(there, picture("before.exr", animated, "6", NULL)), "the frame's scene is missing");
    const char *locked = picture("locked.exr", animated, "7", "--lock-noise");
    ck_assert(same_files(locked, picture("written.exr", still, "0", NULL)));
    ck_assert(!same_files(locked, picture("start.exr", animated, "0", NULL)));
}
END_TEST

/* The noise of frame 0 in the scene of frame 7 too. */
START_TEST(a_dump_of_a_frame_is_judged_by_the_scene_of_that_frame) {
    static const char *const locks[] = {NULL, "--lock-noise"};
    const char *animated = scene("moving.yaml", moving), *still = scene("seventh.yaml", seventh), *dump = file_of("dump");
    for (int i = 0; i < 2; i++) {
        char command[700];
        RUN_EXPECT(0, "render", animated, "-q", "-o", file_of("dumped.exr"), "--crop", "8,0,16,8", "--frame", "7", "--dump", dump, locks[i]);
        const Ran *run = RUN("verify", dump, dump, "--flips", "0");
        ck_assert_msg(run->status == 0 && strstr(run->out, "passed: "), "%s%s", run->out, run->err);
        RUN_EXPECT(0, "verify", dump, dump, "--flips", "0", "--scene", still, "-q");
        RUN_EXPECT(0, "stage", "path.track", "--from", dump, "--launch", "0:1", "-q", "-o", file_of("ours"));
        RUN_EXPECT(0, "stage", "path.track", "--from", dump, "--launch", "0:1", "--scene", still, "-q", "-o", file_of("written"));
        ck_assert(same_files(file_of("ours/path.distance.npy"), file_of("written/path.distance.npy")));
        run = RUN("info", dump, "--json");
        ck_assert_ptr_nonnull(strstr(run->out, i ? "\"frame\": 0,\n  \"scene_frame\": 7" : "\"frame\": 7,\n"));
#ifdef NPH_HAVE_BUGGED
        if (i == 1) RUN_EXPECT(0, "verify", dump, dump, "-q"); /* measures tolerances */
#endif
        snprintf(command, sizeof command, "rm -rf '%s'", dump);
        ck_assert_int_eq(system(command), 0);
    }
}
END_TEST

/* A scene of which only frame 7 is there: who loads another one fails. */
START_TEST(every_command_takes_the_frame) {
    NphContext *context = nph_test_context(1);
    NphArray array = {0};
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 3, (int64_t[]){2, 2, 2}, "array", &array), NPH_OK);
    for (int i = 0; i < 8; i++) ((float *)array.data)[i] = 1;
    ck_assert_int_eq(nph_npy_write(context, file_of("smoke.0007.npy"), &array), NPH_OK);
    nph_array_free(context, &array);
    nph_test_context_close(context);
    const char *path = scene("smoke.yaml", "nephos: 1\ncamera: {resolution: [16, 16], position: [0, -3, 0], look_at: [0, 0, 0], fov: 40}\n"
                                           "media:\n- {density: {file: smoke.####.npy, box: [[-1, -1, -1], [1, 1, 1]]}, extinction: 2}\n"
                                           "lights:\n- {type: constant, radiance: 1}\n");
    const char *exr = file_of("smoke.exr"), *out = file_of("stage");
    RUN_EXPECT(4, "plan", path, "--frame", "6");
    RUN_EXPECT(0, "plan", path, "--frame", "7");
    RUN_EXPECT(0, "render", path, "-q", "-o", exr, "--spp", "16", "-f", "7");
    RUN_EXPECT(0, "render", path, "--only", "7,8,8,0");
    RUN_EXPECT(4, "render", path, "--only", "0,8,8,0", "--frame", "7");
    RUN_EXPECT(0, "bench", path, "--spp", "16", "--repeat", "1", "--frame", "7");
    RUN_EXPECT(0, "stage", "path.generate", "--scene", path, "--frame", "7", "--set", "tile=0", "--spp", "16", "-q", "-o", out);
    const Ran *run = RUN("info", path, "--frame", "7", "--json");
    ck_assert_msg(run->status == 0 && strstr(run->out, "\"animated_at_frame\": 7"), "%s%s", run->out, run->err);
    RUN_EXPECT(2, "info", exr, "--frame", "7");
#ifdef NPH_HAVE_BUGGED
    RUN_EXPECT(0, "tolerance", path, "--frame", "7", "-o", file_of("tolerances.json"), "-q");
    RUN_EXPECT(0, "diagnose", "--show", "one_over_4_pi", path, "--frame", "7", "--spp", "16", "-q", "-o", exr);
#endif
}
END_TEST

START_TEST(info_tells_the_state_at_a_frame) {
    const Ran *run = RUN("info", scene("moving.yaml", moving), "--frame", "9", "--json");
    ck_assert_msg(run->status == 0 && strstr(run->out, "\"bounds_min_m\": [-1, -1, -1.25]"), "%s%s", run->out, run->err);
    ck_assert_ptr_nonnull(strstr(run->out, "\"animated_at_frame\": 9"));
    ck_assert_ptr_null(strstr(RUN("info", scene("seventh.yaml", seventh), "--json")->out, "animated"));
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, a_frame_is_the_picture_of_the_scene_written_out);
    tcase_add_test(cases, a_dump_of_a_frame_is_judged_by_the_scene_of_that_frame);
    tcase_add_test(cases, every_command_takes_the_frame);
    tcase_add_test(cases, info_tells_the_state_at_a_frame);
}

int main(void) { return nph_test_main("cli_frames", fill); }
