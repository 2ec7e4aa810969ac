/* SPDX-License-Identifier: Apache-2.0
 *
 * Dumps: a tap that writes what launches leave behind. Each worker keeps its own list of what it has written, and for the
 * batch under way which file holds a buffer's present contents, so that the inputs of a launch are the files of earlier ones. The
 * lists are joined, sorted and written as manifest.json when all is there: a dump without one is not whole. */
#define _POSIX_C_SOURCE 200809L
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/json.h"
#include "core/memory.h"
#include "core/message.h"
#include "io/file.h"
#include "io/volume.h"
#include "method/job.h"
#include "oracle/digest.h"
#include "oracle/dump_facts.h"
#include "oracle/stages.h"

enum { FILE_NAME = 96 };

/* An array in a file, once for each launch that reads or wrote it. */
typedef struct Use {
    int buffer, input, rank;
    NphType type;
    int64_t shape[NPH_MAX_RANK];
    char file[FILE_NAME], digest[NPH_DIGEST_TEXT];
} Use;

typedef struct Record {
    NphLaunch launch;
    int first, count; /* of its uses */
    const Use *uses;  /* once all is joined */
} Record;

typedef struct Worker {
    Record *records;
    Use *uses;
    size_t record_room, use_room;
    int record_count, use_count;
    Use now[NPH_MAX_BUFFERS]; /* what holds each buffer; file[0] 0: nothing does */
    int file;         /* of the batch under way; -1 */
    int64_t file_batch, file_bytes;
} Worker;

typedef struct Dump {
    NphContext *context;
    const NphMethod *method;
    const NphDumpOptions *options;
    int stage, write; /* write: 0 only counts */
    int64_t tile;     /* of options.pixel */
    int thread_count;
    pthread_mutex_t lock;
    uint64_t bytes;   /* of all workers, under the lock */
    uint64_t once;    /* of them, what is written once: NPH_BATCH_OF_SCENE */
    Worker *workers;
} Dump;

void nph_dump_options_default(NphDumpOptions *options) {
    *options = (NphDumpOptions){.launch = -1, .batch = -1, .limit_bytes = (uint64_t)4 << 30};
}

/* What is launched once is always written: no stage can be ported without what media hold. */
static int is_selected(const Dump *dump, const NphLaunch *launch) {
    const NphDumpOptions *o = dump->options;
    if (launch->batch == NPH_BATCH_OF_SCENE) return 1;
    return (dump->stage < 0 || launch->stage == dump->stage) && (o->launch < 0 || launch->number == o->launch) &&
           (o->batch < 0 || launch->batch == o->batch) && (dump->tile < 0 || launch->arguments[0] == dump->tile);
}

/* Doubles the room of a list that is full. */
static NphStatus grow(NphContext *context, void **list, size_t *room, int count, size_t size) {
    if ((size_t)count < *room) return NPH_OK;
    void *larger = NULL;
    size_t wanted = *room ? 2 * *room : 256;
    NPH_TRY(nph_alloc(context, wanted, size, "list of a dump", &larger));
    if (count) memcpy(larger, *list, (size_t)count * size);
    nph_free(context, *list);
    *list = larger;
    *room = wanted;
    return NPH_OK;
}

static NphStatus add_use(Dump *dump, Worker *worker, const Use *use, int input) {
    void *list = worker->uses;
    NphStatus status = grow(dump->context, &list, &worker->use_room, worker->use_count, sizeof(Use));
    worker->uses = list;
    if (status != NPH_OK) return status;
    worker->uses[worker->use_count] = *use;
    worker->uses[worker->use_count++].input = input;
    worker->records[worker->record_count - 1].count++;
    return NPH_OK;
}

static NphStatus add_record(Dump *dump, Worker *worker, const NphLaunch *launch) {
    void *list = worker->records;
    NphStatus status = grow(dump->context, &list, &worker->record_room, worker->record_count, sizeof(Record));
    worker->records = list;
    if (status != NPH_OK) return status;
    worker->records[worker->record_count++] = (Record){*launch, worker->use_count, 0, NULL};
    return NPH_OK;
}

/* Of the elements, row by row: as if they lay without gaps. */
static void digest_rows(const NphView *view, size_t row, size_t rows, char text[NPH_DIGEST_TEXT]) {
    NphDigest digest;
    nph_digest_begin(&digest);
    for (size_t r = 0; r < rows; r++)
        nph_digest_add(&digest, (const char *)view->data + r * (size_t)view->stride * nph_type_size(view->type), row);
    nph_digest_end(&digest, text);
}

