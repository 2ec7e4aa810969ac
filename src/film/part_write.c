/* SPDX-License-Identifier: Apache-2.0
 *
 * Writing a part file: header, texts, tiles, the nodes' values as little-endian doubles, and the XXH3-128 digest of all
 * that. Pixels outside the crop are left out, and every NaN is written as the same one. */
#define XXH_STATIC_LINKING_ONLY /* the digest's state on the stack */
#include <string.h>
#include <xxhash.h>

#include "core/memory.h"
#include "core/message.h"
#include "film/part.h"
#include "film/tree.h"
#include "io/file.h"

enum { BUFFER_BYTES = 1 << 16 };

typedef struct Output {
    FILE *stream;
    XXH3_state_t digest;
    size_t used;
    uint8_t buffer[BUFFER_BYTES];
} Output;

/* stdio remembers a failed write until the file is committed. */
static void flush(Output *out) {
    XXH3_128bits_update(&out->digest, out->buffer, out->used);
    fwrite(out->buffer, 1, out->used, out->stream);
    out->used = 0;
}

static void put(Output *out, uint64_t value, int bytes) {
    if (out->used + 8 > BUFFER_BYTES) flush(out);
    for (int i = 0; i < bytes; i++) out->buffer[out->used++] = (uint8_t)(value >> (8 * i));
}

static void put_bytes(Output *out, const char *bytes, size_t count) {
    for (size_t i = 0; i < count; i++) put(out, (uint8_t)bytes[i], 1);
}

static void put_double(Output *out, double x) {
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    put(out, x != x ? UINT64_C(0x7ff8000000000000) : bits, 8);
}

static uint64_t text_section_bytes(const NphFilm *film) {
    uint64_t bytes = 0;
    for (int i = 0; i < film->text_count; i++) bytes += 8 + strlen(film->texts[i].name) + strlen(film->texts[i].text);
    return (bytes + 7) / 8 * 8;
}

static uint64_t node_bytes(const NphFilm *film) {
    uint64_t doubles = 0;
    for (int64_t tile = 0; tile < film->tile_count; tile++) {
        NphNode nodes[NPH_MAX_NODES];
        int origin[2], inside[4];
        nph_film_tile_rect(film, tile, origin, inside);
        doubles += (uint64_t)nph_film_tile_nodes(film, tile, nodes) * (uint64_t)film->values *
                   (uint64_t)((inside[2] - inside[0]) * (inside[3] - inside[1]));
    }
    return 8 * doubles;
}

static uint64_t payload_bytes(const NphFilm *film) {
    uint64_t bytes = node_bytes(film);
    for (int level = 0; level < NPH_REGION_LEVELS && nph_film_is_shared(film); level++)
        bytes += node_bytes(film->regions[level]);
    return bytes;
}

static void put_header(Output *out, const NphFilm *film) {
    uint64_t texts = text_section_bytes(film);
    put_bytes(out, NPH_PART_MAGIC, 8);
    put(out, (uint64_t)film->channels, 2);
    put(out, (uint64_t)nph_film_is_shared(film), 2);
    put(out, (uint64_t)film->text_count, 4);
    put(out, (uint64_t)film->width, 4);
    put(out, (uint64_t)film->height, 4);
    for (int i = 0; i < 4; i++) put(out, (uint64_t)film->crop[i], 4);
    put(out, (uint64_t)(film->chunk_begin * NPH_CHUNK), 8);
    put(out, (uint64_t)(film->chunk_end * NPH_CHUNK), 8);
    put(out, texts, 8);
    put(out, (uint64_t)film->tile_count, 8);
    put(out,
        NPH_PART_HEADER_BYTES + texts + (uint64_t)film->tile_count * NPH_PART_TILE_BYTES + payload_bytes(film) +
            NPH_PART_DIGEST_BYTES,
        8);
}

static void put_texts(Output *out, const NphFilm *film) {
    uint64_t written = 0;
    for (int i = 0; i < film->text_count; i++) {
        size_t name = strlen(film->texts[i].name), text = strlen(film->texts[i].text);
        put(out, name, 4);
        put(out, text, 4);
        put_bytes(out, film->texts[i].name, name);
        put_bytes(out, film->texts[i].text, text);
        written += 8 + name + text;
    }
    for (; written % 8 != 0; written++) put(out, 0, 1);
}

static void put_tile(Output *out, const NphFilm *film, int64_t tile) {
    const NphNonfinite *bad = &film->nonfinite[tile];
    put(out, (uint64_t)film->chunks[tile], 8);
    put(out, (uint64_t)bad->count, 8);
    put(out, (uint64_t)bad->x, 4);
    put(out, (uint64_t)bad->y, 4);
    put(out, (uint64_t)bad->sample, 8);
}

static void put_tile_nodes(Output *out, const NphFilm *film, int64_t tile) {
    NphNode nodes[NPH_MAX_NODES];
    int origin[2], inside[4], count = nph_film_tile_nodes(film, tile, nodes);
    nph_film_tile_rect(film, tile, origin, inside);
    for (int slot = 0; slot < count; slot++)
        for (int value = 0; value < film->values; value++) {
            const double *plane = nph_film_node(film, tile, slot) + value * NPH_TILE_PIXELS;
            for (int y = inside[1]; y < inside[3]; y++)
                for (int x = inside[0]; x < inside[2]; x++)
                    put_double(out, plane[(y - origin[1]) * NPH_TILE + x - origin[0]]);
        }
}

static void put_nodes(Output *out, const NphFilm *film) {
    for (int64_t tile = 0; tile < film->tile_count; tile++) put_tile_nodes(out, film, tile);
}

static void put_digest(Output *out) {
    XXH128_canonical_t canonical;
    flush(out);
    XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(&out->digest));
    fwrite(canonical.digest, 1, NPH_PART_DIGEST_BYTES, out->stream);
}

NphStatus nph_film_write_part(NphContext *context, const NphFilm *film, const char *path) {
    Output *out = NULL;
    NphWriter writer;
    NPH_TRY(NPH_NEW(context, 1, "part file buffer", &out));
    NphStatus status = nph_writer_open(context, path, &writer);
    if (status == NPH_OK) {
        out->stream = writer.stream;
        XXH3_128bits_reset(&out->digest);
        put_header(out, film);
        put_texts(out, film);
        for (int64_t tile = 0; tile < film->tile_count; tile++) put_tile(out, film, tile);
        put_nodes(out, film);
        for (int level = 0; level < NPH_REGION_LEVELS && nph_film_is_shared(film); level++)
            put_nodes(out, film->regions[level]);
        put_digest(out);
        status = nph_writer_commit(context, &writer);
    }
    nph_free(context, out);
    return status;
}
