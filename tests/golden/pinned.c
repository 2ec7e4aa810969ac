/* SPDX-License-Identifier: Apache-2.0
 *
 * See pinned.h. */
#define _POSIX_C_SOURCE 200809L
#include "pinned.h"

#include <assert.h>
#include <dirent.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "io/file.h"
#include "method/registry.h"

enum { PATH = 1200 };

/* What a method is run with: fewer photons than by default, and of the quadrature, which is slow, the middle at a coarse tolerance. */
typedef struct Settings {
    const char *method;
    int crop[4];
    const char *knobs[3];
} Settings;

static const Settings settings[] = {
    {"path", {0, 0, 64, 48}, {NULL}},
    {"light", {0, 0, 64, 48}, {NULL}},
    {"single", {16, 12, 48, 36}, {"single.tolerance=0.1"}},
    {"photonmap", {0, 0, 64, 48}, {"photonmap.photons=1000", "photonmap.nearest=20"}},
    {"shdom", {0, 0, 64, 48}, {"shdom.cells=6", "shdom.bands=2", "shdom.gather=2"}},
    {"temporal_photons", {0, 0, 64, 48}, {"tpm.photons=2000", "tpm.generations=2", "tpm.cells=200"}},
    {"principal_ordinates", {0, 0, 64, 48}, {"pop.ordinates=8", "pop.cells=10", "pop.iterations=8"}},
};

static int by_name(const void *a, const void *b) { return strcmp(a, b); }

int pinned_scenes(const char *root, char names[PINNED_SCENES][DIGEST_NAME]) {
    char path[PATH];
    int count = 0;
    snprintf(path, sizeof path, "%s/reference/scenes", root);
    DIR *folder = opendir(path);
    if (!folder) return 0;
    for (struct dirent *entry; (entry = readdir(folder)) && count < PINNED_SCENES;) {
        const char *ending = strstr(entry->d_name, ".yaml");
        if (!ending || ending[5]) continue;
        snprintf(names[count++], DIGEST_NAME, "%.*s", (int)(ending - entry->d_name), entry->d_name);
    }
    closedir(folder);
    qsort(names, (size_t)count, sizeof names[0], by_name);
    return count;
}

/* The scene with its resolution replaced. */
NphStatus pinned_scene(NphContext *context, const char *root, const char *name, NphScene **scene) {
    static const char *const key = "resolution: [";
    char path[PATH], folder[PATH], *text = NULL, *smaller = NULL;
    size_t size;
    snprintf(folder, sizeof folder, "%.1000s/reference/scenes", root);
    snprintf(path, sizeof path, "%.1100s/%s.yaml", folder, name);
    NPH_TRY(nph_file_read(context, path, &text, &size));
    const char *from = strstr(text, key), *to = from ? strchr(from, ']') : NULL;
    NphStatus status = to ? NPH_NEW(context, size + 16, "scene", &smaller)
                          : nph_error(context, NPH_BAD_SCENE, "%s: no '%s'", path, key);
    if (status == NPH_OK) {
        snprintf(smaller, size + 16, "%.*s%s64, 48%s", (int)(from - text), text, key, to);
        status = nph_scene_parse(context, smaller, strlen(smaller), path, folder, scene);
    }
    nph_free(context, smaller);
    nph_free(context, text);
    return status;
}

NphRenderOptions pinned_options(const char *method) {
    NphRenderOptions options;
    nph_render_options_default(&options);
    options.method = method;
    options.samples = 16;
    for (size_t i = 0; i < sizeof settings / sizeof *settings; i++) {
        if (strcmp(settings[i].method, method) != 0) continue;
        options.crop_given = 1;
        memcpy(options.crop, settings[i].crop, sizeof options.crop);
        options.knobs = settings[i].knobs;
        while (options.knob_count < 3 && options.knobs[options.knob_count]) options.knob_count++;
    }
    return options;
}

static int takes(NphContext *context, const NphScene *scene, const NphRenderOptions *options) {
    NphPlan plan = {0};
    NphStatus status = nph_plan_make(context, scene, options, &plan);
    nph_plan_free(context, &plan);
    return status == NPH_OK;
}

