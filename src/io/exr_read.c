/* SPDX-License-Identifier: Apache-2.0
 *
 * Reading OpenEXR through OpenEXRCore: the library parses the header and decompresses, chunk by chunk; chunk bounds are
 * checked and samples turned to float here. The file is in memory as a whole, so every offset is held against its true
 * size. A chunk holds its lines one after the other, each with all channels in the header's (alphabetical) order.
 * The library's own scratch memory, about three chunks, is not counted by the context's limit; file and planes are. */
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "io/describe.h"
#include "io/exr.h"
#include "io/exr_core.h"
#include "io/file.h"
#include "io/half.h"
#include "io/printable.h"
#include "nephos/image.h"

/* No compression of the format reaches this ratio: deflate ends at 1032:1, PXR24 (which drops a byte of four first) at
 * 1376:1, PIZ's run lengths at 410:1, RLE at 64:1, B44A at 11:1. A header that promises more is damaged. */
enum { MAX_RATIO = 2000 };

typedef struct Reader {
    NphExrLog log; /* first: the library's user data */
    NphContext *context;
    const char *path;
    char *bytes;
    size_t size;
    exr_context_t exr;
    exr_attr_box2i_t window;
    exr_storage_t storage;
    exr_compression_t compression;
    const exr_attr_chlist_t *channels;
    size_t pixel_bytes; /* of all channels as stored */
    int inexact;        /* unsigned integers that no float equals */
    NphImage image;
} Reader;

/* Never NPH_NO_MEMORY: the library gives its code for that to deflated data which is longer than its chunk, too.
 * Its text may quote names of the file. */
static NphStatus damaged(Reader *reader, exr_result_t code) {
    char shown[sizeof reader->log.text];
    const char *reason = nph_exr_reason(&reader->log, code);
    return nph_error(reader->context, NPH_BAD_INPUT, "%s: damaged or unsupported OpenEXR file: %s", reader->path,
                     nph_printable(reason, strlen(reason), shown, sizeof shown));
}

#define TRY_EXR(reader, expression)                                                                                    \
    do {                                                                                                               \
        exr_result_t try_code_ = (expression);                                                                         \
        if (try_code_ != EXR_ERR_SUCCESS) return damaged((reader), try_code_);                                         \
    } while (0)

static int64_t read_bytes(exr_const_context_t exr, void *user, void *buffer, uint64_t size, uint64_t offset,
                          exr_stream_error_func_ptr_t error) {
    (void)exr;
    (void)error;
    const Reader *reader = user;
    if (offset > reader->size) return 0;
    uint64_t left = reader->size - offset, count = size < left ? size : left;
    memcpy(buffer, reader->bytes + offset, count);
    return (int64_t)count;
}

static int64_t file_size(exr_const_context_t exr, void *user) {
    (void)exr;
    return (int64_t)((const Reader *)user)->size;
}

static NphStatus check_kind(const Reader *reader) {
    NphFileKind kind = nph_file_kind_of_bytes(reader->bytes, reader->size);
    if (kind == NPH_FILE_EXR) return NPH_OK;
    if (kind == NPH_FILE_HDR || kind == NPH_FILE_PFM || kind == NPH_FILE_PNG)
        return nph_error(reader->context, NPH_BAD_INPUT,
                         "%s: not OpenEXR, but %s; convert it, e.g. `oiiotool in --compression zip -o out.exr`",
                         reader->path, nph_file_kind_name(kind));
    return nph_error(reader->context, NPH_BAD_INPUT,
                     "%s: not OpenEXR, but %s; OpenEXR begins with the bytes 76 2f 31 01", reader->path,
                     nph_file_kind_name(kind));
}

