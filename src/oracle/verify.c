/* SPDX-License-Identifier: Apache-2.0
 *
 * See nephos/verify.h. Items that have an identity are matched by it, since their order is nobody's business: a GPU compacts its queues
 * as its atomics fall. Values of a queue are positions and become identities first. */
#include "nephos/verify.h"

#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/fmath.h"
#include "core/memory.h"
#include "core/message.h"
#include "method/registry.h"
#include "oracle/manifest.h"
#include "oracle/stages.h"
#include "scene/model.h"

enum { NO_ITEM = -1 };

/* The buffers of one launch, of one side. */
typedef struct Side {
    int count;
    NphNamedArray buffers[2 * NPH_MAX_BUFFERS]; /* outputs, then inputs */
    int outputs;
} Side;

typedef struct Verify {
    NphContext *context;
    const NphVerifyOptions *options;
    const NphMethod *method;
    NphManifest reference, candidate;
    NphStages *stages;
    NphVerification *result;
    int room;
} Verify;

void nph_verify_options_default(NphVerifyOptions *options) { *options = (NphVerifyOptions){.ulp = 64.0, .flips = 0.0}; }

static void free_side(NphContext *context, Side *side) {
    for (int i = 0; i < side->count; i++) nph_array_free(context, &side->buffers[i].array);
    side->count = side->outputs = 0;
}

/* Outputs first: a stage that writes what it reads is known by what it wrote. */
static const NphArray *buffer_of(const Side *side, const char *name) {
    for (int i = 0; i < side->count; i++)
        if (strcmp(side->buffers[i].name, name) == 0) return &side->buffers[i].array;
    return NULL;
}

static const NphArray *output_of(const Side *side, const char *name) {
    for (int i = 0; i < side->outputs; i++)
        if (strcmp(side->buffers[i].name, name) == 0) return &side->buffers[i].array;
    return NULL;
}

static NphStatus read_files(Verify *v, const NphManifest *manifest, int count, const NphManifestFile *files, Side *side) {
    for (int i = 0; i < count && side->count < 2 * NPH_MAX_BUFFERS; i++) {
        NphNamedArray *made = &side->buffers[side->count];
        made->name = files[i].buffer;
        NPH_TRY(nph_manifest_array(v->context, manifest, files[i].file, &made->array));
        side->count++;
    }
    return NPH_OK;
}

static NphStatus read_side(Verify *v, const NphManifest *manifest, const NphManifestLaunch *launch, Side *side) {
    NPH_TRY(read_files(v, manifest, launch->output_count, launch->outputs, side));
    side->outputs = side->count;
    return read_files(v, manifest, launch->input_count, launch->inputs, side);
}

/* Arguments by name; those that the manifest does not give are the reference's. */
static void arguments_of(const Verify *v, const NphManifestLaunch *launch, int64_t out[NPH_MAX_ARGUMENTS]) {
    for (int a = 0; a < v->method->argument_count; a++)
        for (int i = 0; i < launch->argument_count; i++)
            if (strcmp(launch->argument_names[i], v->method->arguments[a]) == 0) out[a] = launch->arguments[i];
}

/* What the reference makes of the candidate's inputs, which go with it. */
static NphStatus run_again(Verify *v, const NphManifestLaunch *launch, const NphManifestLaunch *ours, const Side *candidate, Side *side) {
    int64_t arguments[NPH_MAX_ARGUMENTS] = {0};
    arguments_of(v, ours, arguments);
    arguments_of(v, launch, arguments);
    NPH_TRY(nph_stages_run(v->stages, ours->stage, arguments, candidate->count - candidate->outputs,
                           candidate->buffers + candidate->outputs, &side->count, side->buffers));
    side->outputs = side->count;
    v->result->run_again++;
    return read_files(v, &v->candidate, launch->input_count, launch->inputs, side);
}

