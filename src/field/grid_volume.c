/* SPDX-License-Identifier: Apache-2.0
 *
 * From a sparse volume to bricks. The lattice begins one sample below the box of the active voxels, so leaves and bricks
 * are not aligned: along each axis a leaf lies in two bricks (one sample of it in both, as the apron of the lower one).
 * First each leaf says for its eight pieces whether they are zeros, one constant, or neither; from these and the tiles
 * follows which bricks need memory; then the leaves copy their rows into them. No voxel is ever searched for. */
#include "core/memory.h"
#include "core/message.h"
#include "core/pool.h"
#include "field/grid_build.h"

enum { EDGE = NPH_BRICK_EDGE, LEAVES_PER_BLOCK = 64 };

typedef struct LeafMarks {
    int32_t code[8]; /* of the pieces: bit 0 upper in x, bit 1 in y, bit 2 in z */
    int16_t bad;     /* first bad active voxel of the leaf + 1, else 0 */
    int16_t stray;   /* inactive voxels that are not 0 */
} LeafMarks;

typedef struct VolumeBuild {
    NphContext *context;
    const NphVolume *volume;
    const char *what;
    NphGrid *grid;
    int64_t base[3];    /* the file's lattice point of sample 0 */
    int64_t samples[3]; /* active box */
    LeafMarks *marks;   /* one a leaf */
    int16_t *covered;   /* one a brick: samples that have been given a constant */
    int32_t shared_end;
} VolumeBuild;

/* ---- the box of the active voxels ---- */

static void widen(int64_t lo[3], int64_t hi[3], const int64_t begin[3], const int64_t end[3]) {
    for (int axis = 0; axis < 3; axis++) {
        if (begin[axis] < lo[axis]) lo[axis] = begin[axis];
        if (end[axis] > hi[axis]) hi[axis] = end[axis];
    }
}

/* Ranges of x, y, z with an active voxel in them; 0 when there is none. */
static int leaf_range(const NphLeaf *leaf, int64_t begin[3], int64_t end[3]) {
    uint64_t plane = 0;
    unsigned used[3] = {0, 0, 0};
    for (int x = 0; x < NPH_LEAF_SIZE; x++) {
        plane |= leaf->active[x];
        used[0] |= (unsigned)(leaf->active[x] != 0) << x;
    }
    for (int y = 0; y < NPH_LEAF_SIZE; y++) {
        unsigned row = (unsigned)(plane >> (8 * y)) & 255u;
        used[1] |= (unsigned)(row != 0) << y;
        used[2] |= row;
    }
    if (plane == 0) return 0;
    for (int axis = 0; axis < 3; axis++) {
        int first = 0, last = NPH_LEAF_SIZE - 1;
        while (!(used[axis] >> first & 1u)) first++;
        while (!(used[axis] >> last & 1u)) last--;
        begin[axis] = (int64_t)leaf->origin[axis] + first;
        end[axis] = (int64_t)leaf->origin[axis] + last;
    }
    return 1;
}

static void find_box(VolumeBuild *build) {
    const NphVolume *volume = build->volume;
    int64_t lo[3] = {INT64_MAX, INT64_MAX, INT64_MAX}, hi[3] = {INT64_MIN, INT64_MIN, INT64_MIN}, begin[3], end[3];
    for (int64_t i = 0; i < volume->leaf_count; i++)
        if (leaf_range(&volume->leaves[i], begin, end)) widen(lo, hi, begin, end);
    for (int64_t i = 0; i < volume->tile_count; i++) {
        const NphTile *tile = &volume->tiles[i];
        if (!tile->active) continue;
        for (int axis = 0; axis < 3; axis++) {
            begin[axis] = tile->origin[axis];
            end[axis] = begin[axis] + tile->size - 1;
        }
        widen(lo, hi, begin, end);
    }
    for (int axis = 0; axis < 3; axis++) {
        if (lo[axis] > hi[axis]) lo[axis] = hi[axis] = 0;
        build->base[axis] = lo[axis] - 1;
        build->samples[axis] = hi[axis] - lo[axis] + 1;
    }
}

