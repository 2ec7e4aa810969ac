/* SPDX-License-Identifier: Apache-2.0
 *
 * One stage of a method alone: inputs are placed in the memory of a worker as the run would have left them there. */
#include "oracle/stages.h"

#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "method/job.h"

const char *const nph_class_names[] = {[NPH_EXACT] = "exact", [NPH_NEAR] = "near", [NPH_STAT] = "stat", [NPH_BIAS] = "bias"};

struct NphStages {
    NphContext *context;
    const NphMethod *method;
    NphJob job;
    void *state;
    NphFilm *film;
};

int nph_buffer_find(const NphMethod *method, const char *name) {
    for (int b = 0; b < method->buffer_count; b++)
        if (strcmp(method->buffers[b].name, name) == 0) return b;
    return -1;
}

int nph_stage_find(const NphMethod *method, const char *name) {
    for (int s = 0; s < method->stage_count; s++)
        if (strcmp(method->stages[s].name, name) == 0) return s;
    return -1;
}

NphStatus nph_stages_supported(NphContext *context, const NphMethod *method) {
    if (method->launch) return NPH_OK;
    return nph_error(context, NPH_BAD_USAGE, "the stages of method %s cannot be dumped or run alone", method->name);
}

static int64_t row_length(const NphView *view) {
    int64_t length = 1;
    for (int a = view->rank > 1; a < view->rank; a++) length *= view->shape[a];
    return length;
}

static int64_t row_count(const NphView *view) { return view->rank > 1 ? view->shape[0] : 1; }

NphStatus nph_buffer_take(NphContext *context, const NphMethod *method, void *state, int worker, int buffer, NphArray *array) {
    NphView view;
    memset(array, 0, sizeof *array);
    if (!method->view(state, worker, buffer, &view)) return NPH_OK;
    NPH_TRY(nph_array_new(context, view.type, view.rank, view.shape, method->buffers[buffer].name, array));
    size_t element = nph_type_size(view.type), bytes = (size_t)row_length(&view) * element;
    for (int64_t r = 0; r < row_count(&view) && bytes; r++)
        memcpy((char *)array->data + (size_t)r * bytes, (const char *)view.data + (size_t)(r * view.stride) * element, bytes);
    return NPH_OK;
}

NphStatus nph_stages_open(NphContext *context, const NphScene *scene, const NphRenderOptions *options, NphStages **stages) {
    NphStages *made = NULL;
    NPH_TRY(NPH_NEW(context, 1, "stages", &made));
    made->context = context;
    NphStatus status = nph_job_make(context, scene, options, &made->method, &made->job);
    const NphJob *job = &made->job;
    if (status == NPH_OK) status = nph_stages_supported(context, made->method);
    if (status == NPH_OK)
        status = nph_film_new(context, scene->sensor.width, scene->sensor.height, job->crop, made->method->channels(job),
                              job->sample_begin, job->sample_end, &made->film);
    if (status == NPH_OK) status = made->method->open(job, &made->state);
    if (status != NPH_OK) nph_stages_close(made);
    else *stages = made;
    return status;
}

void nph_stages_close(NphStages *stages) {
    if (!stages) return;
    if (stages->state) stages->method->close(stages->state);
    nph_film_free(stages->context, stages->film);
    nph_free(stages->context, stages);
}

int nph_stages_count(const NphStages *stages) { return stages->method->stage_count; }
int nph_stages_buffer_count(const NphStages *stages) { return stages->method->buffer_count; }
int nph_stages_argument_count(const NphStages *stages) { return stages->method->argument_count; }
const char *nph_stages_argument(const NphStages *stages, int index) { return stages->method->arguments[index]; }

NphStageInfo nph_stages_stage(const NphStages *stages, int index) {
    const NphStage *stage = &stages->method->stages[index];
    return (NphStageInfo){stage->name, stage->source, stage->reads, stage->writes};
}

