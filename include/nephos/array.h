/* SPDX-License-Identifier: Apache-2.0
 *
 * N-dimensional arrays in C order (the last index is the fastest), 64-byte aligned: what files and buffers hold. */
#ifndef NEPHOS_ARRAY_H
#define NEPHOS_ARRAY_H

#include <stddef.h>
#include <stdint.h>

#include "nephos/context.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { NPH_MAX_RANK = 6 };

typedef enum NphType {
    NPH_U8, NPH_I8, NPH_U16, NPH_I16, NPH_F16, NPH_U32, NPH_I32, NPH_F32, NPH_U64, NPH_I64, NPH_F64
} NphType;

typedef struct NphArray {
    NphType type;
    int rank;                    /* 0 (one element) to NPH_MAX_RANK */
    int64_t shape[NPH_MAX_RANK]; /* each >= 0; entries from rank on are 1 */
    void *data;                  /* owned; NULL while the array is empty */
} NphArray;

size_t nph_type_size(NphType type);
const char *nph_type_name(NphType type); /* "f32", "u8", ... */

/* Number of elements; the constructor guarantees it fits. */
int64_t nph_array_count(const NphArray *array);

/* Zero-filled array. NPH_BAD_INPUT for a bad rank, a negative or overflowing shape; NPH_NO_MEMORY. what names the
 * array in messages. *array is untouched on failure. */
NphStatus nph_array_new(NphContext *context, NphType type, int rank, const int64_t *shape, const char *what,
                        NphArray *array);

/* NumPy's .npy files: C order is written; Fortran order and other byte orders are read too. *array is untouched on failure.
 * PATH@OFFSET reads the array that begins at that byte of a file: dumps hold one after the other. */
NphStatus nph_array_read_npy(NphContext *context, const char *path, NphArray *array);
NphStatus nph_array_write_npy(NphContext *context, const char *path, const NphArray *array);

/* Frees the data and zeroes the struct; safe on a zeroed struct. */
void nph_array_free(NphContext *context, NphArray *array);

#ifdef __cplusplus
}
#endif
#endif
