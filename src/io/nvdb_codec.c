/* SPDX-License-Identifier: Apache-2.0
 *
 * The codecs and checksums of a NanoVDB file. A zip grid is one zlib stream behind a 64-bit size; a blosc grid is a row
 * of blocks of up to 1 GiB of unpacked bytes, each behind a 64-bit size. What a grid claims to unpack to is believed
 * only as far as its codec can compress: deflate 1032 : 1, LZ4 255 : 1. */
#include <blosc.h>
#include <zlib.h>

#include "core/memory.h"
#include "core/message.h"
#include "io/nvdb.h"

enum { SIZE_BYTES = 8, BLOSC_FORMAT_LZ4 = 1 };
static const uint64_t blosc_block = (uint64_t)1 << 30;

const char *nph_nvdb_codec_name(uint32_t codec) {
    static const char *const names[NPH_NVDB_CODECS] = {"none", "zip", "blosc"};
    return codec < NPH_NVDB_CODECS ? names[codec] : NULL;
}

static NphStatus damaged(NphContext *context, const char *path, const NphNvdbEntry *entry, uint64_t at,
                         const char *what) {
    return nph_error(context, NPH_BAD_INPUT, "%s: grid '%s', byte %llu: %s", path, entry->shown,
                     (unsigned long long)at, what);
}

static NphStatus unpack_zip(NphContext *context, const char *path, const unsigned char *file,
                            const NphNvdbEntry *entry, unsigned char *grid) {
    uint64_t at = entry->data_at;
    if (entry->file_bytes < SIZE_BYTES || nph_load_u64(file + at) != entry->file_bytes - SIZE_BYTES)
        return damaged(context, path, entry, at, "the size of the zip data does not agree with the grid's description");
    uLongf made = (uLongf)entry->grid_bytes;
    uLong used = (uLong)(entry->file_bytes - SIZE_BYTES);
    int result = uncompress2(grid, &made, file + at + SIZE_BYTES, &used);
    if (result == Z_MEM_ERROR) return nph_error(context, NPH_NO_MEMORY, "%s: no memory to unpack zip data", path);
    if (result != Z_OK) return damaged(context, path, entry, at + SIZE_BYTES, "the zip data are damaged");
    if (made != entry->grid_bytes || used != entry->file_bytes - SIZE_BYTES)
        return damaged(context, path, entry, at + SIZE_BYTES, "the zip data unpack to another size than announced");
    return NPH_OK;
}

/* Only LZ4 is let through: NanoVDB writes nothing else, and the library would print about codecs it lacks. */
static int block_is_sound(const unsigned char *block, uint64_t bytes, uint64_t expected) {
    size_t unpacked = 0;
    return bytes >= BLOSC_MIN_HEADER_LENGTH && block[2] >> 5 == BLOSC_FORMAT_LZ4 &&
           blosc_cbuffer_validate(block, bytes, &unpacked) == 0 && unpacked == expected;
}

static NphStatus unpack_blosc(NphContext *context, const char *path, const unsigned char *file,
                              const NphNvdbEntry *entry, unsigned char *grid) {
    uint64_t at = entry->data_at, end = entry->data_at + entry->file_bytes, left = entry->grid_bytes;
    while (left > 0) {
        uint64_t expected = left < blosc_block ? left : blosc_block;
        if (end - at < SIZE_BYTES) return damaged(context, path, entry, at, "a blosc block is missing");
        uint64_t bytes = nph_load_u64(file + at);
        at += SIZE_BYTES;
        if (bytes > end - at) return damaged(context, path, entry, at - SIZE_BYTES, "a blosc block exceeds its grid");
        if (!block_is_sound(file + at, bytes, expected) ||
            blosc_decompress_ctx(file + at, grid, expected, 1) != (int)expected)
            return damaged(context, path, entry, at, "the blosc block is damaged");
        grid += expected;
        left -= expected;
        at += bytes;
    }
    if (at != end) return damaged(context, path, entry, at, "bytes follow the last blosc block of the grid");
    return NPH_OK;
}

NphStatus nph_nvdb_unpack(NphContext *context, const char *path, const unsigned char *file, const NphNvdbEntry *entry,
                          unsigned char **grid) {
    int zip = entry->codec == NPH_NVDB_ZIP;
    uint64_t ratio = zip ? 1032 : 255;
    if (entry->grid_bytes / ratio > entry->file_bytes)
        return nph_error(context, NPH_BAD_INPUT,
                         "%s: grid '%s', byte %llu: %llu bytes of %s data cannot unpack to %llu bytes", path,
                         entry->shown, (unsigned long long)entry->meta_at, (unsigned long long)entry->file_bytes,
                         zip ? "zip" : "blosc", (unsigned long long)entry->grid_bytes);
    unsigned char *made = NULL;
    NPH_TRY(nph_alloc(context, entry->grid_bytes, 1, path, (void **)&made));
    NphStatus status = zip ? unpack_zip(context, path, file, entry, made)
                           : unpack_blosc(context, path, file, entry, made);
    if (status != NPH_OK) {
        nph_free(context, made);
        return status;
    }
    *grid = made;
    return NPH_OK;
}

const char *nph_nvdb_checksum(const NphNvdbBuffer *buffer, uint64_t words, uint64_t head_end, uint64_t tail_start) {
    static const uint64_t start = 16, block = 4096; /* magic and checksum themselves are left out */
    uint32_t head = (uint32_t)words, tail = (uint32_t)(words >> 32), none = UINT32_MAX;
    if (head != none && head != (uint32_t)crc32_z(0, buffer->bytes + start, head_end - start))
        return "the grid's header";
    if (!tail_start || head == none || tail == none) return NULL;
    uLong crc = crc32_z(0, NULL, 0);
    uint64_t blocks = (buffer->size - tail_start) / block; /* the last one takes the rest */
    for (uint64_t i = 0; i < blocks; i++) {
        uint64_t at = tail_start + i * block, length = i + 1 == blocks ? buffer->size - at : block;
        uint32_t one = (uint32_t)crc32_z(0, buffer->bytes + at, length);
        unsigned char word[4] = {one & 255u, one >> 8 & 255u, one >> 16 & 255u, one >> 24};
        crc = crc32_z(crc, word, sizeof word);
    }
    return (uint32_t)crc == tail ? NULL : "the nodes";
}
