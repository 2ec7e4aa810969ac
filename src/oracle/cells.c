/* SPDX-License-Identifier: Apache-2.0
 *
 * See cells.h. Items that have an identity are matched by it, since their order is nobody's business: a GPU compacts its queues
 * as its atomics fall. Values of a queue are positions and become identities first. */
#include "oracle/cells.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/fmath.h"
#include "core/memory.h"
#include "core/message.h"
#include "oracle/stages.h"

enum { SLABS = 8 };
enum { NO_ITEM = -1, IN_OURS = 1, IN_THEIRS = 2, TURNED = 4 };
#define NOWHERE 1e30

typedef struct Comparison {
    NphContext *context;
    const NphMethod *method;
    int precision;
    const NphSide *ours, *theirs;
    const NphCellWatch *watch;
    double *ids;           /* of both sides, each once, rising: they may be far apart */
    int64_t identities;
    unsigned char *turned; /* by place in ids */
    int agree;             /* all integers without identities */
    double *gap;           /* of the buffer under way */
    int64_t gap_room;
} Comparison;

void nph_side_free(NphContext *context, NphSide *side) {
    for (int i = 0; i < side->count; i++) nph_array_free(context, &side->buffers[i].array);
    side->count = side->outputs = 0;
}

static const NphArray *find(const NphSide *side, int count, const char *name) {
    for (int i = 0; i < count && name; i++)
        if (strcmp(side->buffers[i].name, name) == 0) return &side->buffers[i].array;
    return NULL;
}

/* Outputs first: a stage that writes what it reads is known by what it wrote. */
static const NphArray *buffer_of(const NphSide *side, const char *name) { return find(side, side->count, name); }
static const NphArray *output_of(const NphSide *side, const char *name) { return find(side, side->outputs, name); }

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
static int64_t length_of(const NphArray *array) { return array->rank ? array->shape[array->rank - 1] : 1; }

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

int nph_octave(double ulp) {
    int octave = 0;
    for (double edge = 0.0; octave < NPH_OCTAVES - 1 && !(ulp <= edge); octave++) edge = edge > 0.0 ? 2.0 * edge : 1.0;
    return octave;
}

/* Identities of a buffer's items, where they are as many as its last axis is long; NULL: by position. */
static const NphArray *identities_of(const NphSide *side, const NphBuffer *buffer, const NphArray *array) {
    const NphArray *id = buffer_of(side, buffer->identity);
    return id && (buffer->queue || (array->rank > 0 && nph_array_count(id) == length_of(array))) ? id : NULL;
}

static int has_last_axis(const NphBuffer *buffer, const char *axis) {
    size_t length = strlen(buffer->shape), end = strlen(axis);
    return length >= end && strcmp(buffer->shape + length - end, axis) == 0;
}

/* The last axis is the identity itself. */
static int is_by_identity(const NphBuffer *buffer) { return has_last_axis(buffer, "[id]"); }

/* What one item has under way, as much as that happens to be: where its integers differ so may all of it. */
static int is_one_item(const NphBuffer *buffer) { return has_last_axis(buffer, "[waiting]"); }

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

/* Positions in `theirs` of the items of `ours`; NO_ITEM where it has none. */
static NphStatus match(const Comparison *c, const NphArray *ours, const NphArray *theirs, int64_t **out) {
    int64_t count = nph_array_count(ours), others = nph_array_count(theirs), known = 0;
    Item *items = NULL;
    NPH_TRY(NPH_NEW(c->context, count > 0 ? count : 1, "positions of items", out));
    NphStatus status = NPH_NEW(c->context, others > 0 ? others : 1, "items by identity", &items);
    if (status != NPH_OK) {
        nph_free(c->context, *out);
        *out = NULL;
        return status;
    }
    for (int64_t i = 0; i < others; i++)
        if (value_at(theirs, i) >= 0.0) items[known++] = (Item){value_at(theirs, i), i};
    qsort(items, (size_t)known, sizeof *items, by_id);
    for (int64_t i = 0; i < count; i++) (*out)[i] = place_of(items, known, value_at(ours, i));
    nph_free(c->context, items);
    return NPH_OK;
}

