/* SPDX-License-Identifier: Apache-2.0
 *
 * Parts back into one film. A part declares a box: its crop times its range of samples. The boxes must fill the
 * smallest box around them exactly, so that nothing is there twice and nothing is missing; an interrupted part, which
 * has fewer samples than it declares, may be the last of its pixels only.
 *
 * The nodes of a pixel's parts, put one behind the other with siblings merged, are the normal form of the whole range:
 * the bytes are those of a film that was never split. */
#include <string.h>

#include "core/float_state.h"
#include "core/memory.h"
#include "core/message.h"
#include "film/tree.h"

typedef struct Merge {
    NphContext *context;
    int count;
    NphFilm *const *parts;
    const char *const *names;
    int *order;  /* parts by their first sample */
    int *active; /* those of them that meet the current tile, in that order */
    int active_count;
    NphFilm layout; /* of the result */
} Merge;

/* Pixels [x0, x1) x [y0, y1) and samples: bounds 0, 1 and 2 lie below, 3, 4 and 5 beyond. */
typedef struct Box {
    int64_t bound[6];
} Box;

static Box box_of(const NphFilm *film) {
    return (Box){{film->crop[0], film->crop[1], film->chunk_begin * NPH_CHUNK, film->crop[2], film->crop[3],
                  film->chunk_end * NPH_CHUNK}};
}

static int box_holds(const Box *box, const int64_t point[3]) {
    for (int axis = 0; axis < 3; axis++)
        if (point[axis] < box->bound[axis] || point[axis] >= box->bound[axis + 3]) return 0;
    return 1;
}

/* Where both hold samples; 0 when nowhere. */
static int box_common(const Box *a, const Box *b, Box *common) {
    for (int axis = 0; axis < 3; axis++) {
        common->bound[axis] = a->bound[axis] > b->bound[axis] ? a->bound[axis] : b->bound[axis];
        common->bound[axis + 3] = a->bound[axis + 3] < b->bound[axis + 3] ? a->bound[axis + 3] : b->bound[axis + 3];
        if (common->bound[axis] >= common->bound[axis + 3]) return 0;
    }
    return 1;
}

static NphStatus refuse_text(const Merge *merge, int i, const NphFilmText *text, const char *other) {
    if (!other)
        return nph_error(merge->context, NPH_BAD_INPUT,
                         "%s: its text \"%s\" is missing in %s; they are parts of different runs", merge->names[0],
                         text->name, merge->names[i]);
    return nph_error(merge->context, NPH_BAD_INPUT,
                     "%s: its \"%s\" is \"%s\", but that of %s is \"%s\"; they are parts of different runs",
                     merge->names[0], text->name, text->text, merge->names[i], other);
}

/* Part i against part 0. */
static NphStatus check_alike(const Merge *merge, int i) {
    const NphFilm *first = merge->parts[0], *part = merge->parts[i];
    if (part->width != first->width || part->height != first->height)
        return nph_error(merge->context, NPH_BAD_INPUT, "%s: is of a picture of %d x %d pixels, but %s of %d x %d",
                         merge->names[0], first->width, first->height, merge->names[i], part->width, part->height);
    if (part->channels != first->channels)
        return nph_error(merge->context, NPH_BAD_INPUT, "%s: has %d channels, but %s has %d", merge->names[0],
                         first->channels, merge->names[i], part->channels);
    if (nph_film_is_shared(part) != nph_film_is_shared(first))
        return nph_error(merge->context, NPH_BAD_INPUT, "%s and %s: only in one of them pixels share samples",
                         merge->names[0], merge->names[i]);
    if (nph_film_is_shared(first) && memcmp(part->crop, first->crop, sizeof part->crop) != 0)
        return nph_error(merge->context, NPH_BAD_INPUT,
                         "%s and %s: their pixels share samples, so they merge by samples only, but their crops differ",
                         merge->names[0], merge->names[i]);
    for (int t = 0; t < first->text_count; t++) {
        const char *other = nph_film_text(part, first->texts[t].name);
        if (!other || strcmp(other, first->texts[t].text) != 0) return refuse_text(merge, i, &first->texts[t], other);
    }
    for (int t = 0; t < part->text_count; t++)
        if (!nph_film_text(first, part->texts[t].name))
            return nph_error(merge->context, NPH_BAD_INPUT,
                             "%s: its text \"%s\" is missing in %s; they are parts of different runs", merge->names[i],
                             part->texts[t].name, merge->names[0]);
    return NPH_OK;
}