NphBufferInfo nph_stages_buffer(const NphStages *stages, int index) {
    const NphBuffer *b = &stages->method->buffers[index];
    return (NphBufferInfo){b->name, b->shape, b->unit, b->meaning, nph_class_names[b->comparison], b->needed, b->identity, b->queue};
}

static const NphArray *input_of(int count, const NphNamedArray *inputs, const char *name) {
    for (int i = 0; i < count; i++)
        if (strcmp(inputs[i].name, name) == 0) return &inputs[i].array;
    return NULL;
}

static int is_real(NphType type) { return type == NPH_F32 || type == NPH_F64; }

static void copy_row(const NphArray *array, int64_t first, int64_t count, NphType type, void *to) {
    size_t element = nph_type_size(array->type);
    if (type == array->type) memcpy(to, (const char *)array->data + (size_t)first * element, (size_t)count * element);
    else if (type == NPH_F64)
        for (int64_t i = 0; i < count; i++) ((double *)to)[i] = (double)((const float *)array->data)[first + i];
    else
        for (int64_t i = 0; i < count; i++) ((float *)to)[i] = (float)((const double *)array->data)[first + i];
}

NphStatus nph_buffer_place(NphContext *context, const NphMethod *method, void *state, int worker, int buffer, const NphArray *array) {
    const NphBuffer *what = &method->buffers[buffer];
    NphView view;
    int64_t shape[NPH_MAX_RANK];
    for (int a = 0; a < NPH_MAX_RANK; a++) shape[a] = a < array->rank ? array->shape[a] : 1;
    if (array->rank < 1 || (method->view(state, worker, buffer, &view) && array->rank != view.rank))
        return nph_error(context, NPH_BAD_INPUT, "input %s: %d axes, expected %s", what->name, array->rank, what->shape);
    NPH_TRY(method->extend(state, worker, buffer, shape));
    if (!method->view(state, worker, buffer, &view)) return NPH_OK;
    for (int a = 0; a < view.rank; a++)
        if (view.shape[a] != array->shape[a])
            return nph_error(context, NPH_BAD_INPUT, "input %s: axis %d has %lld elements, expected %lld (%s)", what->name, a,
                             (long long)array->shape[a], (long long)view.shape[a], what->shape);
    if (view.type != array->type && !(is_real(view.type) && is_real(array->type)))
        return nph_error(context, NPH_BAD_INPUT, "input %s: type %s, expected %s", what->name, nph_type_name(array->type),
                         nph_type_name(view.type));
    for (int64_t r = 0; r < row_count(&view); r++)
        copy_row(array, r * row_length(&view), row_length(&view), view.type,
                 (char *)view.data + (size_t)(r * view.stride) * nph_type_size(view.type));
    return NPH_OK;
}

/* Before anything is placed: whether a buffer is there depends on the scene alone. */
static NphStatus begin(NphStages *stages, const char *stage, const int64_t *arguments, NphLaunch *launch) {
    const NphMethod *method = stages->method;
    *launch = (NphLaunch){.stage = nph_stage_find(method, stage)};
    if (launch->stage < 0)
        return nph_error(stages->context, NPH_BAD_USAGE, "method %s has no stage %s", method->name, stage);
    for (int a = 0; a < method->argument_count; a++) launch->arguments[a] = arguments[a];
    return method->begin_launch(stages->state, 0, stages->film, launch);
}

NphStatus nph_stages_missing(NphStages *stages, const char *stage, const int64_t *arguments, int input_count, const NphNamedArray *inputs,
                             const char **missing) {
    NphLaunch launch;
    NPH_TRY(begin(stages, stage, arguments, &launch));
    *missing = NULL;
    for (int b = 0; b < stages->method->buffer_count && !*missing; b++) {
        NphView view;
        const char *name = stages->method->buffers[b].name;
        if (nph_stage_lists(stages->method->stages[launch.stage].reads, name) && !input_of(input_count, inputs, name) &&
            stages->method->view(stages->state, 0, b, &view))
            *missing = name;
    }
    return NPH_OK;
}

