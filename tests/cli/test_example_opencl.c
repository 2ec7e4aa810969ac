/* SPDX-License-Identifier: Apache-2.0
 *
 * examples/opencl: what the device makes of a dump is the reference's, and each mistake that it can be told to make is found by
 * verify where it was made. Skipped where there is no OpenCL. */
#include <math.h>

#include "cli/program.h"
#include "nephos/scene.h"
#include "nephos/verify.h"

static const char thin_text[] = "nephos: 1\n"
                                "camera: {resolution: [16, 16], position: [-2, -1.5, 1.2], look_at: [0.5, 0.5, 0.5], fov: 40}\n"
                                "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 0.02, albedo: 0.95, phase: {type: hg, g: 0.8}}\n"
                                "lights:\n  - {type: sun, direction: [-1, 0.2, 0.3], irradiance: 3}\n";

/* A grid under constant light, whose flights are weighed; a box under a sun; one whose camera rays are split. */
typedef struct Scene {
    const char *path, *crop;
    int stages; /* path.track alone, or path.majorant too */
} Scene;
static const Scene scenes[] = {{"reference/scenes/smoke.yaml", "192,144,208,160", 2},
                               {"reference/scenes/cube_g070.yaml", "112,112,128,128", 1},
                               {NULL, "0,0,16,16", 1}};
enum { SMOKE };

static char reference[600], mine[600], scene[1200];

static void make_dump(const Scene *what) {
    snprintf(reference, sizeof reference, "%s", file_of("reference"));
    snprintf(mine, sizeof mine, "%s", file_of("mine"));
    if (what->path) snprintf(scene, sizeof scene, "%s", nph_test_path(what->path));
    else {
        snprintf(scene, sizeof scene, "%s", file_of("thin.yaml"));
        write_text(scene, thin_text);
    }
    RUN_EXPECT(0, "render", scene, "-q", "-o", file_of("picture.exr"), "--spp", "16", "--crop", what->crop, "--dump", reference);
}

static void remove_dumps(void) {
    char command[2000];
    snprintf(command, sizeof command, "rm -rf '%s' '%s'", reference, mine);
    ck_assert_int_eq(system(command), 0);
}

/* Runs the example on the dump; 0 where there is nothing to run it on. */
static int run_port(const char *plant) {
    char path[1024];
    const char *root = getenv("NEPHOS_PROGRAM_ROOT");
    snprintf(path, sizeof path, "%s/examples/example_opencl", root ? root : "build");
    setenv("POCL_CACHE_DIR", nph_test_temporary(""), 0);
    const Ran *run = program_finish(program_start_at(path, (const char *const[]){reference, mine, plant ? "--plant" : NULL, plant, NULL}));
    int nothing = strstr(run->err, "OpenCL: there is no") || strstr(run->err, "otherwise than nephos/portable.h needs");
    if (nothing) nph_test_skip(run->err);
    else ck_assert_msg(run->status == 0, "%d %s%s", run->status, run->out, run->err);
    return !nothing;
}

static int can_run(void) {
    char path[1024];
    const char *root = getenv("NEPHOS_PROGRAM_ROOT");
    snprintf(path, sizeof path, "%s/examples/example_opencl", root ? root : "build");
    if (getenv("NEPHOS_TEST_QUICK")) nph_test_skip("OpenCL: not under sanitizers, which find fault with the platform's compiler");
    else if (!exists(path)) nph_test_skip("OpenCL: built without it (ocl-icd-opencl-dev)");
    else return 1;
    return 0;
}

/* With tolerances measured on the reference's own launches, as the command line would; NULL: to the bit. */
static void verify(NphContext *context, const NphTolerances *tolerances, NphVerification *result) {
    NphScene *loaded = NULL;
    NphVerifyOptions options;
    nph_verify_options_default(&options);
    ck_assert_int_eq(nph_scene_load(context, scene, &loaded), NPH_OK);
    options.scene = loaded;
    options.tolerances = tolerances;
    if (!tolerances) options.ulp = 0.0;
    NphStatus status = nph_verify(context, reference, mine, &options, result);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    nph_scene_free(context, loaded);
}

