/* SPDX-License-Identifier: Apache-2.0
 *
 * See dump_parts.h. The tap writes a buffer where it has changed, which its digest tells, while it still lies in the cache. A
 * launch's line in the manifest is opened before it, with its inputs, and closed after it. */
#define _POSIX_C_SOURCE 200809L
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "core/memory.h"
#include "core/message.h"
#include "io/volume.h"
#include "oracle/dump_parts.h"

/* What is launched once is always written: no stage can be ported without what media hold. */
static int is_selected(const NphDump *dump, const NphLaunch *launch) {
    const NphDumpOptions *o = dump->options;
    if (launch->batch == NPH_BATCH_OF_SCENE) return 1;
    return (dump->stage < 0 || launch->stage == dump->stage) && (o->launch < 0 || launch->number == o->launch) &&
           (o->batch < 0 || launch->batch == o->batch) && (dump->tile < 0 || launch->arguments[0] == dump->tile);
}

/* Another block, with what there is of the line. */
static NphStatus add_block(NphDumpWorker *worker, size_t length) {
    enum { BLOCK_BYTES = 1 << 18 };
    NphDumpRecord *record = &worker->records[worker->record_count - 1];
    size_t begun = worker->block ? (size_t)(worker->block->text + worker->block_used - record->line) : 0;
    size_t room = begun + length < BLOCK_BYTES / 2 ? BLOCK_BYTES : 2 * (begun + length);
    NphDumpBlock *made = NULL;
    NPH_TRY(nph_alloc(worker->context, sizeof *made + room, 1, "manifest of a dump", (void **)&made));
    if (begun) memcpy(made->text, record->line, begun);
    made->before = worker->block;
    record->line = made->text;
    worker->block = made;
    worker->block_room = room;
    worker->block_used = begun;
    return NPH_OK;
}

/* NphTextFn: to the line of the record made last. */
static void add_text(void *user, const char *text, size_t length) {
    NphDumpWorker *worker = user;
    if (worker->text_status == NPH_OK && worker->block_used + length > worker->block_room)
        worker->text_status = add_block(worker, length);
    if (worker->text_status != NPH_OK) return;
    memcpy(worker->block->text + worker->block_used, text, length);
    worker->block_used += length;
}

static NphStatus add_record(NphDumpWorker *worker, const NphLaunch *launch) {
    if (worker->record_count == worker->record_room) {
        size_t room = 2 * worker->record_room + 256;
        NPH_TRY(nph_realloc(worker->context, room, sizeof *worker->records, "launches of a dump", (void **)&worker->records));
        worker->record_room = room;
    }
    const char *line = worker->block ? worker->block->text + worker->block_used : NULL;
    worker->records[worker->record_count++] = (NphDumpRecord){launch->batch, launch->number, line, 0};
    return NPH_OK;
}

static void json_shape(NphJson *json, int rank, const int64_t *shape) {
    nph_json_array(json, "shape");
    for (int a = 0; a < rank; a++) nph_json_integer(json, NULL, shape[a]);
    nph_json_close(json);
}

/* From its batch to its grid. */
static void json_launch(NphJson *json, const NphMethod *method, const NphLaunch *launch) {
    const NphStage *stage = &method->stages[launch->stage];
    nph_json_integer(json, "batch", launch->batch);
    nph_json_integer(json, "number", launch->number);
    nph_json_text(json, "stage", stage->name);
    nph_json_object(json, "arguments");
    for (int a = 0; a < method->argument_count; a++) nph_json_integer(json, method->arguments[a], launch->arguments[a]);
    nph_json_close(json);
    nph_json_integer(json, "items", launch->items);
    nph_json_array(json, "grid");
    nph_json_integer(json, NULL, (launch->items + stage->block[0] - 1) / stage->block[0]);
    nph_json_integer(json, NULL, 1);
    nph_json_integer(json, NULL, 1);
    nph_json_close(json);
}

