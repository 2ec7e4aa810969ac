/* SPDX-License-Identifier: Apache-2.0
 *
 * See nephos/verify.h: launches are paired, the reference's stage is run again where the candidate had inputs of its own, and what
 * oracle/cells.h says of each buffer is held against a tolerance. */
#include "nephos/verify.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/fmath.h"
#include "core/memory.h"
#include "core/message.h"
#include "io/half.h"
#include "method/registry.h"
#include "oracle/cells.h"
#include "oracle/digest.h"
#include "oracle/manifest.h"
#include "oracle/stages.h"
#include "scene/model.h"

/* Where a buffer's row began to differ: the first launch with an item turned over, and the first with more than chance explains. */
typedef struct Place {
    int64_t sequence, batch, number; /* sequence: of launches; -1: nowhere */
} Place;

typedef struct Found {
    Place turned, untypical, failed;
} Found;

typedef struct Verify {
    NphContext *context;
    const NphVerifyOptions *options;
    const NphMethod *method;
    NphManifest reference, candidate;
    NphStages *stages;
    NphVerification *result;
    NphDigestFn digest;
    Found *found; /* by row */
    int room;
    const NphManifestLaunch *launch; /* under way */
    const NphSide *theirs;
} Verify;

void nph_verify_options_default(NphVerifyOptions *options) { *options = (NphVerifyOptions){.ulp = 64.0, .flips = 0.0}; }

static int is_declared_half(const Verify *v, const char *buffer) {
    for (int i = 0; i < v->candidate.half_count; i++)
        if (strcmp(v->candidate.halves[i], buffer) == 0) return 1;
    for (int i = 0; i < v->options->allow_count; i++)
        if (strncmp(v->options->allow[i], "f16:", 4) == 0 && strcmp(v->options->allow[i] + 4, buffer) == 0) return 1;
    return 0;
}

/* Halves become floats; among outputs only where they are declared. */
static NphStatus widen(Verify *v, NphNamedArray *made) {
    NphArray wide;
    if (made->array.type != NPH_F16) return NPH_OK;
    NPH_TRY(nph_array_new(v->context, NPH_F32, made->array.rank, made->array.shape, made->name, &wide));
    for (int64_t i = 0; i < nph_array_count(&wide); i++)
        ((float *)wide.data)[i] = nph_float_from_half(((const uint16_t *)made->array.data)[i]);
    nph_array_free(v->context, &made->array);
    made->array = wide;
    return NPH_OK;
}

/* The reference is what it was when it was written. */
static NphStatus check_digest(const Verify *v, const NphManifestFile *file, const NphArray *array) {
    char digest[NPH_DIGEST_TEXT];
    if (!file->digest) return NPH_OK;
    v->digest(array->data, 1, (size_t)nph_array_count(array) * nph_type_size(array->type), 0, digest);
    if (strcmp(digest, file->digest) == 0) return NPH_OK;
    return nph_error(v->context, NPH_BAD_INPUT, "%s%s: %s has the digest %s, the manifest says %s: it has been changed or torn", v->reference.folder, file->file,
                     file->buffer, digest, file->digest);
}

static NphStatus read_files(Verify *v, const NphManifest *manifest, int count, const NphManifestFile *files, int inputs, NphSide *side) {
    for (int i = 0; i < count && side->count < 2 * NPH_MAX_BUFFERS; i++) {
        NphNamedArray *made = &side->buffers[side->count];
        made->name = files[i].buffer;
        NPH_TRY(nph_manifest_array(v->context, manifest, files[i].file, &made->array));
        side->count++;
        if (manifest == &v->reference) NPH_TRY(check_digest(v, &files[i], &made->array));
        if (inputs || is_declared_half(v, made->name)) NPH_TRY(widen(v, made));
    }
    return NPH_OK;
}

static NphStatus read_side(Verify *v, const NphManifest *manifest, const NphManifestLaunch *launch, NphSide *side) {
    NPH_TRY(read_files(v, manifest, launch->output_count, launch->outputs, 0, side));
    side->outputs = side->count;
    return read_files(v, manifest, launch->input_count, launch->inputs, 1, side);
}

