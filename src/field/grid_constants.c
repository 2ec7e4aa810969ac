/* SPDX-License-Identifier: Apache-2.0
 *
 * From the codes of bricks to their numbers (grid_build.h): equal constant bricks become one, so that the inside of a
 * cloud of tiles costs a table entry a brick. A hash table from code to number: open addressing, 0 is a free key.
 */
#include "field/grid_build.h"

#include "core/memory.h"
#include "core/message.h"

static int64_t product3(const int32_t n[3]) { return (int64_t)n[0] * n[1] * n[2]; }

typedef struct Constants {
    int32_t *keys, *numbers;
    uint32_t capacity; /* a power of two */
    int32_t count;
} Constants;

static uint32_t constant_slot(const Constants *constants, int32_t key) {
    uint32_t slot = (uint32_t)key * 2654435761u;
    slot = (slot ^ slot >> 15) & (constants->capacity - 1);
    while (constants->keys[slot] != 0 && constants->keys[slot] != key) slot = (slot + 1) & (constants->capacity - 1);
    return slot;
}

static void constants_free(NphContext *context, Constants *constants) {
    nph_free(context, constants->keys);
    nph_free(context, constants->numbers);
}

static NphStatus constants_grow(NphContext *context, const char *what, Constants *constants) {
    Constants grown = {.capacity = constants->capacity ? constants->capacity * 4 : 64, .count = constants->count};
    NPH_TRY(NPH_NEW(context, grown.capacity, what, &grown.keys));
    NphStatus status = NPH_NEW(context, grown.capacity, what, &grown.numbers);
    if (status != NPH_OK) {
        constants_free(context, &grown);
        return status;
    }
    for (uint32_t i = 0; i < constants->capacity; i++) {
        if (constants->keys[i] == 0) continue;
        uint32_t slot = constant_slot(&grown, constants->keys[i]);
        grown.keys[slot] = constants->keys[i];
        grown.numbers[slot] = constants->numbers[i];
    }
    constants_free(context, constants);
    *constants = grown;
    return NPH_OK;
}

/* Numbers 1, 2, ... in the order in which the constants first appear in the table. */
static NphStatus number_constants(NphContext *context, const char *what, NphGrid *grid, Constants *constants) {
    int64_t bricks = product3(grid->bricks);
    int32_t key = 0, number = 0;
    for (int64_t brick = 0; brick < bricks; brick++) {
        int32_t code = grid->brick_index[brick];
        if (code <= 0) continue;
        if (code != key) {
            if ((uint32_t)constants->count * 2 >= constants->capacity)
                NPH_TRY(constants_grow(context, what, constants));
            uint32_t slot = constant_slot(constants, code);
            if (constants->keys[slot] == 0) {
                constants->keys[slot] = code;
                constants->numbers[slot] = ++constants->count;
            }
            key = code;
            number = constants->numbers[slot];
        }
        grid->brick_index[brick] = number;
    }
    return NPH_OK;
}

static void fill_constants(const Constants *constants, NphGrid *grid) {
    for (uint32_t slot = 0; slot < constants->capacity; slot++) {
        if (constants->keys[slot] == 0) continue;
        float value, *values = grid->values + (int64_t)constants->numbers[slot] * NPH_BRICK_STRIDE;
        memcpy(&value, &constants->keys[slot], sizeof value);
        for (int i = 0; i < NPH_BRICK_SAMPLES; i++) values[i] = value;
    }
}

NphStatus nph_grid_number(NphContext *context, const char *what, NphGrid *grid, int32_t *shared_end) {
    Constants constants = {0};
    NphStatus status = number_constants(context, what, grid, &constants);
    if (status == NPH_OK) {
        int64_t bricks = product3(grid->bricks);
        int32_t next = constants.count + 1;
        *shared_end = next;
        for (int64_t brick = 0; brick < bricks; brick++)
            if (grid->brick_index[brick] == NPH_BRICK_OWN) grid->brick_index[brick] = next++;
        grid->brick_count = next;
        if (next > NPH_GRID_BRICKS_MAX)
            status = nph_error(context, NPH_BAD_INPUT,
                               "%s: %d bricks of 8^3 samples that are not empty are too many; "
                               "at most %d (16 GiB)",
                               what, (int)next, NPH_GRID_BRICKS_MAX);
        else
            status = NPH_NEW(context, (size_t)next * NPH_BRICK_STRIDE, what, &grid->values);
    }
    if (status == NPH_OK) fill_constants(&constants, grid);
    constants_free(context, &constants);
    return status;
}
