/* SPDX-License-Identifier: Apache-2.0
 *
 * See measure.h. Where the largest differences of a buffer are those of few items and far above all others', these items made another
 * decision that no integer tells of (a tentative collision taken for a virtual one): they count as turned over, not as
 * rounding. */
#include "altered/measure.h"

#include <stdio.h>
#include <string.h>

#include "altered/altered.h"
#include "core/memory.h"
#include "core/message.h"
#include "io/half.h"
#include "method/job.h"
#include "oracle/cells.h"
#include "oracle/stages.h"

enum { MAX_CAUSES = 10 + NPH_MAX_BUFFERS, SALT = 1 };
#define HIDDEN_PART 1e-4  /* of the items at most may be turned over unseen */
#define HIDDEN_JUMP 64.0  /* and what they leave must be smaller by this factor */

/* One buffer of one stage under one cause, over all launches. */
typedef struct Row {
    int stage, buffer, cause, numbers;
    int64_t launches, items, turned;
    int64_t octave_items[NPH_OCTAVES];
    double octave_largest[NPH_OCTAVES], octave_absolute[NPH_OCTAVES];
} Row;

/* A cause and how it is simulated. */
typedef struct Simulation {
    AlteredCause cause;
    NphStages *stages;
    const NphAccuracy *accuracy;
    int half; /* buffer kept in halves; -1: none */
} Simulation;

struct AlteredMeasure {
    NphContext *context;
    NphJob job;
    const NphMethod *method;
    NphStages *exact;
    NphStages *opened[4];
    int opened_count, cause_count, row_count;
    size_t row_room;
    Simulation simulations[MAX_CAUSES];
    Row *rows;
    int64_t launches, seen[NPH_MAX_STAGES];
    int stage, cause; /* under way */
    char from[160];
};

static NphStatus open_level(AlteredMeasure *m, const NphScene *scene, const NphRenderOptions *options, int precision, NphIsa level,
                            NphStages **out) {
    NphRenderOptions other = *options;
    other.precision = precision;
    *out = NULL;
    if (!altered_choose_level(m->context, level)) return NPH_OK;
    NphStatus status = nph_stages_open(m->context, scene, &other, out);
    altered_choose_level(m->context, NPH_ISA_BASE);
    if (status == NPH_OK) m->opened[m->opened_count++] = *out;
    return status;
}

static Simulation *add_cause(AlteredMeasure *m, const char *name, const char *buffer, const char *source, NphStages *stages,
                             const char *unmeasured) {
    Simulation *made = &m->simulations[m->cause_count++];
    snprintf(made->cause.name, sizeof made->cause.name, "%s%s", name, buffer);
    made->cause.source = source;
    made->cause.unmeasured = stages ? NULL : unmeasured;
    made->stages = stages;
    made->half = -1;
    return made;
}

/* Whatever the run's precision. */
static int is_of_doubles(const NphMethod *method) {
    for (int b = 0; b < method->buffer_count; b++)
        if (method->buffers[b].type == NPH_TYPE_REAL) return 0;
    return 1;
}