static NphStatus check_overlaps(const Merge *merge) {
    for (int i = 0; i < merge->count; i++)
        for (int j = 0; j < i; j++) {
            Box a = box_of(merge->parts[j]), b = box_of(merge->parts[i]), both;
            if (!box_common(&a, &b, &both)) continue;
            const int64_t *at = both.bound;
            return nph_error(merge->context, NPH_BAD_INPUT,
                             "%s and %s overlap: both hold samples %lld:%lld of the pixels %lld,%lld,%lld,%lld",
                             merge->names[j], merge->names[i], (long long)at[2], (long long)at[5], (long long)at[0],
                             (long long)at[1], (long long)at[3], (long long)at[4]);
        }
    return NPH_OK;
}

static int part_at(const Merge *merge, const int64_t point[3]) {
    for (int i = 0; i < merge->count; i++) {
        Box box = box_of(merge->parts[i]);
        if (box_holds(&box, point)) return i;
    }
    return -1;
}

/* The least point of the outer box, in order of y, x, sample, that no part holds; 0 when there is none. Its coordinates
 * lie where a part ends or the outer box begins, so the walk goes from end to end. */
static int find_gap(const Merge *merge, const Box *outer, int64_t point[3]) {
    for (point[1] = outer->bound[1]; point[1] < outer->bound[4];) {
        int64_t next_y = outer->bound[4];
        for (point[0] = outer->bound[0]; point[0] < outer->bound[3];) {
            int64_t next_x = outer->bound[3];
            for (point[2] = outer->bound[2]; point[2] < outer->bound[5];) {
                int part = part_at(merge, point);
                if (part < 0) return 1;
                Box box = box_of(merge->parts[part]);
                point[2] = box.bound[5];
                if (box.bound[3] < next_x) next_x = box.bound[3];
                if (box.bound[4] < next_y) next_y = box.bound[4];
            }
            point[0] = next_x;
        }
        point[1] = next_y;
    }
    return 0;
}

static NphStatus check_gaps(const Merge *merge, const Box *outer) {
    int64_t point[3], end = outer->bound[5];
    if (!find_gap(merge, outer, point)) return NPH_OK;
    for (int i = 0; i < merge->count; i++) { /* the gap ends where the next part of this pixel begins */
        Box box = box_of(merge->parts[i]);
        int64_t probe[3] = {point[0], point[1], box.bound[2]};
        if (box.bound[2] > point[2] && box.bound[2] < end && box_holds(&box, probe)) end = box.bound[2];
    }
    return nph_error(merge->context, NPH_BAD_INPUT,
                     "%s and the other parts (%d in all) leave a gap: none holds samples %lld:%lld of pixel %lld,%lld",
                     merge->names[0], merge->count, (long long)point[2], (long long)end, (long long)point[0],
                     (long long)point[1]);
}

static Box box_around(const Merge *merge) {
    Box outer = box_of(merge->parts[0]);
    for (int i = 1; i < merge->count; i++) {
        Box box = box_of(merge->parts[i]);
        for (int axis = 0; axis < 3; axis++) {
            if (box.bound[axis] < outer.bound[axis]) outer.bound[axis] = box.bound[axis];
            if (box.bound[axis + 3] > outer.bound[axis + 3]) outer.bound[axis + 3] = box.bound[axis + 3];
        }
    }
    return outer;
}

static NphStatus check_parts(Merge *merge) {
    for (int i = 1; i < merge->count; i++) NPH_TRY(check_alike(merge, i));
    NPH_TRY(check_overlaps(merge));
    Box outer = box_around(merge);
    NPH_TRY(check_gaps(merge, &outer));
    int crop[4] = {(int)outer.bound[0], (int)outer.bound[1], (int)outer.bound[3], (int)outer.bound[4]};
    nph_film_lay_out(&merge->layout, merge->parts[0]->width, merge->parts[0]->height, crop, merge->parts[0]->channels);
    merge->layout.chunk_begin = outer.bound[2] / NPH_CHUNK;
    merge->layout.chunk_end = outer.bound[5] / NPH_CHUNK;
    merge->layout.slots = nph_tree_slots(merge->layout.chunk_begin, merge->layout.chunk_end);
    return NPH_OK;
}

/* The tile of a part that lies at the result's tile; -1 when the part does not meet it. */
static int64_t part_tile(const NphFilm *layout, int64_t tile, const NphFilm *part) {
    int64_t x = layout->tile_x0 + tile % layout->tiles_x - part->tile_x0;
    int64_t y = layout->tile_y0 + tile / layout->tiles_x - part->tile_y0;
    return x < 0 || y < 0 || x >= part->tiles_x || y >= part->tiles_y ? -1 : y * part->tiles_x + x;
}