/* Arguments by name; those that the manifest does not give are the reference's. */
static void arguments_of(const Verify *v, const NphManifestLaunch *launch, int64_t out[NPH_MAX_ARGUMENTS]) {
    for (int a = 0; a < v->method->argument_count; a++)
        for (int i = 0; i < launch->argument_count; i++)
            if (strcmp(launch->argument_names[i], v->method->arguments[a]) == 0) out[a] = launch->arguments[i];
}

static NphStatus row_of(Verify *v, const char *stage, const char *buffer, int *out) {
    NphVerification *result = v->result;
    for (int r = 0; r < result->row_count; r++)
        if (strcmp(result->rows[r].stage, stage) == 0 && strcmp(result->rows[r].buffer, buffer) == 0) {
            *out = r;
            return NPH_OK;
        }
    if (result->row_count == v->room) {
        NphVerifyRow *larger = NULL;
        Found *places = NULL;
        v->room = v->room ? 2 * v->room : 64;
        NPH_TRY(NPH_NEW(v->context, v->room, "rows of a verification", &larger));
        if (result->row_count) memcpy(larger, result->rows, (size_t)result->row_count * sizeof *larger);
        nph_free(v->context, result->rows);
        result->rows = larger;
        NPH_TRY(NPH_NEW(v->context, v->room, "places of a verification", &places));
        if (result->row_count) memcpy(places, v->found, (size_t)result->row_count * sizeof *places);
        nph_free(v->context, v->found);
        v->found = places;
    }
    *out = result->row_count++;
    v->found[*out] = (Found){{-1, 0, 0}, {-1, 0, 0}, {-1, 0, 0}};
    snprintf(result->rows[*out].stage, NPH_VERIFY_NAME, "%s", stage);
    snprintf(result->rows[*out].buffer, NPH_VERIFY_NAME, "%s", buffer);
    return NPH_OK;
}

static void put(const Verify *v, Place *place) {
    if (place->sequence < 0) *place = (Place){v->result->launches, v->launch->batch, v->launch->number};
}

/* A row that fails whatever its cells are; the first reason is kept. */
static void fail(Verify *v, int row, const char *problem) {
    NphVerifyRow *r = &v->result->rows[row];
    if (!r->problem[0])
        snprintf(r->problem, sizeof r->problem, "batch %lld launch %lld: %s", (long long)v->launch->batch, (long long)v->launch->number,
                 problem);
    r->failed = 1;
    put(v, &v->found[row].failed);
}

static const NphArray *their_output(const Verify *v, const char *buffer) {
    for (int i = 0; i < v->theirs->outputs; i++)
        if (strcmp(v->theirs->buffers[i].name, buffer) == 0) return &v->theirs->buffers[i].array;
    return NULL;
}

/* Some causes are of every port; halves and, where the reference has doubles, floats only of those that say so; of interfaces each, or
 * the one that was named. */
static int counts(const Verify *v, const NphTolerance *row) {
    static const char *const always[] = {"f64", "contraction", "division"};
    for (size_t i = 0; i < sizeof always / sizeof *always; i++)
        if (strcmp(row->cause, always[i]) == 0) return 1;
    if (strncmp(row->cause, "f16:", 4) == 0) return is_declared_half(v, row->cause + 4);
    if (strcmp(row->cause, "f32") == 0) {
        const NphArray *array = their_output(v, row->buffer);
        return array && array->type == NPH_F32;
    }
    return !v->options->interface || strcmp(row->cause, v->options->interface) == 0;
}

