/* SPDX-License-Identifier: Apache-2.0
 *
 * Writing OpenEXR: one scanline part, ZIP, lines from the top, the library doing header and compression into the
 * stream of an NphWriter. Samples are packed here: little endian, half rounded to nearest even. No time, host or
 * version of a library goes into the file, and the deflate level is fixed, so equal images are equal bytes. */
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "io/exr.h"
#include "io/exr_core.h"
#include "io/file.h"
#include "io/half.h"
#include "nephos/image.h"

enum { ZIP_LEVEL = 6, SHORT_NAME_BYTES = 31 };

typedef struct Writer {
    NphExrLog log; /* first: the library's user data */
    NphContext *context;
    const char *path;
    const NphImage *image;
    NphWriter file;
    uint64_t position;
    exr_context_t exr;
    int *order; /* channels by name */
    exr_result_t (*compress)(exr_encode_pipeline_t *);
    int64_t overflows; /* finite values that became infinite halves or clamped integers */
} Writer;

static NphStatus failed(Writer *writer, exr_result_t code) {
    if (writer->file.stream && ferror(writer->file.stream))
        return nph_writer_commit(writer->context, &writer->file); /* fails, telling the system's reason */
    NphStatus status = code == EXR_ERR_OUT_OF_MEMORY ? NPH_NO_MEMORY : NPH_BAD_OUTPUT;
    return nph_error(writer->context, status, "%s: cannot write OpenEXR: %s", writer->path,
                     nph_exr_reason(&writer->log, code));
}

#define TRY_EXR(writer, expression)                                                                                    \
    do {                                                                                                               \
        exr_result_t try_code_ = (expression);                                                                         \
        if (try_code_ != EXR_ERR_SUCCESS) return failed((writer), try_code_);                                          \
    } while (0)

static int64_t write_bytes(exr_const_context_t exr, void *user, const void *bytes, uint64_t size, uint64_t offset,
                           exr_stream_error_func_ptr_t error) {
    (void)exr;
    (void)error;
    Writer *writer = user;
    FILE *stream = writer->file.stream;
    if (!stream) return -1; /* the write has failed before; exr_finish still tries */
    if (offset != writer->position && fseeko(stream, (off_t)offset, SEEK_SET) != 0) return -1;
    size_t done = fwrite(bytes, 1, size, stream);
    writer->position = offset + done;
    return done == size ? (int64_t)size : -1;
}

static NphStatus check_image(const Writer *writer) {
    const NphImage *image = writer->image;
    if (image->channel_count < 1)
        return nph_error(writer->context, NPH_BAD_USAGE, "%s: an image without channels cannot be written",
                         writer->path);
    int64_t limit = NPH_EXR_MAX_COORDINATE;
    if (image->width < 1 || image->height < 1 || image->full_width < 1 || image->full_height < 1 ||
        image->x0 < -limit || image->y0 < -limit || image->x0 + (int64_t)image->width > limit ||
        image->y0 + (int64_t)image->height > limit || image->full_width > limit || image->full_height > limit)
        return nph_error(
            writer->context, NPH_BAD_USAGE,
            "%s: cannot write %d x %d pixels at (%d, %d) of %d x %d: sizes are 1 or more, coordinates within 2^30",
            writer->path, image->width, image->height, image->x0, image->y0, image->full_width, image->full_height);
    return NPH_OK;
}

static int has_long_name(const NphImage *image) {
    for (int i = 0; i < image->channel_count; i++)
        if (strlen(image->channels[i].name) > SHORT_NAME_BYTES) return 1;
    for (int i = 0; i < image->attribute_count; i++)
        if (strlen(image->attributes[i].name) > SHORT_NAME_BYTES) return 1;
    return 0;
}

/* Channels in the order of their names' bytes, which the format demands. */
static NphStatus sort_channels(Writer *writer) {
    const NphImage *image = writer->image;
    NPH_TRY(NPH_NEW(writer->context, image->channel_count, "channel order", &writer->order));
    for (int i = 0; i < image->channel_count; i++) {
        int at = i;
        while (at > 0 && strcmp(image->channels[writer->order[at - 1]].name, image->channels[i].name) > 0) {
            writer->order[at] = writer->order[at - 1];
            at--;
        }
        writer->order[at] = i;
    }
    return NPH_OK;
}

static const NphChannel *sorted_channel(const Writer *writer, int i) {
    return &writer->image->channels[writer->order[i]];
}