static void find_active(Merge *merge, int64_t tile) {
    merge->active_count = 0;
    for (int i = 0; i < merge->count; i++)
        if (part_tile(&merge->layout, tile, merge->parts[merge->order[i]]) >= 0)
            merge->active[merge->active_count++] = merge->order[i];
}

static int holds_pixel(const NphFilm *part, int x, int y) {
    return x >= part->crop[0] && x < part->crop[2] && y >= part->crop[1] && y < part->crop[3];
}

/* Chunks of a pixel from the result's first on, without gaps. */
static NphStatus check_pixel(const Merge *merge, int64_t tile, int x, int y, int64_t *chunks) {
    int64_t reached = merge->layout.chunk_begin;
    int last = -1;
    for (int i = 0; i < merge->active_count; i++) {
        const NphFilm *part = merge->parts[merge->active[i]];
        int64_t own = part->chunks[part_tile(&merge->layout, tile, part)];
        if (!holds_pixel(part, x, y)) continue;
        if (own > 0 && part->chunk_begin != reached)
            return nph_error(merge->context, NPH_BAD_INPUT,
                             "%s: was interrupted: samples %lld:%lld of pixel %d,%d are missing before those of %s",
                             merge->names[last], (long long)(reached * NPH_CHUNK),
                             (long long)(part->chunk_begin * NPH_CHUNK), x, y, merge->names[merge->active[i]]);
        if (own > 0) reached = part->chunk_begin + own;
        last = merge->active[i];
    }
    *chunks = reached - merge->layout.chunk_begin;
    return NPH_OK;
}

/* All pixels of a tile must have as many samples. */
static NphStatus check_tile(Merge *merge, int64_t tile, int64_t *chunks) {
    int origin[2], inside[4];
    nph_film_tile_rect(&merge->layout, tile, origin, inside);
    find_active(merge, tile);
    NPH_TRY(check_pixel(merge, tile, inside[0], inside[1], chunks));
    for (int y = inside[1]; y < inside[3]; y++)
        for (int x = inside[0]; x < inside[2]; x++) {
            int64_t own = 0;
            NPH_TRY(check_pixel(merge, tile, x, y, &own));
            if (own != *chunks)
                return nph_error(
                    merge->context, NPH_BAD_INPUT,
                    "%s: was interrupted, or another part: pixel %d,%d has %lld samples, but %d,%d in the same "
                    "tile has %lld; finish it first",
                    merge->names[merge->active[0]], x, y, (long long)(own * NPH_CHUNK), inside[0], inside[1],
                    (long long)(*chunks * NPH_CHUNK));
        }
    return NPH_OK;
}

/* A pixel's normal form in the making. */
typedef struct Stack {
    int count, channels, values;
    NphNode nodes[NPH_MAX_NODES + 1];
    double value[NPH_MAX_NODES + 1][NPH_MAX_VALUES];
} Stack;

static NphMoments moments_at(const double *value) { return (NphMoments){value[0], value[1], value[2], value[3]}; }

/* Merges the last node into the one before it, its sibling. */
static void merge_last(Stack *stack) {
    int at = --stack->count;
    double *left = stack->value[at - 1], *right = stack->value[at];
    int64_t samples = nph_node_samples(stack->nodes[at]);
    NphJoin join = nph_join_of(samples, samples);
    for (int c = 0; c < stack->channels; c++) {
        NphMoments a = moments_at(left + NPH_MOMENTS * c), b = moments_at(right + NPH_MOMENTS * c);
        NphMoments both = nph_join_moments(&join, &a, &b);
        left[NPH_MOMENTS * c] = both.mean;
        left[NPH_MOMENTS * c + 1] = both.m2;
        left[NPH_MOMENTS * c + 2] = both.m3;
        left[NPH_MOMENTS * c + 3] = both.m4;
    }
    for (int v = NPH_MOMENTS * stack->channels; v < stack->values; v++)
        left[v] = nph_join_mean(&join, left[v], right[v]);
    stack->nodes[at - 1] = (NphNode){stack->nodes[at].level + 1, stack->nodes[at].index >> 1};
}

static int last_are_siblings(const Stack *stack) {
    const NphNode *last = &stack->nodes[stack->count - 1];
    return stack->count > 1 && (last->index & 1) && last[-1].level == last->level;
}

/* Appends the nodes of one part at a pixel; planes: its tile's first node. */
static void push_part(Stack *stack, const NphFilm *part, int64_t tile, int pixel) {
    NphNode nodes[NPH_MAX_NODES];
    int count = nph_film_tile_nodes(part, tile, nodes);
    for (int slot = 0; slot < count; slot++) {
        const double *planes = nph_film_node(part, tile, slot) + pixel;
        for (int v = 0; v < stack->values; v++) stack->value[stack->count][v] = planes[v * NPH_TILE_PIXELS];
        stack->nodes[stack->count++] = nodes[slot];
        while (last_are_siblings(stack)) merge_last(stack);
    }
}