/* The loosest of the causes that count, of numbers and of decisions each; 0 where nothing has been measured. */
static int tolerance_of(const Verify *v, const char *stage, const char *buffer, NphTolerance *out) {
    const NphTolerances *all = v->options->tolerances;
    int known = 0;
    *out = (NphTolerance){.ulp = v->options->ulp, .flips = v->options->flips, .typical = v->options->ulp, .tail = 1.0};
    for (int t = 0; all && t < all->count; t++) {
        const NphTolerance *row = &all->rows[t];
        if (strcmp(row->stage, stage) != 0 || strcmp(row->buffer, buffer) != 0 || !counts(v, row)) continue;
        NphTolerance before = known++ ? *out : *row;
        *out = row->ulp > before.ulp || (row->ulp >= before.ulp && row->flips > before.flips) ? *row : before;
        if (row->flips > before.flips) before.flips = row->flips;
        if (row->typical > before.typical) before.typical = row->typical;
        out->flips = before.flips;
        out->typical = before.typical;
    }
    return known || !all;
}

static double limit_of(void *user, const NphBuffer *buffer) {
    const Verify *v = user;
    NphTolerance tolerance;
    return tolerance_of(v, v->launch->stage, buffer->name, &tolerance) ? tolerance.ulp : 0.0;
}

static void keep_worst(NphVerifyRow *row, const NphManifestLaunch *launch, const NphBufferGap *gap) {
    NphVerifyCell cell = {launch->batch, launch->number, gap->rank, {0}, gap->reference, gap->candidate, gap->ulp, gap->absolute, 0.0};
    cell.relative = gap->absolute / nph_abs(gap->reference);
    memcpy(cell.index, gap->index, sizeof cell.index);
    row->worst = cell;
}

static NphStatus take(void *user, const NphBufferGap *gap) {
    static const int bins[NPH_VERIFY_BINS] = {0, 1, 3, 5, 7, 11, 21, NPH_OCTAVES - 1}; /* last octave of each */
    Verify *v = user;
    int r;
    NPH_TRY(row_of(v, v->launch->stage, gap->buffer->name, &r));
    NphVerifyRow *row = &v->result->rows[r];
    row->launches++;
    if (gap->problem[0]) fail(v, r, gap->problem);
    if (!tolerance_of(v, row->stage, row->buffer, &row->tolerance)) fail(v, r, "the tolerances have nothing for this buffer");
    for (int octave = 0, bin = 0; octave < NPH_OCTAVES; octave++) {
        bin += octave > bins[bin];
        row->histogram[bin] += gap->octaves[octave];
    }
    row->cells += gap->cells;
    row->beyond += gap->beyond;
    row->items += gap->items;
    row->turned += gap->turned;
    if (gap->ulp > row->worst.ulp) keep_worst(row, v->launch, gap);
    int64_t untypical = 0;
    for (int64_t i = 0; i < gap->gap_count; i++) untypical += gap->gap[i] > row->tolerance.typical;
    row->untypical += untypical;
    if (gap->turned > 0) put(v, &v->found[r].turned);
    if (untypical > 0) put(v, &v->found[r].untypical);
    double chance = row->tolerance.flips * (double)gap->items;
    if ((double)gap->turned > chance + (chance > 0.0)) {
        row->failed = 1;
        put(v, &v->found[r].failed);
    }
    return NPH_OK;
}

/* What the reference makes of the candidate's inputs, which go with it. made: 0 where they are too few for the stage. */
static NphStatus run_again(Verify *v, const NphManifestLaunch *launch, const NphManifestLaunch *ours, const NphSide *candidate,
                           NphSide *side, int *made) {
    int64_t arguments[NPH_MAX_ARGUMENTS] = {0};
    const char *missing = NULL;
    int row;
    arguments_of(v, ours, arguments);
    arguments_of(v, launch, arguments);
    const NphNamedArray *inputs = candidate->buffers + candidate->outputs;
    int count = candidate->count - candidate->outputs;
    NPH_TRY(nph_stages_missing(v->stages, ours->stage, arguments, count, inputs, &missing));
    *made = missing == NULL;
    if (missing) {
        NPH_TRY(row_of(v, launch->stage, missing, &row));
        fail(v, row, "is not among the inputs, which the stage reads");
        return NPH_OK;
    }
    NphStatus status = nph_stages_run(v->stages, ours->stage, arguments, count, inputs, &side->count, side->buffers);
    *made = status == NPH_OK;
    if (status == NPH_BAD_INPUT) { /* told by a message; an earlier stage made them */
        NPH_TRY(row_of(v, launch->stage, "", &row));
        fail(v, row, "its inputs are none that a run could have");
        return NPH_OK;
    }
    NPH_TRY(status);
    side->outputs = side->count;
    v->result->run_again++;
    return read_files(v, &v->candidate, launch->input_count, launch->inputs, 1, side);
}