static void json_output(NphJson *json, const char *buffer, const NphDumpArray *array) {
    nph_json_object(json, NULL);
    nph_json_text(json, "buffer", buffer);
    nph_json_text(json, "file", array->file);
    nph_json_text(json, "type", nph_type_name(array->type));
    json_shape(json, array->rank, array->shape);
    nph_json_text(json, "digest", array->digest);
    nph_json_close(json);
}

static NphStatus cannot(const NphDumpWorker *worker, const char *what) {
    return nph_error(worker->context, NPH_BAD_OUTPUT, "%s: cannot be %s: %s", worker->path, what, strerror(errno));
}

static NphStatus close_file(NphDumpWorker *worker) {
    if (!worker->is_open) return NPH_OK;
    NphStatus status = nph_appender_flush(worker->context, &worker->file);
    worker->is_open = 0;
    if (close(worker->file.file) != 0 && status == NPH_OK) status = cannot(worker, "written");
    return status;
}

static NphStatus open_file(const NphDump *dump, NphDumpWorker *worker, const char *name) {
    snprintf(worker->path, sizeof worker->path, "%s/%s", dump->options->folder, name);
    int file = open(worker->path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file < 0) return cannot(worker, "made");
    NphStatus status = worker->file.block ? NPH_OK : nph_appender_open(worker->context, file, worker->path, &worker->file);
    if (status != NPH_OK) close(file);
    else worker->file.file = file;
    worker->is_open = status == NPH_OK;
    return status;
}

/* To the file of the batch, which holds its arrays one after the other. */
static NphStatus append(const NphDump *dump, NphDumpWorker *worker, const NphLaunch *launch, const NphView *view, char place[NPH_DUMP_NAME]) {
    char name[NPH_DUMP_NAME / 2];
    NphArray array = {view->type, view->rank, {0}, view->data};
    for (int a = 0; a < NPH_MAX_RANK; a++) array.shape[a] = a < view->rank ? view->shape[a] : 1;
    if (launch->batch == NPH_BATCH_OF_SCENE) snprintf(name, sizeof name, "scene.npys");
    else snprintf(name, sizeof name, "%06lld.npys", (long long)launch->batch);
    if (!worker->is_open || worker->batch != launch->batch) {
        NPH_TRY(close_file(worker));
        NPH_TRY(open_file(dump, worker, name));
        worker->batch = launch->batch;
        worker->bytes = 0;
    }
    snprintf(place, NPH_DUMP_NAME, "%s@%lld", name, (long long)worker->bytes);
    int64_t stride = view->rank > 1 ? view->stride * (int64_t)nph_type_size(view->type) : 0;
    return nph_npy_append(worker->context, &worker->file, &array, stride, &worker->bytes);
}

static NphStatus count_bytes(NphDump *dump, const NphLaunch *launch, uint64_t bytes) {
    pthread_mutex_lock(&dump->lock);
    uint64_t all = dump->bytes += bytes;
    if (launch->batch == NPH_BATCH_OF_SCENE) dump->once += bytes;
    pthread_mutex_unlock(&dump->lock);
    if (!dump->write || all <= dump->options->limit_bytes) return NPH_OK;
    return nph_error(dump->context, NPH_NO_MEMORY, "the dump grows beyond its limit of %.1f MiB: write less (--dump-select), or allow more "
                     "(--dump-limit)", (double)dump->options->limit_bytes / 1048576.0);
}

/* Writes a buffer as it stands; worker->now[buffer] is then its file: the one that held it before where nothing has changed. */
static NphStatus write_buffer(NphDump *dump, NphDumpWorker *worker, const NphLaunch *launch, const NphView *view, NphDumpArray *now) {
    NphDumpArray made = {.rank = view->rank, .type = view->type};
    size_t rows = view->rank > 1 ? (size_t)view->shape[0] : 1, row = nph_type_size(view->type);
    for (int a = view->rank > 1; a < view->rank; a++) row *= (size_t)view->shape[a];
    memcpy(made.shape, view->shape, sizeof made.shape);
    dump->digest(view->data, rows, row, (size_t)view->stride * nph_type_size(view->type), made.digest);
    if (now->file[0] && now->rank == made.rank && strcmp(now->digest, made.digest) == 0 &&
        memcmp(now->shape, made.shape, sizeof made.shape) == 0)
        return NPH_OK;
    NPH_TRY(count_bytes(dump, launch, row * rows + 128));
    if (dump->write) NPH_TRY(append(dump, worker, launch, view, made.file));
    else made.file[0] = '-';
    *now = made;
    return NPH_OK;
}