static void merge_pixel(const Merge *merge, NphFilm *film, int64_t tile, int x, int y) {
    Stack stack;
    int origin[2], inside[4];
    nph_film_tile_rect(film, tile, origin, inside);
    int pixel = (y - origin[1]) * NPH_TILE + x - origin[0];
    stack.count = 0;
    stack.channels = film->channels;
    stack.values = film->values;
    for (int i = 0; i < merge->active_count; i++) {
        const NphFilm *part = merge->parts[merge->active[i]];
        if (holds_pixel(part, x, y)) push_part(&stack, part, part_tile(film, tile, part), pixel);
    }
    for (int slot = 0; slot < stack.count; slot++)
        for (int v = 0; v < stack.values; v++)
            nph_film_node(film, tile, slot)[v * NPH_TILE_PIXELS + pixel] = stack.value[slot][v];
}

static void merge_tile(Merge *merge, NphFilm *film, int64_t tile) {
    int origin[2], inside[4];
    nph_film_tile_rect(film, tile, origin, inside);
    find_active(merge, tile);
    for (int i = 0; i < merge->active_count; i++) {
        const NphFilm *part = merge->parts[merge->active[i]];
        nph_nonfinite_join(&film->nonfinite[tile], &part->nonfinite[part_tile(film, tile, part)]);
    }
    for (int y = inside[1]; y < inside[3]; y++)
        for (int x = inside[0]; x < inside[2]; x++) merge_pixel(merge, film, tile, x, y);
}

static NphStatus merge_into(Merge *merge, NphFilm *film) {
    for (int i = 0; i < merge->parts[0]->text_count; i++)
        NPH_TRY(
            nph_film_set_text(merge->context, film, merge->parts[0]->texts[i].name, merge->parts[0]->texts[i].text));
    for (int64_t tile = 0; tile < film->tile_count; tile++) NPH_TRY(check_tile(merge, tile, &film->chunks[tile]));
    for (int64_t tile = 0; tile < film->tile_count; tile++) merge_tile(merge, film, tile);
    return NPH_OK;
}

static void sort_by_sample(Merge *merge) {
    for (int i = 0; i < merge->count; i++) {
        int at = i;
        for (; at > 0 && merge->parts[merge->order[at - 1]]->chunk_begin > merge->parts[i]->chunk_begin; at--)
            merge->order[at] = merge->order[at - 1];
        merge->order[at] = i;
    }
}

static NphStatus run_merge(Merge *merge, NphFilm **film);

/* The regions' means are films too. */
static NphStatus merge_level(const Merge *merge, int level, NphFilm **film) {
    NphFilm **levels = NULL;
    NPH_TRY(NPH_NEW(merge->context, merge->count, "parts", &levels));
    for (int i = 0; i < merge->count; i++) levels[i] = merge->parts[i]->regions[level];
    Merge coarse = {.context = merge->context, .count = merge->count, .parts = levels, .names = merge->names};
    NphStatus status = run_merge(&coarse, film);
    nph_free(merge->context, coarse.order);
    nph_free(merge->context, coarse.active);
    nph_free(merge->context, levels);
    return status;
}

static NphStatus run_merge(Merge *merge, NphFilm **film) {
    NphFilm *made = NULL;
    NPH_TRY(check_parts(merge));
    NPH_TRY(NPH_NEW(merge->context, merge->count, "parts", &merge->order));
    NPH_TRY(NPH_NEW(merge->context, merge->count, "parts", &merge->active));
    sort_by_sample(merge);
    NPH_TRY(nph_film_make(merge->context, &merge->layout, &made));
    NphStatus status = merge_into(merge, made);
    for (int level = 0; level < NPH_REGION_LEVELS && nph_film_is_shared(merge->parts[0]); level++)
        if (status == NPH_OK) status = merge_level(merge, level, &made->regions[level]);
    if (status != NPH_OK) {
        nph_film_free(merge->context, made);
        return status;
    }
    *film = made;
    return NPH_OK;
}

NphStatus nph_film_merge(NphContext *context, int count, NphFilm *const *parts, const char *const *names,
                         NphFilm **film) {
    Merge merge = {.context = context, .count = count, .parts = parts, .names = names};
    NphFloatState state;
    if (count < 1) return nph_error(context, NPH_BAD_USAGE, "merge: no parts given");
    nph_float_state_enter(&state);
    NphStatus status = run_merge(&merge, film);
    nph_float_state_leave(&state);
    nph_free(context, merge.order);
    nph_free(context, merge.active);
    return status;
}