static NphStatus add_causes(AlteredMeasure *m, const NphScene *scene, const NphRenderOptions *options) {
    static const char no_fma[] = "not measured: this processor or build has no fused multiply-add";
    int f32 = m->job.precision == 32, doubles = is_of_doubles(m->method), floats = f32 && !doubles;
    NphStages *other = NULL, *contracted = NULL, *divided = NULL;
    if (!doubles) NPH_TRY(open_level(m, scene, options, f32 ? 64 : 32, NPH_ISA_BASE, &other));
    NPH_TRY(open_level(m, scene, options, m->job.precision, NPH_ISA_AVX2, &contracted));
    if (floats) NPH_TRY(open_level(m, scene, options, 32, NPH_ISA_AVX512, &divided));
    add_cause(m, f32 ? "f64" : "f32", "", "the other precision, whose random numbers have other bits too", other,
              "not measured: all of this method is of doubles");
    add_cause(m, "contraction", "", "a * b + c with one rounding", contracted, no_fma);
    add_cause(m, "division", "", "a / b as a times an approximate reciprocal with one step of Newton's method", divided,
              floats ? no_fma : "not measured: of floats only");
    for (int i = 0; i < altered_interface_count(); i++) {
        const NphAccuracy *interface = altered_interface(i);
        add_cause(m, interface->name, "", interface->source, floats || interface->doubles ? m->exact : NULL,
                  "not measured: it promises nothing of doubles")->accuracy = interface;
    }
    for (int b = 0; b < m->method->buffer_count; b++)
        if (m->method->buffers[b].type == NPH_TYPE_REAL)
            add_cause(m, "f16:", m->method->buffers[b].name, "halves in place of this buffer's numbers", m->exact, NULL)->half = b;
    return NPH_OK;
}

NphStatus altered_measure_open(NphContext *context, const NphScene *scene, const NphRenderOptions *options, AlteredMeasure **measure) {
    AlteredMeasure *made = NULL;
    NPH_TRY(NPH_NEW(context, 1, "measurement of tolerances", &made));
    made->context = context;
    NphStatus status = nph_job_make(context, scene, options, &made->method, &made->job);
    if (status == NPH_OK) status = nph_stages_supported(context, made->method);
    if (status == NPH_OK) status = open_level(made, scene, options, made->job.precision, NPH_ISA_BASE, &made->exact);
    if (status == NPH_OK) status = add_causes(made, scene, options);
    if (status != NPH_OK) altered_measure_close(made);
    else *measure = made;
    return status;
}

void altered_measure_close(AlteredMeasure *m) {
    if (!m) return;
    for (int i = 0; i < m->opened_count; i++) nph_stages_close(m->opened[i]);
    nph_free(m->context, m->rows);
    nph_free(m->context, m);
}

static NphStatus row_of(AlteredMeasure *m, int buffer, Row **out) {
    for (int r = 0; r < m->row_count; r++)
        if (m->rows[r].stage == m->stage && m->rows[r].buffer == buffer && m->rows[r].cause == m->cause) {
            *out = &m->rows[r];
            return NPH_OK;
        }
    if ((size_t)m->row_count == m->row_room) {
        Row *larger = NULL;
        m->row_room = m->row_room ? 2 * m->row_room : 256;
        NPH_TRY(NPH_NEW(m->context, m->row_room, "rows of a measurement", &larger));
        if (m->row_count) memcpy(larger, m->rows, (size_t)m->row_count * sizeof *larger);
        nph_free(m->context, m->rows);
        m->rows = larger;
    }
    *out = &m->rows[m->row_count++];
    (*out)->stage = m->stage;
    (*out)->buffer = buffer;
    (*out)->cause = m->cause;
    return NPH_OK;
}

static double no_limit(void *user, const NphBuffer *buffer) {
    (void)user;
    (void)buffer;
    return nph_infinity();
}

static NphStatus take(void *user, const NphBufferGap *gap) {
    AlteredMeasure *m = user;
    Row *row = NULL;
    if (gap->problem[0]) return nph_error(m->context, NPH_BAD_INPUT, "%s: %s", gap->buffer->name, gap->problem);
    NPH_TRY(row_of(m, nph_buffer_find(m->method, gap->buffer->name), &row));
    row->launches++;
    row->items += gap->items;
    row->numbers = gap->limit > 0.0;
    row->turned += row->numbers ? 0 : gap->turned;
    for (int64_t i = 0; i < gap->gap_count && row->numbers; i++) {
        int octave = gap->gap[i] < 0.0 ? -1 : nph_octave(gap->gap[i]);
        if (octave < 0) continue;
        row->octave_items[octave]++;
        if (gap->gap[i] > row->octave_largest[octave]) row->octave_largest[octave] = gap->gap[i];
    }
    int octave = nph_octave(gap->ulp);
    if (nph_abs(gap->reference) < 1e30 && gap->absolute > row->octave_absolute[octave]) row->octave_absolute[octave] = gap->absolute;
    return NPH_OK;
}

