/* SPDX-License-Identifier: Apache-2.0
 *
 * A NanoVDB grid buffer to leaves and tiles. Reads through PNanoVDB.h (32.4.2) with a buffer type of our own whose
 * every read is checked, and never with its cached accessor. Each node's range is checked before it is entered, nodes
 * are counted against what the tree announces (which is checked against the buffer's size, so that nothing is visited
 * more often than it has bytes), and what was decoded must agree with the counts, the active box, the statistics and
 * the checksum that the file carries. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/text.h"
#include "io/nvdb.h"
#include "io/nvdb_leaf.h"

/* PNanoVDB's view of a buffer: a read outside gives 0, though every range is checked before it is read. */
typedef struct pnanovdb_buf_t {
    const unsigned char *bytes;
    uint64_t size;
} pnanovdb_buf_t;

static inline uint32_t pnanovdb_buf_read_uint32(pnanovdb_buf_t buf, uint64_t at) {
    return buf.size < 4 || at > buf.size - 4 ? 0 : nph_load_u32(buf.bytes + at);
}
static inline uint64_t pnanovdb_buf_read_uint64(pnanovdb_buf_t buf, uint64_t at) {
    return buf.size < 8 || at > buf.size - 8 ? 0 : nph_load_u64(buf.bytes + at);
}
typedef uint32_t pnanovdb_grid_type_t;
#define PNANOVDB_GRID_TYPE_GET(type, name) pnanovdb_grid_type_constants[type].name
#define PNANOVDB_C
#define PNANOVDB_BUF_CUSTOM
#include <nanovdb/PNanoVDB.h>

enum { UPPER_SIZE = 4096, LOWER_SIZE = 128, LEAF_FLAGS = 15, QUANTISED_HEAD = 96, MAX_LOG_BITS = 4 };

/* Where the parts of an inner node lie; upper and lower nodes differ in numbers only. */
typedef struct Level {
    int32_t size, child_size; /* edges in voxels */
    uint32_t log_children;    /* children along an edge, as a power of two */
    uint32_t value_mask, child_mask, table, bytes;
} Level;

typedef struct LeafPlace {
    int32_t origin[3]; /* first: compare_origins */
    uint64_t at;
} LeafPlace;

typedef struct Tree {
    NphContext *context;
    const NphNvdbBuffer *source;
    pnanovdb_buf_t buf;
    pnanovdb_grid_type_t type;
    pnanovdb_grid_handle_t grid;
    pnanovdb_tree_handle_t tree;
    pnanovdb_root_handle_t root;
    Level upper, lower;
    uint32_t upper_count, lower_count, leaf_count; /* announced */
    uint32_t upper_seen, lower_seen, leaf_seen;
    LeafPlace *places;
    int64_t tile_capacity;
    NphVolume volume;
} Tree;

