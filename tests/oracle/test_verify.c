/* SPDX-License-Identifier: Apache-2.0
 *
 * Mistakes planted in a copy of a dump, and what verify says of them: the stage, the buffer, the cell. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "harness.h"
#include "method/registry.h"
#include "nephos/scene.h"
#include "nephos/verify.h"
#include "oracle/cells.h"
#include "oracle/manifest.h"
#include "oracle/planted.h"

static NphContext *context;
static NphScene *scene;
static const char *ours, *theirs;
static NphManifest manifest; /* of theirs */

static void shell(const char *format, const char *a, const char *b) {
    char command[9000];
    snprintf(command, sizeof command, format, a, b);
    ck_assert_int_eq(system(command), 0);
}

static const char *method = "path"; /* of dumps */

static void dump(const char *folder, int precision) {
    static const char *const few[] = {"photonmap.photons=500", "photonmap.step=1"};
    NphRenderOptions options;
    NphDumpOptions what;
    NphFilm *film = NULL;
    nph_render_options_default(&options);
    options.method = method;
    options.samples = 16;
    options.precision = precision;
    options.knob_count = strcmp(method, "photonmap") == 0 ? 2 : 0;
    options.knobs = few;
    nph_dump_options_default(&what);
    what.folder = folder;
    ck_assert_int_eq(nph_dump(context, scene, "test.yaml", &options, &what, &film, NULL), NPH_OK);
    nph_film_free(context, film);
}

static void begin(void) {
    context = nph_test_context(1);
    ck_assert_int_eq(nph_scene_parse(context, planted_scene, strlen(planted_scene), "test.yaml", ".", &scene), NPH_OK);
    ours = nph_test_temporary("ours");
    theirs = nph_test_temporary("theirs");
    dump(ours, 32);
    shell("cp -r '%s' '%s'", ours, theirs);
    ck_assert_int_eq(nph_manifest_read(context, theirs, &manifest), NPH_OK);
}

static void end(void) {
    nph_manifest_free(context, &manifest);
    nph_scene_free(context, scene);
    shell("rm -r '%s' '%s'", ours, theirs);
    nph_test_context_close(context);
}

static void verify(NphVerification *result, int whole_run) {
    NphVerifyOptions options;
    nph_verify_options_default(&options);
    options.scene = whole_run ? NULL : scene;
    options.whole_run = whole_run;
    NphStatus status = nph_verify(context, ours, theirs, &options, result);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
}

/* Both modes put the finger on the same launch. */
static void expect(const char *stage, const char *buffer, const NphManifestLaunch *launch, int64_t row, int64_t item) {
    for (int whole_run = 0; whole_run < 2; whole_run++) {
        NphVerification result;
        verify(&result, whole_run);
        ck_assert_int_eq(result.failed, 1);
        ck_assert_int_ge(result.first, 0);
        const NphVerifyRow *first = &result.rows[result.first];
        ck_assert_str_eq(first->stage, stage);
        ck_assert_str_eq(first->buffer, buffer);
        ck_assert_int_eq(result.first_batch, launch->batch);
        ck_assert_int_eq(result.first_number, launch->number);
        ck_assert_int_gt(first->beyond, 0);
        if (item >= 0 && whole_run) {
            ck_assert_int_eq(first->worst.index[0], row);
            ck_assert_int_eq(first->worst.index[1], item);
        }
        nph_verification_free(context, &result);
    }
}

START_TEST(a_dump_is_its_own_copy) {
    begin();
    for (int whole_run = 0; whole_run < 2; whole_run++) {
        NphVerification result;
        verify(&result, whole_run);
        ck_assert_int_eq(result.failed, 0);
        ck_assert_int_eq(result.first, -1);
        ck_assert_int_eq(result.left_out, 0);
        ck_assert_int_eq(result.launches, manifest.launch_count);
        ck_assert_int_gt(result.row_count, 20);
        for (int r = 0; r < result.row_count; r++) ck_assert_int_eq(result.rows[r].histogram[0], result.rows[r].cells);
        nph_verification_free(context, &result);
    }
    end();
}
END_TEST

START_TEST(each_planted_mistake_is_located) {
    const NphManifestLaunch *launch = NULL;
    begin();
    plant(context, &manifest, &planted[_i], &launch);
    expect(planted[_i].stage, planted[_i].buffer, launch, planted[_i].row, planted[_i].item);
    end();
}
END_TEST