/* What is left of numbers kept as halves; 0 where one is beyond their range. */
static int round_to_halves(NphArray *array) {
    int within = 1;
    for (int64_t i = 0; i < nph_array_count(array); i++) {
        float x = array->type == NPH_F64 ? (float)((double *)array->data)[i] : ((float *)array->data)[i];
        float y = nph_float_from_half(nph_half_from_float(x));
        within &= nph_absf(y) < nph_infinityf();
        if (array->type == NPH_F64) ((double *)array->data)[i] = (double)y;
        else ((float *)array->data)[i] = y;
    }
    return within;
}

static NphStatus copy_of(NphContext *context, const NphNamedArray *from, NphNamedArray *to) {
    to->name = from->name;
    NPH_TRY(nph_array_new(context, from->array.type, from->array.rank, from->array.shape, from->name, &to->array));
    size_t bytes = (size_t)nph_array_count(&from->array) * nph_type_size(from->array.type);
    if (bytes) memcpy(to->array.data, from->array.data, bytes);
    return NPH_OK;
}

static int is_half(const AlteredMeasure *m, const Simulation *s, const char *name) {
    return s->half >= 0 && nph_buffer_find(m->method, name) == s->half;
}

/* The launch under one simulation. changed: its own copy of the input that is kept in halves. */
static NphStatus simulate(AlteredMeasure *m, Simulation *s, const int64_t *arguments, const NphNamedArray *inputs, int count,
                          NphSide *side, NphNamedArray *changed) {
    NphNamedArray used[NPH_MAX_BUFFERS];
    int within = 1;
    for (int i = 0; i < count; i++) {
        used[i] = inputs[i];
        if (!is_half(m, s, inputs[i].name)) continue;
        NPH_TRY(copy_of(m->context, &inputs[i], changed));
        within = round_to_halves(&changed->array);
        used[i] = *changed;
    }
    if (within) {
        nph_accuracy = s->accuracy;
        nph_accuracy_salt = SALT;
        NphStatus status = nph_stages_run(s->stages, m->method->stages[m->stage].name, arguments, count, used, &side->outputs, side->buffers);
        nph_accuracy = NULL;
        side->count = side->outputs;
        NPH_TRY(status);
    }
    for (int o = 0; o < side->outputs; o++)
        if (is_half(m, s, side->buffers[o].name)) within &= round_to_halves(&side->buffers[o].array);
    if (!within) s->cause.unmeasured = "not measured: it holds numbers beyond the range of halves";
    for (int i = 0; i < count; i++) side->buffers[side->count++] = used[i];
    return NPH_OK;
}

/* Outputs only: inputs are others'. */
static void free_outputs(NphContext *context, NphSide *side) {
    side->count = side->outputs;
    nph_side_free(context, side);
}

static NphStatus measure_cause(AlteredMeasure *m, const int64_t *arguments, int count, const NphNamedArray *inputs, const NphSide *exact) {
    Simulation *s = &m->simulations[m->cause];
    NphCellWatch watch = {m, no_limit, take};
    NphSide side = {0};
    NphNamedArray changed = {0};
    const NphStage *stage = &m->method->stages[m->stage];
    const char *half = s->half >= 0 ? m->method->buffers[s->half].name : NULL;
    if (s->cause.unmeasured || (half && !nph_stage_lists(stage->reads, half) && !nph_stage_lists(stage->writes, half))) return NPH_OK;
    NphStatus status = simulate(m, s, arguments, inputs, count, &side, &changed);
    if (status == NPH_OK && !s->cause.unmeasured)
        status = nph_compare_sides(m->context, m->method, m->job.precision, exact, &side, &watch);
    free_outputs(m->context, &side);
    nph_array_free(m->context, &changed.array);
    return status;
}

