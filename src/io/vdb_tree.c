/* SPDX-License-Identifier: Apache-2.0
 *
 * A float grid of a .vdb file to leaves and tiles. What the tree's bytes are, all little endian:
 *     topology  int32 1, root (background, counts, tiles, children), upper nodes (32^3), lower nodes (16^3), leaf masks
 *     buffers   leaf by leaf, in the same order: its mask once more, its values
 * Values: a byte that says which of inactive values and selection mask follow, those, then the data, of the active
 * values alone where the compression says so, packed on their own behind a 64-bit size (negative: not packed). First
 * everything is followed and checked against the grid's end, then leaves are allocated and unpacked in order. */
#include <blosc.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "core/memory.h"
#include "core/message.h"
#include "io/nvdb_leaf.h"
#include "io/vdb.h"

enum { UPPER_MASK = 4096, LOWER_MASK = 512, LEAF_MASK = 64, LZ4_FORMAT = 1 };
enum { UPPER_SIZE = 4096, LOWER_SIZE = 128, UPPER_VALUES = 32768 };
enum { ROOT_TILE_BYTES = 17, ORIGIN_BYTES = 12, SIZE_BYTES = 8 };
/* What the byte before the values says: inactive values are the background, or its negative, or one or two others. */
enum { BACKGROUND = 0, ONE_INACTIVE = 2, MASK = 3, MASK_ONE_INACTIVE = 4, MASK_TWO_INACTIVE = 5, ALL_VALUES = 6 };

typedef struct LeafPlace {
    int32_t origin[3];
    uint64_t mask_at, values_at;
} LeafPlace;

typedef struct Walk {
    NphContext *context;
    const char *path, *name;
    const NphVdbSource *source;
    uint64_t at;
    LeafPlace *places; /* in the order of the file */
    int64_t place_capacity, tile_capacity, leaf_seen;
    unsigned char *packed; /* room for the values of an upper node, as in the file and decoded */
    float *values;
    NphVolume volume;
} Walk;

