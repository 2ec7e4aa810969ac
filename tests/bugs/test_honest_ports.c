/* SPDX-License-Identifier: Apache-2.0
 *
 * Measured tolerances: ports that are honest and yet different pass with them, each planted mistake fails, and no tolerance is
 * looser than it may be. A port is a whole run of altered kernels (src/altered), with another salt than was measured. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "altered/altered.h"
#include "altered/measure.h"
#include "harness.h"
#include "nephos/scene.h"
#include "oracle/planted.h"

static const char chromatic[] =
    "nephos: 1\ncamera: {type: perspective, resolution: [16, 16], position: [-2, -1.5, 1.2], look_at: [0.5, 0.5, 0.5], fov: 30}\n"
    "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: [2, 4, 7], albedo: [0.9, 0.8, 0.6], phase: {type: hg, g: 0.5}}\n"
    "lights:\n  - {type: sun, direction: [-1, 0.2, 0.3], irradiance: 3}\n";

/* A file below reference/scenes, or a text; crop: what is dumped. */
static const struct {
    const char *file, *text;
    int crop[4];
} scenes[] = {
    {"reference/scenes/cube_g070.yaml", NULL, {112, 112, 128, 128}},
    {"reference/scenes/smoke.yaml", NULL, {192, 144, 208, 152}},
    {NULL, chromatic, {0, 0, 16, 16}},
};

static NphContext *context;
static NphScene *scene;
static NphRenderOptions options;
static NphTolerances tolerances;

/* Scene and tolerances, of `run`'s method and knobs. */
static void begin_method(const char *file, const char *text, const int crop[4], const NphRenderOptions *run) {
    context = nph_test_context(1);
    altered_choose_level(context, NPH_ISA_BASE);
    NphStatus status = file ? nph_scene_load(context, nph_test_path(file), &scene)
                            : nph_scene_parse(context, text, strlen(text), "test.yaml", ".", &scene);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    options = *run;
    options.samples = 16;
    options.crop_given = crop != NULL;
    if (crop) memcpy(options.crop, crop, sizeof options.crop);
    AlteredMeasure *measure = NULL;
    NphRenderOptions few = options;
    few.crop_given = 0;
    altered_few(scene, &few, &few);
    ck_assert_int_eq(altered_measure_open(context, scene, &few, &measure), NPH_OK);
    status = altered_measure_run(measure, scene, &few);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    ck_assert_int_eq(altered_measure_tolerances(measure, &tolerances), NPH_OK);
    altered_measure_close(measure);
}

static void begin(const char *file, const char *text, const int crop[4]) {
    NphRenderOptions path;
    nph_render_options_default(&path);
    begin_method(file, text, crop, &path);
}

static void end(void) {
    nph_tolerances_free(context, &tolerances);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}

static void dump(const char *folder, int precision) {
    NphRenderOptions run = options;
    NphDumpOptions what;
    NphFilm *film = NULL;
    run.precision = precision;
    nph_dump_options_default(&what);
    what.folder = folder;
    ck_assert_int_eq(nph_dump(context, scene, "test.yaml", &run, &what, &film, NULL), NPH_OK);
    nph_film_free(context, film);
}

static void remove_folder(const char *folder) {
    char command[4200];
    snprintf(command, sizeof command, "rm -r '%s'", folder);
    ck_assert_int_eq(system(command), 0);
}

static void verify(const char *ours, const char *theirs, const char *interface, const char *allowed, NphVerification *result) {
    NphVerifyOptions how;
    nph_verify_options_default(&how);
    how.scene = scene;
    how.tolerances = &tolerances;
    how.interface = interface;
    how.allow_count = allowed != NULL;
    how.allow = &allowed;
    NphStatus status = nph_verify(context, ours, theirs, &how, result);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
}

static void tell(const NphVerification *result) {
    for (int r = 0; r < result->row_count; r++) {
        const NphVerifyRow *row = &result->rows[r];
        if (!row->failed) continue;
        printf("    %s %s: %lld of %lld items turned, %lld untypical, %.3g ulp, tolerance %.3g, typical %.3g, flips %.3g of %s; %s\n",
               row->stage, row->buffer, (long long)row->turned, (long long)row->items, (long long)row->untypical, row->worst.ulp,
               row->tolerance.ulp, row->tolerance.typical, row->tolerance.flips, row->tolerance.cause, row->problem);
    }
}