/* Reverses the last axis. */
static void reverse(NphArray *array) {
    size_t size = nph_type_size(array->type);
    int64_t length = array->shape[array->rank - 1], rows = nph_array_count(array) / (length ? length : 1);
    char kept[8];
    for (int64_t r = 0; r < rows; r++)
        for (int64_t i = 0; i < length / 2; i++) {
            char *a = (char *)array->data + (size_t)(r * length + i) * size, *b = (char *)array->data + (size_t)(r * length + length - 1 - i) * size;
            memcpy(kept, a, size);
            memcpy(a, b, size);
            memcpy(b, kept, size);
        }
}

START_TEST(the_order_of_items_is_nobodys_business) {
    const NphManifestLaunch *launch = NULL;
    NphVerification result;
    begin();
    launch_file(&manifest, "path.scatter", 1, "path.id", &launch);
    for (int o = 0; o < launch->output_count; o++)
        if (strcmp(launch->outputs[o].buffer, "path.sample") != 0)
            change_array(context, launch_file(&manifest, "path.scatter", 1, launch->outputs[o].buffer, NULL), reverse);
    verify(&result, 1);
    for (int r = 0; r < result.row_count; r++)
        if (strcmp(result.rows[r].stage, "path.scatter") == 0) ck_assert_int_eq(result.rows[r].beyond, 0);
    nph_verification_free(context, &result);
    change_array(context, launch_file(&manifest, "path.scatter", 1, "path.pdf", NULL), reverse); /* now in the order of nothing else */
    expect("path.scatter", "path.pdf", launch, 0, -1);
    end();
}
END_TEST

static void move_an_item(NphArray *array) { ((int32_t *)array->data)[5] = ((int32_t *)array->data)[6]; }
static void reverse_ids(NphArray *array) { reverse(array); }

START_TEST(queues_are_sets_of_identities) {
    const NphManifestLaunch *launch = NULL;
    NphVerification result;
    begin();
    change_array(context, launch_file(&manifest, "path.track", 1, "path.colliding", &launch), reverse_ids);
    verify(&result, 1);
    ck_assert_int_eq(result.failed, 0);
    nph_verification_free(context, &result);
    change_array(context, launch_file(&manifest, "path.track", 1, "path.colliding", NULL), move_an_item);
    expect("path.track", "path.colliding", launch, 0, -1);
    end();
}
END_TEST

/* Photon i of n becomes number n - 1 - i. */
static void turn_positions(NphArray *array) {
    int32_t last = (int32_t)array->shape[0] - 1;
    for (int64_t i = 0; i <= last; i++) ((int32_t *)array->data)[i] = last - ((int32_t *)array->data)[i];
}

static void swap_two(NphArray *array) {
    int32_t *nodes = array->data, kept = nodes[2];
    nodes[2] = nodes[3];
    nodes[3] = kept;
}

/* A map whose photons stand in another order is the same map, and so is its tree: nodes are compared by the photon they are. */
START_TEST(photons_may_stand_in_any_order) {
    const NphManifestLaunch *launch = NULL;
    NphVerification result;
    method = "photonmap";
    begin();
    launch_file(&manifest, "photonmap.trace", 3, "photonmap.id", &launch);
    for (int o = 0; o < launch->output_count; o++)
        change_array(context, launch_file(&manifest, "photonmap.trace", 3, launch->outputs[o].buffer, NULL), reverse);
    change_array(context, launch_file(&manifest, "photonmap.tree", 3, "photonmap.node_photon", &launch), turn_positions);
    for (int whole_run = 0; whole_run < 2; whole_run++) {
        verify(&result, whole_run);
        ck_assert_int_eq(result.failed, 0);
        for (int r = 0; r < result.row_count; r++) ck_assert_msg(result.rows[r].beyond == 0, "%s", result.rows[r].buffer);
        ck_assert_int_eq(result.row_count, 16);
        ck_assert_int_eq(result.run_again > 0, !whole_run);
        nph_verification_free(context, &result);
    }
    change_array(context, launch_file(&manifest, "photonmap.tree", 3, "photonmap.node_photon", NULL), swap_two);
    expect("photonmap.tree", "photonmap.node_photon", launch, 2, -1);
    end();
    method = "path";
}
END_TEST