static NphStatus open_file(Reader *reader) {
    exr_context_initializer_t settings = EXR_DEFAULT_CONTEXT_INITIALIZER;
    settings.error_handler_fn = nph_exr_note;
    settings.user_data = reader;
    settings.read_fn = read_bytes;
    settings.size_fn = file_size;
    settings.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION; /* half a picture is no picture */
    TRY_EXR(reader, exr_start_read(&reader->exr, reader->path, &settings));
    int parts = 0;
    TRY_EXR(reader, exr_get_count(reader->exr, &parts));
    if (parts < 1) return nph_error(reader->context, NPH_BAD_INPUT, "%s: has no part", reader->path);
    if (parts > 1) nph_warn(reader->context, "%s: has %d parts; the first is read", reader->path, parts);
    TRY_EXR(reader, exr_get_storage(reader->exr, 0, &reader->storage));
    TRY_EXR(reader, exr_get_compression(reader->exr, 0, &reader->compression));
    TRY_EXR(reader, exr_get_channels(reader->exr, 0, &reader->channels));
    TRY_EXR(reader, exr_get_data_window(reader->exr, 0, &reader->window));
    return NPH_OK;
}

/* Kinds of files that are sound but cannot be read. */
static NphStatus check_supported(const Reader *reader) {
    NphContext *context = reader->context;
    const char *path = reader->path;
    if (reader->storage != EXR_STORAGE_SCANLINE && reader->storage != EXR_STORAGE_TILED)
        return nph_error(
            context, NPH_BAD_INPUT,
            "%s: holds deep samples, which are not read; flatten it, e.g. `oiiotool in.exr --flatten -o out.exr`",
            path);
    if (reader->compression == EXR_COMPRESSION_DWAA || reader->compression == EXR_COMPRESSION_DWAB)
        return nph_error(context, NPH_BAD_INPUT,
                         "%s: is compressed with %s, which is not decoded here; convert it, e.g. "
                         "`oiiotool in.exr --compression zip -o out.exr`",
                         path, reader->compression == EXR_COMPRESSION_DWAA ? "DWAA" : "DWAB");
    if (reader->channels->num_channels < 1) return nph_error(context, NPH_BAD_INPUT, "%s: has no channel", path);
    for (int i = 0; i < reader->channels->num_channels; i++) {
        const exr_attr_chlist_entry_t *entry = &reader->channels->entries[i];
        char name[64];
        if (entry->x_sampling != 1 || entry->y_sampling != 1)
            return nph_error(
                context, NPH_BAD_INPUT,
                "%s: channel \"%s\" is subsampled (%d x %d), which is not read; convert it to RGB at full resolution",
                path, nph_printable(entry->name.str, strlen(entry->name.str), name, sizeof name), entry->x_sampling,
                entry->y_sampling);
    }
    return NPH_OK;
}

static int outside(int64_t coordinate) {
    return coordinate < -NPH_EXR_MAX_COORDINATE || coordinate > NPH_EXR_MAX_COORDINATE;
}