static NphStatus close_file(Dump *dump, Worker *worker) {
    int file = worker->file;
    worker->file = -1;
    if (file < 0 || close(file) == 0) return NPH_OK;
    return nph_error(dump->context, NPH_BAD_OUTPUT, "%s: batch %lld cannot be written: %s", dump->options->folder,
                     (long long)worker->file_batch, strerror(errno));
}

static void batch_file(const NphLaunch *launch, char name[FILE_NAME / 2]) {
    if (launch->batch == NPH_BATCH_OF_SCENE) snprintf(name, FILE_NAME / 2, "scene.npys");
    else snprintf(name, FILE_NAME / 2, "%06lld.npys", (long long)launch->batch);
}

/* To the file of the batch, which holds its arrays one after the other. */
static NphStatus append(Dump *dump, Worker *worker, const NphLaunch *launch, const NphArray *array, int64_t stride,
                        Use *use) {
    char path[4096], name[FILE_NAME / 2];
    batch_file(launch, name);
    if (worker->file < 0 || worker->file_batch != launch->batch) {
        worker->file_bytes = 0;
        if (dump->write) NPH_TRY(close_file(dump, worker));
        worker->file_batch = launch->batch;
    }
    snprintf(use->file, sizeof use->file, "%s@%lld", name, (long long)worker->file_bytes);
    if (!dump->write) return NPH_OK;
    snprintf(path, sizeof path, "%s/%s", dump->options->folder, name);
    if (worker->file < 0) worker->file = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (worker->file < 0) return nph_error(dump->context, NPH_BAD_OUTPUT, "%s: cannot be made: %s", path, strerror(errno));
    return nph_npy_append(dump->context, worker->file, path, array, array->rank > 1 ? stride : 0, &worker->file_bytes);
}

/* Writes a buffer as it stands; worker->now[buffer] is then its file: the one that held it before where nothing has changed. */
static NphStatus write_buffer(Dump *dump, Worker *worker, void *state, int index, const NphLaunch *launch, int buffer) {
    NphView view;
    Use *use = &worker->now[buffer], made = {.buffer = buffer};
    size_t row, rows;
    if (!dump->method->view(state, index, buffer, &view)) {
        use->file[0] = 0;
        return NPH_OK;
    }
    rows = view.rank > 1 ? (size_t)view.shape[0] : 1;
    row = nph_type_size(view.type);
    for (int a = view.rank > 1; a < view.rank; a++) row *= (size_t)view.shape[a];
    made.rank = view.rank;
    made.type = view.type;
    memcpy(made.shape, view.shape, sizeof made.shape);
    digest_rows(&view, row, rows, made.digest);
    if (use->file[0] && use->rank == made.rank && strcmp(use->digest, made.digest) == 0 &&
        memcmp(use->shape, made.shape, sizeof made.shape) == 0)
        return NPH_OK;
    *use = made;
    pthread_mutex_lock(&dump->lock);
    uint64_t all = dump->bytes += row * rows + 128;
    if (launch->batch == NPH_BATCH_OF_SCENE) dump->once += row * rows + 128;
    pthread_mutex_unlock(&dump->lock);
    if (dump->write && all > dump->options->limit_bytes)
        return nph_error(dump->context, NPH_NO_MEMORY, "the dump grows beyond its limit of %.1f MiB: write less (--dump-select), or "
                         "allow more (--dump-limit)", (double)dump->options->limit_bytes / 1048576.0);
    NphArray array = {view.type, view.rank, {0}, view.data};
    for (int a = 0; a < NPH_MAX_RANK; a++) array.shape[a] = a < view.rank ? view.shape[a] : 1;
    return append(dump, worker, launch, &array, view.stride * (int64_t)nph_type_size(view.type), use);
}

static NphStatus before(void *user, void *state, int index, const NphLaunch *launch) {
    Dump *dump = user;
    Worker *worker = &dump->workers[index];
    const NphStage *stage = &dump->method->stages[launch->stage];
    int alone = launch->number == 0 || launch->batch == NPH_BATCH_OF_SCENE;
    for (int b = 0; b < dump->method->buffer_count && alone; b++) worker->now[b].file[0] = 0;
    if (!is_selected(dump, launch)) return NPH_OK;
    NPH_TRY(add_record(dump, worker, launch));
    for (int b = 0; b < dump->method->buffer_count; b++) {
        if (!nph_stage_lists(stage->reads, dump->method->buffers[b].name)) continue;
        if (!worker->now[b].file[0]) NPH_TRY(write_buffer(dump, worker, state, index, launch, b));
        if (worker->now[b].file[0]) NPH_TRY(add_use(dump, worker, &worker->now[b], 1));
    }
    return NPH_OK;
}