/* Of light.trace: light.place, light.waiting_at, light.waiting. */
static void make_waiting(NphSide *side, int64_t copies, float weight) {
    static const char *const names[] = {"light.place", "light.waiting_at", "light.waiting"};
    const int64_t shapes[3][2] = {{2, 0}, {4, copies}, {15, copies}};
    const NphType types[] = {NPH_I64, NPH_I32, NPH_F32};
    memset(side, 0, sizeof *side);
    side->count = side->outputs = 3;
    for (int b = 0; b < 3; b++) {
        NphNamedArray *made = &side->buffers[b];
        made->name = names[b];
        ck_assert_int_eq(nph_array_new(context, types[b], b ? 2 : 1, shapes[b], names[b], &made->array), NPH_OK);
        for (int64_t i = 0; b == 2 && i < 15 * copies; i++) ((float *)made->array.data)[i] = weight;
    }
}

static double ulp_64(void *user, const NphBuffer *buffer) {
    (void)user;
    (void)buffer;
    return 64.0;
}

static NphStatus keep_gap(void *user, const NphBufferGap *gap) {
    NphBufferGap *gaps = user;
    int at = strcmp(gap->buffer->name, "light.waiting") == 0 ? 2 : strcmp(gap->buffer->name, "light.waiting_at") == 0;
    gaps[at] = *gap;
    return NPH_OK;
}

static void compare_waiting(int64_t copies, float weight, NphBufferGap gaps[3]) {
    NphSide sides[2];
    const NphMethod *light = NULL;
    NphCellWatch watch = {gaps, ulp_64, keep_gap};
    make_waiting(&sides[0], 2, 1.0f);
    make_waiting(&sides[1], copies, weight);
    ck_assert_int_eq(nph_method_find(context, "light", &light), NPH_OK);
    ck_assert_int_eq(nph_compare_sides(context, light, 32, &sides[0], &sides[1], &watch), NPH_OK);
    for (int s = 0; s < 2; s++) nph_side_free(context, &sides[s]);
}

/* Of another photon, or of more copies of it: numbers tell nothing then. */
START_TEST(what_a_photon_has_under_way_is_one_decision) {
    NphBufferGap gaps[3];
    context = nph_test_context(1);
    for (int64_t copies = 0; copies < 4; copies++) {
        compare_waiting(copies, copies == 2 ? 1.5f : 9.0f, gaps);
        for (int b = 0; b < 3; b++) ck_assert_str_eq(gaps[b].problem, "");
        ck_assert_int_eq(gaps[1].items, 1);
        ck_assert_int_eq(gaps[1].turned, copies != 2);
        ck_assert_int_eq(gaps[2].items, copies == 2 ? 2 : 0);
        ck_assert_int_eq(gaps[2].turned, copies == 2 ? 2 : 0);
    }
    nph_test_context_close(context);
}
END_TEST

START_TEST(missing_and_misshaped_buffers_are_named) {
    const NphManifestLaunch *launch = NULL;
    NphVerification result;
    NphArray array;
    int64_t shape[2] = {5, 7};
    begin();
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 2, shape, "misshaped", &array), NPH_OK);
    store_array(context, launch_file(&manifest, "path.track", 0, "path.weight", &launch), &array);
    nph_array_free(context, &array);
    verify(&result, 1);
    ck_assert_int_eq(result.failed, 1);
    ck_assert_str_eq(result.rows[result.first].buffer, "path.weight");
    ck_assert_ptr_nonnull(strstr(result.rows[result.first].problem, "f32 [5, 7], expected f32 [1, "));
    nph_verification_free(context, &result);
    end();
}
END_TEST

static void turn_medium(NphArray *array) { ((int32_t *)array->data)[5] = -1 - ((int32_t *)array->data)[5]; }
static void double_distance(NphArray *array) { ((float *)array->data)[5] *= 2.0f; }

static const NphVerifyRow *row_of(const NphVerification *result, const char *stage, const char *buffer) {
    for (int r = 0; r < result->row_count; r++)
        if (strcmp(result->rows[r].stage, stage) == 0 && strcmp(result->rows[r].buffer, buffer) == 0) return &result->rows[r];
    ck_abort_msg("no row");
    return NULL;
}

START_TEST(a_decision_that_fell_the_other_way_is_counted_once) {
    const NphManifestLaunch *launch = NULL;
    NphVerification result;
    begin();
    change_array(context, launch_file(&manifest, "path.track", 1, "path.distance", &launch), double_distance);
    expect("path.track", "path.distance", launch, 0, -1);
    change_array(context, launch_file(&manifest, "path.track", 1, "path.medium", NULL), turn_medium);
    verify(&result, 1);
    ck_assert_int_eq(result.failed, 1);
    ck_assert_int_eq(row_of(&result, "path.track", "path.medium")->turned, 1);
    ck_assert_int_eq(row_of(&result, "path.track", "path.distance")->beyond, 0);
    nph_verification_free(context, &result);
    end();
}
END_TEST