/* Of an identity; NO_ITEM where neither side has it. */
static int64_t rank_of(const Comparison *c, double id) {
    int64_t lo = 0, hi = c->identities;
    while (lo < hi) {
        int64_t middle = lo + (hi - lo) / 2;
        if (c->ids[middle] < id) lo = middle + 1;
        else hi = middle;
    }
    return lo < c->identities && !(c->ids[lo] > id) && id >= 0.0 ? lo : NO_ITEM;
}

static int is_turned(const Comparison *c, double id) {
    int64_t rank = rank_of(c, id);
    return rank != NO_ITEM && (c->turned[rank] & TURNED);
}

/* How many items the candidate has that the reference has not, of those whose decision is not known to have been turned. */
static int64_t surplus(const Comparison *c, const NphArray *a, const NphArray *b, const NphArray *ids, const int64_t *place, int all) {
    int64_t length = length_of(a), others = length_of(b), matched = 0, known = 0;
    for (int64_t i = 0; i < length; i++) matched += place[i] != NO_ITEM;
    for (int64_t j = 0; j < others && !all; j++) known += is_turned(c, value_at(ids, j));
    for (int64_t i = 0; i < length && !all; i++) known -= place[i] != NO_ITEM && is_turned(c, value_at(ids, place[i]));
    return others - matched - known;
}

/* Where the cell differs most, index and all. */
static void keep_worst(NphBufferGap *gap, const NphArray *a, int64_t i, double x, double y, double ulp) {
    gap->rank = a->rank;
    gap->reference = x;
    gap->candidate = y;
    gap->ulp = ulp;
    gap->absolute = nph_abs(x - y);
    for (int axis = a->rank - 1; axis >= 0; axis--) {
        gap->index[axis] = i % a->shape[axis];
        i /= a->shape[axis];
    }
}

static double largest_of(const NphArray *a, int64_t first, int64_t length) {
    double largest = 0.0;
    for (int64_t i = first; i < first + length; i++) {
        double size = nph_abs(value_at(a, i));
        largest = size > largest && size < NOWHERE ? size : largest;
    }
    return largest;
}

/* How far y is from x: infinite where one of the two is not a number. */
static double distance_of(const Comparison *c, const NphArray *a, double x, double y, double largest) {
    NphType type = c->precision == 32 ? NPH_F32 : a->type;
    int both_nan = !(x >= x) && !(y >= y);
    if ((x >= y && x <= y) || both_nan) return 0.0;
    double off = nph_abs(x - y), size = nph_abs(x);
    if (is_real(a)) off /= unit_of(size > largest ? size : largest, type);
    return off >= 0.0 ? off : nph_infinity();
}

/* Rows of the last axis; `place` reorders the candidate's. */
static void compare_rows(const Comparison *c, NphBufferGap *gap, const NphArray *a, const NphArray *b, const NphArray *ids,
                         const int64_t *place) {
    int64_t length = length_of(a), others = length_of(b), rows = length ? nph_array_count(a) / length : 0;
    int numbers = is_real(a), by_identity = is_by_identity(gap->buffer);
    for (int64_t i = 0; i < length; i++) c->gap[i] = -1.0;
    for (int64_t r = 0; r < rows; r++) {
        double largest = numbers ? largest_of(a, r * length, length) : 0.0;
        for (int64_t i = 0; i < length; i++) {
            double id = ids ? value_at(ids, i) : by_identity ? (double)i : -1.0;
            if (numbers && is_turned(c, id)) continue;
            int64_t j = place ? place[i] : i;
            double x = value_at(a, r * length + i), y = j == NO_ITEM || j >= others ? nph_nan() : value_at(b, r * others + j);
            double ulp = j == NO_ITEM ? nph_infinity() : distance_of(c, a, x, y, largest);
            gap->cells++;
            gap->beyond += ulp > gap->limit;
            gap->octaves[nph_octave(ulp)]++;
            if (ulp > gap->ulp) keep_worst(gap, a, r * length + i, x, y, ulp);
            if (ulp > c->gap[i]) c->gap[i] = ulp;
        }
    }
    for (int64_t i = 0; i < length; i++) {
        gap->items += c->gap[i] >= 0.0;
        gap->turned += c->gap[i] > gap->limit;
    }
    gap->gap = c->gap;
    gap->gap_count = numbers ? length : 0;
}