/* What the reader guarantees and the parallel copying rests on: leaves are aligned and no two are the same. */
static NphStatus check_order(const VolumeBuild *build) {
    const NphVolume *volume = build->volume;
    for (int64_t i = 0; i < volume->leaf_count; i++) {
        const int32_t *now = volume->leaves[i].origin, *before = i > 0 ? volume->leaves[i - 1].origin : NULL;
        int rises = !before;
        for (int axis = 0; axis < 3 && before && !rises; axis++) {
            if (now[axis] < before[axis]) break;
            rises = now[axis] > before[axis];
        }
        if (!rises || ((now[0] | now[1] | now[2]) & (NPH_LEAF_SIZE - 1)))
            return nph_error(build->context, NPH_BAD_INPUT,
                             "%s: leaf %lld at (%d, %d, %d) is not on a multiple of 8 or not in order", build->what,
                             (long long)i, (int)now[0], (int)now[1], (int)now[2]);
    }
    for (int64_t i = 0; i < volume->tile_count; i++)
        if (volume->tiles[i].size < 1)
            return nph_error(build->context, NPH_BAD_INPUT, "%s: tile %lld has the size %d", build->what, (long long)i,
                             (int)volume->tiles[i].size);
    return NPH_OK;
}

/* ---- leaves ---- */

/* The two bricks of a leaf along an axis: `lower` holds voxels 0 .. split from its sample `offset` on, lower + 1 holds
 * voxels split .. 7 from its sample 0 on. */
typedef struct Span {
    int32_t lower;
    int split, offset;
} Span;

static Span leaf_span(int64_t first_sample) {
    int64_t lower = first_sample > 0 ? (first_sample - 1) / NPH_BRICK : -((NPH_BRICK - first_sample) / NPH_BRICK);
    Span span = {(int32_t)lower, (int)(NPH_BRICK * (lower + 1) - first_sample),
                 (int)(first_sample - NPH_BRICK * lower)};
    return span;
}

static void leaf_spans(const VolumeBuild *build, const NphLeaf *leaf, Span spans[3]) {
    for (int axis = 0; axis < 3; axis++) spans[axis] = leaf_span(leaf->origin[axis] - build->base[axis]);
}

/* Number of the table entry of a leaf's piece, or -1 outside the table (where the leaf has inactive voxels only). Also
 * the piece's voxels begin .. end - 1 and where in the brick the first one goes. */
static int64_t piece_brick(const NphGrid *grid, const Span spans[3], int piece, int begin[3], int end[3], int at[3]) {
    int32_t brick[3];
    int inside = 1;
    for (int axis = 0; axis < 3; axis++) {
        int upper = piece >> axis & 1;
        brick[axis] = spans[axis].lower + upper;
        begin[axis] = upper ? spans[axis].split : 0;
        end[axis] = upper ? NPH_LEAF_SIZE : spans[axis].split + 1;
        at[axis] = upper ? 0 : spans[axis].offset;
        inside &= brick[axis] >= 0 && brick[axis] < grid->bricks[axis];
    }
    if (!inside) return -1;
    return ((int64_t)brick[2] * grid->bricks[1] + brick[1]) * grid->bricks[0] + brick[0];
}

/* Transposed to z * 64 + y * 8 + x, inactive voxels 0. */
static void unpack_leaf(const NphLeaf *leaf, float voxels[NPH_LEAF_VOXELS]) {
    for (int x = 0; x < 8; x++) {
        const float *plane = leaf->values + 64 * x;
        for (int y = 0; y < 8; y++) {
            unsigned active = (unsigned)(leaf->active[x] >> (8 * y)) & 255u;
            for (int z = 0; z < 8; z++)
                voxels[z * 64 + y * 8 + x] = active >> z & 1u && plane[y * 8 + z] > 0 ? plane[y * 8 + z] : 0;
        }
    }
}