/* Windows to the image's numbers, and the plausibility of the size, before anything is allocated. */
static NphStatus measure(Reader *reader) {
    exr_attr_box2i_t data = reader->window, display;
    TRY_EXR(reader, exr_get_display_window(reader->exr, 0, &display));
    int64_t width = (int64_t)data.max.x - data.min.x + 1, height = (int64_t)data.max.y - data.min.y + 1;
    int64_t full_width = (int64_t)display.max.x - display.min.x + 1,
            full_height = (int64_t)display.max.y - display.min.y + 1;
    if (width < 1 || height < 1 || full_width < 1 || full_height < 1)
        return nph_error(reader->context, NPH_BAD_INPUT,
                         "%s: damaged: data window (%d, %d) - (%d, %d), display window (%d, %d) - (%d, %d)",
                         reader->path, data.min.x, data.min.y, data.max.x, data.max.y, display.min.x, display.min.y,
                         display.max.x, display.max.y);
    int64_t x0 = (int64_t)data.min.x - display.min.x, y0 = (int64_t)data.min.y - display.min.y;
    if (outside(x0) || outside(y0) || outside(x0 + width) || outside(y0 + height) || outside(full_width) ||
        outside(full_height))
        return nph_error(reader->context, NPH_BAD_INPUT, "%s: data window (%d, %d) - (%d, %d) is beyond 2^30",
                         reader->path, data.min.x, data.min.y, data.max.x, data.max.y);
    for (int i = 0; i < reader->channels->num_channels; i++)
        reader->pixel_bytes += reader->channels->entries[i].pixel_type == EXR_PIXEL_HALF ? 2 : 4;
    double promised = (double)width * (double)height * (double)reader->pixel_bytes;
    if (promised > (double)reader->size * (reader->compression == EXR_COMPRESSION_NONE ? 1 : MAX_RATIO))
        return nph_error(reader->context, NPH_BAD_INPUT,
                         "%s: damaged or cut short: %lld x %lld pixels in %d channels (%.4g bytes) cannot come from a "
                         "file of %zu bytes",
                         reader->path, (long long)width, (long long)height, reader->channels->num_channels, promised,
                         reader->size);
    NPH_TRY(nph_image_new(reader->context, (int)width, (int)height, &reader->image));
    reader->image.x0 = (int)x0;
    reader->image.y0 = (int)y0;
    reader->image.full_width = (int)full_width;
    reader->image.full_height = (int)full_height;
    return NPH_OK;
}

/* The container's complaints (an empty or doubled name) are the file's here. */
static NphStatus blame_file(const Reader *reader, NphStatus status) {
    if (status != NPH_BAD_USAGE) return status;
    return nph_error(reader->context, NPH_BAD_INPUT, "%s: damaged OpenEXR header", reader->path);
}

static NphStatus add_channels(Reader *reader) {
    for (int i = 0; i < reader->channels->num_channels; i++) {
        const exr_attr_chlist_entry_t *entry = &reader->channels->entries[i];
        NphStatus status = nph_image_add_channel(reader->context, &reader->image, entry->name.str, NULL);
        if (status != NPH_OK) return blame_file(reader, status);
        reader->image.channels[i].was_half = entry->pixel_type == EXR_PIXEL_HALF;
        reader->image.channels[i].was_uint = entry->pixel_type == EXR_PIXEL_UINT;
    }
    return NPH_OK;
}

static NphStatus add_attributes(Reader *reader) {
    NphContext *context = reader->context;
    NphImage *image = &reader->image;
    int32_t count = 0;
    TRY_EXR(reader, exr_get_attribute_count(reader->exr, 0, &count));
    for (int i = 0; i < count; i++) {
        const exr_attribute_t *a = NULL;
        TRY_EXR(reader, exr_get_attribute_by_index(reader->exr, 0, EXR_ATTR_LIST_FILE_ORDER, i, &a));
        if (nph_exr_reserved_name(a->name)) continue;
        NphStatus status = NPH_OK;
        if (a->type == EXR_ATTR_STRING)
            status = nph_image_set_text(context, image, a->name, a->string->str ? a->string->str : "");
        if (a->type == EXR_ATTR_INT) status = nph_image_set_number(context, image, a->name, NPH_ATTRIBUTE_INT, a->i);
        if (a->type == EXR_ATTR_FLOAT)
            status = nph_image_set_number(context, image, a->name, NPH_ATTRIBUTE_FLOAT, (double)a->f);
        if (a->type == EXR_ATTR_DOUBLE)
            status = nph_image_set_number(context, image, a->name, NPH_ATTRIBUTE_DOUBLE, a->d);
        if (status != NPH_OK) return blame_file(reader, status);
    }
    return NPH_OK;
}

/* ---- pixels ---- */

typedef struct Block { /* pixels of a chunk within the image */
    int x, y, width, height;
} Block;

static uint32_t little16(const uint8_t *b) { return (uint32_t)b[0] | (uint32_t)b[1] << 8; }
static uint32_t little32(const uint8_t *b) { return little16(b) | little16(b + 2) << 16; }