static NphStatus row_of(Verify *v, const char *stage, const char *buffer, NphVerifyRow **out) {
    NphVerification *result = v->result;
    for (int r = 0; r < result->row_count; r++)
        if (strcmp(result->rows[r].stage, stage) == 0 && strcmp(result->rows[r].buffer, buffer) == 0) {
            *out = &result->rows[r];
            return NPH_OK;
        }
    if (result->row_count == v->room) {
        NphVerifyRow *larger = NULL;
        v->room = v->room ? 2 * v->room : 64;
        NPH_TRY(NPH_NEW(v->context, v->room, "rows of a verification", &larger));
        if (result->row_count) memcpy(larger, result->rows, (size_t)result->row_count * sizeof *larger);
        nph_free(v->context, result->rows);
        result->rows = larger;
    }
    *out = &result->rows[result->row_count++];
    snprintf((*out)->stage, sizeof(*out)->stage, "%s", stage);
    snprintf((*out)->buffer, sizeof(*out)->buffer, "%s", buffer);
    return NPH_OK;
}

static void fail(Verify *v, NphVerifyRow *row, const NphManifestLaunch *launch) {
    row->failed = v->result->failed = 1;
    if (v->result->first >= 0) return;
    v->result->first = (int)(row - v->result->rows);
    v->result->first_batch = launch->batch;
    v->result->first_number = launch->number;
}

static double value_at(const NphArray *array, int64_t i) {
    switch (array->type) {
    case NPH_F32: return (double)((const float *)array->data)[i];
    case NPH_F64: return ((const double *)array->data)[i];
    case NPH_I32: return (double)((const int32_t *)array->data)[i];
    case NPH_U32: return (double)((const uint32_t *)array->data)[i];
    case NPH_I64: return (double)((const int64_t *)array->data)[i];
    case NPH_U8: return (double)((const uint8_t *)array->data)[i];
    default: return nph_nan();
    }
}

static int is_real(const NphArray *array) { return array->type == NPH_F32 || array->type == NPH_F64; }

/* The distance from |x| to the next number of the type away from 0. */
static double unit_of(double x, NphType type) {
    double least = type == NPH_F32 ? 1.401298464324817e-45 : 4.9406564584124654e-324, size = nph_abs(x), exponent;
    if (!(size > least)) return least;
    nph_mantissa(size, &exponent);
    double top = nph_power_of_2(exponent < -1000.0 ? -1000.0 : exponent); /* within a factor sqrt 2 of a power of 2 below */
    while (top > size) top *= 0.5;
    double unit = top * (type == NPH_F32 ? 1.1920928955078125e-07 : 2.2204460492503131e-16);
    return unit > least ? unit : least;
}

static int bin_of(double ulp) {
    static const double edges[NPH_VERIFY_BINS - 1] = {0.0, 1.0, 4.0, 16.0, 64.0, 1024.0, 1048576.0};
    int bin = 0;
    while (bin < NPH_VERIFY_BINS - 1 && !(ulp <= edges[bin])) bin++;
    return bin;
}

/* An item and where it stands. */
typedef struct Item {
    double id;
    int64_t at;
} Item;

static int by_id(const void *a, const void *b) {
    const Item *x = a, *y = b;
    if (x->id < y->id || x->id > y->id) return x->id < y->id ? -1 : 1;
    return (x->at > y->at) - (x->at < y->at);
}

/* The last place of an item in a sorted list; NO_ITEM where it is not there. */
static int64_t place_of(const Item *items, int64_t count, double id) {
    int64_t lo = 0, hi = count; /* items before lo are not above id, those from hi on are */
    while (lo < hi) {
        int64_t middle = lo + (hi - lo) / 2;
        if (items[middle].id > id) hi = middle;
        else lo = middle + 1;
    }
    return lo > 0 && !(items[lo - 1].id < id) ? items[lo - 1].at : NO_ITEM;
}

/* Positions in the candidate of the reference's items; NO_ITEM where it has none. Identities may be far apart. */
static NphStatus match(Verify *v, const NphArray *ours, const NphArray *theirs, int64_t **out) {
    int64_t count = nph_array_count(ours), others = nph_array_count(theirs), known = 0;
    Item *items = NULL;
    NPH_TRY(NPH_NEW(v->context, count > 0 ? count : 1, "positions of items", out));
    NPH_TRY(NPH_NEW(v->context, others > 0 ? others : 1, "items by identity", &items));
    for (int64_t i = 0; i < others; i++)
        if (value_at(theirs, i) >= 0.0) items[known++] = (Item){value_at(theirs, i), i};
    qsort(items, (size_t)known, sizeof *items, by_id);
    for (int64_t i = 0; i < count; i++) (*out)[i] = place_of(items, known, value_at(ours, i));
    nph_free(v->context, items);
    return NPH_OK;
}