/* Dumps under what is simulated now and holds the dump against ours. */
static void expect_honest(const char *name, const char *ours, int precision, const char *interface) {
    const char *theirs = nph_test_temporary("theirs");
    NphVerification result;
    dump(theirs, precision);
    nph_accuracy = NULL;
    altered_choose_level(context, NPH_ISA_BASE);
    verify(ours, theirs, interface, NULL, &result);
    if (result.failed) tell(&result);
    ck_assert_msg(!result.failed, "the honest port with %s fails", name);
    ck_assert_int_gt(result.run_again, 20);
    nph_verification_free(context, &result);
    remove_folder(theirs);
}

/* Each interface by itself, on kernels that contract too where the processor can. */
START_TEST(honest_ports_pass_with_measured_tolerances) {
    char ours[600]; /* the harness' names are reused */
    if (_i > 0 && !nph_test_statistics("honest ports of a second and third scene")) return;
    begin(scenes[_i].file, scenes[_i].text, scenes[_i].crop);
    snprintf(ours, sizeof ours, "%s", nph_test_temporary("ours"));
    dump(ours, 32);
    expect_honest("f64", ours, 64, NULL);
    if (altered_choose_level(context, NPH_ISA_AVX512)) expect_honest("approximate reciprocals", ours, 32, NULL);
    for (int i = 0; i < altered_interface_count(); i++) {
        altered_choose_level(context, NPH_ISA_AVX2);
        nph_accuracy = altered_interface(i);
        nph_accuracy_salt = 2 + (uint32_t)i;
        expect_honest(nph_accuracy->name, ours, 32, nph_accuracy->name);
    }
    remove_folder(ours);
    end();
}
END_TEST

static const char *ours, *theirs;
static NphManifest manifest; /* of theirs */

static void begin_copy(void) {
    begin(NULL, planted_scene, NULL);
    ours = nph_test_temporary("ours");
    theirs = nph_test_temporary("theirs");
    dump(ours, 32);
    dump(theirs, 32);
    ck_assert_int_eq(nph_manifest_read(context, theirs, &manifest), NPH_OK);
}

static void end_copy(void) {
    nph_manifest_free(context, &manifest);
    remove_folder(ours);
    remove_folder(theirs);
    end();
}

static int fails(const char *interface, const char *allowed) {
    NphVerification result;
    verify(ours, theirs, interface, allowed, &result);
    int failed = result.failed;
    nph_verification_free(context, &result);
    return failed;
}

/* Where it happened is told where the candidate's interface is: Vulkan's sines may be off by more than halves are, and one cell by a
 * thousandth is within that. */
START_TEST(each_planted_mistake_fails_with_measured_tolerances) {
    const NphManifestLaunch *launch = NULL;
    NphVerification result;
    if (_i > 0 && !nph_test_long("planted mistakes but one")) return;
    begin_copy();
    ck_assert_int_eq(fails(NULL, NULL), 0);
    plant(context, &manifest, &planted[_i], &launch);
    if (planted[_i].mistake != one_cell) ck_assert_int_eq(fails(NULL, NULL), 1);
    verify(ours, theirs, "cuda", NULL, &result);
    ck_assert_int_eq(result.failed, 1);
    ck_assert_str_eq(result.rows[result.first].stage, planted[_i].stage);
    ck_assert_str_eq(result.rows[result.first].buffer, planted[_i].buffer);
    ck_assert_int_eq(result.first_batch, launch->batch);
    ck_assert_int_eq(result.first_number, launch->number);
    nph_verification_free(context, &result);
    end_copy();
}
END_TEST