static int by_value(const void *a, const void *b) {
    int32_t x = *(const int32_t *)a, y = *(const int32_t *)b;
    return (x > y) - (x < y);
}

/* Who stands in a queue twice would be taken up twice. */
static NphStatus check_queue(NphContext *context, const char *name, const NphArray *queue) {
    int32_t *sorted = NULL;
    int64_t count = nph_array_count(queue);
    if (queue->type != NPH_I32 || count < 2) return NPH_OK;
    NPH_TRY(NPH_NEW(context, count, "queue", &sorted));
    memcpy(sorted, queue->data, (size_t)count * sizeof *sorted);
    qsort(sorted, (size_t)count, sizeof *sorted, by_value);
    NphStatus status = NPH_OK;
    for (int64_t i = 1; i < count && status == NPH_OK; i++)
        if (sorted[i] == sorted[i - 1]) status = nph_error(context, NPH_BAD_INPUT, "input %s: position %d stands there twice", name, (int)sorted[i]);
    nph_free(context, sorted);
    return status;
}

static NphStatus place_inputs(NphStages *stages, const NphStage *stage, int count, const NphNamedArray *inputs) {
    for (int i = 0; i < count; i++)
        if (nph_buffer_find(stages->method, inputs[i].name) < 0 || !nph_stage_lists(stage->reads, inputs[i].name))
            return nph_error(stages->context, NPH_BAD_INPUT, "input %s: %s reads %s", inputs[i].name, stage->name,
                             stage->reads[0] ? stage->reads : "nothing");
    for (int b = 0; b < stages->method->buffer_count; b++) {
        NphView view;
        const char *name = stages->method->buffers[b].name;
        const NphArray *input = input_of(count, inputs, name);
        if (!nph_stage_lists(stage->reads, name)) continue;
        if (input && stages->method->buffers[b].queue == NPH_QUEUE_AS_SET) NPH_TRY(check_queue(stages->context, name, input));
        if (input) NPH_TRY(nph_buffer_place(stages->context, stages->method, stages->state, 0, b, input));
        else if (stages->method->view(stages->state, 0, b, &view))
            return nph_error(stages->context, NPH_BAD_INPUT, "%s reads %s, which is not among the inputs", stage->name, name);
    }
    return NPH_OK;
}

/* What is left from one output on has been freed where taking it fails. */
static NphStatus take_outputs(NphStages *stages, const NphStage *stage, int *count, NphNamedArray *outputs) {
    int made = 0;
    NphStatus status = NPH_OK;
    for (int b = 0; b < stages->method->buffer_count && status == NPH_OK; b++) {
        const char *name = stages->method->buffers[b].name;
        if (!nph_stage_lists(stage->writes, name)) continue;
        outputs[made].name = name;
        status = nph_buffer_take(stages->context, stages->method, stages->state, 0, b, &outputs[made].array);
        if (status == NPH_OK && outputs[made].array.rank > 0) made++;
    }
    for (int o = 0; o < made && status != NPH_OK; o++) nph_array_free(stages->context, &outputs[o].array);
    *count = status == NPH_OK ? made : 0;
    return status;
}

NphStatus nph_stages_run(NphStages *stages, const char *stage, const int64_t *arguments, int input_count,
                         const NphNamedArray *inputs, int *output_count, NphNamedArray *outputs) {
    const NphMethod *method = stages->method;
    NphLaunch launch;
    NPH_TRY(begin(stages, stage, arguments, &launch));
    NPH_TRY(place_inputs(stages, &method->stages[launch.stage], input_count, inputs));
    NPH_TRY(method->check(stages->state, 0, &launch));
    NPH_TRY(method->launch(stages->state, 0, &launch));
    return take_outputs(stages, &method->stages[launch.stage], output_count, outputs);
}