NphStatus altered_measure_launch(AlteredMeasure *m, const char *stage, const int64_t *arguments, int count, const NphNamedArray *inputs) {
    NphSide exact = {0};
    m->stage = nph_stage_find(m->method, stage);
    NPH_TRY(nph_stages_run(m->exact, stage, arguments, count, inputs, &exact.outputs, exact.buffers));
    exact.count = exact.outputs;
    for (int i = 0; i < count; i++) exact.buffers[exact.count++] = inputs[i];
    NphStatus status = NPH_OK;
    for (m->cause = 0; m->cause < m->cause_count && status == NPH_OK; m->cause++)
        status = measure_cause(m, arguments, count, inputs, &exact);
    m->launches++;
    free_outputs(m->context, &exact);
    return status;
}

/* Which of a stage's launches: all where they are few, else a part that has nothing to do with how they follow each other. */
static int is_chosen(int64_t index, int64_t of) {
    uint32_t mixed = (uint32_t)index * 0x9E3779B9u;
    return of <= ALTERED_LAUNCHES || (double)mixed < 4294967296.0 * ALTERED_LAUNCHES / (double)of;
}

NphStatus altered_measure_dump(AlteredMeasure *m, const char *folder) {
    NphManifest manifest;
    int64_t of[NPH_MAX_STAGES] = {0};
    NPH_TRY(nph_manifest_read(m->context, folder, &manifest));
    NphStatus status = NPH_OK;
    for (int l = 0; l < manifest.launch_count; l++) {
        int stage = nph_stage_find(m->method, manifest.launches[l].stage);
        if (stage >= 0) of[stage]++;
    }
    for (int l = 0; l < manifest.launch_count && status == NPH_OK; l++) {
        NphNamedArray inputs[NPH_MAX_BUFFERS];
        const NphManifestLaunch *launch = &manifest.launches[l];
        int64_t arguments[NPH_MAX_ARGUMENTS] = {0};
        int count = 0, stage = nph_stage_find(m->method, launch->stage);
        if (stage < 0 || !is_chosen(m->seen[stage]++, of[stage])) continue;
        status = nph_launch_inputs(m->context, &manifest, launch, m->exact, arguments, inputs, &count);
        if (status == NPH_OK) status = altered_measure_launch(m, launch->stage, arguments, count, inputs);
        for (int i = 0; i < count; i++) nph_array_free(m->context, &inputs[i].array);
        nph_progress(m->context, "measuring", l + 1, manifest.launch_count, -1.0);
    }
    snprintf(m->from, sizeof m->from, "a dump: of each stage about %d of its launches at most", ALTERED_LAUNCHES);
    nph_manifest_free(m->context, &manifest);
    return status;
}

static NphStatus before(void *user, void *state, int worker, const NphLaunch *launch) {
    AlteredMeasure *m = user;
    NphNamedArray inputs[NPH_MAX_BUFFERS];
    const NphStage *stage = &m->method->stages[launch->stage];
    int count = 0;
    NphStatus status = NPH_OK;
    for (int b = 0; b < m->method->buffer_count && status == NPH_OK; b++) {
        if (!nph_stage_lists(stage->reads, m->method->buffers[b].name)) continue;
        status = nph_buffer_take(m->context, m->method, state, worker, b, &inputs[count].array);
        inputs[count].name = m->method->buffers[b].name;
        count += status == NPH_OK && inputs[count].array.rank > 0;
    }
    if (status == NPH_OK) status = altered_measure_launch(m, stage->name, launch->arguments, count, inputs);
    for (int i = 0; i < count; i++) nph_array_free(m->context, &inputs[i].array);
    return status;
}

static NphStatus after(void *user, void *state, int worker, const NphLaunch *launch) {
    (void)user;
    (void)state;
    (void)worker;
    (void)launch;
    return NPH_OK;
}

