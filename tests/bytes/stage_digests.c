/* SPDX-License-Identifier: Apache-2.0
 *
 * See stage_digests.h. Each worker keeps a list of what its launches wrote; the lists are joined and sorted in the end. Which cells
 * are kept follows from hashes of where they stand, so that a change elsewhere in the run does not choose others. */
#include "stage_digests.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "method/job.h"

enum { CELLS_OF_A_LAUNCH = 8 };

/* What one launch wrote into one buffer. */
typedef struct Written {
    int row;
    uint32_t batch, number;
    NphType type;
    int64_t elements;
    XXH128_canonical_t digest;
    int cell_count;
    DigestCell cells[CELLS_OF_A_LAUNCH];
} Written;

typedef struct Worker {
    Written *list;
    size_t count, room;
    char *scratch;
    size_t scratch_bytes;
} Worker;

typedef struct Taker {
    NphContext *context;
    const NphMethod *method;
    Worker *workers;
} Taker;

static NphStatus add_written(NphContext *context, Worker *worker, Written **out) {
    if (worker->count == worker->room) {
        void *list = worker->list;
        NPH_TRY(nph_realloc(context, 2 * worker->room + 256, sizeof **out, "digests", &list));
        worker->list = list;
        worker->room = 2 * worker->room + 256;
    }
    *out = &worker->list[worker->count++];
    return NPH_OK;
}

static uint64_t hash_of(uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    uint32_t words[4] = {a, b, c, d};
    return XXH64(words, sizeof words, 0);
}

/* At most `most` different cells of an array; returns how many. */
static int choose_cells(const void *data, NphType type, int64_t elements, const Written *from, int most, DigestCell *cells) {
    int count = 0;
    size_t size = nph_type_size(type);
    for (int k = 0; k < most && elements > 0; k++) {
        DigestCell cell = {from->batch, from->number, 0, 0};
        int taken = 0;
        cell.index = (uint32_t)(hash_of(from->batch, from->number, (uint32_t)from->row, (uint32_t)k) % (uint64_t)elements);
        for (int i = 0; i < count; i++) taken |= cells[i].index == cell.index;
        if (taken) continue;
        memcpy(&cell.bits, (const char *)data + cell.index * size, size);
        cells[count++] = cell;
    }
    return count;
}

/* The rows of a view, without gaps. */
static NphStatus gather(NphContext *context, Worker *worker, const NphView *view, int64_t *elements) {
    int64_t row = 1, rows = view->rank > 1 ? view->shape[0] : 1;
    for (int a = view->rank > 1; a < view->rank; a++) row *= view->shape[a];
    *elements = row * rows;
    size_t size = nph_type_size(view->type), bytes = (size_t)*elements * size;
    if (bytes > worker->scratch_bytes) {
        void *larger = NULL;
        NPH_TRY(nph_alloc(context, bytes, 1, "rows of a buffer", &larger));
        nph_free(context, worker->scratch);
        worker->scratch = larger;
        worker->scratch_bytes = bytes;
    }
    for (int64_t r = 0; r < rows && row; r++)
        memcpy(worker->scratch + (size_t)(r * row) * size, (const char *)view->data + (size_t)(r * view->stride) * size,
               (size_t)row * size);
    return NPH_OK;
}

static NphStatus before(void *user, void *state, int worker, const NphLaunch *launch) {
    (void)user, (void)state, (void)worker, (void)launch;
    return NPH_OK;
}

static NphStatus after(void *user, void *state, int index, const NphLaunch *launch) {
    Taker *taker = user;
    Worker *worker = &taker->workers[index];
    const NphMethod *method = taker->method;
    for (int b = 0; b < method->buffer_count; b++) {
        NphView view;
        Written *written;
        if (!nph_stage_lists(method->stages[launch->stage].writes, method->buffers[b].name)) continue;
        if (!method->view(state, index, b, &view)) continue;
        NPH_TRY(add_written(taker->context, worker, &written));
        written->row = launch->stage * method->buffer_count + b;
        written->batch = (uint32_t)launch->batch;
        written->number = (uint32_t)launch->number;
        written->type = view.type;
        NPH_TRY(gather(taker->context, worker, &view, &written->elements));
        size_t bytes = (size_t)written->elements * nph_type_size(view.type);
        XXH128_canonicalFromHash(&written->digest, XXH3_128bits(worker->scratch, bytes));
        written->cell_count =
            choose_cells(worker->scratch, view.type, written->elements, written, CELLS_OF_A_LAUNCH, written->cells);
    }
    return NPH_OK;
}

static int by_launch(const void *a, const void *b) {
    const Written *x = a, *y = b;
    if (x->row != y->row) return x->row < y->row ? -1 : 1;
    if (x->batch != y->batch) return x->batch < y->batch ? -1 : 1;
    return (x->number > y->number) - (x->number < y->number);
}

static uint64_t rank_of(const DigestCell *cell) { return hash_of(cell->batch, cell->number, cell->index, 0); }

static int by_rank(const void *a, const void *b) {
    uint64_t x = rank_of(a), y = rank_of(b);
    return (x > y) - (x < y);
}

static int by_place(const void *a, const void *b) {
    const DigestCell *x = a, *y = b;
    if (x->batch != y->batch) return x->batch < y->batch ? -1 : 1;
    if (x->number != y->number) return x->number < y->number ? -1 : 1;
    return (x->index > y->index) - (x->index < y->index);
}