/* Marks who is in a queue; counts positions that no item has, or that stand there twice. */
static int64_t mark_queue(const Comparison *c, const NphArray *queue, const NphArray *ids, unsigned char mark, unsigned char *seen) {
    int64_t strangers = 0;
    for (int64_t i = 0; i < nph_array_count(queue); i++) {
        double at = value_at(queue, i);
        int64_t rank = at >= 0.0 && at < (double)nph_array_count(ids) ? rank_of(c, value_at(ids, (int64_t)at)) : NO_ITEM;
        if (rank == NO_ITEM || (seen[rank] & mark)) strangers++;
        else seen[rank] |= mark;
    }
    return strangers;
}

/* Identities of a queue's items, each counted once as a cell: those that only one side has differ. */
static NphStatus compare_queue(const Comparison *c, NphBufferGap *gap, const NphArray *a, const NphArray *b, const NphArray *ours,
                               const NphArray *theirs) {
    unsigned char *seen = NULL;
    NPH_TRY(NPH_NEW(c->context, c->identities + 1, "items of a queue", &seen));
    gap->beyond = mark_queue(c, a, ours, IN_OURS, seen) + mark_queue(c, b, theirs, IN_THEIRS, seen);
    gap->rank = 1;
    for (int64_t rank = 0; rank < c->identities; rank++) {
        if (!seen[rank]) continue;
        int differs = seen[rank] != (IN_OURS | IN_THEIRS);
        gap->cells++;
        gap->octaves[nph_octave(differs)]++;
        if (differs && gap->ulp <= 0.0) {
            gap->index[0] = (int64_t)c->ids[rank];
            gap->reference = seen[rank] & IN_OURS ? 1.0 : 0.0;
            gap->candidate = 1.0 - gap->reference;
            gap->ulp = gap->absolute = 1.0;
        }
        gap->beyond += differs;
    }
    gap->items = gap->cells;
    gap->turned = gap->beyond;
    nph_free(c->context, seen);
    return NPH_OK;
}

/* A list of positions as one of identities; a position that no item has is `none`. */
static NphStatus name_items(const Comparison *c, const NphArray *list, const NphArray *ids, int64_t none, NphArray *out) {
    NPH_TRY(nph_array_new(c->context, NPH_I64, list->rank, list->shape, "identities of a list", out));
    for (int64_t i = 0; i < nph_array_count(list); i++) {
        double at = value_at(list, i);
        int there = at >= 0.0 && at < (double)nph_array_count(ids);
        ((int64_t *)out->data)[i] = there ? (int64_t)value_at(ids, (int64_t)at) : none;
    }
    return NPH_OK;
}

/* Shapes agree but for the number of items of buffers that have an identity. */
static int shapes_fit(const NphArray *a, const NphArray *b, int free_last) {
    if (a->rank != b->rank || is_real(a) != is_real(b)) return 0;
    for (int axis = 0; axis < a->rank - free_last; axis++)
        if (a->shape[axis] != b->shape[axis]) return 0;
    return 1;
}

static void shape_text(const NphArray *array, char text[80]) {
    size_t used = (size_t)snprintf(text, 80, "%s [", nph_type_name(array->type));
    for (int a = 0; a < array->rank && used < 60; a++)
        used += (size_t)snprintf(text + used, 80 - used, "%s%lld", a ? ", " : "", (long long)array->shape[a]);
    snprintf(text + used, 80 - used, "]");
}