static NphStatus after(void *user, void *state, int index, const NphLaunch *launch) {
    Dump *dump = user;
    Worker *worker = &dump->workers[index];
    const NphStage *stage = &dump->method->stages[launch->stage];
    for (int b = 0; b < dump->method->buffer_count; b++) {
        if (!nph_stage_lists(stage->writes, dump->method->buffers[b].name)) continue;
        if (!is_selected(dump, launch)) {
            worker->now[b].file[0] = 0;
            continue;
        }
        NPH_TRY(write_buffer(dump, worker, state, index, launch, b));
        if (worker->now[b].file[0]) NPH_TRY(add_use(dump, worker, &worker->now[b], 0));
    }
    return NPH_OK;
}

static int by_launch(const void *a, const void *b) {
    const NphLaunch *x = &((const Record *)a)->launch, *y = &((const Record *)b)->launch;
    if (x->batch != y->batch) return x->batch < y->batch ? -1 : 1;
    return (x->number > y->number) - (x->number < y->number);
}

static NphStatus join_records(Dump *dump, Record **out, int *count) {
    int total = 0;
    for (int w = 0; w < dump->thread_count; w++) total += dump->workers[w].record_count;
    NPH_TRY(NPH_NEW(dump->context, total > 0 ? total : 1, "launches of a dump", out));
    *count = 0;
    for (int w = 0; w < dump->thread_count; w++) {
        Worker *worker = &dump->workers[w];
        for (int r = 0; r < worker->record_count; r++) {
            worker->records[r].uses = worker->uses + worker->records[r].first;
            (*out)[(*count)++] = worker->records[r];
        }
    }
    qsort(*out, (size_t)total, sizeof **out, by_launch);
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

static void json_inputs(NphJson *json, const Dump *dump, const Record *record) {
    nph_json_object(json, "inputs");
    for (int u = 0; u < record->count; u++)
        if (record->uses[u].input)
            nph_json_text(json, dump->method->buffers[record->uses[u].buffer].name, record->uses[u].file);
    nph_json_close(json);
}

static void json_outputs(NphJson *json, const Dump *dump, const Record *record) {
    nph_json_array(json, "outputs");
    for (int u = 0; u < record->count; u++) {
        const Use *use = &record->uses[u];
        double shape[NPH_MAX_RANK];
        if (use->input) continue;
        for (int a = 0; a < use->rank; a++) shape[a] = (double)use->shape[a];
        nph_json_object(json, NULL);
        nph_json_text(json, "buffer", dump->method->buffers[use->buffer].name);
        nph_json_text(json, "file", use->file);
        nph_json_text(json, "type", nph_type_name(use->type));
        nph_json_numbers(json, "shape", use->rank, shape);
        nph_json_text(json, "digest", use->digest);
        nph_json_close(json);
    }
    nph_json_close(json);
}

static void json_launches(NphJson *json, const Dump *dump, const Record *records, int count) {
    nph_json_array(json, "launches");
    for (int r = 0; r < count; r++) {
        const NphLaunch *launch = &records[r].launch;
        const NphStage *stage = &dump->method->stages[launch->stage];
        int64_t blocks = (launch->items + stage->block[0] - 1) / stage->block[0];
        double grid[3] = {(double)blocks, 1.0, 1.0};
        nph_json_object(json, NULL);
        nph_json_integer(json, "batch", launch->batch);
        nph_json_integer(json, "number", launch->number);
        nph_json_text(json, "stage", stage->name);
        nph_json_object(json, "arguments");
        for (int a = 0; a < dump->method->argument_count; a++)
            nph_json_integer(json, dump->method->arguments[a], launch->arguments[a]);
        nph_json_close(json);
        nph_json_integer(json, "items", launch->items);
        nph_json_numbers(json, "grid", 3, grid);
        json_inputs(json, dump, &records[r]);
        json_outputs(json, dump, &records[r]);
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

static NphStatus write_manifest(Dump *dump, const NphJob *job, const char *scene_name) {
    Record *records = NULL;
    int count = 0;
    char path[4096];
    NphWriter writer;
    NphJson json;
    NPH_TRY(join_records(dump, &records, &count));
    snprintf(path, sizeof path, "%s/manifest.json", dump->options->folder);
    NphStatus status = nph_writer_open(dump->context, path, &writer);
    if (status == NPH_OK) {
        nph_json_begin(&json, nph_json_to_file, writer.stream);
        nph_json_object(&json, NULL);
        json_job(&json, job, dump->method, scene_name);
        json_stages(&json, dump->method);
        json_buffers(&json, dump->method, job->precision);
        status = nph_json_facts(&json, dump->method, job);
        json_launches(&json, dump, records, count);
        nph_json_close(&json);
        NphStatus written = nph_writer_commit(dump->context, &writer);
        status = status == NPH_OK ? written : status;
    }
    nph_free(dump->context, records);
    return status;
}

static NphStatus open_dump(Dump *dump, const NphJob *job, const NphDumpOptions *options) {
    const int *crop = job->crop;
    dump->context = job->context;
    dump->options = options;
    dump->stage = options->stage ? nph_stage_find(dump->method, options->stage) : -1;
    dump->tile = -1;
    if (options->stage && dump->stage < 0)
        return nph_error(job->context, NPH_BAD_USAGE, "method %s has no stage %s", dump->method->name, options->stage);
    if (options->pixel_given) {
        const int *p = options->pixel;
        if (dump->method->shares_samples)
            return nph_error(job->context, NPH_BAD_USAGE, "launches of method %s are not of single pixels: select a stage, a launch or a "
                             "batch", dump->method->name);
        if (p[0] < crop[0] || p[1] < crop[1] || p[0] >= crop[2] || p[1] >= crop[3])
            return nph_error(job->context, NPH_BAD_USAGE, "pixel %d,%d is not in the picture (%d,%d to %d,%d)", p[0], p[1], crop[0],
                             crop[1], crop[2] - 1, crop[3] - 1);
        int first = crop[0] / NPH_TILE, across = (crop[2] - 1) / NPH_TILE - first + 1;
        dump->tile = (int64_t)(p[1] / NPH_TILE - crop[1] / NPH_TILE) * across + p[0] / NPH_TILE - first;
    }
    dump->thread_count = nph_context_threads(job->context);
    if (pthread_mutex_init(&dump->lock, NULL) != 0) return nph_error(job->context, NPH_NO_MEMORY, "no lock for a dump");
    NPH_TRY(NPH_NEW(job->context, dump->thread_count, "workers of a dump", &dump->workers));
    for (int w = 0; w < dump->thread_count; w++) dump->workers[w].file = -1;
    return NPH_OK;
}

static NphStatus close_files(Dump *dump) {
    NphStatus status = NPH_OK;
    for (int w = 0; w < dump->thread_count; w++) {
        NphStatus closed = close_file(dump, &dump->workers[w]);
        if (closed != NPH_OK) status = closed;
    }
    return status;
}

static void close_dump(Dump *dump) {
    for (int w = 0; dump->workers && w < dump->thread_count; w++) {
        if (dump->workers[w].file >= 0) close(dump->workers[w].file); /* of a run that failed */
        nph_free(dump->context, dump->workers[w].records);
        nph_free(dump->context, dump->workers[w].uses);
    }
    nph_free(dump->context, dump->workers);
    pthread_mutex_destroy(&dump->lock);
}

/* An empty folder, made if it is not there. */
static NphStatus check_folder(NphContext *context, const char *path) {
    if (mkdir(path, 0777) == 0) return NPH_OK;
    DIR *folder = errno == EEXIST ? opendir(path) : NULL;
    int error = errno, entries = 0;
    if (!folder) return nph_error(context, NPH_BAD_OUTPUT, "%s: cannot be made: %s", path, strerror(error == EEXIST ? ENOTDIR : error));
    for (struct dirent *entry; (entry = readdir(folder)) != NULL;)
        entries += strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
    closedir(folder);
    return entries == 0 ? NPH_OK : nph_error(context, NPH_BAD_OUTPUT, "%s: holds files already: a dump needs an empty folder", path);
}

static int tiles_of(const int crop[4]) {
    return ((crop[2] - 1) / NPH_TILE - crop[0] / NPH_TILE + 1) * ((crop[3] - 1) / NPH_TILE - crop[1] / NPH_TILE + 1);
}

/* Counts what the tiles around the middle would take, of the first samples, and scales it up; all tiles where pixels share their
 * samples. */
static NphStatus forecast(const NphScene *scene, const NphRenderOptions *options, const NphDumpOptions *what, const NphJob *job,
                          const NphMethod *method, double *bytes) {
    enum { REACH = 2 * NPH_TILE };
    Dump dump = {.method = method};
    NphDumpOptions all = *what;
    NphRenderOptions few = *options;
    NphFilm *film = NULL;
    int one = what->batch >= 0, shared = method->shares_samples, tiles = 0, whole = 0;
    all.pixel_given = 0;
    few.samples = few.sample_begin = few.sample_end = 0;
    few.target_error = few.time_budget_s = 0.0;
    few.sample_end = NPH_CHUNK;
    few.crop_given = 1;
    for (int a = 0; a < 2; a++) {
        int middle = what->pixel_given ? what->pixel[a] : (job->crop[a] + job->crop[a + 2]) / 2, at = middle / NPH_TILE * NPH_TILE;
        int reach = what->pixel_given ? 0 : shared ? job->crop[a + 2] : REACH; /* photons are the whole picture's */
        few.crop[a] = at - reach > job->crop[a] ? at - reach : job->crop[a];
        few.crop[a + 2] = at + reach + NPH_TILE < job->crop[a + 2] ? at + reach + NPH_TILE : job->crop[a + 2];
    }
    tiles = tiles_of(few.crop);
    whole = what->pixel_given ? 1 : tiles_of(job->crop);
    all.batch = one && shared ? what->batch % (NPH_CHUNK + whole) : -1;
    NPH_TRY(open_dump(&dump, job, &all));
    NphTap tap = {&dump, before, after};
    NphStatus status = nph_render_tapped(job->context, scene, &few, &tap, &film, NULL);
    *bytes = (double)(dump.bytes - dump.once);
    *bytes *= one ? (shared ? 1.0 : 1.0 / tiles) : (double)whole / tiles * (double)(job->sample_end - job->sample_begin) / NPH_CHUNK;
    *bytes += (double)dump.once;
    close_dump(&dump);
    nph_film_free(job->context, film);
    return status;
}

/* Densities are made dense to be written: none that is too large already. */
static NphStatus check_densities(const NphScene *scene, const NphDumpOptions *what, const NphJob *job, const NphMethod *method) {
    int shown = 0;
    for (int s = 0; s < method->stage_count; s++) shown |= strstr(method->stages[s].name, ".majorant") != NULL;
    for (int m = 0; m < scene->medium_count && shown; m++) {
        const NphMedium *medium = &scene->media[m];
        double bytes = medium->shape == NPH_SHAPE_GRID ? 4.0 * (double)nph_grid_dense_count(&medium->grid) : 0.0;
        if (bytes > (double)what->limit_bytes)
            return nph_error(job->context, NPH_NO_MEMORY, "the density of %s takes %.1f MiB as a dense array, the dump's limit is %.1f MiB "
                             "(--dump-limit)", medium->name, bytes / 1048576.0, (double)what->limit_bytes / 1048576.0);
    }
    return NPH_OK;
}

static NphStatus check_size(const NphScene *scene, const NphRenderOptions *options, const NphDumpOptions *what, const NphJob *job,
                            const NphMethod *method) {
    double bytes = 0.0;
    NPH_TRY(check_densities(scene, what, job, method));
    NPH_TRY(forecast(scene, options, what, job, method, &bytes));
    if (bytes <= (double)what->limit_bytes) return NPH_OK;
    return nph_error(job->context, NPH_NO_MEMORY, "the dump will take about %.1f MiB, its limit is %.1f MiB: write less "
                     "(--dump-select), or allow more (--dump-limit)", bytes / 1048576.0, (double)what->limit_bytes / 1048576.0);
}

NphStatus nph_dump(NphContext *context, const NphScene *scene, const char *scene_name, const NphRenderOptions *options,
                   const NphDumpOptions *what, NphFilm **film, NphRenderStatistics *statistics) {
    Dump dump = {.write = 1};
    NphJob job;
    NPH_TRY(nph_job_make(context, scene, options, &dump.method, &job));
    NPH_TRY(nph_stages_supported(context, dump.method));
    NPH_TRY(open_dump(&dump, &job, what));
    NphTap tap = {&dump, before, after};
    NphStatus status = check_size(scene, options, what, &job, dump.method);
    if (status == NPH_OK) status = check_folder(context, what->folder);
    if (status == NPH_OK) status = nph_render_tapped(context, scene, options, &tap, film, statistics);
    if (status == NPH_OK || status == NPH_INTERRUPTED) { /* what there is, is whole */
        NphStatus written = close_files(&dump);
        if (written == NPH_OK) written = write_manifest(&dump, &job, scene_name);
        if (written != NPH_OK) status = written;
    }
    close_dump(&dump);
    return status;
}