/* One row of launches that wrote the same buffer in the same stage. */
static NphStatus fold_row(NphContext *context, const Written *list, size_t count, DigestRow *row) {
    DigestCell *cells = NULL;
    size_t cell_count = 0;
    XXH128_canonical_t *digests = NULL;
    NPH_TRY(NPH_NEW(context, count, "digests", &digests));
    NphStatus status = NPH_NEW(context, count * CELLS_OF_A_LAUNCH, "cells", &cells);
    for (size_t i = 0; i < count && status == NPH_OK; i++) {
        digests[i] = list[i].digest;
        row->elements += list[i].elements;
        for (int c = 0; c < list[i].cell_count; c++) cells[cell_count++] = list[i].cells[c];
    }
    if (status == NPH_OK) {
        row->type = list[0].type;
        row->launches = (int64_t)count;
        nph_digest_text(digests, count * sizeof *digests, row->digest);
        qsort(cells, cell_count, sizeof *cells, by_rank);
        row->cell_count = cell_count < DIGEST_CELLS ? (int)cell_count : DIGEST_CELLS;
        memcpy(row->cells, cells, (size_t)row->cell_count * sizeof *cells);
        qsort(row->cells, (size_t)row->cell_count, sizeof *cells, by_place);
    }
    nph_free(context, cells);
    nph_free(context, digests);
    return status;
}

static NphStatus join_workers(const Taker *taker, int threads, Written **out, size_t *count) {
    size_t total = 0;
    for (int w = 0; w < threads; w++) total += taker->workers[w].count;
    NPH_TRY(NPH_NEW(taker->context, total > 0 ? total : 1, "digests", out));
    *count = 0;
    for (int w = 0; w < threads; w++) {
        if (taker->workers[w].count) memcpy(*out + *count, taker->workers[w].list, taker->workers[w].count * sizeof **out);
        *count += taker->workers[w].count;
    }
    qsort(*out, total, sizeof **out, by_launch);
    return NPH_OK;
}

static NphStatus fold_rows(const Taker *taker, const Written *list, size_t count, DigestTable *table) {
    for (size_t first = 0, end; first < count; first = end) {
        DigestRow *row = &table->rows[table->count++];
        const NphMethod *method = taker->method;
        for (end = first; end < count && list[end].row == list[first].row;) end++;
        snprintf(row->stage, sizeof row->stage, "%s", method->stages[list[first].row / method->buffer_count].name);
        snprintf(row->buffer, sizeof row->buffer, "%s", method->buffers[list[first].row % method->buffer_count].name);
        NPH_TRY(fold_row(taker->context, list + first, end - first, row));
    }
    return NPH_OK;
}

static void picture_row(const NphImage *image, int channel, DigestRow *row) {
    const float *pixels = image->channels[channel].pixels;
    Written whole = {.row = channel};
    XXH128_canonical_t digest;
    row->type = NPH_F32;
    row->launches = 1;
    row->elements = (int64_t)image->width * image->height;
    snprintf(row->stage, sizeof row->stage, "picture");
    snprintf(row->buffer, sizeof row->buffer, "%s", image->channels[channel].name);
    XXH128_canonicalFromHash(&digest, XXH3_128bits(pixels, (size_t)row->elements * sizeof *pixels));
    nph_digest_text(&digest, sizeof digest, row->digest);
    row->cell_count = choose_cells(pixels, NPH_F32, row->elements, &whole, DIGEST_CELLS, row->cells);
    qsort(row->cells, (size_t)row->cell_count, sizeof row->cells[0], by_place);
}

static NphStatus fill_table(const Taker *taker, int threads, const NphFilm *film, DigestTable *table) {
    Written *list = NULL;
    size_t count = 0;
    NphImage image;
    NPH_TRY(nph_film_image(taker->context, film, &image));
    int most = taker->method->stage_count * taker->method->buffer_count + image.channel_count;
    NphStatus status = NPH_NEW(taker->context, most, "digests", &table->rows);
    if (status == NPH_OK) status = join_workers(taker, threads, &list, &count);
    if (status == NPH_OK) status = fold_rows(taker, list, count, table);
    for (int c = 0; c < image.channel_count && status == NPH_OK; c++)
        picture_row(&image, c, &table->rows[table->count++]);
    nph_free(taker->context, list);
    nph_image_free(taker->context, &image);
    return status;
}

NphStatus digests_take(NphContext *context, const NphScene *scene, const NphRenderOptions *options, DigestTable *table) {
    Taker taker = {.context = context};
    NphTap tap = {&taker, before, after};
    NphFilm *film = NULL;
    int threads = nph_context_threads(context);
    *table = (DigestTable){0};
    NPH_TRY(nph_method_find(context, options->method ? options->method : "path", &taker.method));
    NPH_TRY(NPH_NEW(context, threads, "workers", &taker.workers));
    NphStatus status = nph_render_tapped(context, scene, options, taker.method->view ? &tap : NULL, &film, NULL);
    if (status == NPH_OK) status = fill_table(&taker, threads, film, table);
    for (int w = 0; w < threads; w++) {
        nph_free(context, taker.workers[w].list);
        nph_free(context, taker.workers[w].scratch);
    }
    nph_free(context, taker.workers);
    if (film) nph_film_free(context, film);
    if (status != NPH_OK) {
        nph_free(context, table->rows);
        *table = (DigestTable){0};
    }
    return status;
}