static void count_cell(const Verify *v, NphVerifyRow *row, const NphManifestLaunch *launch, const NphArray *a, int64_t i, double x,
                       double y, double largest) {
    NphType type = v->reference.precision == 32 ? NPH_F32 : a->type; /* moments in double of floats are no better than floats */
    int both_nan = !(x >= x) && !(y >= y), equal = (x >= y && x <= y) || both_nan, real = is_real(a);
    double unit = real ? unit_of(x, type) : 1.0, off = nph_abs(x - y), ulp = equal ? 0.0 : off / unit;
    if (!(ulp >= 0.0)) ulp = nph_infinity();
    int beyond = real ? ulp > v->options->ulp && !(off <= v->options->ulp * unit_of(largest, type)) : !equal;
    row->cells++;
    row->beyond += beyond;
    row->histogram[bin_of(ulp)]++;
    /* what is beyond the tolerance goes before what has more units but is not */
    int worse = ulp > row->worst.ulp && (beyond || row->beyond == 0);
    if (!(worse || (beyond && row->beyond == 1))) return;
    NphVerifyCell cell = {launch->batch, launch->number, a->rank, {0}, x, y, ulp, off, off / nph_abs(x)};
    for (int axis = a->rank - 1; axis >= 0; axis--) {
        cell.index[axis] = i % a->shape[axis];
        i /= a->shape[axis];
    }
    row->worst = cell;
}

/* Rows of the last axis; `place` reorders the candidate's. */
static void compare_cells(Verify *v, NphVerifyRow *row, const NphManifestLaunch *launch, const NphArray *a, const NphArray *b,
                          const int64_t *place) {
    int64_t length = a->rank ? a->shape[a->rank - 1] : 1, others = b->rank ? b->shape[b->rank - 1] : 1;
    int64_t rows = length ? nph_array_count(a) / length : 0;
    for (int64_t r = 0; r < rows; r++) {
        double largest = 0.0;
        for (int64_t i = 0; i < length; i++) {
            double size = nph_abs(value_at(a, r * length + i));
            largest = size > largest && size < DBL_MAX ? size : largest;
        }
        for (int64_t i = 0; i < length; i++) {
            int64_t j = place ? place[i] : i;
            double y = j == NO_ITEM || j >= others ? nph_nan() : value_at(b, r * others + j);
            count_cell(v, row, launch, a, r * length + i, value_at(a, r * length + i), y, largest);
        }
    }
}

/* Identities of a queue's items, each counted once as a cell: those that only one side has differ. */
static NphStatus compare_queue(Verify *v, NphVerifyRow *row, const NphManifestLaunch *launch, const NphArray *a, const NphArray *b,
                               const NphArray *ours, const NphArray *theirs) {
    const NphArray *queue[2] = {a, b}, *ids[2] = {ours, theirs};
    int64_t most = -1;
    unsigned char *seen = NULL;
    for (int64_t i = 0; i < nph_array_count(ours); i++) most = value_at(ours, i) > (double)most ? (int64_t)value_at(ours, i) : most;
    NPH_TRY(NPH_NEW(v->context, most + 2, "items of a queue", &seen));
    for (int s = 0; s < 2; s++)
        for (int64_t i = 0; i < nph_array_count(queue[s]); i++) {
            double at = value_at(queue[s], i);
            int within = at >= 0.0 && at < (double)nph_array_count(ids[s]);
            double id = within ? value_at(ids[s], (int64_t)at) : -1.0;
            if (id >= 0.0 && id <= (double)most) seen[(int64_t)id] |= (unsigned char)(1 << s);
            else row->beyond++; /* a position that no item has, or an item that the reference has not */
        }
    for (int64_t id = 0; id <= most; id++) {
        if (!seen[id]) continue;
        row->cells++;
        row->histogram[seen[id] == 3 ? 0 : bin_of(1.0)]++;
        if (seen[id] == 3) continue;
        if (row->beyond++ == 0)
            row->worst = (NphVerifyCell){launch->batch, launch->number, 1, {id}, seen[id] & 1, seen[id] >> 1, 1.0, 1.0, 1.0};
    }
    nph_free(v->context, seen);
    return NPH_OK;
}