/* Both sides' arrays of a buffer, and their identities or NULL; 0 where they cannot be compared. */
static int pair_of(const Comparison *c, const NphBuffer *buffer, const NphArray *pair[2], const NphArray *ids[2]) {
    pair[0] = output_of(c->ours, buffer->name);
    pair[1] = output_of(c->theirs, buffer->name);
    ids[0] = pair[0] ? identities_of(c->ours, buffer, pair[0]) : NULL;
    ids[1] = pair[1] ? identities_of(c->theirs, buffer, pair[1]) : NULL;
    if (!ids[0] || !ids[1]) ids[0] = ids[1] = NULL;
    return pair[0] && pair[1] && shapes_fit(pair[0], pair[1], is_one_item(buffer) || (ids[0] && buffer->queue != NPH_QUEUE_IN_ORDER));
}

static NphStatus make_room(Comparison *c, int64_t items) {
    if (items <= c->gap_room) return NPH_OK;
    nph_free(c->context, c->gap);
    c->gap = NULL;
    c->gap_room = items;
    return NPH_NEW(c->context, c->gap_room, "differences of items", &c->gap);
}

/* Matched by identity; by position where there is none. */
static NphStatus compare_items(Comparison *c, NphBufferGap *gap, const NphArray *pair[2], const NphArray *ids[2]) {
    int64_t *place = NULL;
    NphStatus status = make_room(c, length_of(pair[0]));
    if (status == NPH_OK && ids[0]) status = match(c, ids[0], ids[1], &place);
    if (status == NPH_OK) compare_rows(c, gap, pair[0], pair[1], ids[0], place);
    if (status == NPH_OK && place) {
        int64_t more = surplus(c, pair[0], pair[1], ids[1], place, !is_real(pair[0]));
        gap->beyond += more;
        gap->turned += more;
    }
    nph_free(c->context, place);
    return status;
}

/* Identities at the same places of a list. */
static NphStatus compare_list(Comparison *c, NphBufferGap *gap, const NphArray *pair[2], const NphArray *ids[2]) {
    NphArray named[2] = {{0}, {0}};
    NphStatus status = make_room(c, length_of(pair[0]));
    for (int side = 0; side < 2 && status == NPH_OK; side++) status = name_items(c, pair[side], ids[side], -2 - side, &named[side]);
    if (status == NPH_OK) compare_rows(c, gap, &named[0], &named[1], NULL, NULL);
    for (int side = 0; side < 2; side++) nph_array_free(c->context, &named[side]);
    return status;
}

/* Whole numbers that are sums over chance: one decision on the edge changes a cell by as much as chance does, so what is compared are
 * sums over slabs of cells, SLABS of them along each axis. [a][z][y][x][c] -> [a c][slabs along z, y, x] */
static NphStatus sum_slabs(const Comparison *c, const NphArray *sums, NphArray *out) {
    const int64_t *n = sums->shape, tail = n[4];
    NPH_TRY(nph_array_new(c->context, NPH_F64, 2, (const int64_t[]){n[0] * tail, 3 * SLABS}, "sums of cells", out));
    double *to = out->data;
    for (int64_t i = 0, cell = 0; i < nph_array_count(sums); i++, cell = i / tail) {
        int64_t row = cell / (n[1] * n[2] * n[3]) * tail + i % tail, at[3] = {cell / (n[2] * n[3]) % n[1], cell / n[3] % n[2], cell % n[3]};
        for (int a = 0; a < 3; a++) to[(row * 3 + a) * SLABS + at[a] * SLABS / n[1 + a]] += value_at(sums, i);
    }
    return NPH_OK;
}

static int is_statistical(const NphBuffer *buffer, const NphArray *array) {
    return buffer->comparison == NPH_STAT && !is_real(array) && array->rank == 5;
}