static NphStatus add_rows(NphContext *context, const char *method, const DigestTable *table, Pinned *pinned) {
    void *rows = pinned->rows;
    NPH_TRY(nph_realloc(context, (size_t)(pinned->count + table->count), sizeof *pinned->rows, "digests", &rows));
    pinned->rows = rows;
    for (int r = 0; r < table->count; r++) {
        PinnedRow *row = &pinned->rows[pinned->count++];
        snprintf(row->method, sizeof row->method, "%s", method);
        row->row = table->rows[r];
    }
    return NPH_OK;
}

NphStatus pinned_take(NphContext *context, const char *root, const char *name, Pinned *pinned) {
    NphScene *scene = NULL;
    NPH_TRY(pinned_scene(context, root, name, &scene));
    *pinned = (Pinned){0};
    NphStatus status = NPH_OK;
    for (int m = 0; m < nph_method_count() && status == NPH_OK; m++) {
        DigestTable table = {0};
        NphRenderOptions options = pinned_options(nph_method(m)->name);
        if (!takes(context, scene, &options)) continue;
        status = digests_take(context, scene, &options, &table);
        if (status == NPH_OK) status = add_rows(context, options.method, &table, pinned);
        nph_free(context, table.rows);
    }
    nph_scene_free(context, scene);
    if (status != NPH_OK) nph_free(context, pinned->rows);
    return status;
}

/* ---- the files ---- */

static const char *const header = "method,stage,buffer,type,launches,elements,digest,since,before,cells\n";

static void path_of(const char *root, const char *scene, const char *ending, char path[PATH]) {
    snprintf(path, PATH, "%.1000s/reference/golden/digests/%s.%s", root, scene, ending);
}

static int type_of(const char *name, NphType *type) {
    for (int t = NPH_U8; t <= NPH_F64; t++)
        if (strcmp(nph_type_name((NphType)t), name) == 0) {
            *type = (NphType)t;
            return 1;
        }
    return 0;
}

static int read_row(const char *line, PinnedRow *out) {
    PinnedRow row;
    char type[8], before[17] = "";
    memset(&row, 0, sizeof row);
    if (sscanf(line, "%39[^,],%39[^,],%39[^,],%7[^,],%" SCNd64 ",%" SCNd64 ",%32[^,],%15[^,],%16[^\n]", row.method, row.row.stage,
               row.row.buffer, type, &row.row.launches, &row.row.elements, row.row.digest, row.since, before) != 9)
        return 0;
    char *comma = strchr(before, ',');
    if (!comma || !type_of(type, &row.row.type)) return 0;
    row.row.cell_count = atoi(comma + 1);
    snprintf(row.before, sizeof row.before, "%.*s", (int)(comma - before), before);
    *out = row;
    return row.row.cell_count >= 0 && row.row.cell_count <= DIGEST_CELLS;
}

static NphStatus read_rows(NphContext *context, const char *path, const char *text, Pinned *pinned) {
    const char *line = strchr(text, '\n');
    for (; line && line[1]; line = strchr(line + 1, '\n')) {
        void *rows = pinned->rows;
        NPH_TRY(nph_realloc(context, (size_t)pinned->count + 1, sizeof *pinned->rows, "digests", &rows));
        pinned->rows = rows;
        if (!read_row(line + 1, &pinned->rows[pinned->count]))
            return nph_error(context, NPH_BAD_INPUT, "%s: row %d is none", path, pinned->count + 1);
        pinned->count++;
    }
    return NPH_OK;
}

