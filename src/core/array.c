/* SPDX-License-Identifier: Apache-2.0
 *
 * N-dimensional arrays. */
#include "nephos/array.h"

#include <string.h>

#include "core/memory.h"
#include "core/message.h"

static const struct {
    const char *name;
    size_t size;
} types[] = {{"u8", 1},  {"i8", 1},  {"u16", 2}, {"i16", 2}, {"f16", 2}, {"u32", 4},
             {"i32", 4}, {"f32", 4}, {"u64", 8}, {"i64", 8}, {"f64", 8}};

size_t nph_type_size(NphType type) { return types[type].size; }
const char *nph_type_name(NphType type) { return types[type].name; }

int64_t nph_array_count(const NphArray *array) {
    int64_t count = 1;
    for (int axis = 0; axis < array->rank; axis++) count *= array->shape[axis];
    return count;
}

NphStatus nph_array_new(NphContext *context, NphType type, int rank, const int64_t *shape, const char *what,
                        NphArray *array) {
    if (rank < 0 || rank > NPH_MAX_RANK)
        return nph_error(context, NPH_BAD_INPUT, "%s: rank %d is not in 0 to %d", what, rank, NPH_MAX_RANK);
    NphArray made = {.type = type, .rank = rank};
    int64_t count = 1;
    for (int axis = 0; axis < NPH_MAX_RANK; axis++) {
        int64_t n = axis < rank ? shape[axis] : 1;
        if (n < 0) return nph_error(context, NPH_BAD_INPUT, "%s: axis %d has the negative size %lld", what, axis, (long long)n);
        if (n > 0 && count > (INT64_MAX / 16) / n)
            return nph_error(context, NPH_BAD_INPUT, "%s: its shape overflows at axis %d (%lld)", what, axis, (long long)n);
        made.shape[axis] = n;
        count *= n;
    }
    NPH_TRY(nph_alloc(context, (size_t)count, nph_type_size(type), what, &made.data));
    *array = made;
    return NPH_OK;
}

void nph_array_free(NphContext *context, NphArray *array) {
    nph_free(context, array->data);
    memset(array, 0, sizeof *array);
}