static NphStatus declare_channels(Writer *writer) {
    NPH_TRY(sort_channels(writer));
    for (int i = 0; i < writer->image->channel_count; i++) {
        const NphChannel *channel = sorted_channel(writer, i);
        exr_pixel_type_t type = EXR_PIXEL_FLOAT;
        if (channel->was_uint) type = EXR_PIXEL_UINT;
        if (channel->was_half) type = EXR_PIXEL_HALF;
        TRY_EXR(writer, exr_add_channel(writer->exr, 0, channel->name, type, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1));
    }
    return NPH_OK;
}

static NphStatus declare_attributes(Writer *writer) {
    for (int i = 0; i < writer->image->attribute_count; i++) {
        const NphAttribute *a = &writer->image->attributes[i];
        exr_result_t code = EXR_ERR_INVALID_ARGUMENT;
        switch (a->type) {
        case NPH_ATTRIBUTE_STRING: code = exr_attr_set_string(writer->exr, 0, a->name, a->text); break;
        case NPH_ATTRIBUTE_INT: code = exr_attr_set_int(writer->exr, 0, a->name, (int32_t)a->number); break;
        case NPH_ATTRIBUTE_FLOAT: code = exr_attr_set_float(writer->exr, 0, a->name, (float)a->number); break;
        case NPH_ATTRIBUTE_DOUBLE: code = exr_attr_set_double(writer->exr, 0, a->name, a->number); break;
        }
        if (code != EXR_ERR_SUCCESS)
            return nph_error(writer->context, NPH_BAD_OUTPUT, "%s: cannot write attribute \"%s\": %s", writer->path,
                             a->name, nph_exr_reason(&writer->log, code));
    }
    return NPH_OK;
}

static exr_attr_box2i_t window(int x0, int y0, int width, int height) {
    exr_attr_box2i_t box;
    box.min.x = x0;
    box.min.y = y0;
    box.max.x = x0 + width - 1;
    box.max.y = y0 + height - 1;
    return box;
}

static NphStatus write_header(Writer *writer) {
    const NphImage *image = writer->image;
    exr_attr_box2i_t data = window(image->x0, image->y0, image->width, image->height);
    exr_attr_box2i_t display = window(0, 0, image->full_width, image->full_height);
    exr_attr_v2f_t centre;
    centre.x = centre.y = 0;
    exr_context_initializer_t settings = EXR_DEFAULT_CONTEXT_INITIALIZER;
    settings.error_handler_fn = nph_exr_note;
    settings.user_data = writer;
    settings.write_fn = write_bytes;
    settings.zip_level = ZIP_LEVEL;
    int part = 0;
    TRY_EXR(writer, exr_start_write(&writer->exr, writer->path, EXR_WRITE_FILE_DIRECTLY, &settings));
    TRY_EXR(writer, exr_set_longname_support(writer->exr, has_long_name(image)));
    TRY_EXR(writer, exr_add_part(writer->exr, NULL, EXR_STORAGE_SCANLINE, &part));
    TRY_EXR(writer, exr_initialize_required_attr(writer->exr, part, &display, &data, 1.0f, &centre, 1.0f,
                                                 EXR_LINEORDER_INCREASING_Y, EXR_COMPRESSION_ZIP));
    NPH_TRY(declare_channels(writer));
    NPH_TRY(declare_attributes(writer));
    TRY_EXR(writer, exr_write_header(writer->exr));
    return NPH_OK;
}

/* ---- pixels ---- */

static uint8_t *put16(uint8_t *to, uint32_t bits) {
    to[0] = (uint8_t)(bits & 255);
    to[1] = (uint8_t)(bits >> 8 & 255);
    return to + 2;
}

static uint8_t *put32(uint8_t *to, uint32_t bits) { return put16(put16(to, bits & 0xffff), bits >> 16); }

static uint32_t uint_from_float(float value, int64_t *overflows) {
    if (value >= 0 && value < 4294967296.0f) return (uint32_t)value;
    ++*overflows;
    return value > 0 ? UINT32_MAX : 0; /* NaN becomes 0 */
}

static uint8_t *pack_line(const NphChannel *channel, const float *from, int width, uint8_t *to, int64_t *overflows) {
    for (int x = 0; x < width; x++) {
        if (channel->was_half) {
            uint16_t half = nph_half_from_float(from[x]);
            *overflows += (half & 0x7fff) == 0x7c00 && from[x] - from[x] == 0;
            to = put16(to, half);
        } else {
            uint32_t bits;
            if (channel->was_uint)
                bits = uint_from_float(from[x], overflows);
            else
                memcpy(&bits, &from[x], sizeof bits);
            to = put32(to, bits);
        }
    }
    return to;
}