START_TEST(halves_pass_where_they_are_declared) {
    const NphManifestLaunch *launch = NULL;
    char command[1000];
    begin_copy();
    change_array(context, launch_file(&manifest, "path.scatter", 1, "path.weight", &launch), store_halves);
    ck_assert_int_eq(fails("cuda", NULL), 1);
    ck_assert_int_eq(fails("cuda", "f16:path.pdf"), 1);
    ck_assert_int_eq(fails("cuda", "f16:path.weight"), 0);
    snprintf(command, sizeof command, "sed -i '/\"name\": \"path.weight\"/{n;s/f32/f16/}' '%s/manifest.json'", theirs);
    ck_assert_int_eq(system(command), 0);
    ck_assert_int_eq(fails("cuda", NULL), 0);
    end_copy();
}
END_TEST

static const NphTolerance *row_of(const char *stage, const char *buffer, const char *cause) {
    for (int t = 0; t < tolerances.count; t++) {
        const NphTolerance *row = &tolerances.rows[t];
        if (strcmp(row->stage, stage) == 0 && strcmp(row->buffer, buffer) == 0 && strcmp(row->cause, cause) == 0) return row;
    }
    ck_abort_msg("no tolerance of %s %s for %s", stage, buffer, cause);
    return NULL;
}

/* And the gaps are of the size that arithmetic tells: a sine off by 2^-11 turns a direction by as much, in units of 2^-24 at the
 * largest; a logarithm off by 3 ulp and a product or two move a distance by a few. */
START_TEST(no_tolerance_is_looser_than_sixteen_gaps) {
    int numbers = 0;
    begin(NULL, planted_scene, NULL);
    for (int t = 0; t < tolerances.count; t++) {
        const NphTolerance *row = &tolerances.rows[t];
        ck_assert_double_le(row->ulp, 16.0 * fmax(row->gap, 1.0));
        ck_assert_double_le(row->typical, row->ulp);
        ck_assert_double_le(row->flips, 1.0);
        numbers += row->gap > 0.0;
    }
    ck_assert_int_gt(numbers, 50);
    double turn = row_of("path.scatter", "path.ray", "vulkan")->gap, distance = row_of("path.track", "path.distance", "opencl")->gap;
    ck_assert_double_ge(turn, 1024.0);
    ck_assert_double_ge(distance, 1.0);
    ck_assert_double_le(distance, 32.0);
    end();
}
END_TEST

/* Stage and buffer whose arithmetic each cause must reach; division NULL: all of the method is of doubles, and what is of floats is left out. */
static const struct {
    const char *method, *stage, *buffer, *knob, *division;
} reached[] = {
    {"light", "light.trace", "light.flight_distance", "light.photons=3000", "division"},
    {"photonmap", "photonmap.trace", "photonmap.place", "photonmap.photons=3000", "division"},
    {"single", "single.march", "single.transmittance", NULL, NULL},
};

static int has_cause(const char *cause) {
    for (int t = 0; t < tolerances.count; t++)
        if (strcmp(tolerances.rows[t].cause, cause) == 0) return 1;
    return 0;
}

START_TEST(causes_reach_the_arithmetic_of_every_method_or_are_left_out) {
    NphRenderOptions run;
    if (!nph_test_long("causes in all methods")) return;
    nph_render_options_default(&run);
    run.method = reached[_i].method;
    run.knob_count = reached[_i].knob != NULL;
    run.knobs = &reached[_i].knob;
    begin_method(NULL, planted_scene, NULL, &run);
    int levels = altered_choose_level(context, NPH_ISA_AVX2);
    ck_assert_double_gt(row_of(reached[_i].stage, reached[_i].buffer, "opencl")->gap, 0.0);
    if (levels) ck_assert_double_gt(row_of(reached[_i].stage, reached[_i].buffer, "contraction")->gap, 0.0);
    if (levels && reached[_i].division) ck_assert_double_gt(row_of(reached[_i].stage, reached[_i].buffer, reached[_i].division)->gap, 0.0);
    ck_assert_int_eq(has_cause("contraction"), levels);
    ck_assert_int_eq(has_cause("division"), levels && reached[_i].division);
    ck_assert_int_eq(has_cause("f64"), reached[_i].division != NULL);
    ck_assert_int_eq(has_cause("vulkan"), reached[_i].division != NULL);
    end();
}
END_TEST

/* [kind][z][y][x][value] */
static void lose_a_sixth(NphArray *array) {
    int64_t *sums = array->data;
    for (int64_t i = 0; i < nph_array_count(array); i++) sums[i] -= sums[i] / 6;
}