static void validate_leaf(const NphLeaf *leaf, LeafMarks *marks) {
    for (int i = 0; i < NPH_LEAF_VOXELS; i++) {
        int active = leaf->active[i >> 6] >> (i & 63) & 1u;
        float value = leaf->values[i];
        if (active && !nph_density_ok((double)value) && marks->bad == 0) marks->bad = (int16_t)(i + 1);
        marks->stray = (int16_t)(marks->stray + (!active && value != 0));
    }
}

static int32_t piece_code(const float voxels[NPH_LEAF_VOXELS], const int begin[3], const int end[3]) {
    float first = voxels[begin[2] * 64 + begin[1] * 8 + begin[0]];
    for (int z = begin[2]; z < end[2]; z++)
        for (int y = begin[1]; y < end[1]; y++)
            for (int x = begin[0]; x < end[0]; x++)
                if (voxels[z * 64 + y * 8 + x] != first) return NPH_BRICK_OWN;
    return nph_brick_code(first);
}

static NphStatus code_leaves(void *data, int64_t block, int worker) {
    (void)worker;
    VolumeBuild *build = data;
    int64_t last = (block + 1) * LEAVES_PER_BLOCK;
    if (last > build->volume->leaf_count) last = build->volume->leaf_count;
    for (int64_t i = block * LEAVES_PER_BLOCK; i < last; i++) {
        const NphLeaf *leaf = &build->volume->leaves[i];
        LeafMarks *marks = &build->marks[i];
        float voxels[NPH_LEAF_VOXELS];
        Span spans[3];
        int begin[3], end[3], at[3];
        validate_leaf(leaf, marks);
        unpack_leaf(leaf, voxels);
        leaf_spans(build, leaf, spans);
        for (int piece = 0; piece < 8; piece++)
            if (piece_brick(build->grid, spans, piece, begin, end, at) >= 0)
                marks->code[piece] = piece_code(voxels, begin, end);
    }
    return NPH_OK;
}

static NphStatus fill_leaves(void *data, int64_t block, int worker) {
    (void)worker;
    VolumeBuild *build = data;
    int64_t last = (block + 1) * LEAVES_PER_BLOCK;
    if (last > build->volume->leaf_count) last = build->volume->leaf_count;
    for (int64_t i = block * LEAVES_PER_BLOCK; i < last; i++) {
        const NphLeaf *leaf = &build->volume->leaves[i];
        float voxels[NPH_LEAF_VOXELS];
        Span spans[3];
        int begin[3], end[3], at[3];
        unpack_leaf(leaf, voxels);
        leaf_spans(build, leaf, spans);
        for (int piece = 0; piece < 8; piece++) {
            int64_t entry = piece_brick(build->grid, spans, piece, begin, end, at);
            if (entry < 0 || build->marks[i].code[piece] == 0) continue;
            int32_t number = build->grid->brick_index[entry];
            if (number < build->shared_end) continue;
            float *values = build->grid->values + (int64_t)number * NPH_BRICK_STRIDE;
            for (int z = begin[2]; z < end[2]; z++)
                for (int y = begin[1]; y < end[1]; y++) {
                    int row = ((z - begin[2] + at[2]) * EDGE + y - begin[1] + at[1]) * EDGE + at[0];
                    for (int x = begin[0]; x < end[0]; x++) values[row + x - begin[0]] = voxels[z * 64 + y * 8 + x];
                }
        }
    }
    return NPH_OK;
}

/* ---- tiles ---- */

/* Bricks that hold a sample of the tile, along one axis: first .. last. */
static void tile_bricks(const VolumeBuild *build, const NphTile *tile, int64_t first[3], int64_t last[3],
                        int64_t sample[3]) {
    for (int axis = 0; axis < 3; axis++) {
        sample[axis] = tile->origin[axis] - build->base[axis]; /* >= 1: the tile is in the active box */
        first[axis] = (sample[axis] - 1) / NPH_BRICK;
        last[axis] = (sample[axis] + tile->size - 1) / NPH_BRICK;
        if (last[axis] >= build->grid->bricks[axis]) last[axis] = build->grid->bricks[axis] - 1;
    }
}