static NphStatus read_cells(NphContext *context, const char *path, Pinned *pinned) {
    NphArray array;
    int64_t wanted = 0, at = 0;
    for (int r = 0; r < pinned->count; r++) wanted += pinned->rows[r].row.cell_count;
    NPH_TRY(nph_array_read_npy(context, path, &array));
    const uint64_t *pairs = array.data;
    NphStatus status = array.type == NPH_U64 && array.rank == 2 && array.shape[0] == wanted && array.shape[1] == 2
                           ? NPH_OK
                           : nph_error(context, NPH_BAD_INPUT, "%s: expected u64 [%lld][2]", path, (long long)wanted);
    for (int r = 0; r < pinned->count && status == NPH_OK; r++)
        for (int c = 0; c < pinned->rows[r].row.cell_count; c++, at++)
            pinned->rows[r].row.cells[c] = (DigestCell){(uint32_t)(pairs[2 * at] >> 48), (uint32_t)(pairs[2 * at] >> 32) & 0xffffu,
                                                        (uint32_t)pairs[2 * at], pairs[2 * at + 1]};
    nph_array_free(context, &array);
    return status;
}

NphStatus pinned_read(NphContext *context, const char *root, const char *scene, Pinned *pinned) {
    char path[PATH], *text = NULL;
    size_t size;
    *pinned = (Pinned){0};
    path_of(root, scene, "csv", path);
    NPH_TRY(nph_file_read(context, path, &text, &size));
    NphStatus status = read_rows(context, path, text, pinned);
    nph_free(context, text);
    path_of(root, scene, "npy", path);
    if (status == NPH_OK) status = read_cells(context, path, pinned);
    if (status != NPH_OK) nph_free(context, pinned->rows);
    return status;
}

static NphStatus write_cells(NphContext *context, const char *path, const Pinned *pinned) {
    NphArray array;
    int64_t count = 0, at = 0;
    for (int r = 0; r < pinned->count; r++) count += pinned->rows[r].row.cell_count;
    NPH_TRY(nph_array_new(context, NPH_U64, 2, (int64_t[2]){count, 2}, "cells", &array));
    uint64_t *pairs = array.data;
    for (int r = 0; r < pinned->count; r++)
        for (int c = 0; c < pinned->rows[r].row.cell_count; c++, at++) {
            const DigestCell *cell = &pinned->rows[r].row.cells[c];
            assert(cell->batch < 65536 && cell->number < 65536);
            pairs[2 * at] = (uint64_t)cell->batch << 48 | (uint64_t)cell->number << 32 | cell->index;
            pairs[2 * at + 1] = cell->bits;
        }
    NphStatus status = nph_array_write_npy(context, path, &array);
    nph_array_free(context, &array);
    return status;
}

NphStatus pinned_write(NphContext *context, const char *root, const char *scene, const Pinned *pinned) {
    char path[PATH];
    NphWriter writer;
    path_of(root, scene, "npy", path);
    NPH_TRY(write_cells(context, path, pinned));
    path_of(root, scene, "csv", path);
    NPH_TRY(nph_writer_open(context, path, &writer));
    fputs(header, writer.stream);
    for (int r = 0; r < pinned->count; r++) {
        const PinnedRow *p = &pinned->rows[r];
        fprintf(writer.stream, "%s,%s,%s,%s,%lld,%lld,%s,%s,%s,%d\n", p->method, p->row.stage, p->row.buffer, nph_type_name(p->row.type),
                (long long)p->row.launches, (long long)p->row.elements, p->row.digest, p->since, p->before, p->row.cell_count);
    }
    return nph_writer_commit(context, &writer);
}

/* ---- what moved ---- */

const PinnedRow *pinned_find(const Pinned *pinned, const PinnedRow *like) {
    for (int r = 0; r < pinned->count; r++) {
        const PinnedRow *row = &pinned->rows[r];
        if (strcmp(row->method, like->method) == 0 && strcmp(row->row.stage, like->row.stage) == 0 &&
            strcmp(row->row.buffer, like->row.buffer) == 0)
            return row;
    }
    return NULL;
}

static double value_of(NphType type, uint64_t bits) {
    float single;
    double number;
    memcpy(&single, &bits, sizeof single);
    memcpy(&number, &bits, sizeof number);
    return type == NPH_F32 ? (double)single : type == NPH_F64 ? number : (double)(int64_t)bits;
}

