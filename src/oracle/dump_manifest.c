/* SPDX-License-Identifier: Apache-2.0
 *
 * manifest.json of a dump, written when all else is there: a dump without one is not whole. See dump_parts.h. */
#define _POSIX_C_SOURCE 200809L
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "oracle/dump_facts.h"
#include "oracle/dump_parts.h"

static int by_launch(const void *a, const void *b) {
    const NphDumpRecord *x = a, *y = b;
    if (x->batch != y->batch) return x->batch < y->batch ? -1 : 1;
    return (x->number > y->number) - (x->number < y->number);
}

typedef struct Sink {
    NphContext *context;
    NphAppender file;
    NphStatus status;
} Sink;

/* NphTextFn: most of the manifest is lines of launches, too long for a stream's small writes. */
static void add_text(void *user, const char *text, size_t length) {
    Sink *sink = user;
    if (sink->status == NPH_OK) sink->status = nph_appender_add(sink->context, &sink->file, text, length);
}

static NphStatus join_records(const NphDump *dump, NphDumpRecord **out, size_t *count) {
    size_t total = 0;
    for (int w = 0; w < dump->worker_count; w++) total += dump->workers[w].record_count;
    NPH_TRY(NPH_NEW(dump->context, total > 0 ? total : 1, "launches of a dump", out));
    *count = 0;
    for (int w = 0; w < dump->worker_count; w++) {
        const NphDumpWorker *worker = &dump->workers[w];
        if (worker->record_count) memcpy(*out + *count, worker->records, worker->record_count * sizeof **out);
        *count += worker->record_count;
    }
    qsort(*out, total, sizeof **out, by_launch);
    return NPH_OK;
}

/* Blank-separated names as an array of texts. */
static void json_names(NphJson *json, const char *key, const char *names) {
    char name[128];
    nph_json_array(json, key);
    for (const char *at = names; *at; at += strspn(at, " ")) {
        size_t length = strcspn(at, " ");
        snprintf(name, sizeof name, "%.*s", (int)length, at);
        nph_json_text(json, NULL, name);
        at += length;
    }
    nph_json_close(json);
}

static void json_stages(NphJson *json, const NphMethod *method) {
    nph_json_array(json, "stages");
    for (int s = 0; s < method->stage_count; s++) {
        const NphStage *stage = &method->stages[s];
        double block[3] = {stage->block[0], stage->block[1], stage->block[2]};
        nph_json_object(json, NULL);
        nph_json_text(json, "name", stage->name);
        nph_json_text(json, "source", stage->source);
        json_names(json, "reads", stage->reads);
        json_names(json, "writes", stage->writes);
        nph_json_numbers(json, "block", 3, block);
        nph_json_integer(json, "scratch_bytes", (int64_t)stage->scratch_bytes);
        nph_json_close(json);
    }
    nph_json_close(json);
}

static void json_buffers(NphJson *json, const NphMethod *method, int precision) {
    nph_json_array(json, "buffers");
    for (int b = 0; b < method->buffer_count; b++) {
        const NphBuffer *buffer = &method->buffers[b];
        NphType type = buffer->type == NPH_TYPE_REAL ? (precision == 32 ? NPH_F32 : NPH_F64) : (NphType)buffer->type;
        nph_json_object(json, NULL);
        nph_json_text(json, "name", buffer->name);
        nph_json_text(json, "type", nph_type_name(type));
        nph_json_text(json, "shape", buffer->shape);
        nph_json_text(json, "unit", buffer->unit);
        nph_json_text(json, "meaning", buffer->meaning);
        nph_json_text(json, "comparison", nph_class_names[buffer->comparison]);
        nph_json_text(json, "needed", buffer->needed);
        nph_json_text(json, "identity", buffer->identity);
        nph_json_boolean(json, "queue", buffer->queue);
        nph_json_close(json);
    }
    nph_json_close(json);
}

static void json_job(NphJson *json, const NphJob *job, const NphMethod *method, const char *scene_name) {
    char digest[NPH_DIGEST_TEXT];
    for (int i = 0; i < 16; i++) snprintf(digest + 2 * i, 3, "%02x", job->scene->digest[i]);
    nph_json_integer(json, "nephos_dump", 1);
    nph_json_text(json, "version", nph_version());
    nph_json_text(json, "scene", scene_name);
    nph_json_integer(json, "scene_frame", job->scene->frame);
    nph_json_text(json, "scene_digest", digest);
    nph_json_text(json, "method", method->name);
    nph_json_text(json, "precision", job->precision == 32 ? "f32" : "f64");
    nph_json_text(json, "plan", job->plan_full ? "full" : "lean");
    nph_json_integer(json, "seed", job->seed);
    nph_json_integer(json, "frame", job->frame);
    nph_json_numbers(json, "resolution", 2, (double[2]){job->scene->sensor.width, job->scene->sensor.height});
    nph_json_numbers(json, "crop", 4, (double[4]){job->crop[0], job->crop[1], job->crop[2], job->crop[3]});
    nph_json_numbers(json, "samples", 2, (double[2]){(double)job->sample_begin, (double)job->sample_end});
    nph_json_object(json, "knobs");
    for (int k = 0; k < method->knob_count; k++) nph_json_number(json, method->knobs[k].name, job->knobs[k]);
    nph_json_close(json);
}

static NphStatus write_text(const NphDump *dump, const NphJob *job, const char *scene_name, size_t count, const NphDumpRecord *records,
                            Sink *sink) {
    NphJson json;
    nph_json_begin(&json, add_text, sink);
    nph_json_object(&json, NULL);
    json_job(&json, job, dump->method, scene_name);
    json_stages(&json, dump->method);
    json_buffers(&json, dump->method, job->precision);
    NPH_TRY(nph_json_facts(&json, dump->method, job));
    nph_json_array(&json, "launches");
    for (size_t r = 0; r < count; r++) nph_json_copy(&json, NULL, records[r].line, records[r].length);
    nph_json_close(&json);
    nph_json_close(&json);
    return sink->status == NPH_OK ? nph_appender_flush(sink->context, &sink->file) : sink->status;
}

NphStatus nph_dump_write_manifest(const NphDump *dump, const NphJob *job, const char *scene_name) {
    NphDumpRecord *records = NULL;
    size_t count = 0;
    char path[NPH_DUMP_PATH];
    NphWriter writer;
    Sink sink = {.context = dump->context};
    const NphDumpOptions *what = dump->options;
    NPH_TRY(join_records(dump, &records, &count));
    snprintf(path, sizeof path, "%s/manifest.json", dump->options->folder);
    NphStatus status = nph_writer_open(dump->context, path, &writer);
    if (status == NPH_OK) {
        status = nph_appender_open(dump->context, fileno(writer.stream), path, &sink.file);
        if (status == NPH_OK) status = write_text(dump, job, scene_name, count, records, &sink);
        nph_appender_close(dump->context, &sink.file);
        if (status == NPH_OK) status = nph_writer_commit_unsynced(dump->context, &writer);
        else nph_writer_abandon(dump->context, &writer);
    }
    nph_free(dump->context, records);
    if (status == NPH_OK && count == 0 && (what->stage || what->launch >= 0 || what->batch >= 0 || what->pixel_given))
        return nph_error(dump->context, NPH_BAD_USAGE, "%s: no launch of this run is among those to be written (--dump-select)", path);
    return status;
}