void altered_few(const NphScene *scene, const NphRenderOptions *options, NphRenderOptions *few) {
    int whole[4] = {0, 0, scene->sensor.width, scene->sensor.height};
    *few = *options;
    few->target_error = few->time_budget_s = 0.0;
    few->samples = few->sample_begin = 0;
    few->sample_end = NPH_CHUNK;
    if (!options->crop_given) memcpy(few->crop, whole, sizeof whole);
    few->crop_given = 1;
    for (int a = 0; a < 2; a++) {
        int middle = (few->crop[a] + few->crop[a + 2]) / 2 / NPH_TILE * NPH_TILE;
        if (few->crop[a] < middle - NPH_TILE) few->crop[a] = middle - NPH_TILE;
        if (few->crop[a + 2] > middle + NPH_TILE) few->crop[a + 2] = middle + NPH_TILE;
    }
}

NphStatus altered_measure_run(AlteredMeasure *m, const NphScene *scene, const NphRenderOptions *options) {
    NphTap tap = {m, before, after};
    NphFilm *film = NULL;
    const int *crop = m->job.crop;
    snprintf(m->from, sizeof m->from, "a run of samples %lld to %lld of the pixels from %d,%d to %d,%d", (long long)m->job.sample_begin,
             (long long)m->job.sample_end - 1, crop[0], crop[1], crop[2] - 1, crop[3] - 1);
    NphStatus status = nph_render_tapped(m->context, scene, options, &tap, &film, NULL);
    nph_film_free(m->context, film);
    return status;
}

/* Largest difference that rounding made, and how many items are above it for another reason. */
static int kept_octaves(const Row *row, int64_t *hidden) {
    int kept = NPH_OCTAVES - 1, top;
    int64_t above = 0;
    *hidden = 0;
    while (kept > 0 && row->octave_items[kept] == 0) kept--;
    top = kept;
    for (int octave = kept; octave > 0; octave--) {
        above += row->octave_items[octave];
        int next = octave - 1;
        while (next > 0 && row->octave_items[next] == 0) next--;
        if ((double)above > HIDDEN_PART * (double)row->items) break;
        if (row->octave_largest[next] * HIDDEN_JUMP > row->octave_largest[top]) continue;
        *hidden = above;
        kept = top = next;
    }
    return kept;
}

/* The difference that a part of the items does not exceed. */
static double quantile(const Row *row, double part) {
    int64_t below = 0;
    int octave = 0;
    for (; octave < NPH_OCTAVES - 1; octave++) {
        below += row->octave_items[octave];
        if ((double)below >= part * (double)row->items) break;
    }
    return row->octave_largest[octave];
}

static void tolerance_of(const AlteredMeasure *m, const Row *row, NphTolerance *out, int64_t *turned) {
    int64_t hidden;
    int kept = kept_octaves(row, &hidden);
    *turned = row->turned + hidden;
    out->gap = row->octave_largest[kept];
    double part = row->items > 0 ? (double)*turned / (double)row->items : 0.0;
    snprintf(out->stage, sizeof out->stage, "%s", m->method->stages[row->stage].name);
    snprintf(out->buffer, sizeof out->buffer, "%s", m->method->buffers[row->buffer].name);
    snprintf(out->cause, sizeof out->cause, "%s", m->simulations[row->cause].cause.name);
    out->ulp = row->numbers ? ALTERED_FACTOR * (out->gap > 1.0 ? out->gap : 1.0) : 0.0;
    double typical = quantile(row, 1.0 - ALTERED_TAIL);
    typical = typical < out->gap ? typical : out->gap;
    out->typical = row->numbers ? ALTERED_TYPICAL * (typical > 1.0 ? typical : 1.0) : 0.0;
    out->tail = ALTERED_FACTOR * ALTERED_TAIL;
    out->flips = ALTERED_FACTOR * (part > ALTERED_FLOOR ? part : ALTERED_FLOOR);
    if (out->flips > 1.0) out->flips = 1.0;
}