static NphStatus compare_launch(Verify *v, const NphManifestLaunch *theirs, const NphManifestLaunch *ours) {
    NphSide reference = {0}, candidate = {0};
    NphCellWatch watch = {v, limit_of, take};
    int again = v->stages && !v->options->whole_run && theirs->input_count > 0, made = 1;
    v->launch = ours;
    v->theirs = &candidate;
    NphStatus status = read_side(v, &v->candidate, theirs, &candidate);
    if (status == NPH_OK)
        status = again ? run_again(v, theirs, ours, &candidate, &reference, &made) : read_side(v, &v->reference, ours, &reference);
    if (status == NPH_OK && made)
        status = nph_compare_sides(v->context, v->method, v->reference.precision, &reference, &candidate, &watch);
    v->result->launches++;
    v->theirs = NULL;
    nph_side_free(v->context, &reference);
    nph_side_free(v->context, &candidate);
    return status;
}

/* What a candidate cannot be judged by at all. */
static NphStatus check_candidate(const Verify *v) {
    const NphManifest *m = &v->candidate;
    if (!m->launch_count) return nph_error(v->context, NPH_BAD_INPUT, "%smanifest.json: has no launches: there is nothing to compare", m->folder);
    for (int l = 0; l < m->launch_count; l++) {
        const NphManifestLaunch *launch = &m->launches[l];
        if (nph_stage_find(v->method, launch->stage) < 0)
            return nph_error(v->context, NPH_BAD_INPUT, "%smanifest.json: batch %lld launch %lld: method %s has no stage %s", m->folder,
                             (long long)launch->batch, (long long)launch->number, v->method->name, launch->stage);
    }
    return NPH_OK;
}

static NphStatus compare_launches(Verify *v) {
    for (int l = 0; l < v->candidate.launch_count; l++) {
        const NphManifestLaunch *theirs = &v->candidate.launches[l], *ours = nph_manifest_find(&v->reference, theirs->batch, theirs->number);
        char problem[160];
        int row;
        if (ours && strcmp(ours->stage, theirs->stage) == 0) {
            NPH_TRY(compare_launch(v, theirs, ours));
            continue;
        }
        if (!v->options->whole_run && v->stages && theirs->input_count) {
            /* another run: paths live longer or shorter; the stage is known all the same */
            NPH_TRY(compare_launch(v, theirs, theirs));
            continue;
        }
        v->launch = theirs;
        NPH_TRY(row_of(v, theirs->stage, "", &row));
        snprintf(problem, sizeof problem, "the reference has %.120s there", ours ? ours->stage : "no launch");
        fail(v, row, problem);
    }
    for (int l = 0; l < v->reference.launch_count; l++) {
        const NphManifestLaunch *ours = &v->reference.launches[l];
        v->result->left_out += !nph_manifest_find(&v->candidate, ours->batch, ours->number);
    }
    return NPH_OK;
}

/* Rows with more items turned over than their part of all fail too; then which was the first. */
static void conclude(Verify *v) {
    NphVerification *result = v->result;
    int64_t first = -1;
    result->failed = v->options->complete && result->left_out > 0;
    for (int r = 0; r < result->row_count; r++) {
        NphVerifyRow *row = &result->rows[r];
        Found *found = &v->found[r];
        double decided = row->tolerance.cause[0] && row->tolerance.ulp <= 0.0; /* one decision on the edge is always possible */
        int turned = (double)row->turned > row->tolerance.flips * (double)row->items + decided;
        int untypical = (double)row->untypical > row->tolerance.tail * (double)row->items + 1.0;
        row->failed |= turned || untypical;
        if (!row->failed) continue;
        const Place *place = found->failed.sequence >= 0 ? &found->failed : turned ? &found->turned : &found->untypical;
        result->failed = 1;
        if (first >= 0 && place->sequence >= first) continue;
        first = place->sequence;
        result->first = r;
        result->first_batch = place->batch;
        result->first_number = place->number;
    }
}