/* Shapes agree but for the number of items of buffers that have an identity. */
static int shapes_fit(const NphArray *a, const NphArray *b, int free_last) {
    if (a->rank != b->rank || is_real(a) != is_real(b)) return 0;
    for (int axis = 0; axis < a->rank - free_last; axis++)
        if (a->shape[axis] != b->shape[axis]) return 0;
    return 1;
}

static void shape_text(const NphArray *array, char text[96]) {
    size_t used = (size_t)snprintf(text, 96, "%s [", nph_type_name(array->type));
    for (int a = 0; a < array->rank && used < 80; a++)
        used += (size_t)snprintf(text + used, 96 - used, "%s%lld", a ? ", " : "", (long long)array->shape[a]);
    snprintf(text + used, 96 - used, "]");
}

/* How many items the candidate has that the reference has not. */
static int64_t surplus(const NphArray *a, const NphArray *b, const int64_t *place) {
    int64_t length = a->rank ? a->shape[a->rank - 1] : 1, matched = 0;
    for (int64_t i = 0; i < length; i++) matched += place[i] != NO_ITEM;
    return (b->rank ? b->shape[b->rank - 1] : 1) - matched;
}

static NphStatus compare_buffer(Verify *v, const NphManifestLaunch *launch, const NphBuffer *buffer, const Side *ours, const Side *theirs) {
    const NphArray *a = output_of(ours, buffer->name), *b = output_of(theirs, buffer->name);
    const NphArray *id_a = buffer->identity ? buffer_of(ours, buffer->identity) : NULL;
    const NphArray *id_b = buffer->identity ? buffer_of(theirs, buffer->identity) : NULL;
    int known = id_a && id_b && (buffer->queue || (a->rank > 0 && nph_array_count(id_a) == a->shape[a->rank - 1]));
    NphVerifyRow *row = NULL;
    int64_t *place = NULL;
    NPH_TRY(row_of(v, launch->stage, buffer->name, &row));
    row->launches++;
    int64_t cells = row->cells, beyond = row->beyond;
    if (!b || !shapes_fit(a, b, known)) {
        char expected[96], found[96] = "missing";
        shape_text(a, expected);
        if (b) shape_text(b, found);
        if (!row->problem[0])
            snprintf(row->problem, sizeof row->problem, "batch %lld launch %lld: %s, expected %s", (long long)launch->batch,
                     (long long)launch->number, found, expected);
        fail(v, row, launch);
        return NPH_OK;
    }
    NphStatus status = NPH_OK;
    if (known && buffer->queue) status = compare_queue(v, row, launch, a, b, id_a, id_b);
    else {
        if (known) status = match(v, id_a, id_b, &place);
        if (status == NPH_OK) compare_cells(v, row, launch, a, b, place);
        if (status == NPH_OK && place) row->beyond += surplus(a, b, place);
        nph_free(v->context, place);
    }
    if (status != NPH_OK) return status;
    cells = row->cells - cells;
    beyond = row->beyond - beyond;
    double allowed = is_real(a) ? 0.0 : v->options->flips * (double)cells;
    if ((double)beyond > allowed) fail(v, row, launch);
    return NPH_OK;
}

static NphStatus compare_launch(Verify *v, const NphManifestLaunch *theirs, const NphManifestLaunch *ours) {
    Side reference = {0}, candidate = {0};
    int again = v->stages && !v->options->whole_run && theirs->input_count > 0;
    NphStatus status = read_side(v, &v->candidate, theirs, &candidate);
    if (status == NPH_OK)
        status = again ? run_again(v, theirs, ours, &candidate, &reference) : read_side(v, &v->reference, ours, &reference);
    for (int o = 0; o < reference.outputs && status == NPH_OK; o++) {
        int buffer = nph_buffer_find(v->method, reference.buffers[o].name);
        if (buffer >= 0) status = compare_buffer(v, ours, &v->method->buffers[buffer], &reference, &candidate);
    }
    v->result->launches++;
    free_side(v->context, &reference);
    free_side(v->context, &candidate);
    return status;
}