/* The samples begin .. end - 1 of a brick that lie in the tile, along one axis. */
static int tile_overlap(int64_t sample, int32_t size, int64_t brick, int *begin, int *end) {
    int64_t from = sample - brick * NPH_BRICK, to = from + size;
    *begin = from > 0 ? (int)from : 0;
    *end = to < EDGE ? (int)to : EDGE;
    return *end - *begin;
}

typedef void (*TileFn)(VolumeBuild *build, const NphTile *tile, int64_t entry, const int begin[3], const int end[3]);

static void for_tile_bricks(VolumeBuild *build, const NphTile *tile, TileFn function) {
    int64_t first[3], last[3], sample[3], at[3];
    int begin[3], end[3];
    tile_bricks(build, tile, first, last, sample);
    for (at[2] = first[2]; at[2] <= last[2]; at[2]++) {
        tile_overlap(sample[2], tile->size, at[2], &begin[2], &end[2]);
        for (at[1] = first[1]; at[1] <= last[1]; at[1]++) {
            tile_overlap(sample[1], tile->size, at[1], &begin[1], &end[1]);
            for (at[0] = first[0]; at[0] <= last[0]; at[0]++) {
                tile_overlap(sample[0], tile->size, at[0], &begin[0], &end[0]);
                function(build, tile, (at[2] * build->grid->bricks[1] + at[1]) * build->grid->bricks[0] + at[0], begin,
                         end);
            }
        }
    }
}

/* Adds `count` samples of a code to a brick's. */
static void mark_brick(VolumeBuild *build, int64_t entry, int32_t code, int count) {
    int32_t *now = &build->grid->brick_index[entry];
    if (code == 0) return;
    *now = *now == 0 || *now == code ? code : NPH_BRICK_OWN;
    if (build->covered[entry] <= NPH_BRICK_SAMPLES) build->covered[entry] = (int16_t)(build->covered[entry] + count);
}

static void mark_tile(VolumeBuild *build, const NphTile *tile, int64_t entry, const int begin[3], const int end[3]) {
    int count = (end[0] - begin[0]) * (end[1] - begin[1]) * (end[2] - begin[2]);
    mark_brick(build, entry, nph_brick_code(tile->value), count);
}

static void fill_tile(VolumeBuild *build, const NphTile *tile, int64_t entry, const int begin[3], const int end[3]) {
    int32_t number = build->grid->brick_index[entry];
    if (number < build->shared_end) return;
    float *values = build->grid->values + (int64_t)number * NPH_BRICK_STRIDE;
    for (int z = begin[2]; z < end[2]; z++)
        for (int y = begin[1]; y < end[1]; y++)
            for (int x = begin[0]; x < end[0]; x++) values[(z * EDGE + y) * EDGE + x] = tile->value;
}

static void for_tiles(VolumeBuild *build, TileFn function) {
    for (int64_t i = 0; i < build->volume->tile_count; i++) {
        const NphTile *tile = &build->volume->tiles[i];
        if (tile->active && tile->value > 0) for_tile_bricks(build, tile, function);
    }
}

/* ---- the build ---- */

static NphStatus check_values(const VolumeBuild *build) {
    const NphVolume *volume = build->volume;
    uint64_t stray = 0;
    for (int64_t i = 0; i < volume->leaf_count; i++) {
        const NphLeaf *leaf = &volume->leaves[i];
        int bad = build->marks[i].bad - 1;
        stray += (uint64_t)build->marks[i].stray;
        if (bad >= 0)
            return nph_error(build->context, NPH_BAD_INPUT,
                             "%s: voxel (%d, %d, %d) is %g; densities are finite, not negative and at most %g",
                             build->what, (int)leaf->origin[0] + (bad >> 6), (int)leaf->origin[1] + (bad >> 3 & 7),
                             (int)leaf->origin[2] + (bad & 7), (double)leaf->values[bad], NPH_DENSITY_MAX);
    }
    for (int64_t i = 0; i < volume->tile_count; i++) {
        const NphTile *tile = &volume->tiles[i];
        if (!tile->active)
            stray += (uint64_t)(tile->value != 0);
        else if (!nph_density_ok((double)tile->value))
            return nph_error(build->context, NPH_BAD_INPUT,
                             "%s: the tile of %d^3 voxels from (%d, %d, %d) on is %g; "
                             "densities are finite, not negative and at most %g",
                             build->what, (int)tile->size, (int)tile->origin[0], (int)tile->origin[1],
                             (int)tile->origin[2], (double)tile->value, NPH_DENSITY_MAX);
    }
    if (stray > 0)
        nph_warn(build->context, "%s: %llu inactive voxels or tiles are not 0; they are taken as 0", build->what,
                 (unsigned long long)stray);
    return NPH_OK;
}