/* One line of one channel; returns the bytes that follow it. */
static const uint8_t *convert_line(Reader *reader, const NphChannel *channel, const uint8_t *from, float *to,
                                   int width) {
    if (channel->was_half) {
        for (int x = 0; x < width; x++) to[x] = nph_float_from_half((uint16_t)little16(from + 2 * x));
        return from + 2 * (size_t)width;
    }
    for (int x = 0; x < width; x++) {
        uint32_t bits = little32(from + 4 * (size_t)x);
        if (channel->was_uint) {
            to[x] = (float)bits;
            if ((double)to[x] != (double)bits) reader->inexact++;
        } else {
            memcpy(&to[x], &bits, sizeof bits);
        }
    }
    return from + 4 * (size_t)width;
}

static void store_block(Reader *reader, const Block *block, const uint8_t *from) {
    const NphImage *image = &reader->image;
    for (int line = 0; line < block->height; line++)
        for (int c = 0; c < image->channel_count; c++) {
            size_t first = (size_t)(block->y + line) * (size_t)image->width + (size_t)block->x;
            from = convert_line(reader, &image->channels[c], from, image->channels[c].pixels + first, block->width);
        }
}

/* Zeroed, so that what a damaged chunk leaves unwritten is at least the same in every run. */
static void *alloc_zeroed(exr_transcoding_pipeline_buffer_id_t id, size_t bytes) {
    (void)id;
    return calloc(1, bytes);
}

static void free_zeroed(exr_transcoding_pipeline_buffer_id_t id, void *pointer) {
    (void)id;
    free(pointer);
}

/* The library leaves chunks that reach beyond the file half read, and empty ones unwritten: neither passes here. */
static NphStatus check_chunk(const Reader *reader, const exr_chunk_info_t *chunk, const Block *block) {
    uint64_t expected = (uint64_t)block->width * (uint64_t)block->height * reader->pixel_bytes;
    const char *wrong = NULL;
    if (chunk->width != block->width || chunk->height != block->height || chunk->unpacked_size != expected)
        wrong = "has another size than its header says";
    else if (chunk->packed_size < 1)
        wrong = "is empty";
    else if (chunk->packed_size > expected)
        wrong = "is larger than its pixels";
    else if (reader->compression == EXR_COMPRESSION_NONE && chunk->packed_size != expected)
        wrong = "is smaller than its pixels";
    else if (chunk->data_offset > reader->size || chunk->packed_size > reader->size - chunk->data_offset)
        wrong = "reaches beyond the end of the file";
    if (!wrong) return NPH_OK;
    return nph_error(reader->context, NPH_BAD_INPUT,
                     "%s: damaged or cut short: the chunk of pixels (%d, %d) + %d x %d %s (byte %llu)", reader->path,
                     block->x, block->y, block->width, block->height, wrong, (unsigned long long)chunk->data_offset);
}

typedef struct Decoder {
    exr_decode_pipeline_t pipeline;
    exr_result_t (*decompress)(exr_decode_pipeline_t *);
} Decoder;

/* A chunk that compression would not make smaller is stored as it is; the library knows that of all compressions but
 * B44 and B44A, from whose raw chunks it makes noise. */
static NphStatus read_chunk(Reader *reader, Decoder *decoder, const exr_chunk_info_t *chunk, const Block *block) {
    exr_decode_pipeline_t *decode = &decoder->pipeline;
    NPH_TRY(check_chunk(reader, chunk, block));
    if (!decode->context) {
        TRY_EXR(reader, exr_decoding_initialize(reader->exr, 0, chunk, decode));
        decode->alloc_fn = alloc_zeroed;
        decode->free_fn = free_zeroed;
        TRY_EXR(reader, exr_decoding_choose_default_routines(reader->exr, 0, decode));
        decode->unpack_and_convert_fn = NULL; /* store_block does it */
        decoder->decompress = decode->decompress_fn;
    } else {
        TRY_EXR(reader, exr_decoding_update(reader->exr, 0, chunk, decode));
    }
    decode->decompress_fn = chunk->packed_size == chunk->unpacked_size ? NULL : decoder->decompress;
    TRY_EXR(reader, exr_decoding_run(reader->exr, 0, decode));
    store_block(reader, block, decode->unpacked_buffer);
    return NPH_OK;
}

