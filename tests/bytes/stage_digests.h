/* SPDX-License-Identifier: Apache-2.0
 *
 * A run as digests: of every buffer that its stages write, and of every channel of its picture; with a sample of the cells, by
 * which a digest that moved can be told by how much. The same for any number of threads. docs/determinism.md, Pinned digests. */
#ifndef NPH_TESTS_STAGE_DIGESTS_H
#define NPH_TESTS_STAGE_DIGESTS_H

#include "nephos/array.h"
#include "nephos/render.h"
#include "oracle/digest.h"

enum { DIGEST_CELLS = 64, DIGEST_NAME = 40 };

/* One element of what a launch wrote. */
typedef struct DigestCell {
    uint32_t batch, number, index;
    uint64_t bits; /* of the value, in the lowest bits */
} DigestCell;

typedef struct DigestRow {
    char stage[DIGEST_NAME], buffer[DIGEST_NAME]; /* "picture" and a channel's name; "path.track" and "path.distance" */
    NphType type;
    int64_t launches, elements; /* over all launches */
    char digest[NPH_DIGEST_TEXT]; /* XXH3 of the launches' digests (16 bytes each) by rising batch and number */
    int cell_count;
    DigestCell cells[DIGEST_CELLS]; /* by rising batch, number, index */
} DigestRow;

typedef struct DigestTable {
    int count;
    DigestRow *rows;
} DigestTable;

/* Renders and fills the table; free it with nph_free(context, table->rows). A method whose buffers cannot be looked at has rows of its
 * picture alone. */
NphStatus digests_take(NphContext *context, const NphScene *scene, const NphRenderOptions *options, DigestTable *table);

#endif