/* The same of what the method shows; no file where this scene has no such buffer. */
static NphStatus write_shown(NphDump *dump, int index, void *state, const NphLaunch *launch, int buffer) {
    NphView view;
    NphDumpArray *now = &dump->workers[index].now[buffer];
    if (dump->method->view(state, index, buffer, &view)) return write_buffer(dump, &dump->workers[index], launch, &view, now);
    now->file[0] = 0;
    return NPH_OK;
}

NphStatus nph_dump_before(void *user, void *state, int index, const NphLaunch *launch) {
    NphDump *dump = user;
    NphDumpWorker *worker = &dump->workers[index];
    const NphMethod *method = dump->method;
    NphJson *json = &worker->json;
    if (dump->one_batch && launch->batch > 0) return NPH_INTERRUPTED;
    int alone = launch->number == 0 || launch->batch == NPH_BATCH_OF_SCENE;
    for (int b = 0; b < method->buffer_count && alone; b++) worker->now[b].file[0] = 0;
    if (!is_selected(dump, launch)) return NPH_OK;
    NPH_TRY(add_record(worker, launch));
    nph_json_begin_line(json, add_text, worker);
    nph_json_object(json, NULL);
    json_launch(json, method, launch);
    nph_json_object(json, "inputs");
    for (int b = 0; b < method->buffer_count; b++) {
        if (!dump->reads[launch->stage][b]) continue;
        if (!worker->now[b].file[0]) NPH_TRY(write_shown(dump, index, state, launch, b));
        if (worker->now[b].file[0]) nph_json_text(json, method->buffers[b].name, worker->now[b].file);
    }
    nph_json_close(json);
    return worker->text_status;
}

NphStatus nph_dump_after(void *user, void *state, int index, const NphLaunch *launch) {
    NphDump *dump = user;
    NphDumpWorker *worker = &dump->workers[index];
    const NphMethod *method = dump->method;
    int selected = is_selected(dump, launch);
    if (selected) nph_json_array(&worker->json, "outputs");
    for (int b = 0; b < method->buffer_count; b++) {
        if (!dump->writes[launch->stage][b]) continue;
        if (selected) NPH_TRY(write_shown(dump, index, state, launch, b));
        else worker->now[b].file[0] = 0;
        if (worker->now[b].file[0]) json_output(&worker->json, method->buffers[b].name, &worker->now[b]);
    }
    if (!selected) return NPH_OK;
    nph_json_close(&worker->json);
    nph_json_close(&worker->json);
    if (worker->text_status != NPH_OK) return worker->text_status;
    NphDumpRecord *record = &worker->records[worker->record_count - 1];
    record->length = (size_t)(worker->block->text + worker->block_used - record->line);
    return NPH_OK;
}

NphStatus nph_dump_close_files(NphDump *dump) {
    NphStatus status = NPH_OK;
    for (int w = 0; w < dump->worker_count; w++) {
        NphStatus closed = close_file(&dump->workers[w]);
        if (closed != NPH_OK) status = closed;
    }
    return status;
}

void nph_dump_free_workers(NphDump *dump) {
    for (int w = 0; dump->workers && w < dump->worker_count; w++) {
        NphDumpWorker *worker = &dump->workers[w];
        if (worker->is_open) close(worker->file.file); /* of a run that failed */
        nph_appender_close(dump->context, &worker->file);
        nph_free(dump->context, worker->records);
        for (NphDumpBlock *block = worker->block, *before; block; block = before) {
            before = block->before;
            nph_free(dump->context, block);
        }
    }
    nph_free(dump->context, dump->workers);
}