static NphStatus check_scene(NphContext *context, const NphManifest *manifest, const NphScene *scene) {
    char digest[33];
    for (int i = 0; i < 16; i++) snprintf(digest + 2 * i, 3, "%02x", scene->digest[i]);
    if (!manifest->scene_digest || strcmp(digest, manifest->scene_digest) == 0) return NPH_OK;
    return nph_error(context, NPH_BAD_INPUT, "the scene is not the one of the dump %s: digest %s, expected %s", manifest->folder, digest,
                     manifest->scene_digest);
}

static NphStatus open_stages(Verify *v) {
    NphRenderOptions options;
    if (!v->options->scene) return NPH_OK;
    NPH_TRY(check_scene(v->context, &v->reference, v->options->scene));
    nph_manifest_options(&v->reference, &options);
    return nph_stages_open(v->context, v->options->scene, &options, &v->stages);
}

/* Tolerances are of one method, precision and scene. */
static NphStatus check_tolerances(const Verify *v) {
    const NphTolerances *t = v->options->tolerances;
    const char *interface = v->options->interface;
    int known = !interface;
    if (!t) return NPH_OK;
    if (strcmp(t->method, v->reference.method) != 0 || t->precision != v->reference.precision)
        return nph_error(v->context, NPH_BAD_INPUT, "the tolerances are of method %s in f%d, the dump %s is of %s in f%d", t->method,
                         t->precision, v->reference.folder, v->reference.method, v->reference.precision);
    if (v->reference.scene_digest && strcmp(t->scene_digest, v->reference.scene_digest) != 0)
        return nph_error(v->context, NPH_BAD_INPUT, "the tolerances were measured on another scene than that of the dump %s: digest %s, "
                         "expected %s", v->reference.folder, t->scene_digest, v->reference.scene_digest);
    for (int i = 0; i < t->count && !known; i++) known = strcmp(t->rows[i].cause, interface) == 0;
    return known ? NPH_OK : nph_error(v->context, NPH_BAD_USAGE, "the tolerances know no interface %s", interface);
}

NphStatus nph_verify(NphContext *context, const char *reference, const char *candidate, const NphVerifyOptions *options,
                     NphVerification *result) {
    NphVerification made = {.first = -1};
    Verify v = {.context = context, .options = options, .result = &made, .digest = nph_digest_pick(nph_context_isa(context))};
    NphStatus status = nph_manifest_read(context, reference, &v.reference);
    if (status == NPH_OK) status = nph_manifest_read(context, candidate, &v.candidate);
    if (status == NPH_OK) status = nph_method_find(context, v.reference.method, &v.method);
    if (status == NPH_OK && strcmp(v.reference.method, v.candidate.method) != 0)
        status = nph_error(context, NPH_BAD_INPUT, "%s is a dump of method %s, %s of %s", reference, v.reference.method, candidate,
                           v.candidate.method);
    if (status == NPH_OK) status = check_candidate(&v);
    if (status == NPH_OK) status = check_tolerances(&v);
    if (status == NPH_OK) status = open_stages(&v);
    if (status == NPH_OK) status = compare_launches(&v);
    if (status == NPH_OK) conclude(&v);
    nph_free(context, v.found);
    nph_stages_close(v.stages);
    nph_manifest_free(context, &v.reference);
    nph_manifest_free(context, &v.candidate);
    if (status != NPH_OK) nph_verification_free(context, &made);
    else *result = made;
    return status;
}

void nph_verification_free(NphContext *context, NphVerification *result) {
    nph_free(context, result->rows);
    *result = (NphVerification){.first = -1};
}