/* A candidate of one launch, whose manifest lists all inputs but one. */
START_TEST(a_missing_input_is_a_row_that_fails) {
    const NphManifestLaunch *launch = NULL;
    NphVerification result;
    char path[4200];
    begin();
    launch_file(&manifest, "path.track", 1, "path.distance", &launch);
    snprintf(path, sizeof path, "%s/manifest.json", theirs);
    FILE *file = fopen(path, "w");
    ck_assert_ptr_nonnull(file);
    fprintf(file, "{\"nephos_dump\": 1, \"method\": \"path\", \"launches\": [{\"batch\": %d, \"number\": %d, \"stage\": \"path.track\", "
                  "\"outputs\": {}, \"inputs\": {\"path.id\": \"%s\"", (int)launch->batch, (int)launch->number, launch->inputs[0].file);
    ck_assert_str_eq(launch->inputs[0].buffer, "path.id");
    for (int i = 1; i < launch->input_count; i++)
        if (strcmp(launch->inputs[i].buffer, "path.ray") != 0)
            fprintf(file, ", \"%s\": \"%s\"", launch->inputs[i].buffer, launch->inputs[i].file);
    fprintf(file, "}}]}\n");
    ck_assert_int_eq(fclose(file), 0);
    verify(&result, 0);
    ck_assert_int_eq(result.failed, 1);
    ck_assert_int_eq(result.first_number, launch->number);
    ck_assert_str_eq(result.rows[result.first].stage, "path.track");
    ck_assert_str_eq(result.rows[result.first].buffer, "path.ray");
    ck_assert_ptr_nonnull(strstr(result.rows[result.first].problem, "is not among the inputs"));
    nph_verification_free(context, &result);
    end();
}
END_TEST

static int64_t turned_in(const NphVerification *result) {
    int64_t turned = 0;
    for (int r = 0; r < result->row_count; r++) turned += result->rows[r].turned;
    return turned;
}

/* f64 makes other decisions here and there; on its own inputs each stage is right within what f32 can tell. In the whole run, what
 * followed a decision is other too. */
START_TEST(one_flipped_decision_does_not_damn_what_follows) {
    NphVerification alone, whole;
    NphVerifyOptions options;
    begin();
    shell("rm -r '%s' && true '%s'", theirs, ours);
    dump(theirs, 64);
    nph_verify_options_default(&options);
    options.scene = scene;
    options.ulp = 1000;
    options.flips = 0.002;
    ck_assert_int_eq(nph_verify(context, ours, theirs, &options, &alone), NPH_OK);
    if (alone.failed)
        printf("    %s %s: %lld of %lld\n", alone.rows[alone.first].stage, alone.rows[alone.first].buffer,
               (long long)alone.rows[alone.first].beyond, (long long)alone.rows[alone.first].cells);
    ck_assert_int_eq(alone.failed, 0);
    ck_assert_int_gt(alone.run_again, 20);
    options.whole_run = 1;
    ck_assert_int_eq(nph_verify(context, ours, theirs, &options, &whole), NPH_OK);
    ck_assert_int_gt(turned_in(&whole), 10 * turned_in(&alone));
    nph_verification_free(context, &alone);
    nph_verification_free(context, &whole);
    end();
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, a_dump_is_its_own_copy);
    tcase_add_loop_test(cases, each_planted_mistake_is_located, 0, PLANTED);
    tcase_add_test(cases, the_order_of_items_is_nobodys_business);
    tcase_add_test(cases, queues_are_sets_of_identities);
    tcase_add_test(cases, photons_may_stand_in_any_order);
    tcase_add_test(cases, what_a_photon_has_under_way_is_one_decision);
    tcase_add_test(cases, missing_and_misshaped_buffers_are_named);
    tcase_add_test(cases, a_decision_that_fell_the_other_way_is_counted_once);
    tcase_add_test(cases, a_missing_input_is_a_row_that_fails);
    tcase_add_test(cases, one_flipped_decision_does_not_damn_what_follows);
}

int main(void) { return nph_test_main("verify", fill); }