static NphStatus damaged(const Walk *walk, uint64_t at, const char *format, ...) NPH_PRINTF(3, 4);
static NphStatus damaged(const Walk *walk, uint64_t at, const char *format, ...) {
    char text[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return nph_error(walk->context, NPH_BAD_INPUT, "%s: grid '%s', byte %llu: %s; the file was cut or damaged",
                     walk->path, walk->name, (unsigned long long)at, text);
}

/* Moves over `bytes` and gives their place. */
static NphStatus take(Walk *walk, uint64_t bytes, const char *what, const unsigned char **taken) {
    if (bytes > walk->source->size - walk->at)
        return nph_error(walk->context, NPH_BAD_INPUT,
                         "%s: grid '%s', byte %llu: %s goes beyond the grid's end; the file was cut or damaged", walk->path,
                         walk->name, (unsigned long long)walk->at, what);
    *taken = walk->source->bytes + walk->at;
    walk->at += bytes;
    return NPH_OK;
}

static uint64_t count_on(const unsigned char *mask, uint64_t bytes) {
    uint64_t count = 0;
    for (uint64_t i = 0; i < bytes; i++)
        for (unsigned word = mask[i]; word; word &= word - 1) count++;
    return count;
}

/* ---- values ---- */

/* Only LZ4 is let through: OpenVDB writes nothing else, and blosc would print about codecs it lacks. */
static int is_sound_block(const unsigned char *block, uint64_t bytes, uint64_t expected) {
    size_t unpacked = 0;
    return bytes >= BLOSC_MIN_HEADER_LENGTH && bytes <= expected + BLOSC_MAX_OVERHEAD && block[2] >> 5 == LZ4_FORMAT &&
           blosc_cbuffer_validate(block, (size_t)bytes, &unpacked) == 0 && unpacked == expected;
}

static NphStatus walk_packed(Walk *walk, uint64_t expected) {
    const unsigned char *word = NULL, *block = NULL;
    uint64_t at = walk->at;
    NPH_TRY(take(walk, SIZE_BYTES, "the size of values", &word));
    uint64_t size = nph_load_u64(word);
    int plain = size == 0 || size >> 63;
    uint64_t bytes = plain ? 0 - size : size;
    if (plain && bytes != expected)
        return damaged(walk, at, "%llu bytes of values are announced, not %llu", (unsigned long long)bytes,
                       (unsigned long long)expected);
    NPH_TRY(take(walk, bytes, "a block of values", &block));
    if (plain) return NPH_OK;
    if ((walk->source->compression & NPH_VDB_BLOSC) && !is_sound_block(block, bytes, expected))
        return damaged(walk, at + SIZE_BYTES, "the blosc block is damaged");
    return NPH_OK;
}

static NphStatus walk_values(Walk *walk, const unsigned char *active, uint64_t mask_bytes) {
    const unsigned char *kind = NULL, *skipped = NULL;
    uint64_t count = 8 * mask_bytes, element = walk->source->half ? 2 : 4;
    NPH_TRY(take(walk, 1, "a node", &kind));
    if (*kind > ALL_VALUES) return damaged(walk, walk->at - 1, "a node's values are stored in an unknown way, %d", *kind);
    uint64_t inactive = *kind == MASK_TWO_INACTIVE ? 8 : *kind == ONE_INACTIVE || *kind == MASK_ONE_INACTIVE ? 4 : 0;
    NPH_TRY(take(walk, inactive, "a node's inactive values", &skipped));
    if (*kind >= MASK && *kind <= MASK_TWO_INACTIVE) NPH_TRY(take(walk, mask_bytes, "a node's mask", &skipped));
    if ((walk->source->compression & NPH_VDB_ACTIVE) && *kind != ALL_VALUES) count = count_on(active, mask_bytes);
    if (walk->source->half && count == 0) return NPH_OK;
    if (walk->source->compression & (NPH_VDB_ZIP | NPH_VDB_BLOSC)) return walk_packed(walk, count * element);
    return take(walk, count * element, "a node's values", &skipped);
}

/* `bytes` of data at `at`, which walk_values followed. */
static NphStatus unpack(const Walk *walk, uint64_t at, uint64_t bytes, unsigned char *out) {
    uint32_t compression = walk->source->compression;
    uint64_t size = compression & (NPH_VDB_ZIP | NPH_VDB_BLOSC) ? nph_load_u64(walk->source->bytes + at) : 0;
    const unsigned char *data = walk->source->bytes + at + (compression & (NPH_VDB_ZIP | NPH_VDB_BLOSC) ? SIZE_BYTES : 0);
    if (size == 0 || size >> 63) {
        memcpy(out, data, bytes);
    } else if (compression & NPH_VDB_BLOSC) {
        if (bytes > 0 && blosc_decompress_ctx(data, out, bytes, 1) != (int)bytes)
            return damaged(walk, at + SIZE_BYTES, "the blosc block is damaged");
    } else {
        uLongf made = (uLongf)bytes;
        uLong used = (uLong)size;
        int result = uncompress2(out, &made, data, &used);
        if (result == Z_MEM_ERROR) return nph_error(walk->context, NPH_NO_MEMORY, "%s: no memory to unpack zip data", walk->path);
        if (result != Z_OK || made != bytes || used != size)
            return damaged(walk, at + SIZE_BYTES, "the zip data are damaged");
    }
    return NPH_OK;
}

/* All values of a node into walk->values: those that are stored, the inactive ones in between. */
static NphStatus decode_values(const Walk *walk, uint64_t at, const unsigned char *active, uint64_t mask_bytes) {
    const unsigned char *next = walk->source->bytes + at, *selection = NULL;
    uint64_t total = 8 * mask_bytes, count = total, element = walk->source->half ? 2 : 4;
    int kind = *next++;
    float background = walk->volume.background, inactive[2] = {kind == BACKGROUND ? background : -background, background};
    if (kind == ONE_INACTIVE || kind == MASK_ONE_INACTIVE || kind == MASK_TWO_INACTIVE) {
        inactive[0] = nph_load_f32(next);
        next += 4;
    }
    if (kind == MASK_TWO_INACTIVE) {
        inactive[1] = nph_load_f32(next);
        next += 4;
    }
    if (kind >= MASK && kind <= MASK_TWO_INACTIVE) {
        selection = next;
        next += mask_bytes;
    }
    int active_only = (walk->source->compression & NPH_VDB_ACTIVE) && kind != ALL_VALUES;
    if (active_only) count = count_on(active, mask_bytes);
    if (count > 0) NPH_TRY(unpack(walk, (uint64_t)(next - walk->source->bytes), count * element, walk->packed));
    const unsigned char *stored = walk->packed;
    for (uint64_t i = 0; i < total; i++) {
        if (active_only && !(active[i >> 3] >> (i & 7) & 1)) {
            walk->values[i] = inactive[selection && selection[i >> 3] >> (i & 7) & 1];
            continue;
        }
        walk->values[i] = walk->source->half ? nph_load_f16(stored) : nph_load_f32(stored);
        stored += element;
    }
    return NPH_OK;
}

/* ---- topology ---- */

/* Inactive tiles that hold the background say nothing and are left out. */
static NphStatus add_tile(Walk *walk, const NphTile *tile) {
    NphVolume *volume = &walk->volume;
    if (!tile->active && tile->value == volume->background) return NPH_OK;
    if (volume->tile_count == walk->tile_capacity) {
        int64_t capacity = walk->tile_capacity ? 2 * walk->tile_capacity : 64;
        NPH_TRY(nph_realloc(walk->context, (size_t)capacity, sizeof *volume->tiles, "volume tiles",
                            (void **)&volume->tiles));
        walk->tile_capacity = capacity;
    }
    volume->tiles[volume->tile_count++] = *tile;
    return NPH_OK;
}

static NphStatus walk_leaf_mask(Walk *walk, const int32_t origin[3]) {
    const unsigned char *mask = NULL;
    if (walk->leaf_seen == walk->place_capacity) {
        int64_t capacity = walk->place_capacity ? 2 * walk->place_capacity : 256;
        NPH_TRY(nph_realloc(walk->context, (size_t)capacity, sizeof *walk->places, "leaf places",
                            (void **)&walk->places));
        walk->place_capacity = capacity;
    }
    LeafPlace *place = &walk->places[walk->leaf_seen++];
    memcpy(place->origin, origin, sizeof place->origin);
    place->mask_at = walk->at;
    return take(walk, LEAF_MASK, "a leaf's mask", &mask);
}

static int is_on(const unsigned char *mask, uint32_t bit) { return mask[bit >> 3] >> (bit & 7) & 1; }

/* Corner of entry n of a node: x in the highest bits, z in the lowest. */
static void place_entry(const int32_t origin[3], int is_upper, uint32_t n, int32_t corner[3]) {
    uint32_t side = is_upper ? 5 : 4, steps[3] = {n >> 2 * side, n >> side & ((1u << side) - 1), n & ((1u << side) - 1)};
    for (int axis = 0; axis < 3; axis++)
        corner[axis] = origin[axis] + (int32_t)steps[axis] * (is_upper ? LOWER_SIZE : NPH_LEAF_SIZE);
}

/* An upper node, whose children are lower ones, or a lower node, whose children are leaves. */
static NphStatus walk_inner(Walk *walk, const int32_t origin[3], int is_upper) {
    const unsigned char *children = NULL, *active = NULL;
    uint64_t mask_bytes = is_upper ? UPPER_MASK : LOWER_MASK, at = walk->at;
    uint32_t count = (uint32_t)(8 * mask_bytes);
    int32_t corner[3];
    NPH_TRY(take(walk, mask_bytes, "a node's mask of children", &children));
    NPH_TRY(take(walk, mask_bytes, "a node's mask of values", &active));
    for (uint64_t i = 0; i < mask_bytes; i++)
        if (children[i] & active[i]) return damaged(walk, at + i, "a node's entry is child and active value at once");
    uint64_t values_at = walk->at;
    NPH_TRY(walk_values(walk, active, mask_bytes));
    NPH_TRY(decode_values(walk, values_at, active, mask_bytes));
    for (uint32_t n = 0; n < count; n++) {
        if (is_on(children, n)) continue;
        place_entry(origin, is_upper, n, corner);
        NphTile tile = {{corner[0], corner[1], corner[2]}, is_upper ? LOWER_SIZE : NPH_LEAF_SIZE, walk->values[n],
                        is_on(active, n)};
        NPH_TRY(add_tile(walk, &tile));
    }
    for (uint32_t n = 0; n < count; n++) {
        if (!is_on(children, n)) continue;
        place_entry(origin, is_upper, n, corner);
        NPH_TRY(is_upper ? walk_inner(walk, corner, 0) : walk_leaf_mask(walk, corner));
    }
    return NPH_OK;
}

static void load_origin(const unsigned char *at, int32_t origin[3]) {
    for (int axis = 0; axis < 3; axis++) origin[axis] = (int32_t)nph_load_u32(at + 4 * axis);
}

/* -1, 0, 1 as the origin at a lies before, on or behind that at b. */
static int compare_stored(const unsigned char *a, const unsigned char *b) {
    for (int axis = 0; axis < 3; axis++) {
        int32_t x = (int32_t)nph_load_u32(a + 4 * axis), y = (int32_t)nph_load_u32(b + 4 * axis);
        if (x != y) return x < y ? -1 : 1;
    }
    return 0;
}

/* Entries are written in order, and the buffers follow that order: what is not sorted would be misread. */
static NphStatus check_origin(const Walk *walk, const unsigned char *origin, const unsigned char *before) {
    uint64_t at = (uint64_t)(origin - walk->source->bytes);
    for (int axis = 0; axis < 3; axis++)
        if (nph_load_u32(origin + 4 * axis) % UPPER_SIZE)
            return damaged(walk, at, "an entry of the root does not lie on a multiple of %d", UPPER_SIZE);
    if (before && compare_stored(before, origin) >= 0)
        return damaged(walk, at, "the entries of the root are not in order");
    return NPH_OK;
}

static NphStatus walk_root(Walk *walk) {
    const unsigned char *head = NULL, *tiles = NULL, *before = NULL;
    NPH_TRY(take(walk, 16, "the root", &head)); /* number of buffers, background, counts */
    if (nph_load_u32(head) != 1) return damaged(walk, walk->at - 16, "the number of buffers is not 1");
    walk->volume.background = nph_load_f32(head + 4);
    uint64_t tile_count = nph_load_u32(head + 8), child_count = nph_load_u32(head + 12);
    NPH_TRY(take(walk, tile_count * ROOT_TILE_BYTES, "the root's table", &tiles));
    for (uint64_t i = 0; i < tile_count; i++) {
        const unsigned char *tile = tiles + i * ROOT_TILE_BYTES;
        NPH_TRY(check_origin(walk, tile, i ? tile - ROOT_TILE_BYTES : NULL));
        if (tile[ROOT_TILE_BYTES - 1] > 1)
            return damaged(walk, (uint64_t)(tile - walk->source->bytes), "a tile is neither active nor inactive");
        NphTile made = {{0, 0, 0}, UPPER_SIZE, nph_load_f32(tile + ORIGIN_BYTES), tile[ROOT_TILE_BYTES - 1]};
        load_origin(tile, made.origin);
        NPH_TRY(add_tile(walk, &made));
    }
    uint64_t next_tile = 0;
    for (uint64_t i = 0; i < child_count; i++) {
        const unsigned char *origin = NULL;
        NPH_TRY(take(walk, ORIGIN_BYTES, "a child of the root", &origin));
        NPH_TRY(check_origin(walk, origin, before));
        while (next_tile < tile_count && compare_stored(tiles + next_tile * ROOT_TILE_BYTES, origin) < 0) next_tile++;
        if (next_tile < tile_count && compare_stored(tiles + next_tile * ROOT_TILE_BYTES, origin) == 0)
            return damaged(walk, walk->at - ORIGIN_BYTES, "an entry of the root is tile and child at once");
        int32_t corner[3];
        load_origin(origin, corner);
        NPH_TRY(walk_inner(walk, corner, 1));
        before = origin;
    }
    return NPH_OK;
}

static NphStatus walk_buffers(Walk *walk) {
    for (int64_t i = 0; i < walk->leaf_seen; i++) {
        const unsigned char *mask = NULL;
        LeafPlace *place = &walk->places[i];
        NPH_TRY(take(walk, LEAF_MASK, "a leaf", &mask));
        if (memcmp(mask, walk->source->bytes + place->mask_at, LEAF_MASK) != 0)
            return damaged(walk, walk->at - LEAF_MASK, "a leaf's mask differs from that at byte %llu",
                           (unsigned long long)place->mask_at);
        place->values_at = walk->at;
        NPH_TRY(walk_values(walk, mask, LEAF_MASK));
    }
    return NPH_OK;
}

/* For LeafPlace and NphTile: both start with their origin. */
static int compare_origins(const void *a, const void *b) {
    const int32_t *x = a, *y = b;
    for (int axis = 0; axis < 3; axis++)
        if (x[axis] != y[axis]) return x[axis] < y[axis] ? -1 : 1;
    return 0;
}

static NphStatus decode_leaves(Walk *walk) {
    NphVolume *volume = &walk->volume;
    if (walk->leaf_seen) qsort(walk->places, (size_t)walk->leaf_seen, sizeof *walk->places, compare_origins);
    if (volume->tile_count) qsort(volume->tiles, (size_t)volume->tile_count, sizeof *volume->tiles, compare_origins);
    NPH_TRY(NPH_NEW(walk->context, walk->leaf_seen, "volume leaves", &volume->leaves));
    volume->leaf_count = walk->leaf_seen;
    for (int64_t i = 0; i < walk->leaf_seen; i++) {
        const LeafPlace *place = &walk->places[i];
        const unsigned char *mask = walk->source->bytes + place->mask_at;
        NphLeaf *leaf = &volume->leaves[i];
        NPH_TRY(decode_values(walk, place->values_at, mask, LEAF_MASK));
        memcpy(leaf->origin, place->origin, sizeof leaf->origin);
        memcpy(leaf->values, walk->values, sizeof leaf->values);
        for (int x = 0; x < 8; x++) leaf->active[x] = nph_load_u64(mask + 8 * x);
    }
    return NPH_OK;
}

static NphStatus decode(Walk *walk, uint64_t block_at) {
    NPH_TRY(nph_alloc(walk->context, UPPER_VALUES, sizeof(float), "packed values", (void **)&walk->packed));
    NPH_TRY(NPH_NEW(walk->context, UPPER_VALUES, "values of a node", &walk->values));
    NPH_TRY(walk_root(walk));
    if (walk->at != block_at)
        return damaged(walk, walk->at, "the tree's topology ends here, but is announced to end at byte %llu",
                       (unsigned long long)block_at);
    NPH_TRY(walk_buffers(walk));
    if (walk->at != walk->source->size)
        return damaged(walk, walk->at, "the values end here, but the grid is announced to end at byte %llu",
                       (unsigned long long)walk->source->size);
    NPH_TRY(decode_leaves(walk));
    nph_volume_measure(&walk->volume);
    return NPH_OK;
}

NphStatus nph_vdb_decode(NphContext *context, const char *path, const char *name, const NphVdbSource *source,
                         NphVolume *volume) {
    Walk walk = {.context = context, .path = path, .name = name, .source = source, .at = source->topology_at};
    NphStatus status = decode(&walk, source->block_at);
    nph_free(context, walk.places);
    nph_free(context, walk.packed);
    nph_free(context, walk.values);
    if (status != NPH_OK) nph_volume_free(context, &walk.volume);
    else *volume = walk.volume;
    return status;
}