static void measure_tolerances(NphContext *context, NphTolerances *tolerances) {
    RUN_EXPECT(0, "tolerance", reference, "--scene", scene, "-q", "-o", file_of("tolerances.json"));
    ck_assert_int_eq(nph_tolerances_read(context, file_of("tolerances.json"), tolerances), NPH_OK);
}

/* Nor by what it makes itself of the reference's inputs. */
static void expect_none_beyond_measured_tolerances(NphContext *context) {
    NphTolerances tolerances;
    NphVerification result;
    measure_tolerances(context, &tolerances);
    verify(context, &tolerances, &result);
    ck_assert_int_eq(result.failed, 0);
    for (int r = 0; r < result.row_count; r++) ck_assert_int_ne(result.rows[r].tolerance.cause[0], '\0');
    nph_verification_free(context, &result);
    nph_tolerances_free(context, &tolerances);
}

static const NphVerifyRow *row_of(const NphVerification *result, const char *buffer) {
    for (int r = 0; r < result->row_count; r++)
        if (strcmp(result->rows[r].buffer, buffer) == 0) return &result->rows[r];
    ck_abort_msg("nothing was said of %s", buffer);
    return NULL;
}

START_TEST(the_opencl_client_is_the_reference_to_the_bit) {
    NphContext *context = nph_test_context(2);
    NphVerification result;
    if (can_run()) make_dump(&scenes[_i]);
    if (can_run() && run_port(NULL)) {
        verify(context, NULL, &result);
        int stages = 1;
        for (int r = 0; r < result.row_count; r++) {
            const NphVerifyRow *row = &result.rows[r];
            printf("    %s %s: %lld cells, largest ulp %g\n", row->stage, row->buffer, (long long)row->cells, row->worst.ulp);
            stages += r > 0 && strcmp(row->stage, result.rows[r - 1].stage) != 0;
        }
        ck_assert_int_eq(result.failed, 0);
        ck_assert_int_eq(stages, scenes[_i].stages);
        ck_assert_int_eq(result.run_again, result.launches);
        ck_assert_int_gt(row_of(&result, "path.colliding")->cells, 50);
        nph_verification_free(context, &result);
        RUN_EXPECT(0, "verify", reference, mine, "--scene", scene, "--ulp", "0", "-q");
        if (has_altered()) expect_none_beyond_measured_tolerances(context);
    }
    remove_dumps();
    nph_test_context_close(context);
}
END_TEST

/* Each cell has what its mirror image should have. */
static void expect_transposed(NphContext *context, const NphVerification *result) {
    const NphVerifyCell *worst = &row_of(result, "path.bound")->worst;
    char path[700];
    NphArray bound;
    NphDumpRun *run = NULL;
    snprintf(path, sizeof path, "%s", reference);
    ck_assert_int_eq(nph_dump_run(context, path, &run), NPH_OK);
    ck_assert_int_eq(nph_dump_run_array(context, run, 0, "path.bound", &bound), NPH_OK);
    int64_t mirror = (worst->index[2] * bound.shape[1] + worst->index[1]) * bound.shape[2] + worst->index[0];
    double there = (double)((float *)bound.data)[mirror];
    ck_assert_double_le(fabs(worst->candidate - there), 2e-6 * there);
    ck_assert_double_ne(worst->candidate, worst->reference);
    ck_assert_int_eq(row_of(result, "path.weight")->beyond, 0); /* path.track was given the reference's bounds */
    nph_array_free(context, &bound);
    nph_dump_run_free(context, run);
}

/* More flights collide than should. */
static void expect_dropped(NphContext *context, const NphVerification *result) {
    (void)context;
    const NphVerifyRow *medium = row_of(result, "path.medium");
    ck_assert_int_gt(medium->beyond, 0);
    ck_assert_double_eq(medium->worst.reference, -1.0);
    ck_assert_double_eq(medium->worst.candidate, 0.0);
    ck_assert_int_eq(row_of(result, "path.bound")->beyond, 0);
}

