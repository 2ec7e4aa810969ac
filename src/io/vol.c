/* SPDX-License-Identifier: Apache-2.0
 *
 * Mitsuba's grid volume, little endian throughout:
 *     0 "VOL", version 3 (one byte)   4 int32 type, 1 = float32   8 int32 nx, ny, nz   20 int32 channels
 *     24 float32 box: xmin ymin zmin xmax ymax zmax               48 float32 values
 * x is the fastest axis, the channels of a voxel lie together. Source: manual of Mitsuba 3, plugin gridvolume. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/text.h"
#include "io/file.h"
#include "io/nvdb.h" /* nph_load_u32 */
#include "io/volume.h"

enum { AT_TYPE = 4, AT_SIZE = 8, AT_CHANNELS = 20, AT_BOX = 24, HEADER_BYTES = 48, VERSION = 3, TYPE_FLOAT32 = 1 };
static const char *const type_names[] = {"unknown", "float32", "float16", "uint8", "quantised directions"};

void nph_box_grid_free(NphContext *context, NphBoxGrid *grid) {
    nph_array_free(context, &grid->values);
    memset(grid, 0, sizeof *grid);
}

static float load_float(const unsigned char *at) {
    uint32_t bits = nph_load_u32(at);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static void store_u32(unsigned char *at, uint32_t word) {
    for (int i = 0; i < 4; i++) at[i] = (unsigned char)(word >> (8 * i) & 255u);
}

static void store_float(unsigned char *at, float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    store_u32(at, bits);
}

static NphStatus check_head(NphContext *context, const char *path, const unsigned char *bytes, size_t size) {
    if (size == 0) return nph_error(context, NPH_BAD_INPUT, "%s: is empty", path);
    if (size < 3 || memcmp(bytes, "VOL", 3) != 0)
        return nph_error(context, NPH_BAD_INPUT, "%s: byte 0: no Mitsuba grid volume starts here (\"VOL\")", path);
    if (size < HEADER_BYTES)
        return nph_error(context, NPH_BAD_INPUT, "%s: byte %zu: the header of %d bytes was cut", path, size,
                         HEADER_BYTES);
    if (bytes[3] != VERSION)
        return nph_error(context, NPH_BAD_INPUT, "%s: byte 3: version %d of the format; 3 is read", path, bytes[3]);
    uint32_t type = nph_load_u32(bytes + AT_TYPE);
    if (type != TYPE_FLOAT32)
        return nph_error(context, NPH_BAD_INPUT, "%s: byte %d: type %lu (%s); 1 (float32) is read", path, AT_TYPE,
                         (unsigned long)type, type_names[type < 5 ? type : 0]);
    return NPH_OK;
}

/* Sizes and box; what is believed agrees with the file's size to the byte. */
static NphStatus read_head(NphContext *context, const char *path, const unsigned char *bytes, size_t size,
                           NphBoxGrid *grid) {
    NPH_TRY(check_head(context, path, bytes, size));
    uint32_t channels = nph_load_u32(bytes + AT_CHANNELS);
    if (channels != 1 && channels != 3)
        return nph_error(context, NPH_BAD_INPUT, "%s: byte %d: %lu channels; 1 and 3 are read", path, AT_CHANNELS,
                         (unsigned long)channels);
    int64_t shape[4] = {0, 0, 0, channels};
    uint64_t held = (size - HEADER_BYTES) / sizeof(float), values = channels;
    for (int axis = 0; axis < 3; axis++) {
        uint32_t n = nph_load_u32(bytes + AT_SIZE + 4 * axis);
        if (n < 1 || n > INT32_MAX)
            return nph_error(context, NPH_BAD_INPUT, "%s: byte %d: the size along %c is %ld; at least 1 is needed", path,
                             AT_SIZE + 4 * axis, "xyz"[axis], (long)(int32_t)n);
        shape[2 - axis] = n;
        values = n > held / values ? held + 1 : values * n; /* held + 1: more than there are */
        if (values > held) break;
    }
    if (values > held || (size - HEADER_BYTES) != values * sizeof(float))
        return nph_error(context, NPH_BAD_INPUT,
                         "%s: byte %d: a grid of %lu x %lu x %lu voxels with %lu channels does not fill the file's %zu "
                         "bytes behind the header; it was cut or damaged",
                         path, AT_SIZE, (unsigned long)nph_load_u32(bytes + AT_SIZE),
                         (unsigned long)nph_load_u32(bytes + AT_SIZE + 4),
                         (unsigned long)nph_load_u32(bytes + AT_SIZE + 8), (unsigned long)channels,
                         size - HEADER_BYTES);
    for (int axis = 0; axis < 3; axis++) {
        float lo = load_float(bytes + AT_BOX + 4 * axis), hi = load_float(bytes + AT_BOX + 12 + 4 * axis);
        char text[2][NPH_DOUBLE_TEXT];
        if (!isfinite(lo) || !isfinite(hi) || !(lo < hi))
            return nph_error(context, NPH_BAD_INPUT,
                             "%s: byte %d: the box from %s to %s along %c is no finite, rising range", path,
                             AT_BOX + 4 * axis, nph_format_double((double)lo, text[0]),
                             nph_format_double((double)hi, text[1]), "xyz"[axis]);
        grid->lo[axis] = lo;
        grid->hi[axis] = hi;
    }
    return nph_array_new(context, NPH_F32, channels == 1 ? 3 : 4, shape, path, &grid->values);
}

NphStatus nph_vol_read(NphContext *context, const char *path, NphBoxGrid *grid) {
    char *bytes = NULL;
    size_t size = 0;
    NphBoxGrid made = {0};
    NPH_TRY(nph_file_read(context, path, &bytes, &size));
    NphStatus status = read_head(context, path, (const unsigned char *)bytes, size, &made);
    if (status == NPH_OK) {
        float *values = made.values.data;
        const unsigned char *at = (const unsigned char *)bytes + HEADER_BYTES;
        int64_t count = nph_array_count(&made.values);
        for (int64_t i = 0; i < count; i++) values[i] = load_float(at + 4 * i);
        *grid = made;
    }
    nph_free(context, bytes);
    return status;
}

static NphStatus make_head(NphContext *context, const char *path, const NphBoxGrid *grid,
                           unsigned char head[HEADER_BYTES]) {
    const NphArray *values = &grid->values;
    int64_t channels = values->rank == 4 ? values->shape[3] : 1;
    if (values->type != NPH_F32 || (values->rank != 3 && values->rank != 4) || (channels != 1 && channels != 3))
        return nph_error(context, NPH_BAD_USAGE, "%s: a .vol takes f32 [z][y][x] or [z][y][x][3]", path);
    memcpy(head, "VOL", 3); /* NOLINT(bugprone-not-null-terminated-result): three bytes are the signature */
    head[3] = VERSION;
    store_u32(head + AT_TYPE, TYPE_FLOAT32);
    store_u32(head + AT_CHANNELS, (uint32_t)channels);
    for (int axis = 0; axis < 3; axis++) {
        int64_t n = values->shape[2 - axis];
        float lo = (float)grid->lo[axis], hi = (float)grid->hi[axis];
        char text[2][NPH_DOUBLE_TEXT];
        if (n < 1 || n > INT32_MAX)
            return nph_error(context, NPH_BAD_USAGE, "%s: %lld voxels along %c; a .vol holds 1 to 2147483647", path,
                             (long long)n, "xyz"[axis]);
        if (!(fabs(grid->lo[axis]) <= FLT_MAX) || !(fabs(grid->hi[axis]) <= FLT_MAX) || !(lo < hi))
            return nph_error(context, NPH_BAD_USAGE,
                             "%s: the box from %s to %s along %c is no finite, rising range in float32", path,
                             nph_format_double(grid->lo[axis], text[0]), nph_format_double(grid->hi[axis], text[1]),
                             "xyz"[axis]);
        store_u32(head + AT_SIZE + 4 * axis, (uint32_t)n);
        store_float(head + AT_BOX + 4 * axis, lo);
        store_float(head + AT_BOX + 12 + 4 * axis, hi);
    }
    return NPH_OK;
}

NphStatus nph_vol_write(NphContext *context, const char *path, const NphBoxGrid *grid) {
    unsigned char head[HEADER_BYTES], piece[4096];
    NphWriter writer;
    NPH_TRY(make_head(context, path, grid, head));
    NPH_TRY(nph_writer_open(context, path, &writer));
    fwrite(head, 1, sizeof head, writer.stream); /* the stream keeps its errors; the commit reports them */
    const float *values = grid->values.data;
    int64_t count = nph_array_count(&grid->values);
    for (int64_t i = 0; i < count;) {
        size_t filled = 0;
        for (; i < count && filled < sizeof piece; i++, filled += 4) store_float(piece + filled, values[i]);
        fwrite(piece, 1, filled, writer.stream);
    }
    return nph_writer_commit(context, &writer);
}