static NphStatus damaged(const Tree *tree, uint64_t at, const char *format, ...) NPH_PRINTF(3, 4);
static NphStatus damaged(const Tree *tree, uint64_t at, const char *format, ...) {
    char text[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    const NphNvdbBuffer *source = tree->source;
    return nph_error(tree->context, NPH_BAD_INPUT, "%s: grid '%s', byte %llu%s: %s", source->path, source->name,
                     (unsigned long long)(source->file_offset + at), source->unpacked ? " of the unpacked grid" : "",
                     text);
}

/* ---- ranges and values ---- */

int nph_nvdb_type_readable(uint32_t type) {
    return type == PNANOVDB_GRID_TYPE_FLOAT || type == PNANOVDB_GRID_TYPE_HALF ||
           (type >= PNANOVDB_GRID_TYPE_FP4 && type <= PNANOVDB_GRID_TYPE_FPN);
}

/* Is [at, at + bytes) inside the buffer? */
static int inside(const Tree *tree, uint64_t at, uint64_t bytes) {
    return at <= tree->buf.size && bytes <= tree->buf.size - at;
}

/* Tile values, background and statistics: float for every type but half. */
static float load_value(const Tree *tree, uint64_t at) {
    const unsigned char *bytes = tree->buf.bytes + at;
    return tree->type == PNANOVDB_GRID_TYPE_HALF ? nph_load_f16(bytes) : nph_load_f32(bytes);
}

/* Does the grid carry these statistics in a form to compare with? Quantised grids keep them as codes. */
static int has_statistics(const Tree *tree, uint32_t flag) {
    int exact = tree->type == PNANOVDB_GRID_TYPE_FLOAT || tree->type == PNANOVDB_GRID_TYPE_HALF;
    return exact && (pnanovdb_grid_get_flags(tree->buf, tree->grid) & flag) != 0;
}

/* ---- header, tree and root ---- */

static NphStatus check_checksums(const Tree *tree, uint64_t root_end) {
    uint64_t tree_end = tree->tree.address.byte_offset + PNANOVDB_TREE_SIZE;
    int later = pnanovdb_grid_get_version(tree->buf, tree->grid) > ((uint32_t)NPH_NVDB_MAJOR << 21 | 6u << 10);
    if (root_end > tree->buf.size) return damaged(tree, tree_end, "the root's table exceeds the grid");
    const char *wrong = nph_nvdb_checksum(tree->source, pnanovdb_grid_get_checksum(tree->buf, tree->grid),
                                          later ? tree_end : root_end, later ? tree_end : 0);
    if (!wrong) return NPH_OK;
    return damaged(tree, PNANOVDB_GRID_OFF_CHECKSUM, "the checksum of %s does not match: the file was altered", wrong);
}

static NphStatus read_map(Tree *tree) {
    pnanovdb_map_handle_t map = pnanovdb_grid_get_map(tree->buf, tree->grid);
    double *m = tree->volume.world_from_index;
    for (uint32_t row = 0; row < 3; row++) {
        for (uint32_t column = 0; column < 3; column++)
            m[row * 4 + column] = pnanovdb_map_get_matd(tree->buf, map, row * 3 + column);
        m[row * 4 + 3] = pnanovdb_map_get_vecd(tree->buf, map, row);
    }
    double determinant = m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
                         m[2] * (m[4] * m[9] - m[5] * m[8]);
    int finite = determinant - determinant == 0.0;
    for (int i = 0; i < 12; i++) finite = finite && m[i] - m[i] == 0.0;
    if (!finite || determinant == 0.0)
        return damaged(tree, map.address.byte_offset + PNANOVDB_MAP_OFF_MATD,
                       "the transform from index to world is not invertible");
    return NPH_OK;
}

static NphStatus read_header(Tree *tree, uint32_t announced_type) {
    if (!inside(tree, 0, PNANOVDB_GRID_SIZE + PNANOVDB_TREE_SIZE))
        return damaged(tree, 0, "the grid has %llu bytes; its header alone needs %d",
                       (unsigned long long)tree->buf.size, PNANOVDB_GRID_SIZE + PNANOVDB_TREE_SIZE);
    uint64_t magic = pnanovdb_grid_get_magic(tree->buf, tree->grid);
    if (magic != NPH_NVDB_MAGIC && magic != NPH_NVDB_MAGIC_GRID) return damaged(tree, 0, "no NanoVDB grid starts here");
    uint32_t version = pnanovdb_version_get_major(pnanovdb_grid_get_version(tree->buf, tree->grid));
    if (version != NPH_NVDB_MAJOR)
        return damaged(tree, PNANOVDB_GRID_OFF_VERSION, "the grid has version %lu; %d is read", (unsigned long)version,
                       NPH_NVDB_MAJOR);
    uint64_t size = pnanovdb_grid_get_grid_size(tree->buf, tree->grid);
    if (size != tree->buf.size)
        return damaged(tree, PNANOVDB_GRID_OFF_GRID_SIZE, "the grid's size is %llu bytes, but %llu are announced",
                       (unsigned long long)size, (unsigned long long)tree->buf.size);
    tree->type = pnanovdb_grid_get_grid_type(tree->buf, tree->grid);
    if (tree->type != announced_type)
        return damaged(tree, PNANOVDB_GRID_OFF_GRID_TYPE, "the grid's type %lu differs from the announced type %lu",
                       (unsigned long)tree->type, (unsigned long)announced_type);
    nph_nvdb_type_name(tree->type, tree->volume.type);
    nph_nvdb_class_name(pnanovdb_grid_get_grid_class(tree->buf, tree->grid), tree->volume.grid_class);
    return read_map(tree);
}

static uint64_t leaf_bytes(const Tree *tree) {
    uint64_t bytes = PNANOVDB_GRID_TYPE_GET(tree->type, leaf_size);
    return tree->type == PNANOVDB_GRID_TYPE_FPN ? bytes + NPH_LEAF_VOXELS / 8 : bytes; /* at least one bit a voxel */
}

/* Root and node counts against the buffer, before anything is allocated for them. */
static NphStatus read_root(Tree *tree) {
    uint64_t tree_at = tree->tree.address.byte_offset, root_bytes = PNANOVDB_GRID_TYPE_GET(tree->type, root_size);
    uint64_t root_offset = pnanovdb_tree_get_node_offset_root(tree->buf, tree->tree);
    if (!inside(tree, tree_at + root_offset, root_bytes))
        return damaged(tree, tree_at + PNANOVDB_TREE_OFF_NODE_OFFSET_ROOT, "the root lies outside the grid");
    tree->root = pnanovdb_tree_get_root(tree->buf, tree->tree);
    uint64_t root_at = tree->root.address.byte_offset;
    uint64_t tiles = pnanovdb_root_get_tile_count(tree->buf, tree->root);
    uint64_t table_bytes = tiles * PNANOVDB_GRID_TYPE_GET(tree->type, root_tile_size);
    if (!inside(tree, root_at + root_bytes, table_bytes))
        return damaged(tree, root_at + PNANOVDB_ROOT_OFF_TABLE_SIZE,
                       "the root's table of %llu entries exceeds the grid", (unsigned long long)tiles);
    tree->upper_count = pnanovdb_tree_get_node_count_upper(tree->buf, tree->tree);
    tree->lower_count = pnanovdb_tree_get_node_count_lower(tree->buf, tree->tree);
    tree->leaf_count = pnanovdb_tree_get_node_count_leaf(tree->buf, tree->tree);
    uint64_t size = tree->buf.size;
    if (tree->upper_count > size / tree->upper.bytes || tree->lower_count > size / tree->lower.bytes ||
        tree->leaf_count > size / leaf_bytes(tree))
        return damaged(tree, tree_at + PNANOVDB_TREE_OFF_NODE_COUNT_LEAF,
                       "%lu leaves, %lu lower and %lu upper nodes do not fit into %llu bytes",
                       (unsigned long)tree->leaf_count, (unsigned long)tree->lower_count,
                       (unsigned long)tree->upper_count, (unsigned long long)size);
    tree->volume.background = load_value(tree, root_at + PNANOVDB_GRID_TYPE_GET(tree->type, root_off_background));
    return check_checksums(tree, tree_at + PNANOVDB_TREE_SIZE + root_bytes + table_bytes);
}

/* ---- walk: every node is entered once, every leaf's place is noted ---- */

/* The child whose offset from its parent stands at `entry`; nodes may lie in any order. */
static NphStatus find_child(const Tree *tree, uint64_t parent, uint64_t entry, uint64_t bytes, uint64_t *child) {
    uint64_t offset = nph_load_u64(tree->buf.bytes + entry); /* signed: modulo 2^64 it is the same sum */
    if (offset == 0 || !inside(tree, parent + offset, bytes))
        return damaged(tree, entry, "a child node lies outside the grid");
    *child = parent + offset;
    return NPH_OK;
}

/* Inactive tiles that hold the background say nothing and are left out. */
static NphStatus add_tile(Tree *tree, const int32_t origin[3], int32_t size, float value, int active) {
    NphVolume *volume = &tree->volume;
    if (!active && value == volume->background) return NPH_OK;
    if (volume->tile_count == tree->tile_capacity) {
        int64_t capacity = tree->tile_capacity ? 2 * tree->tile_capacity : 64;
        NPH_TRY(nph_realloc(tree->context, (size_t)capacity, sizeof *volume->tiles, "volume tiles",
                            (void **)&volume->tiles));
        tree->tile_capacity = capacity;
    }
    NphTile tile = {.origin = {origin[0], origin[1], origin[2]}, .size = size, .value = value, .active = active};
    volume->tiles[volume->tile_count++] = tile;
    return NPH_OK;
}

static NphStatus visit_leaf(Tree *tree, uint64_t at, const int32_t origin[3]) {
    if (tree->leaf_seen == tree->leaf_count)
        return damaged(tree, at, "the tree holds more leaves than the %lu announced", (unsigned long)tree->leaf_count);
    LeafPlace *place = &tree->places[tree->leaf_seen++];
    place->at = at;
    for (int axis = 0; axis < 3; axis++) {
        int32_t own = (int32_t)nph_load_u32(tree->buf.bytes + at + 4 * axis);
        place->origin[axis] = origin[axis];
        if ((own & ~(NPH_LEAF_SIZE - 1)) != origin[axis])
            return damaged(tree, at, "the leaf at (%d, %d, %d) says that it is elsewhere", origin[0], origin[1],
                           origin[2]);
    }
    if (tree->type == PNANOVDB_GRID_TYPE_FPN) {
        uint32_t log_bits = tree->buf.bytes[at + LEAF_FLAGS] >> 5;
        if (log_bits > MAX_LOG_BITS || !inside(tree, at, QUANTISED_HEAD + ((uint64_t)NPH_LEAF_VOXELS / 8 << log_bits)))
            return damaged(tree, at + LEAF_FLAGS, "the leaf's codes exceed the grid");
    }
    return NPH_OK;
}

static int mask_bit(const Tree *tree, uint64_t mask, uint32_t bit) {
    return tree->buf.bytes[mask + (bit >> 3)] >> (bit & 7u) & 1;
}

static NphStatus visit_inner(Tree *tree, const Level *level, uint64_t at, const int32_t origin[3]) {
    uint32_t side = level->log_children, count = 1u << 3 * side, axis_mask = (1u << side) - 1u;
    uint64_t stride = PNANOVDB_GRID_TYPE_GET(tree->type, table_stride);
    int is_upper = level->size == UPPER_SIZE;
    uint32_t *seen = is_upper ? &tree->upper_seen : &tree->lower_seen;
    if (++*seen > (is_upper ? tree->upper_count : tree->lower_count))
        return damaged(tree, at, "the tree holds more %s nodes than announced", is_upper ? "upper" : "lower");
    for (uint32_t n = 0; n < count; n++) {
        uint64_t entry = at + level->table + stride * n, child = 0;
        uint32_t steps[3] = {n >> 2 * side, n >> side & axis_mask, n & axis_mask};
        int32_t corner[3];
        for (int axis = 0; axis < 3; axis++) corner[axis] = origin[axis] + (int32_t)steps[axis] * level->child_size;
        if (!mask_bit(tree, at + level->child_mask, n)) {
            int active = mask_bit(tree, at + level->value_mask, n);
            NPH_TRY(add_tile(tree, corner, level->child_size, load_value(tree, entry), active));
        } else if (is_upper) {
            NPH_TRY(find_child(tree, at, entry, tree->lower.bytes, &child));
            NPH_TRY(visit_inner(tree, &tree->lower, child, corner));
        } else {
            NPH_TRY(find_child(tree, at, entry, PNANOVDB_GRID_TYPE_GET(tree->type, leaf_size), &child));
            NPH_TRY(visit_leaf(tree, child, corner));
        }
    }
    return NPH_OK;
}

/* A root key holds the upper 20 bits of each coordinate: x in bits 42 to 61, y from 21, z from 0. */
static int origin_of_key(uint64_t key, int32_t origin[3]) {
    static const uint32_t shifts[3] = {42, 21, 0};
    uint64_t used = 0;
    for (int axis = 0; axis < 3; axis++) {
        uint64_t field = key >> shifts[axis] & 0xfffffu;
        used |= field << shifts[axis];
        origin[axis] = (int32_t)((uint32_t)field << 12);
    }
    return used == key;
}

static NphStatus visit_root(Tree *tree) {
    uint64_t root_at = tree->root.address.byte_offset;
    uint32_t tiles = pnanovdb_root_get_tile_count(tree->buf, tree->root);
    for (uint32_t n = 0; n < tiles; n++) {
        pnanovdb_root_tile_handle_t tile = pnanovdb_root_get_tile(tree->type, tree->root, n);
        uint64_t at = tile.address.byte_offset, child = 0;
        int32_t origin[3];
        if (!origin_of_key(pnanovdb_root_tile_get_key(tree->buf, tile), origin))
            return damaged(tree, at, "the root's entry %lu has no valid key", (unsigned long)n);
        if (pnanovdb_root_tile_get_child(tree->buf, tile) == 0) {
            float value = load_value(tree, at + PNANOVDB_GRID_TYPE_GET(tree->type, root_tile_off_value));
            NPH_TRY(add_tile(tree, origin, UPPER_SIZE, value, pnanovdb_root_tile_get_state(tree->buf, tile) != 0));
        } else {
            NPH_TRY(find_child(tree, root_at, at + PNANOVDB_ROOT_TILE_OFF_CHILD, tree->upper.bytes, &child));
            NPH_TRY(visit_inner(tree, &tree->upper, child, origin));
        }
    }
    if (tree->upper_seen != tree->upper_count || tree->lower_seen != tree->lower_count ||
        tree->leaf_seen != tree->leaf_count)
        return damaged(tree, tree->tree.address.byte_offset + PNANOVDB_TREE_OFF_NODE_COUNT_LEAF,
                       "the tree announces %lu leaves, %lu lower and %lu upper nodes, but holds %lu, %lu and %lu",
                       (unsigned long)tree->leaf_count, (unsigned long)tree->lower_count,
                       (unsigned long)tree->upper_count, (unsigned long)tree->leaf_seen,
                       (unsigned long)tree->lower_seen, (unsigned long)tree->upper_seen);
    return NPH_OK;
}

/* Two root entries with one key would make two volumes in one place. */
static int compare_keys(const void *a, const void *b) {
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

static NphStatus check_root_keys(const Tree *tree) {
    uint32_t tiles = pnanovdb_root_get_tile_count(tree->buf, tree->root);
    uint64_t *keys = NULL;
    NPH_TRY(NPH_NEW(tree->context, tiles, "root keys", &keys));
    for (uint32_t n = 0; n < tiles; n++)
        keys[n] = pnanovdb_root_tile_get_key(tree->buf, pnanovdb_root_get_tile(tree->type, tree->root, n));
    qsort(keys, tiles, sizeof *keys, compare_keys);
    int twice = 0;
    for (uint32_t n = 1; n < tiles; n++) twice |= keys[n] == keys[n - 1];
    nph_free(tree->context, keys);
    return twice ? damaged(tree, tree->root.address.byte_offset, "two entries of the root have one key") : NPH_OK;
}

/* ---- leaves, in order ---- */

/* Files seldom carry a checksum of their nodes, but most state range and average of a leaf's active values: what
 * leaves the range, or shifts the average by more than any way of adding rounds, was altered. NaN passes: it is for
 * the caller to judge. */
static NphStatus check_leaf(const Tree *tree, const LeafPlace *place, const NphLeaf *leaf) {
    const pnanovdb_grid_type_constants_t *facts = &pnanovdb_grid_type_constants[tree->type];
    float lo = load_value(tree, place->at + facts->leaf_off_min);
    float hi = load_value(tree, place->at + facts->leaf_off_max);
    double sum = 0;
    int count = 0, outside = nph_leaf_examine(leaf, lo, hi, &sum, &count);
    char text[NPH_DOUBLE_TEXT];
    if (outside >= 0)
        return damaged(tree, place->at, "voxel (%d, %d, %d) holds %s, outside the range its leaf states",
                       leaf->origin[0] + (outside >> 6), leaf->origin[1] + (outside >> 3 & 7),
                       leaf->origin[2] + (outside & 7), nph_format_double((double)leaf->values[outside], text));
    if (count == 0 || tree->type == PNANOVDB_GRID_TYPE_HALF ||
        !has_statistics(tree, PNANOVDB_GRID_FLAGS_HAS_AVERAGE))
        return NPH_OK;
    double stated = (double)load_value(tree, place->at + facts->leaf_off_ave), extent = fabs((double)lo);
    if (fabs((double)hi) > extent) extent = fabs((double)hi);
    if (fabs(sum / count - stated) > 4e-6 * extent)
        return damaged(tree, place->at, "the values of the leaf at (%d, %d, %d) do not have the average it states",
                       leaf->origin[0], leaf->origin[1], leaf->origin[2]);
    return NPH_OK;
}

static NphStatus decode_leaf(const Tree *tree, const LeafPlace *place, NphLeaf *leaf) {
    const unsigned char *bytes = tree->buf.bytes + place->at;
    const unsigned char *table = bytes + PNANOVDB_GRID_TYPE_GET(tree->type, leaf_off_table);
    memcpy(leaf->origin, place->origin, sizeof leaf->origin);
    for (int x = 0; x < 8; x++) leaf->active[x] = nph_load_u64(bytes + PNANOVDB_LEAF_OFF_VALUE_MASK + 8 * x);
    if (tree->type == PNANOVDB_GRID_TYPE_FLOAT) {
        nph_leaf_floats(table, leaf->values);
    } else if (tree->type == PNANOVDB_GRID_TYPE_HALF) {
        nph_leaf_halves(table, leaf->values);
    } else {
        static const uint32_t log_bits[] = {2, 3, 4}; /* Fp4, Fp8, Fp16 */
        NphQuantised code = {nph_load_f32(table - PNANOVDB_LEAF_TABLE_NEG_OFF_MINIMUM),
                             nph_load_f32(table - PNANOVDB_LEAF_TABLE_NEG_OFF_QUANTUM),
                             tree->type == PNANOVDB_GRID_TYPE_FPN ? (uint32_t)bytes[LEAF_FLAGS] >> 5
                                                                  : log_bits[tree->type - PNANOVDB_GRID_TYPE_FP4]};
        nph_leaf_codes(table, &code, leaf->values);
    }
    return has_statistics(tree, PNANOVDB_GRID_FLAGS_HAS_MIN_MAX) ? check_leaf(tree, place, leaf) : NPH_OK;
}

/* For LeafPlace and NphTile: both start with their origin. */
static int compare_origins(const void *a, const void *b) {
    const int32_t *x = a, *y = b;
    for (int axis = 0; axis < 3; axis++)
        if (x[axis] != y[axis]) return x[axis] < y[axis] ? -1 : 1;
    return 0;
}

static NphStatus decode_leaves(Tree *tree) {
    NphVolume *volume = &tree->volume;
    qsort(tree->places, tree->leaf_seen, sizeof *tree->places, compare_origins);
    if (volume->tile_count) qsort(volume->tiles, (size_t)volume->tile_count, sizeof *volume->tiles, compare_origins);
    NPH_TRY(NPH_NEW(tree->context, tree->leaf_seen, "volume leaves", &volume->leaves));
    volume->leaf_count = tree->leaf_seen;
    for (uint32_t i = 0; i < tree->leaf_seen; i++)
        NPH_TRY(decode_leaf(tree, &tree->places[i], &volume->leaves[i]));
    return NPH_OK;
}

/* ---- what was decoded against what the file says of itself ---- */

static NphStatus check_against_file(const Tree *tree) {
    const NphVolume *volume = &tree->volume;
    uint64_t announced = pnanovdb_tree_get_voxel_count(tree->buf, tree->tree);
    if (announced != volume->active_voxels)
        return damaged(tree, tree->tree.address.byte_offset + PNANOVDB_TREE_OFF_VOXEL_COUNT,
                       "%llu active voxels are announced, but the masks hold %llu", (unsigned long long)announced,
                       (unsigned long long)volume->active_voxels);
    const pnanovdb_grid_type_constants_t *facts = &pnanovdb_grid_type_constants[tree->type];
    uint64_t at = tree->root.address.byte_offset;
    float least = load_value(tree, at + facts->root_off_min), most = load_value(tree, at + facts->root_off_max);
    for (int64_t i = 0; i < volume->tile_count && has_statistics(tree, PNANOVDB_GRID_FLAGS_HAS_MIN_MAX); i++)
        if (volume->tiles[i].active && (volume->tiles[i].value < least || volume->tiles[i].value > most))
            return damaged(tree, at, "the tile at (%d, %d, %d) holds a value outside the range the root states",
                           volume->tiles[i].origin[0], volume->tiles[i].origin[1], volume->tiles[i].origin[2]);
    if (!volume->active_voxels || !(pnanovdb_grid_get_flags(tree->buf, tree->grid) & PNANOVDB_GRID_FLAGS_HAS_BBOX))
        return NPH_OK;
    for (int axis = 0; axis < 3; axis++) {
        int32_t lo = (int32_t)nph_load_u32(tree->buf.bytes + at + PNANOVDB_ROOT_OFF_BBOX_MIN + 4 * axis);
        int32_t hi = (int32_t)nph_load_u32(tree->buf.bytes + at + PNANOVDB_ROOT_OFF_BBOX_MAX + 4 * axis);
        if (lo != volume->bbox_min[axis] || hi != volume->bbox_max[axis])
            return damaged(tree, at, "the active box is announced as %d to %d along %c, but the masks span %d to %d",
                           lo, hi, "xyz"[axis], volume->bbox_min[axis], volume->bbox_max[axis]);
    }
    return NPH_OK;
}

static NphStatus decode(Tree *tree, uint32_t announced_type) {
    NPH_TRY(read_header(tree, announced_type));
    const pnanovdb_grid_type_constants_t *facts = &pnanovdb_grid_type_constants[tree->type];
    tree->upper = (Level){UPPER_SIZE, LOWER_SIZE, 5, PNANOVDB_UPPER_OFF_VALUE_MASK, PNANOVDB_UPPER_OFF_CHILD_MASK,
                          facts->upper_off_table, facts->upper_size};
    tree->lower = (Level){LOWER_SIZE, NPH_LEAF_SIZE, 4, PNANOVDB_LOWER_OFF_VALUE_MASK, PNANOVDB_LOWER_OFF_CHILD_MASK,
                          facts->lower_off_table, facts->lower_size};
    NPH_TRY(read_root(tree));
    NPH_TRY(check_root_keys(tree));
    NPH_TRY(NPH_NEW(tree->context, tree->leaf_count, "leaf places", &tree->places));
    NPH_TRY(visit_root(tree));
    NPH_TRY(decode_leaves(tree));
    nph_volume_measure(&tree->volume);
    return check_against_file(tree);
}

NphStatus nph_nvdb_decode(NphContext *context, const NphNvdbBuffer *buffer, uint32_t type, NphVolume *volume) {
    Tree tree = {.context = context, .source = buffer, .buf = {buffer->bytes, buffer->size}};
    tree.tree.address.byte_offset = PNANOVDB_GRID_SIZE;
    NphStatus status = decode(&tree, type);
    nph_free(context, tree.places);
    if (status != NPH_OK) {
        nph_volume_free(context, &tree.volume);
        return status;
    }
    snprintf(tree.volume.name, sizeof tree.volume.name, "%s", buffer->name);
    *volume = tree.volume;
    return NPH_OK;
}