static void swap_axes(NphArray *array, int first, int second) {
    enum { N = 4, VALUES = 6 };
    int64_t *sums = array->data;
    ck_assert_int_eq(nph_array_count(array), 2 * N * N * N * VALUES);
    for (int i = 0; i < N * N * N; i++) {
        int at[3] = {i / (N * N), i / N % N, i % N}, kept_axis = at[first];
        at[first] = at[second];
        at[second] = kept_axis;
        for (int v = 0, j = (at[0] * N + at[1]) * N + at[2]; v < VALUES && j > i; v++) {
            int64_t kept = sums[i * VALUES + v];
            sums[i * VALUES + v] = sums[j * VALUES + v];
            sums[j * VALUES + v] = kept;
        }
    }
}

static void swap_z_and_x(NphArray *array) { swap_axes(array, 0, 2); }
static void swap_z_and_y(NphArray *array) { swap_axes(array, 0, 1); }
static void swap_y_and_x(NphArray *array) { swap_axes(array, 1, 2); }

/* Photons of an honest port turn elsewhere now and then; sums over parts of the cells tell it from one that loses light or mistakes an axis. */
START_TEST(sums_of_photons_are_held_against_chance) {
    static const char *const knobs[] = {"tpm.photons=40000", "tpm.generations=2", "tpm.cells_x=4", "tpm.cells_y=4", "tpm.cells_z=4"};
    void (*const mistakes[])(NphArray *) = {lose_a_sixth, swap_z_and_x, swap_z_and_y, swap_y_and_x};
    NphRenderOptions run;
    const NphManifestLaunch *launch = NULL;
    if (!nph_test_long("sums of photons")) return;
    char mine[600];
    nph_render_options_default(&run);
    run.method = "temporal_photons";
    run.knob_count = 5;
    run.knobs = knobs;
    begin_method(NULL, planted_scene, NULL, &run);
    snprintf(mine, sizeof mine, "%s", nph_test_temporary("ours"));
    ours = mine;
    dump(ours, 32);
    for (int i = 0; i < altered_interface_count(); i++) {
        altered_choose_level(context, NPH_ISA_AVX2);
        nph_accuracy = altered_interface(i);
        nph_accuracy_salt = 5 + (uint32_t)i;
        expect_honest(nph_accuracy->name, ours, 32, nph_accuracy->name);
    }
    for (int m = 0; m < 4; m++) {
        char copy[600];
        NphVerification result;
        snprintf(copy, sizeof copy, "%s", nph_test_temporary("theirs"));
        theirs = copy;
        dump(theirs, 32);
        ck_assert_int_eq(nph_manifest_read(context, theirs, &manifest), NPH_OK);
        change_array(context, launch_file(&manifest, "tpm.trace", 3, "tpm.partial", &launch), mistakes[m]);
        verify(ours, theirs, "cuda", NULL, &result);
        const NphVerifyRow *row = &result.rows[result.first];
        ck_assert_int_eq(result.failed, 1);
        ck_assert_str_eq(row->buffer, "tpm.partial");
        ck_assert_int_eq(result.first_number, launch->number);
        printf("    mistake %d: %.3g ulp, tolerance %.3g of %s\n", m, row->worst.ulp, row->tolerance.ulp, row->tolerance.cause);
        nph_verification_free(context, &result);
        nph_manifest_free(context, &manifest);
        remove_folder(theirs);
    }
    remove_folder(ours);
    end();
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_loop_test(cases, honest_ports_pass_with_measured_tolerances, 0, (int)(sizeof scenes / sizeof scenes[0]));
    tcase_add_loop_test(cases, each_planted_mistake_fails_with_measured_tolerances, 0, PLANTED);
    tcase_add_test(cases, halves_pass_where_they_are_declared);
    tcase_add_test(cases, sums_of_photons_are_held_against_chance);
    tcase_add_test(cases, no_tolerance_is_looser_than_sixteen_gaps);
    tcase_add_loop_test(cases, causes_reach_the_arithmetic_of_every_method_or_are_left_out, 0, (int)(sizeof reached / sizeof reached[0]));
}

int main(void) { return nph_test_main("honest_ports", fill); }