NphStatus nph_dump_scene(NphContext *context, const char *folder, char *name, size_t bytes, uint32_t *frame) {
    NphManifest manifest;
    NPH_TRY(nph_manifest_read(context, folder, &manifest));
    int fits = !name || (manifest.scene && strlen(manifest.scene) < bytes);
    if (fits) *frame = manifest.scene_frame;
    if (fits && name) memcpy(name, manifest.scene, strlen(manifest.scene) + 1);
    nph_manifest_free(context, &manifest);
    return fits ? NPH_OK : nph_error(context, NPH_BAD_INPUT, "%s: its manifest names no scene", folder);
}

NphStatus nph_dump_run(NphContext *context, const char *folder, NphDumpRun **run) {
    NphDumpRun *made = NULL;
    NPH_TRY(NPH_NEW(context, 1, "run of a dump", &made));
    NphStatus status = nph_manifest_read(context, folder, &made->manifest);
    if (status != NPH_OK) {
        nph_free(context, made);
        return status;
    }
    nph_manifest_options(&made->manifest, &made->options);
    *run = made;
    return NPH_OK;
}

const NphRenderOptions *nph_dump_run_options(const NphDumpRun *run) { return &run->options; }

NphStatus nph_dump_run_check(NphContext *context, const NphDumpRun *run, const NphScene *scene) { return check_scene(context, &run->manifest, scene); }

void nph_dump_run_free(NphContext *context, NphDumpRun *run) {
    if (run) nph_manifest_free(context, &run->manifest);
    nph_free(context, run);
}

/* The table's name of a buffer, which outlives the manifest. */
static const char *lasting_name(const NphStages *stages, const char *name) {
    for (int b = 0; b < nph_stages_buffer_count(stages); b++)
        if (strcmp(nph_stages_buffer(stages, b).name, name) == 0) return nph_stages_buffer(stages, b).name;
    return NULL;
}

NphStatus nph_launch_inputs(NphContext *context, const NphManifest *manifest, const NphManifestLaunch *launch, const NphStages *stages,
                            int64_t *arguments, NphNamedArray *inputs, int *count) {
    NphStatus status = NPH_OK;
    *count = 0;
    for (int a = 0; a < nph_stages_argument_count(stages); a++)
        for (int i = 0; i < launch->argument_count; i++)
            if (strcmp(launch->argument_names[i], nph_stages_argument(stages, a)) == 0) arguments[a] = launch->arguments[i];
    for (int i = 0; i < launch->input_count && i < NPH_MAX_BUFFERS && status == NPH_OK; i++) {
        const char *name = lasting_name(stages, launch->inputs[i].buffer);
        status = name ? nph_manifest_array(context, manifest, launch->inputs[i].file, &inputs[*count].array)
                      : nph_error(context, NPH_BAD_INPUT, "%smanifest.json: there is no buffer %s", manifest->folder, launch->inputs[i].buffer);
        if (status == NPH_OK) inputs[(*count)++].name = name;
    }
    for (int i = 0; i < *count && status != NPH_OK; i++) nph_array_free(context, &inputs[i].array);
    if (status != NPH_OK) *count = 0;
    return status;
}

NphStatus nph_dump_inputs(NphContext *context, const char *folder, int64_t batch, int64_t number, const NphStages *stages,
                          const char *stage, int64_t *arguments, NphNamedArray *inputs, int *count) {
    NphManifest manifest;
    NPH_TRY(nph_manifest_read(context, folder, &manifest));
    const NphManifestLaunch *launch = nph_manifest_find(&manifest, batch, number);
    NphStatus status = NPH_OK;
    *count = 0;
    if (!launch || strcmp(launch->stage, stage) != 0)
        status = nph_error(context, NPH_BAD_INPUT, "%s: launch %lld of batch %lld is %s, not %s", folder, (long long)number, (long long)batch,
                           launch ? launch->stage : "not there", stage);
    if (status == NPH_OK) status = nph_launch_inputs(context, &manifest, launch, stages, arguments, inputs, count);
    nph_manifest_free(context, &manifest);
    return status;
}