static void mark_bricks(VolumeBuild *build) {
    NphGrid *grid = build->grid;
    for (int64_t i = 0; i < build->volume->leaf_count; i++) {
        Span spans[3];
        int begin[3], end[3], at[3];
        leaf_spans(build, &build->volume->leaves[i], spans);
        for (int piece = 0; piece < 8; piece++) {
            int64_t entry = piece_brick(grid, spans, piece, begin, end, at);
            int count = (end[0] - begin[0]) * (end[1] - begin[1]) * (end[2] - begin[2]);
            if (entry >= 0) mark_brick(build, entry, build->marks[i].code[piece], count);
        }
    }
    for_tiles(build, mark_tile);
    int64_t bricks = (int64_t)grid->bricks[0] * grid->bricks[1] * grid->bricks[2];
    for (int64_t i = 0; i < bricks; i++)
        if (grid->brick_index[i] != 0 && build->covered[i] != NPH_BRICK_SAMPLES) grid->brick_index[i] = NPH_BRICK_OWN;
}

static NphStatus build_bricks(VolumeBuild *build, NphCentring centring) {
    NphContext *context = build->context;
    NphGrid *grid = build->grid;
    const NphVolume *volume = build->volume;
    int64_t blocks = (volume->leaf_count + LEAVES_PER_BLOCK - 1) / LEAVES_PER_BLOCK;
    NPH_TRY(check_order(build));
    find_box(build);
    NPH_TRY(nph_grid_layout(context, build->samples, centring, build->what, grid));
    NPH_TRY(NPH_NEW(context, volume->leaf_count, build->what, &build->marks));
    NPH_TRY(
        NPH_NEW(context, (int64_t)grid->bricks[0] * grid->bricks[1] * grid->bricks[2], build->what, &build->covered));
    NPH_TRY(nph_pool_run(context, blocks, code_leaves, build, NULL));
    NPH_TRY(check_values(build));
    mark_bricks(build);
    NPH_TRY(nph_grid_number(context, build->what, grid, &build->shared_end));
    NPH_TRY(nph_pool_run(context, blocks, fill_leaves, build, NULL));
    for_tiles(build, fill_tile);
    const double *m = volume->world_from_index;
    for (int row = 0; row < 3; row++) {
        double *out = grid->world_from_lattice + 4 * row;
        memcpy(out, m + 4 * row, 3 * sizeof *out);
        out[3] = m[4 * row + 3] + (m[4 * row] * (double)build->base[0] + m[4 * row + 1] * (double)build->base[1] +
                                   m[4 * row + 2] * (double)build->base[2]);
    }
    return nph_grid_finish(context, build->what, grid);
}

NphStatus nph_grid_from_volume(NphContext *context, const NphVolume *volume, NphCentring centring, NphLookup lookup,
                               const char *what, NphGrid *grid) {
    if (volume->background != 0)
        return nph_error(context, NPH_BAD_INPUT,
                         "%s: its background is %g; a density has the background 0 (a level set is not a density)",
                         what, (double)volume->background);
    NphGrid made = {.lookup = lookup};
    VolumeBuild build = {.context = context, .volume = volume, .what = what, .grid = &made};
    NphStatus status = build_bricks(&build, centring);
    nph_free(context, build.marks);
    nph_free(context, build.covered);
    if (status != NPH_OK) {
        nph_grid_free(context, &made);
        return status;
    }
    *grid = made;
    return NPH_OK;
}
