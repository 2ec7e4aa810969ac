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

static const char points_text[] = "nephos: 1\n"
                                  "camera: {type: orthographic, resolution: [16, 16], position: [-2, -1.5, 1.2], look_at: [0.5, 0.5, 0.5], "
                                  "extent: 2}\n"
                                  "media:\n  - {box: [[0, 0, 0], [2, 1, 0.7]], extinction: [2, 4, 9], albedo: [0.95, 0.9, 0.6], "
                                  "phase: {type: hg, g: -0.3}}\n"
                                  "lights:\n  - {type: sun, direction: [-1, 0.2, 0.3], irradiance: 3}\n"
                                  "  - {type: point, position: [0.6, 0.4, 0.3], intensity: [1, 2, 3]}\n"
                                  "  - {type: point, position: [0.6, 0.4, 1.3], intensity: 1}\n";

/* Small grids, and of the stages after them no more than must be. */
#define ORDINATES_ALONE "--method", "principal_ordinates", "-D", "pop.ordinates=8"
#define ORDINATES ORDINATES_ALONE, "-D", "pop.residuum=0", "-D", "pop.upsampling=0"

/* A grid under constant light, whose flights are weighed; a box under a sun; one whose camera rays are split. Then the smoke by principal
 * ordinates, whose grids are of directions; and a coloured box seen from afar, lit by a sun, a point within and a point outside, whose
 * channels come to rest at different times. */
typedef struct Scene {
    const char *path, *text, *crop;
    int stages;                  /* path.track alone, or path.majorant too; pop.propagate */
    const char *buffer;          /* has more than `least` cells */
    int64_t least;
    const char *options[20];
} Scene;
static const Scene scenes[] = {
    {"reference/scenes/smoke.yaml", NULL, "192,144,208,160", 2, "path.colliding", 50, {NULL}},
    {"reference/scenes/cube_g070.yaml", NULL, "112,112,128,128", 1, "path.colliding", 50, {NULL}},
    {NULL, thin_text, "0,0,16,16", 1, "path.colliding", 50, {NULL}},
    {"reference/scenes/smoke.yaml", NULL, "192,144,208,160", 1, "pop.light", 50000, {ORDINATES, "-D", "pop.cells=10", "-D", "pop.iterations=8"}},
    {NULL, points_text, "0,0,16,16", 1, "pop.light", 50000, {ORDINATES, "-D", "pop.cells=7", "-D", "pop.epsilon_l=0.3"}}};
enum { SMOKE, SMOKE_BY_ORDINATES = 3, POINTS, SCENES, MISTAKES = 8, REFUSALS = 6 };

static char reference[600], mine[600], scene[1200];

static void make_dump(const Scene *what) {
    snprintf(reference, sizeof reference, "%s", file_of("reference"));
    snprintf(mine, sizeof mine, "%s", file_of("mine"));
    if (what->path) snprintf(scene, sizeof scene, "%s", nph_test_path(what->path));
    else {
        snprintf(scene, sizeof scene, "%s", file_of("own.yaml"));
        write_text(scene, what->text);
    }
    const char *words[40] = {"render", scene, "-q", "-o", file_of("picture.exr"), "--spp", "16", "--crop", what->crop, "--dump", reference};
    for (int w = 0, to = 11; what->options[w]; w++) words[to++] = what->options[w];
    const Ran *run = program_finish(program_start(words));
    ck_assert_msg(run->status == 0, "%s", run->err);
}

static void remove_dumps(void) {
    char command[2000];
    snprintf(command, sizeof command, "rm -rf '%s' '%s'", reference, mine);
    ck_assert_int_eq(system(command), 0);
}

static const char *port_path(void) {
    static char path[1024];
    const char *root = getenv("NEPHOS_PROGRAM_ROOT");
    snprintf(path, sizeof path, "%s/examples/example_opencl", root ? root : "build");
    return path;
}

static const Ran *run_example(const char *plant) {
    setenv("POCL_CACHE_DIR", nph_test_temporary(""), 0);
    return program_finish(program_start_at(port_path(), (const char *const[]){reference, mine, plant ? "--plant" : NULL, plant, NULL}));
}

