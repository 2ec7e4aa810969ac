/* SPDX-License-Identifier: Apache-2.0
 *
 * The build [Wald07]: triangles are binned by the middle of their boxes along the three axes; of the splits between
 * bins the one with the least
 *     area(left) count(left) + area(right) count(right)
 * is taken, or a leaf where that costs less. From a certain depth on, and where all middles coincide, a range is
 * halved as it stands, which bounds the depth: SAH_DEPTH + log2(2^31) < NPH_BVH_DEPTH. All comparisons have a fixed
 * order. */
#include "geometry/bvh.h"

#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/text.h"

enum { BINS = 16, LEAF_MOST = 8, SAH_DEPTH = 31 };
static const double reach_m = 1e12;
static const double cost_of_box = 1.0; /* of testing a node's two boxes, in tests of a triangle */

typedef struct Box {
    float lo[3], hi[3];
} Box;

typedef struct Item {
    Box box;
    int32_t triangle;
} Item;

typedef struct Range {
    int32_t begin, end, depth;
    int32_t parent; /* whose second child this will be; -1 */
} Range;

typedef struct Split {
    int axis, bin; /* items of bins <= bin go left; axis -1: none */
    double cost;
    double from[3], scale[3]; /* bin = (middle - from) * scale */
} Split;

static float step(float x, int up) {
    uint32_t bits;
    if (x == 0.0f) bits = up ? 1u : 0x80000001u;
    else {
        memcpy(&bits, &x, sizeof bits);
        bits += (x > 0.0f) == up ? 1u : UINT32_MAX;
    }
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* The nearest floats that do not lie above (below) x. */
static float at_most(double x) { return (double)(float)x > x ? step((float)x, 0) : (float)x; }
static float at_least(double x) { return (double)(float)x < x ? step((float)x, 1) : (float)x; }

static void box_empty(Box *box) {
    for (int k = 0; k < 3; k++) {
        box->lo[k] = 3e38f;
        box->hi[k] = -3e38f;
    }
}

static void box_add(Box *box, const Box *other) {
    for (int k = 0; k < 3; k++) {
        if (other->lo[k] < box->lo[k]) box->lo[k] = other->lo[k];
        if (other->hi[k] > box->hi[k]) box->hi[k] = other->hi[k];
    }
}

static double box_area(const Box *box) {
    double x = (double)box->hi[0] - box->lo[0], y = (double)box->hi[1] - box->lo[1],
           z = (double)box->hi[2] - box->lo[2];
    return x < 0 ? 0 : x * y + y * z + z * x;
}

/* Twice the middle of the box; the sum of two floats of similar size is exact in double or as good as that. */
static double middle(const Item *item, int axis) { return (double)item->box.lo[axis] + item->box.hi[axis]; }

static int bin_of(const Split *split, const Item *item, int axis) {
    int bin = (int)((middle(item, axis) - split->from[axis]) * split->scale[axis]);
    return bin < BINS ? bin : BINS - 1;
}

/* Where the middles of a range lie: the bins' places. */
static void place_bins(const Item *items, const Range *range, Split *split) {
    for (int axis = 0; axis < 3; axis++) {
        double lo = middle(&items[range->begin], axis), hi = lo;
        for (int32_t i = range->begin + 1; i < range->end; i++) {
            double x = middle(&items[i], axis);
            if (x < lo) lo = x;
            if (x > hi) hi = x;
        }
        split->from[axis] = lo;
        split->scale[axis] = hi > lo ? BINS / (hi - lo) : 0.0;
    }
}

static void try_axis(const Box *boxes, const int32_t *counts, int axis, Split *best) {
    double right_cost[BINS];
    Box sum;
    int64_t count = 0;
    box_empty(&sum);
    for (int b = BINS - 1; b > 0; b--) {
        box_add(&sum, &boxes[b]);
        count += counts[b];
        right_cost[b] = box_area(&sum) * (double)count;
    }
    int64_t total = count + counts[0];
    box_empty(&sum);
    count = 0;
    for (int b = 0; b < BINS - 1; b++) {
        box_add(&sum, &boxes[b]);
        count += counts[b];
        double cost = box_area(&sum) * (double)count + right_cost[b + 1];
        if (count == 0 || count == total || (best->axis >= 0 && !(cost < best->cost))) continue;
        best->axis = axis;
        best->bin = b;
        best->cost = cost;
    }
}

static void find_split(const Item *items, const Range *range, Split *split) {
    Box boxes[3][BINS];
    int32_t counts[3][BINS] = {{0}};
    split->axis = -1;
    place_bins(items, range, split);
    for (int axis = 0; axis < 3; axis++)
        for (int b = 0; b < BINS; b++) box_empty(&boxes[axis][b]);
    for (int32_t i = range->begin; i < range->end; i++)
        for (int axis = 0; axis < 3; axis++) {
            int bin = bin_of(split, &items[i], axis);
            box_add(&boxes[axis][bin], &items[i].box);
            counts[axis][bin]++;
        }
    for (int axis = 0; axis < 3; axis++)
        if (split->scale[axis] > 0.0) try_axis(boxes[axis], counts[axis], axis, split);
}

/* Moves the left items of a split to the front; returns where the right ones begin. */
static int32_t part(Item *items, const Range *range, const Split *split) {
    int32_t i = range->begin, j = range->end;
    while (i < j) {
        if (bin_of(split, &items[i], split->axis) <= split->bin) {
            i++;
            continue;
        }
        Item other = items[--j];
        items[j] = items[i];
        items[i] = other;
    }
    return i;
}

/* Where to cut a range; its end for a leaf. */
static int32_t cut(Item *items, const Range *range, const NphBvhNode *node) {
    int32_t count = range->end - range->begin;
    Split split = {.axis = -1};
    Box box;
    if (count == 1) return range->end;
    if (range->depth < SAH_DEPTH) find_split(items, range, &split);
    if (split.axis < 0) return count <= LEAF_MOST ? range->end : range->begin + count / 2;
    memcpy(box.lo, node->lo, sizeof box.lo);
    memcpy(box.hi, node->hi, sizeof box.hi);
    double area = box_area(&box);
    if (count <= LEAF_MOST && !(cost_of_box * area + split.cost < (double)count * area)) return range->end;
    return part(items, range, &split);
}

/* Depth first: a range's left part is taken next, the right one waits on the stack. */
static void split_all(NphBvh *bvh, Item *items) {
    Range stack[NPH_BVH_DEPTH], range = {0, bvh->triangle_count, 0, -1};
    int waiting = 0;
    for (;;) {
        int32_t number = bvh->node_count++;
        NphBvhNode *node = &bvh->nodes[number];
        Box box;
        if (range.parent >= 0) bvh->nodes[range.parent].first = number;
        box_empty(&box);
        for (int32_t i = range.begin; i < range.end; i++) box_add(&box, &items[i].box);
        memcpy(node->lo, box.lo, sizeof box.lo);
        memcpy(node->hi, box.hi, sizeof box.hi);
        int32_t at = cut(items, &range, node);
        if (at < range.end) {
            stack[waiting++] = (Range){at, range.end, range.depth + 1, number};
            range = (Range){range.begin, at, range.depth + 1, -1};
            continue;
        }
        node->first = range.begin;
        node->count = range.end - range.begin;
        if (waiting == 0) return;
        range = stack[--waiting];
    }
}

static NphStatus copy_vertices(NphContext *context, const NphMesh *mesh, int which, int32_t row, NphBvh *bvh) {
    for (int64_t i = 0; i < 3 * (int64_t)mesh->vertex_count; i++) {
        double x = mesh->vertices_m[i] - bvh->origin[i % 3];
        char shown[NPH_DOUBLE_TEXT];
        if (!(x >= -reach_m && x <= reach_m))
            return nph_error(
                context, NPH_BAD_INPUT,
                "mesh %d: %c of vertex %lld lies %s m from the scene's origin; at most 1e12 m are possible", which,
                "xyz"[i % 3], (long long)(i / 3), nph_format_rounded(x, 4, shown));
        bvh->vertices[3 * (int64_t)row + i] = x;
        bvh->vertices_f32[3 * (int64_t)row + i] = (float)x;
    }
    return NPH_OK;
}

static NphStatus copy_meshes(NphContext *context, const NphMesh *meshes, NphBvh *bvh) {
    int32_t row = 0, number = 0;
    for (int m = 0; m < bvh->mesh_count; m++) {
        const NphMesh *mesh = &meshes[m];
        NPH_TRY(copy_vertices(context, mesh, m, row, bvh));
        bvh->mesh_first[m] = number;
        for (int32_t t = 0; t < mesh->triangle_count; t++, number++) {
            NphBvhTriangle *out = &bvh->triangles[number];
            out->number = number;
            for (int i = 0; i < 3; i++) out->corner[i] = mesh->triangles[3 * (int64_t)t + i] + row;
        }
        row += mesh->vertex_count;
    }
    bvh->mesh_first[bvh->mesh_count] = number;
    return NPH_OK;
}

static void bound(const NphBvh *bvh, const NphBvhTriangle *triangle, Box *box) {
    box_empty(box);
    for (int i = 0; i < 3; i++) {
        const double *p = bvh->vertices + 3 * (int64_t)triangle->corner[i];
        Box point = {{at_most(p[0]), at_most(p[1]), at_most(p[2])}, {at_least(p[0]), at_least(p[1]), at_least(p[2])}};
        box_add(box, &point);
    }
}

static NphStatus make_nodes(NphContext *context, NphBvh *bvh) {
    Item *items = NULL;
    NphBvhTriangle *sorted = NULL;
    int64_t count = bvh->triangle_count;
    if (count == 0) return NPH_OK;
    NPH_TRY(NPH_NEW(context, 2 * count - 1, "nodes over triangles", &bvh->nodes));
    NphStatus status = NPH_NEW(context, count, "boxes of triangles", &items);
    if (status == NPH_OK) status = NPH_NEW(context, count, "triangles by leaves", &sorted);
    if (status == NPH_OK) {
        for (int32_t t = 0; t < count; t++) {
            bound(bvh, &bvh->triangles[t], &items[t].box);
            items[t].triangle = t;
        }
        split_all(bvh, items);
        for (int32_t t = 0; t < count; t++) sorted[t] = bvh->triangles[items[t].triangle];
        memcpy(bvh->triangles, sorted, (size_t)count * sizeof *sorted);
    }
    nph_free(context, items);
    nph_free(context, sorted);
    if (status != NPH_OK) return status;
    return nph_realloc(context, (size_t)bvh->node_count, sizeof *bvh->nodes, "nodes over triangles",
                       (void **)&bvh->nodes);
}

static NphStatus fill(NphContext *context, const NphMesh *meshes, NphBvh *bvh) {
    NPH_TRY(NPH_NEW(context, 3 * (int64_t)bvh->vertex_count, "vertices", &bvh->vertices));
    NPH_TRY(NPH_NEW(context, 3 * (int64_t)bvh->vertex_count, "vertices", &bvh->vertices_f32));
    NPH_TRY(NPH_NEW(context, bvh->triangle_count, "triangles", &bvh->triangles));
    NPH_TRY(NPH_NEW(context, bvh->mesh_count + 1, "meshes", &bvh->mesh_first));
    NPH_TRY(copy_meshes(context, meshes, bvh));
    return make_nodes(context, bvh);
}

NphStatus nph_bvh_build(NphContext *context, const NphMesh *meshes, int mesh_count, const double origin[3],
                        NphBvh *bvh) {
    NphBvh made = {.mesh_count = mesh_count};
    int64_t vertices = 0, triangles = 0;
    memcpy(made.origin, origin, sizeof made.origin);
    for (int m = 0; m < mesh_count; m++) {
        vertices += meshes[m].vertex_count;
        triangles += meshes[m].triangle_count;
    }
    if (vertices > INT32_MAX || triangles > INT32_MAX / 2)
        return nph_error(context, NPH_BAD_INPUT,
                         "all meshes together have more than 2147483647 vertices or 1073741823 triangles");
    made.vertex_count = (int32_t)vertices;
    made.triangle_count = (int32_t)triangles;
    NphStatus status = fill(context, meshes, &made);
    if (status != NPH_OK) {
        nph_bvh_free(context, &made);
        return status;
    }
    *bvh = made;
    return NPH_OK;
}

void nph_bvh_free(NphContext *context, NphBvh *bvh) {
    nph_free(context, bvh->vertices);
    nph_free(context, bvh->vertices_f32);
    nph_free(context, bvh->nodes);
    nph_free(context, bvh->triangles);
    nph_free(context, bvh->mesh_first);
    memset(bvh, 0, sizeof *bvh);
}