static NphStatus compare_slabs(Comparison *c, NphBufferGap *gap, const NphArray *pair[2]) {
    const NphArray *both[2] = {NULL, NULL}, *nobody[2] = {NULL, NULL};
    NphArray slabs[2] = {{0}, {0}};
    NphStatus status = NPH_OK;
    for (int side = 0; side < 2 && status == NPH_OK; side++) status = sum_slabs(c, pair[side], &slabs[side]);
    both[0] = &slabs[0];
    both[1] = &slabs[1];
    if (status == NPH_OK) status = compare_items(c, gap, both, nobody);
    for (int side = 0; side < 2; side++) nph_array_free(c->context, &slabs[side]);
    return status;
}

/* Turned over once, by its integers. */
static NphStatus compare_whole(Comparison *c, NphBufferGap *gap, const NphArray *pair[2], const NphArray *ids[2]) {
    if (is_real(pair[0])) return c->agree ? compare_items(c, gap, pair, ids) : NPH_OK;
    gap->cells = gap->items = 1;
    gap->beyond = gap->turned = !c->agree;
    gap->octaves[nph_octave(!c->agree)] = 1;
    if (!c->agree) gap->ulp = gap->absolute = 1.0;
    return NPH_OK;
}

static NphStatus compare_buffer(Comparison *c, const NphBuffer *buffer) {
    const NphArray *pair[2], *ids[2];
    NphBufferGap gap = {.buffer = buffer};
    int fits = pair_of(c, buffer, pair, ids);
    if (!pair[0]) return NPH_OK;
    if (!fits) {
        char expected[80], found[80] = "missing";
        shape_text(pair[0], expected);
        if (pair[1]) shape_text(pair[1], found);
        snprintf(gap.problem, sizeof gap.problem, "%s, expected %s", found, expected);
        return c->watch->take(c->watch->user, &gap);
    }
    gap.limit = is_real(pair[0]) || is_statistical(buffer, pair[0]) ? c->watch->limit(c->watch->user, buffer) : 0.0;
    NphStatus status = NPH_OK;
    if (ids[0] && buffer->queue == NPH_QUEUE_AS_SET) status = compare_queue(c, &gap, pair[0], pair[1], ids[0], ids[1]);
    else if (ids[0] && buffer->queue) status = compare_list(c, &gap, pair, ids);
    else if (is_statistical(buffer, pair[0]) && gap.limit > 0.0) status = compare_slabs(c, &gap, pair);
    else if (is_one_item(buffer)) status = compare_whole(c, &gap, pair, ids);
    else status = compare_items(c, &gap, pair, ids);
    return status == NPH_OK ? c->watch->take(c->watch->user, &gap) : status;
}

static void turn(Comparison *c, double id) {
    int64_t rank = rank_of(c, id);
    if (rank != NO_ITEM) c->turned[rank] |= TURNED;
}

static void mark_ids(Comparison *c, const NphArray *ids, unsigned char mark) {
    for (int64_t i = 0; i < nph_array_count(ids); i++) {
        int64_t rank = rank_of(c, value_at(ids, i));
        if (rank != NO_ITEM) c->turned[rank] |= mark;
    }
}

/* Turned is what only one side has marked; the marks go. */
static void turn_marked(Comparison *c) {
    for (int64_t rank = 0; rank < c->identities; rank++) {
        int seen = c->turned[rank] & (IN_OURS | IN_THEIRS);
        c->turned[rank] &= TURNED;
        if (seen == IN_OURS || seen == IN_THEIRS) c->turned[rank] |= TURNED;
    }
}

/* Whose integers differ, or are there on one side only. */
static NphStatus turn_values(Comparison *c, const NphArray *pair[2], const NphArray *ids[2]) {
    int64_t length = length_of(pair[0]), others = length_of(pair[1]), rows = length ? nph_array_count(pair[0]) / length : 0, *place = NULL;
    NPH_TRY(match(c, ids[0], ids[1], &place));
    for (int64_t i = 0; i < length; i++) {
        int differs = place[i] == NO_ITEM;
        for (int64_t r = 0; r < rows && !differs; r++)
            differs = distance_of(c, pair[0], value_at(pair[0], r * length + i), value_at(pair[1], r * others + place[i]), 0.0) > 0.0;
        if (differs) turn(c, value_at(ids[0], i));
    }
    nph_free(c->context, place);
    mark_ids(c, ids[0], IN_OURS);
    mark_ids(c, ids[1], IN_THEIRS);
    turn_marked(c);
    return NPH_OK;
}