/* Halves that overflow in a later launch are no cause after all. */
static int is_told(const AlteredMeasure *m, const Row *row) { return !m->simulations[row->cause].cause.unmeasured; }

static void digest_of(const AlteredMeasure *m, char text[33]) {
    for (int i = 0; i < 16; i++) snprintf(text + 2 * i, 3, "%02x", m->job.scene->digest[i]);
}

NphStatus altered_measure_tolerances(const AlteredMeasure *m, NphTolerances *tolerances) {
    NphTolerances made = {.precision = m->job.precision};
    int64_t turned;
    NPH_TRY(NPH_NEW(m->context, m->row_count > 0 ? m->row_count : 1, "tolerances", &made.rows));
    snprintf(made.method, sizeof made.method, "%s", m->method->name);
    digest_of(m, made.scene_digest);
    for (int r = 0; r < m->row_count; r++)
        if (is_told(m, &m->rows[r])) tolerance_of(m, &m->rows[r], &made.rows[made.count++], &turned);
    *tolerances = made;
    return NPH_OK;
}

static void json_row(const AlteredMeasure *m, const Row *row, NphJson *json) {
    NphTolerance tolerance;
    int64_t turned;
    double absolute = 0.0;
    tolerance_of(m, row, &tolerance, &turned);
    for (int octave = 0; octave <= nph_octave(tolerance.gap); octave++)
        if (row->octave_absolute[octave] > absolute) absolute = row->octave_absolute[octave];
    nph_json_object(json, NULL);
    nph_json_text(json, "stage", tolerance.stage);
    nph_json_text(json, "buffer", tolerance.buffer);
    nph_json_text(json, "cause", tolerance.cause);
    nph_json_number(json, "ulp", tolerance.ulp);
    nph_json_number(json, "flips", tolerance.flips);
    nph_json_number(json, "typical_ulp", tolerance.typical);
    nph_json_number(json, "tail", tolerance.tail);
    nph_json_integer(json, "launches", row->launches);
    nph_json_integer(json, "items", row->items);
    nph_json_integer(json, "turned", turned);
    nph_json_number(json, "gap_ulp", tolerance.gap);
    if (row->numbers) {
        nph_json_number(json, "gap_absolute", absolute);
        nph_json_numbers(json, "quantiles_ulp", 3, (double[3]){quantile(row, 0.5), quantile(row, 0.99), quantile(row, 0.999)});
    }
    nph_json_close(json);
}

void altered_measure_write(const AlteredMeasure *m, const char *scene_name, NphJson *json) {
    char digest[33];
    digest_of(m, digest);
    nph_json_object(json, NULL);
    nph_json_integer(json, "nephos_tolerances", 1);
    nph_json_text(json, "version", nph_version());
    nph_json_text(json, "scene", scene_name);
    nph_json_text(json, "scene_digest", digest);
    nph_json_text(json, "method", m->method->name);
    nph_json_text(json, "precision", m->job.precision == 32 ? "f32" : "f64");
    nph_json_text(json, "measured_on", m->from);
    nph_json_integer(json, "launches", m->launches);
    nph_json_number(json, "factor", ALTERED_FACTOR);
    nph_json_number(json, "typical_factor", ALTERED_TYPICAL);
    nph_json_number(json, "least_flips", ALTERED_FLOOR);
    nph_json_array(json, "causes");
    for (int c = 0; c < m->cause_count; c++) {
        const AlteredCause *cause = &m->simulations[c].cause;
        nph_json_object(json, NULL);
        nph_json_text(json, "name", cause->name);
        nph_json_text(json, "is", cause->source);
        nph_json_text(json, "unmeasured", cause->unmeasured);
        nph_json_close(json);
    }
    nph_json_close(json);
    nph_json_array(json, "tolerances");
    for (int r = 0; r < m->row_count; r++)
        if (is_told(m, &m->rows[r])) json_row(m, &m->rows[r], json);
    nph_json_close(json);
    nph_json_close(json);
}