static NphStatus compare_launches(Verify *v) {
    for (int l = 0; l < v->candidate.launch_count; l++) {
        const NphManifestLaunch *theirs = &v->candidate.launches[l], *ours = nph_manifest_find(&v->reference, theirs->batch, theirs->number);
        NphVerifyRow *row = NULL;
        if (ours && strcmp(ours->stage, theirs->stage) == 0) {
            NPH_TRY(compare_launch(v, theirs, ours));
            continue;
        }
        if (ours && !v->options->whole_run && v->stages && theirs->input_count) {
            /* another run: paths live longer or shorter; the stage is known all the same */
            NPH_TRY(compare_launch(v, theirs, theirs));
            continue;
        }
        NPH_TRY(row_of(v, theirs->stage, "", &row));
        if (!row->problem[0])
            snprintf(row->problem, sizeof row->problem, "batch %lld launch %lld: the reference has %s there", (long long)theirs->batch,
                     (long long)theirs->number, ours ? ours->stage : "no launch");
        fail(v, row, theirs);
    }
    for (int l = 0; l < v->reference.launch_count; l++) {
        const NphManifestLaunch *ours = &v->reference.launches[l];
        v->result->left_out += !nph_manifest_find(&v->candidate, ours->batch, ours->number);
    }
    return NPH_OK;
}

static NphStatus open_stages(Verify *v) {
    NphRenderOptions options;
    char digest[33];
    if (!v->options->scene) return NPH_OK;
    for (int i = 0; i < 16; i++) snprintf(digest + 2 * i, 3, "%02x", v->options->scene->digest[i]);
    if (v->reference.scene_digest && strcmp(digest, v->reference.scene_digest) != 0)
        return nph_error(v->context, NPH_BAD_INPUT, "the scene is not the one of the dump %s: digest %s, expected %s", v->reference.folder,
                         digest, v->reference.scene_digest);
    nph_manifest_options(&v->reference, &options);
    return nph_stages_open(v->context, v->options->scene, &options, &v->stages);
}

NphStatus nph_verify(NphContext *context, const char *reference, const char *candidate, const NphVerifyOptions *options,
                     NphVerification *result) {
    NphVerification made = {.first = -1};
    Verify v = {.context = context, .options = options, .result = &made};
    NphStatus status = nph_manifest_read(context, reference, &v.reference);
    if (status == NPH_OK) status = nph_manifest_read(context, candidate, &v.candidate);
    if (status == NPH_OK) status = nph_method_find(context, v.reference.method, &v.method);
    if (status == NPH_OK && strcmp(v.reference.method, v.candidate.method) != 0)
        status = nph_error(context, NPH_BAD_INPUT, "%s is a dump of method %s, %s of %s", reference, v.reference.method, candidate,
                           v.candidate.method);
    if (status == NPH_OK) status = open_stages(&v);
    if (status == NPH_OK) status = compare_launches(&v);
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

NphStatus nph_dump_scene_name(NphContext *context, const char *folder, char *name, size_t bytes) {
    NphManifest manifest;
    NPH_TRY(nph_manifest_read(context, folder, &manifest));
    int fits = manifest.scene && strlen(manifest.scene) < bytes;
    if (fits) memcpy(name, manifest.scene, strlen(manifest.scene) + 1);
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

static NphStatus take_inputs(NphContext *context, const NphManifest *manifest, const NphManifestLaunch *launch, const NphStages *stages,
                             NphNamedArray *inputs, int *count) {
    for (int i = 0; i < launch->input_count && i < NPH_MAX_BUFFERS; i++) {
        const char *name = lasting_name(stages, launch->inputs[i].buffer);
        if (!name) return nph_error(context, NPH_BAD_INPUT, "%smanifest.json: there is no buffer %s", manifest->folder, launch->inputs[i].buffer);
        NPH_TRY(nph_manifest_array(context, manifest, launch->inputs[i].file, &inputs[*count].array));
        inputs[(*count)++].name = name;
    }
    return NPH_OK;
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
    for (int a = 0; a < nph_stages_argument_count(stages) && status == NPH_OK; a++)
        for (int i = 0; i < launch->argument_count; i++)
            if (strcmp(launch->argument_names[i], nph_stages_argument(stages, a)) == 0) arguments[a] = launch->arguments[i];
    if (status == NPH_OK) status = take_inputs(context, &manifest, launch, stages, inputs, count);
    for (int i = 0; i < *count && status != NPH_OK; i++) nph_array_free(context, &inputs[i].array);
    if (status != NPH_OK) *count = 0;
    nph_manifest_free(context, &manifest);
    return status;
}