/* Only paths of the first block, which none has written: what lies there says that all collide at 0. */
static void expect_block(NphContext *context, const NphVerification *result) {
    const NphVerifyRow *medium = row_of(result, "path.medium");
    (void)context;
    ck_assert_int_lt(medium->worst.index[0], 64);
    ck_assert_double_eq(medium->worst.candidate, 0.0);
    ck_assert_int_le(medium->beyond, 64 * medium->launches);
    ck_assert_int_eq(row_of(result, "path.colliding")->failed, 1);
    ck_assert_int_eq(row_of(result, "path.bound")->failed, 0);
}

/* One buffer alone, most of it; what has no end is beyond what halves can hold. */
static void expect_half(NphContext *context, const NphVerification *result) {
    (void)context;
    const NphVerifyRow *distance = row_of(result, "path.distance");
    for (int r = 0; r < result->row_count; r++) ck_assert_int_eq(result->rows[r].failed, &result->rows[r] == distance);
    ck_assert(isinf(distance->worst.candidate) || distance->worst.relative < 0x1p-11);
    ck_assert_int_gt(distance->cells - distance->histogram[0], distance->cells / 2);
}

START_TEST(each_mistake_of_the_opencl_client_is_located) {
    static const struct {
        const char *plant, *stage, *buffer;
        int64_t batch, number;
        void (*expect)(NphContext *context, const NphVerification *result);
    } mistakes[] = {
        {"transposed_axis", "path.majorant", "path.bound", -1, 0, expect_transposed},
        {"dropped_factor", "path.track", "path.weight", 0, 1, expect_dropped},
        {"block_off_by_one", "path.track", "path.medium", 0, 1, expect_block},
        {"half", "path.track", "path.distance", 0, 1, expect_half},
    };
    NphContext *context = nph_test_context(2);
    NphTolerances tolerances;
    NphVerification result;
    int can = can_run() && has_altered();
    if (can) make_dump(&scenes[SMOKE]);
    if (can && run_port(mistakes[_i].plant)) {
        measure_tolerances(context, &tolerances);
        verify(context, &tolerances, &result);
        ck_assert_int_eq(result.failed, 1);
        ck_assert_str_eq(result.rows[result.first].stage, mistakes[_i].stage);
        ck_assert_str_eq(result.rows[result.first].buffer, mistakes[_i].buffer);
        ck_assert_int_eq(result.first_batch, mistakes[_i].batch);
        ck_assert_int_eq(result.first_number, mistakes[_i].number);
        mistakes[_i].expect(context, &result);
        nph_verification_free(context, &result);
        nph_tolerances_free(context, &tolerances);
    }
    remove_dumps();
    nph_test_context_close(context);
}
END_TEST

START_TEST(the_opencl_client_refuses_what_its_kernels_leave_out) {
    if (can_run()) {
        char path[1024];
        const char *root = getenv("NEPHOS_PROGRAM_ROOT");
        snprintf(path, sizeof path, "%s/examples/example_opencl", root ? root : "build");
        snprintf(reference, sizeof reference, "%s", file_of("reference"));
        write_text(file_of("coloured.yaml"), "nephos: 1\ncamera: {resolution: [4, 4], position: [0, -3, 0], look_at: [0, 0, 0], fov: 40}\n"
                                             "media:\n  - {box: [[-1, -1, -1], [1, 1, 1]], extinction: [1, 2, 3]}\n");
        RUN_EXPECT(0, "render", file_of("coloured.yaml"), "-q", "-o", file_of("picture.exr"), "--spp", "16", "--dump", reference);
        const Ran *run = program_finish(program_start_at(path, (const char *const[]){reference, file_of("mine"), NULL}));
        ck_assert_int_eq(run->status, 4);
        ck_assert_ptr_nonnull(strstr(run->err, "these kernels know one grey medium"));
        run = program_finish(program_start_at(path, (const char *const[]){reference, file_of("mine"), "--plant", "nothing", NULL}));
        ck_assert_int_eq(run->status, 2);
        remove_dumps();
    }
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_loop_test(cases, the_opencl_client_is_the_reference_to_the_bit, 0, 3);
    tcase_add_loop_test(cases, each_mistake_of_the_opencl_client_is_located, 0, 4);
    tcase_add_test(cases, the_opencl_client_refuses_what_its_kernels_leave_out);
}

int main(void) { return nph_test_main("example_opencl", fill); }