static NphStatus read_lines(Reader *reader, Decoder *decoder) {
    int32_t lines = 0;
    TRY_EXR(reader, exr_get_scanlines_per_chunk(reader->exr, 0, &lines));
    if (lines < 1) return damaged(reader, EXR_ERR_INCORRECT_CHUNK);
    const NphImage *image = &reader->image;
    for (int y = 0; y < image->height; y += lines) {
        Block block = {0, y, image->width, image->height - y < lines ? image->height - y : lines};
        exr_chunk_info_t chunk = {0};
        TRY_EXR(reader, exr_read_scanline_chunk_info(reader->exr, 0, reader->window.min.y + y, &chunk));
        NPH_TRY(read_chunk(reader, decoder, &chunk, &block));
    }
    return NPH_OK;
}

/* Level (0, 0) of single, mip and rip levels alike. */
static NphStatus read_tiles(Reader *reader, Decoder *decoder) {
    int32_t tile_width = 0, tile_height = 0;
    TRY_EXR(reader, exr_get_tile_sizes(reader->exr, 0, 0, 0, &tile_width, &tile_height));
    if (tile_width < 1 || tile_height < 1) return damaged(reader, EXR_ERR_INCORRECT_CHUNK);
    const NphImage *image = &reader->image;
    for (int64_t y = 0; y < image->height; y += tile_height)
        for (int64_t x = 0; x < image->width; x += tile_width) {
            int64_t right = image->width - x, below = image->height - y;
            Block block = {(int)x, (int)y, (int)(right < tile_width ? right : tile_width),
                           (int)(below < tile_height ? below : tile_height)};
            exr_chunk_info_t chunk = {0};
            TRY_EXR(reader, exr_read_tile_chunk_info(reader->exr, 0, (int)(x / tile_width), (int)(y / tile_height), 0,
                                                     0, &chunk));
            NPH_TRY(read_chunk(reader, decoder, &chunk, &block));
        }
    return NPH_OK;
}

static NphStatus read_pixels(Reader *reader) {
    Decoder decoder = {EXR_DECODE_PIPELINE_INITIALIZER, NULL};
    NphStatus status =
        reader->storage == EXR_STORAGE_TILED ? read_tiles(reader, &decoder) : read_lines(reader, &decoder);
    if (decoder.pipeline.context) exr_decoding_destroy(reader->exr, &decoder.pipeline);
    if (status == NPH_OK && reader->inexact)
        nph_warn(reader->context, "%s: %d integers above 2^24 were rounded to float", reader->path, reader->inexact);
    return status;
}

static NphStatus read_image(Reader *reader) {
    NPH_TRY(check_kind(reader));
    NPH_TRY(open_file(reader));
    NPH_TRY(check_supported(reader));
    NPH_TRY(measure(reader));
    NPH_TRY(add_attributes(reader));
    NPH_TRY(add_channels(reader));
    return read_pixels(reader);
}

NphStatus nph_exr_read(NphContext *context, const char *path, NphImage *image) {
    Reader reader = {.context = context, .path = path};
    NPH_TRY(nph_file_read(context, path, &reader.bytes, &reader.size));
    NphStatus status = read_image(&reader);
    if (reader.exr) exr_finish(&reader.exr);
    nph_free(context, reader.bytes);
    if (status != NPH_OK) {
        nph_image_free(context, &reader.image);
        return status;
    }
    *image = reader.image;
    return NPH_OK;
}