/* Runs the example on the dump; 0 where there is nothing to run it on. */
static int run_port(const char *plant) {
    const Ran *run = run_example(plant);
    int nothing = strstr(run->err, "OpenCL: there is no") || strstr(run->err, "otherwise than nephos/portable.h needs");
    if (nothing) nph_test_skip(run->err);
    else ck_assert_msg(run->status == 0, "%d %s%s", run->status, run->out, run->err);
    return !nothing;
}

static int can_run(void) {
    if (getenv("NEPHOS_TEST_QUICK")) nph_test_skip("OpenCL: not under sanitizers, which find fault with the platform's compiler");
    else if (!exists(port_path())) nph_test_skip("OpenCL: built without it (ocl-icd-opencl-dev)");
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

/* What the reference's pop.propagate was given in an iteration, which is what the one before wrote. */
static void read_given(NphContext *context, int64_t iteration, const char *buffer, NphArray *array) {
    NphDumpRun *run = NULL;
    NphDumpLaunch of = {.stage = ""};
    int64_t l = -1;
    ck_assert_int_eq(nph_dump_run(context, reference, &run), NPH_OK);
    while (strcmp(of.stage, "pop.propagate") != 0 || of.arguments[0] != iteration) {
        ck_assert_int_lt(++l, nph_dump_run_launch_count(run));
        nph_dump_run_launch(run, l, &of);
    }
    ck_assert_int_eq(nph_dump_run_array(context, run, l, buffer, array), NPH_OK);
    nph_dump_run_free(context, run);
}

/* Before the last iteration some channels of grids have stopped, and others have not. */
static void expect_some_at_rest(NphContext *context) {
    NphArray power;
    int still = 0, all;
    read_given(context, 19, "pop.power", &power);
    all = (int)nph_array_count(&power) / 2;
    for (int i = 0; i < all; i++) still += ((double *)power.data)[2 * i + 1] <= 0.3 * ((double *)power.data)[2 * i];
    ck_assert_int_eq(all, 9);
    ck_assert(still > 0 && still < all);
    nph_array_free(context, &power);
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
        ck_assert_int_gt(row_of(&result, scenes[_i].buffer)->cells, scenes[_i].least);
        if (_i == POINTS) expect_some_at_rest(context);
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

/* Place along the light, in cells, of what is under way: grids are of 10 x 10 x 10 cells. */
static double mean_plane(const NphArray *light) {
    double sum = 0.0, moment = 0.0;
    for (int64_t i = 0; i < nph_array_count(light); i++) {
        sum += (double)((float *)light->data)[i];
        moment += (double)((float *)light->data)[i] * (double)(i / 100 % 10);
    }
    return moment / sum;
}

/* The light goes back, where the reference's goes on. */
static void expect_swapped(NphContext *context, const NphVerification *result) {
    NphArray light[3]; /* injected; after an iteration of the reference; and of the client */
    read_given(context, 0, "pop.light", &light[0]);
    read_given(context, 1, "pop.light", &light[1]);
    ck_assert_int_eq(nph_array_read_npy(context, file_of("mine/batch-1.5.pop.light.npy"), &light[2]), NPH_OK);
    ck_assert_double_gt(mean_plane(&light[1]), mean_plane(&light[0]) + 0.1);
    ck_assert_double_lt(mean_plane(&light[2]), mean_plane(&light[0]) - 0.1);
    for (int i = 0; i < 3; i++) nph_array_free(context, &light[i]);
    ck_assert_int_eq(row_of(result, "pop.seen")->failed, 0); /* is shown before it is sent */
}

/* Mean cosines alone, and too small: in print they decay faster, for -ln g is more than 1 - g. */
static void expect_printed(NphContext *context, const NphVerification *result) {
    (void)context;
    const NphVerifyRow *cosine = row_of(result, "pop.cosine");
    for (int r = 0; r < result->row_count; r++) ck_assert_int_eq(result->rows[r].failed, &result->rows[r] == cosine);
    ck_assert_double_lt(cosine->worst.candidate, cosine->worst.reference);
    ck_assert_double_gt(cosine->worst.reference, 0.0);
}

/* Too much light is left, also in their sums. */
static void expect_half_an_edge(NphContext *context, const NphVerification *result) {
    const NphVerifyRow *light = row_of(result, "pop.light"), *power = row_of(result, "pop.power");
    (void)context;
    ck_assert_double_gt(light->worst.candidate, light->worst.reference);
    ck_assert_double_gt(power->worst.candidate, power->worst.reference);
    ck_assert_int_eq(power->worst.index[2], 1); /* what is under way, not what was injected */
    ck_assert_int_eq(row_of(result, "pop.seen")->failed, 0);
}

/* How far light is carried on depends on the order of the work-items; but most cells have read what was written over. */
static void expect_in_place(NphContext *context, const NphVerification *result) {
    (void)context;
    ck_assert_int_gt(row_of(result, "pop.light")->beyond, row_of(result, "pop.light")->cells / 2);
    ck_assert_int_gt(row_of(result, "pop.cosine")->beyond, row_of(result, "pop.cosine")->cells / 2);
    ck_assert_int_eq(row_of(result, "pop.seen")->failed, 0); /* a cell shows its own light */
}

START_TEST(each_mistake_of_the_opencl_client_is_located) {
    static const struct {
        const char *plant, *stage, *buffer;
        int64_t batch, number;
        int scene;
        void (*expect)(NphContext *context, const NphVerification *result);
    } mistakes[MISTAKES] = {
        {"transposed_axis", "path.majorant", "path.bound", -1, 0, SMOKE, expect_transposed},
        {"dropped_factor", "path.track", "path.weight", 0, 1, SMOKE, expect_dropped},
        {"block_off_by_one", "path.track", "path.medium", 0, 1, SMOKE, expect_block},
        {"half", "path.track", "path.distance", 0, 1, SMOKE, expect_half},
        {"swapped_direction", "pop.propagate", "pop.light", -1, 5, SMOKE_BY_ORDINATES, expect_swapped},
        {"printed_decay", "pop.propagate", "pop.cosine", -1, 5, SMOKE_BY_ORDINATES, expect_printed},
        {"half_an_edge", "pop.propagate", "pop.light", -1, 5, SMOKE_BY_ORDINATES, expect_half_an_edge},
        {"in_place", "pop.propagate", "pop.light", -1, 5, SMOKE_BY_ORDINATES, expect_in_place},
    };
    NphContext *context = nph_test_context(2);
    NphTolerances tolerances;
    NphVerification result;
    int can = can_run() && has_altered();
    if (can) make_dump(&scenes[mistakes[_i].scene]);
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
    static const char coloured[] = "nephos: 1\ncamera: {resolution: [4, 4], position: [0, -3, 0], look_at: [0, 0, 0], fov: 40}\n"
                                   "media:\n  - {box: [[-1, -1, -1], [1, 1, 1]], extinction: [1, 2, 3]}\n"
                                   "lights:\n  - {type: constant, radiance: 1}\n";
    static const struct {
        const char *words, *plant;
        int status;
        const char *options[8];
    } refused[REFUSALS] = {
        {"these kernels know one grey medium", NULL, 4, {NULL}},
        {"path has no mistake in_place", "in_place", 2, {NULL}},
        {"principal_ordinates has no mistake half", "half", 2, {ORDINATES_ALONE}},
        {"the corrected variant in f32", NULL, 4, {ORDINATES_ALONE, "-D", "pop.variant=1"}},
        {"the corrected variant in f32", NULL, 4, {ORDINATES_ALONE, "--precision", "f64"}},
        {"single is not ported", NULL, 4, {"--method", "single"}},
    };
    if (can_run()) {
        Scene what = {NULL, coloured, "0,0,4,4", 0, NULL, 0, {NULL}};
        for (int w = 0; refused[_i].options[w]; w++) what.options[w] = refused[_i].options[w];
        make_dump(&what);
        const Ran *run = run_example(refused[_i].plant);
        ck_assert_int_eq(run->status, refused[_i].status);
        ck_assert_msg(strstr(run->err, refused[_i].words) != NULL, "%s", run->err);
        ck_assert(!exists(mine));
        remove_dumps();
    }
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_loop_test(cases, the_opencl_client_is_the_reference_to_the_bit, 0, SCENES);
    tcase_add_loop_test(cases, each_mistake_of_the_opencl_client_is_located, 0, MISTAKES);
    tcase_add_loop_test(cases, the_opencl_client_refuses_what_its_kernels_leave_out, 0, REFUSALS);
}

int main(void) { return nph_test_main("example_opencl", fill); }