static void turn_queue(Comparison *c, const NphArray *pair[2], const NphArray *ids[2]) {
    mark_queue(c, pair[0], ids[0], IN_OURS, c->turned);
    mark_queue(c, pair[1], ids[1], IN_THEIRS, c->turned);
    turn_marked(c);
}

static int by_value(const void *a, const void *b) {
    const double *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

static int names_items(const Comparison *c, const char *buffer) {
    for (int b = 0; b < c->method->buffer_count; b++)
        if (c->method->buffers[b].identity && strcmp(c->method->buffers[b].identity, buffer) == 0) return 1;
    return 0;
}

/* The identities of one side's items; none where ids is NULL: counts them. */
static int64_t list_identities(const Comparison *c, const NphSide *side, double *ids) {
    int64_t known = 0;
    for (int i = 0; i < side->count; i++) {
        const NphArray *array = &side->buffers[i].array;
        for (int64_t k = 0; k < nph_array_count(array) && names_items(c, side->buffers[i].name); k++) {
            if (!(value_at(array, k) >= 0.0)) continue;
            if (ids) ids[known] = value_at(array, k);
            known++;
        }
    }
    return known;
}

static NphStatus gather_identities(Comparison *c) {
    int64_t ours = list_identities(c, c->ours, NULL), count = ours + list_identities(c, c->theirs, NULL);
    NPH_TRY(NPH_NEW(c->context, count + 1, "identities of items", &c->ids));
    NPH_TRY(NPH_NEW(c->context, count + 1, "marks of items", &c->turned));
    list_identities(c, c->ours, c->ids);
    list_identities(c, c->theirs, c->ids + ours);
    qsort(c->ids, (size_t)count, sizeof *c->ids, by_value);
    for (int64_t k = 0; k < count; k++)
        if (k == 0 || c->ids[k] > c->ids[k - 1]) c->ids[c->identities++] = c->ids[k];
    return NPH_OK;
}

static int equal_integers(const NphArray *a, const NphArray *b) {
    int64_t count = nph_array_count(a);
    if (count != nph_array_count(b)) return 0;
    for (int64_t i = 0; i < count; i++)
        if (value_at(a, i) < value_at(b, i) || value_at(a, i) > value_at(b, i)) return 0;
    return 1;
}

static NphStatus find_turned(Comparison *c) {
    c->agree = 1;
    NPH_TRY(gather_identities(c));
    for (int b = 0; b < c->method->buffer_count; b++) {
        const NphBuffer *buffer = &c->method->buffers[b];
        const NphArray *pair[2], *ids[2];
        if (!pair_of(c, buffer, pair, ids) || is_real(pair[0]) || is_statistical(buffer, pair[0])) continue;
        if (!buffer->identity) c->agree &= equal_integers(pair[0], pair[1]);
        if (!ids[0]) continue;
        if (buffer->queue == NPH_QUEUE_AS_SET) turn_queue(c, pair, ids);
        else if (!buffer->queue) NPH_TRY(turn_values(c, pair, ids));
    }
    return NPH_OK;
}

NphStatus nph_compare_sides(NphContext *context, const NphMethod *method, int precision, const NphSide *ours, const NphSide *theirs,
                            const NphCellWatch *watch) {
    Comparison c = {.context = context, .method = method, .precision = precision, .ours = ours, .theirs = theirs, .watch = watch};
    NphStatus status = find_turned(&c);
    for (int o = 0; o < ours->outputs && status == NPH_OK; o++) {
        int buffer = nph_buffer_find(method, ours->buffers[o].name);
        if (buffer >= 0) status = compare_buffer(&c, &method->buffers[buffer]);
    }
    nph_free(context, c.ids);
    nph_free(context, c.turned);
    nph_free(context, c.gap);
    return status;
}