/* Steps between two values of a type: from one float to the next, or 1. */
static uint64_t steps_between(NphType type, uint64_t a, uint64_t b) {
    uint64_t sign = type == NPH_F32 ? (uint64_t)1 << 31 : type == NPH_F64 ? (uint64_t)1 << 63 : 0;
    uint64_t x = a & sign ? sign - (a & (sign - 1)) : sign + a, y = b & sign ? sign - (b & (sign - 1)) : sign + b;
    return x > y ? x - y : y - x;
}

void pinned_difference(const PinnedRow *before, const PinnedRow *now, char *text, size_t size) {
    const DigestRow *a = &before->row, *b = &now->row;
    const DigestCell *worst[2] = {NULL, NULL};
    int common = 0, moved = 0;
    uint64_t most = 0;
    for (int i = 0, j = 0; i < a->cell_count && j < b->cell_count;) {
        const DigestCell *x = &a->cells[i], *y = &b->cells[j];
        uint64_t p = (uint64_t)x->batch << 48 | (uint64_t)x->number << 32 | x->index;
        uint64_t q = (uint64_t)y->batch << 48 | (uint64_t)y->number << 32 | y->index;
        i += p <= q;
        j += q <= p;
        if (p != q) continue;
        uint64_t steps = steps_between(a->type, x->bits, y->bits);
        common++;
        moved += steps > 0;
        if (steps <= most) continue;
        most = steps;
        worst[0] = x;
        worst[1] = y;
    }
    int used = snprintf(text, size, "%s %s %s: digest %s, pinned since %s, is now %s; %lld launches and %lld elements were %lld and %lld; "
                        "of %d cells kept %d moved", now->method, b->stage, b->buffer, a->digest, before->since, b->digest,
                        (long long)b->launches, (long long)b->elements, (long long)a->launches, (long long)a->elements, common, moved);
    if (most && used > 0 && (size_t)used < size)
        snprintf(text + used, size - (size_t)used, ", the most by %" PRIu64 " ulp: batch %u launch %u element %u from %.9g to %.9g", most,
                 worst[0]->batch, worst[0]->number, worst[0]->index, value_of(a->type, worst[0]->bits), value_of(a->type, worst[1]->bits));
}

/* ---- CHANGELOG.md ---- */

/* From the heading of a release to the next one. */
static const char *section_of(const char *changelog, const char *release, const char **end) {
    char heading[40];
    size_t length = (size_t)snprintf(heading, sizeof heading, "\n## %s", release);
    for (const char *at = changelog; (at = strstr(at, heading)) != NULL; at++) {
        if (at[length] != ',' && at[length] != '\n') continue;
        *end = strstr(at + 1, "\n## ");
        if (!*end) *end = at + strlen(at);
        return at + 1;
    }
    return NULL;
}

static int has(const char *from, const char *end, const char *words) {
    const char *found = strstr(from, words);
    return found && found < end;
}

int changelog_section(const char *changelog, const char *release, int *released) {
    const char *end, *section = section_of(changelog, release, &end);
    if (!section) return 0;
    *released = !has(section, section + strcspn(section, "\n"), "not released");
    return 1;
}

void changelog_newest(const char *changelog, char release[16]) {
    int released = 0;
    release[0] = 0;
    for (const char *at = changelog; (at = strstr(at, "\n## ")) != NULL; at++)
        if (sscanf(at, "\n## %15[^,\n]", release) == 1 && changelog_section(changelog, release, &released) && released) return;
    release[0] = 0;
}

int changelog_tells(const char *changelog, const PinnedRow *row) {
    const char *end, *at = section_of(changelog, row->since, &end), *next;
    if (!row->before[0]) return 1;
    for (; at && (at = strstr(at, "\n- ")) != NULL && at < end; at = next) {
        next = strstr(at + 1, "\n- ");
        if (!next || next > end) next = end;
        if (has(at, next, "digest") && has(at, next, row->row.stage) && has(at, next, row->before) && has(at, next, row->method)) return 1;
    }
    return 0;
}