/* The pipeline's packing step; the library has allocated packed_buffer with the chunk's unpacked size. */
static exr_result_t pack_chunk(exr_encode_pipeline_t *encode) {
    Writer *writer = encode->encoding_user_data;
    const NphImage *image = writer->image;
    int top = encode->chunk.start_y - image->y0;
    uint8_t *to = encode->packed_buffer;
    for (int line = 0; line < encode->chunk.height; line++)
        for (int c = 0; c < image->channel_count; c++) {
            const NphChannel *channel = sorted_channel(writer, c);
            const float *from = channel->pixels + (size_t)(top + line) * (size_t)image->width;
            to = pack_line(channel, from, image->width, to, &writer->overflows);
        }
    encode->packed_bytes = (uint64_t)(to - (uint8_t *)encode->packed_buffer);
    return EXR_ERR_SUCCESS;
}

/* Compression that does not make a chunk smaller is given up, and readers know such a chunk by its size. The library
 * (3.1.5) stores a deflated chunk of exactly that size, which every reader then takes for raw samples. */
static exr_result_t compress_chunk(exr_encode_pipeline_t *encode) {
    const Writer *writer = encode->encoding_user_data;
    exr_result_t code = writer->compress(encode);
    if (code == EXR_ERR_SUCCESS && encode->compressed_bytes >= encode->packed_bytes) {
        memcpy(encode->compressed_buffer, encode->packed_buffer, encode->packed_bytes);
        encode->compressed_bytes = encode->packed_bytes;
    }
    return code;
}

/* The library chooses its packing only for channels with pixels; the choice is then replaced by pack_chunk. */
static exr_result_t choose_routines(Writer *writer, exr_encode_pipeline_t *encode) {
    for (int c = 0; c < encode->channel_count; c++) {
        encode->channels[c].encode_from_ptr = (const uint8_t *)sorted_channel(writer, c)->pixels;
        encode->channels[c].user_pixel_stride = encode->channels[c].user_bytes_per_element;
        encode->channels[c].user_line_stride = encode->channels[c].user_bytes_per_element;
    }
    exr_result_t code = exr_encoding_choose_default_routines(writer->exr, 0, encode);
    writer->compress = encode->compress_fn;
    encode->convert_and_pack_fn = pack_chunk;
    encode->compress_fn = compress_chunk;
    encode->encoding_user_data = writer;
    return code;
}

static NphStatus write_chunk(Writer *writer, exr_encode_pipeline_t *encode, int y) {
    exr_chunk_info_t chunk = {0};
    TRY_EXR(writer, exr_write_scanline_chunk_info(writer->exr, 0, writer->image->y0 + y, &chunk));
    if (!encode->context) {
        TRY_EXR(writer, exr_encoding_initialize(writer->exr, 0, &chunk, encode));
        TRY_EXR(writer, choose_routines(writer, encode));
    } else {
        TRY_EXR(writer, exr_encoding_update(writer->exr, 0, &chunk, encode));
    }
    TRY_EXR(writer, exr_encoding_run(writer->exr, 0, encode));
    return NPH_OK;
}

static NphStatus write_pixels(Writer *writer) {
    exr_encode_pipeline_t encode = EXR_ENCODE_PIPELINE_INITIALIZER;
    int32_t lines = 0;
    TRY_EXR(writer, exr_get_scanlines_per_chunk(writer->exr, 0, &lines));
    NphStatus status = NPH_OK;
    for (int y = 0; y < writer->image->height && status == NPH_OK; y += lines) status = write_chunk(writer, &encode, y);
    if (encode.context) exr_encoding_destroy(writer->exr, &encode);
    if (status == NPH_OK && writer->overflows)
        nph_warn(writer->context, "%s: %lld values are outside their channel's type (half, unsigned) and were clamped",
                 writer->path, (long long)writer->overflows);
    return status;
}

/* exr_finish writes the chunk table, so it runs, and can fail, before the commit. */
static NphStatus write_file(Writer *writer) {
    NphStatus status = write_header(writer);
    if (status == NPH_OK) status = write_pixels(writer);
    if (!writer->exr) return status;
    exr_result_t code = exr_finish(&writer->exr);
    if (status == NPH_OK && code != EXR_ERR_SUCCESS) return failed(writer, code);
    return status;
}

NphStatus nph_exr_write(NphContext *context, const char *path, const NphImage *image) {
    Writer writer = {.context = context, .path = path, .image = image};
    NPH_TRY(check_image(&writer));
    NPH_TRY(nph_writer_open(context, path, &writer.file));
    NphStatus status = write_file(&writer);
    if (status == NPH_OK) status = nph_writer_commit(context, &writer.file);
    nph_writer_abandon(context, &writer.file);
    nph_free(context, writer.order);
    return status;
}
