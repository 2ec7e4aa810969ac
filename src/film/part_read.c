/* SPDX-License-Identifier: Apache-2.0
 *
 * Reading a part file. Nothing in it is trusted: every size is checked against the file's before anything is
 * allocated, then the digest, then every field against the ones it must agree with. A film that was read has room for
 * the nodes it has: it can be shown, written and merged, not added to. */
#include <string.h>
#include <xxhash.h>

#include "core/memory.h"
#include "core/message.h"
#include "film/part.h"
#include "film/shared.h"
#include "io/file.h"

typedef struct Input {
    NphContext *context;
    const char *path;
    const uint8_t *bytes;
    uint64_t size;
    NphFilm layout;
    int shared; /* pixels share samples */
    uint64_t text_count, text_bytes, tiles_at, nodes_at, digest_at;
} Input;

static uint64_t get(const Input *in, uint64_t at, int bytes) {
    uint64_t value = 0;
    for (int i = 0; i < bytes; i++) value |= (uint64_t)in->bytes[at + (uint64_t)i] << (8 * i);
    return value;
}

/* As a number in 0 .. limit; anything else (negative included) as limit + 1. */
static int64_t get_up_to(const Input *in, uint64_t at, int bytes, int64_t limit) {
    uint64_t value = get(in, at, bytes);
    return value > (uint64_t)limit ? limit + 1 : (int64_t)value;
}

static NphStatus bad(const Input *in, uint64_t at, const char *what) {
    return nph_error(in->context, NPH_BAD_INPUT, "%s: byte %llu: %s", in->path, (unsigned long long)at, what);
}

static NphStatus check_picture(Input *in) {
    const int limit = NPH_FILM_MAX_SIZE;
    int crop[4], channels = (int)get_up_to(in, NPH_PART_CHANNELS, 2, 3);
    int width = (int)get_up_to(in, NPH_PART_WIDTH, 4, limit), height = (int)get_up_to(in, NPH_PART_HEIGHT, 4, limit);
    if (channels != 1 && channels != 3) return bad(in, NPH_PART_CHANNELS, "the number of channels is neither 1 nor 3");
    in->shared = (int)get_up_to(in, NPH_PART_SHARED, 2, 1);
    if (in->shared > 1) return bad(in, NPH_PART_SHARED, "whether pixels share samples is neither 0 nor 1");
    if (width < 1 || width > limit) return bad(in, NPH_PART_WIDTH, "the width is not in 1 to 16777216");
    if (height < 1 || height > limit) return bad(in, NPH_PART_HEIGHT, "the height is not in 1 to 16777216");
    for (int i = 0; i < 4; i++) crop[i] = (int)get_up_to(in, (uint64_t)NPH_PART_CROP + 4 * (uint64_t)i, 4, limit);
    if (crop[0] >= crop[2] || crop[1] >= crop[3] || crop[2] > width || crop[3] > height)
        return bad(in, NPH_PART_CROP, "the crop is empty or not inside the picture");
    int64_t begin = get_up_to(in, NPH_PART_BEGIN, 8, NPH_FILM_MAX_SAMPLES);
    int64_t end = get_up_to(in, NPH_PART_END, 8, NPH_FILM_MAX_SAMPLES);
    if (begin > NPH_FILM_MAX_SAMPLES || begin % NPH_CHUNK)
        return bad(in, NPH_PART_BEGIN, "the first sample is not a multiple of 16 below 2^31");
    if (end > NPH_FILM_MAX_SAMPLES || end % NPH_CHUNK || end <= begin)
        return bad(in, NPH_PART_END, "the end of the samples is not a multiple of 16 above the first, below 2^31");
    nph_film_lay_out(&in->layout, width, height, crop, channels);
    in->layout.chunk_begin = begin / NPH_CHUNK;
    in->layout.chunk_end = end / NPH_CHUNK;
    return NPH_OK;
}

/* Sections lie one behind the other; what they take must leave the digest at the end. */
static NphStatus check_sections(Input *in) {
    uint64_t left = in->size - NPH_PART_HEADER_BYTES - NPH_PART_DIGEST_BYTES;
    if (get(in, NPH_PART_FILE_BYTES, 8) != in->size)
        return nph_error(in->context, NPH_BAD_INPUT, "%s: byte %d: says that the file has %llu bytes, but it has %llu",
                         in->path, NPH_PART_FILE_BYTES, (unsigned long long)get(in, NPH_PART_FILE_BYTES, 8),
                         (unsigned long long)in->size);
    in->digest_at = in->size - NPH_PART_DIGEST_BYTES;
    in->text_count = get(in, NPH_PART_TEXT_COUNT, 4);
    in->text_bytes = get(in, NPH_PART_TEXT_BYTES, 8);
    if (in->text_bytes % 8 != 0 || in->text_bytes > left)
        return bad(in, NPH_PART_TEXT_BYTES, "the texts are longer than the file, or not a multiple of 8");
    if (in->text_count > in->text_bytes / 8 || in->text_count > NPH_FILM_MAX_TEXTS)
        return bad(in, NPH_PART_TEXT_COUNT, "more texts than their bytes can hold, or more than 1024");
    left -= in->text_bytes;
    in->tiles_at = NPH_PART_HEADER_BYTES + in->text_bytes;
    if (get(in, NPH_PART_TILES, 8) != (uint64_t)in->layout.tile_count)
        return bad(in, NPH_PART_TILES, "the number of tiles does not fit the crop");
    if ((uint64_t)in->layout.tile_count > left / NPH_PART_TILE_BYTES)
        return bad(in, NPH_PART_TILES, "more tiles than the file can hold");
    in->nodes_at = in->tiles_at + (uint64_t)in->layout.tile_count * NPH_PART_TILE_BYTES;
    return NPH_OK;
}

static NphStatus check_tile(const Input *in, int64_t tile, uint64_t at) {
    const NphFilm *film = &in->layout;
    int origin[2], inside[4];
    nph_film_tile_rect(film, tile, origin, inside);
    int64_t chunks = get_up_to(in, at, 8, film->chunk_end - film->chunk_begin);
    if (chunks > film->chunk_end - film->chunk_begin)
        return bad(in, at, "a tile has more samples than the part's range");
    int64_t samples = chunks * NPH_CHUNK, all = samples * (inside[2] - inside[0]) * (inside[3] - inside[1]);
    int64_t count = get_up_to(in, at + 8, 8, all), first = film->chunk_begin * NPH_CHUNK;
    if (count > all) return bad(in, at + 8, "a tile has more samples that are not finite than samples");
    int64_t x = get_up_to(in, at + 16, 4, film->width), y = get_up_to(in, at + 20, 4, film->height);
    int64_t sample = get_up_to(in, at + 24, 8, NPH_FILM_MAX_SAMPLES);
    int none = count == 0 && x == 0 && y == 0 && sample == 0;
    int some = count > 0 && x >= inside[0] && x < inside[2] && y >= inside[1] && y < inside[3] && sample >= first &&
               sample < first + samples;
    return none || some ? NPH_OK : bad(in, at + 16, "the sample named as not finite is not in its tile");
}

/* Bytes of the nodes of a tile with so many chunks. */
static uint64_t tile_bytes(const NphFilm *film, int64_t tile, int nodes) {
    int origin[2], inside[4];
    nph_film_tile_rect(film, tile, origin, inside);
    return 8 * (uint64_t)nodes * (uint64_t)film->values * (uint64_t)((inside[2] - inside[0]) * (inside[3] - inside[1]));
}

/* Where pixels share samples all tiles have as many, and the nodes of the regions' means follow. */
static NphStatus check_regions(const Input *in, uint64_t *at) {
    const NphFilm *film = &in->layout;
    for (int64_t tile = 1; tile < film->tile_count; tile++) {
        uint64_t entry = in->tiles_at + (uint64_t)tile * NPH_PART_TILE_BYTES;
        if (get(in, entry, 8) != get(in, in->tiles_at, 8))
            return bad(in, entry, "pixels share samples, but the tiles have unequal numbers of them");
    }
    NphNode nodes[NPH_MAX_NODES];
    int count = nph_tree_nodes(film->chunk_begin, film->chunk_begin + (int64_t)get(in, in->tiles_at, 8), nodes);
    for (int level = 0; level < NPH_REGION_LEVELS; level++) {
        NphFilm coarse;
        nph_shared_lay_out(film, level, &coarse);
        for (int64_t tile = 0; tile < coarse.tile_count; tile++) *at += tile_bytes(&coarse, tile, count);
    }
    if (*at > in->digest_at) return bad(in, in->tiles_at, "the nodes of the regions' means are larger than the file");
    return NPH_OK;
}

/* Checks the tiles; their nodes must fill the file up to its digest. */
static NphStatus check_tiles(Input *in) {
    NphFilm *film = &in->layout;
    uint64_t at = in->nodes_at;
    film->slots = 1;
    for (int64_t tile = 0; tile < film->tile_count; tile++) {
        uint64_t entry = in->tiles_at + (uint64_t)tile * NPH_PART_TILE_BYTES;
        NPH_TRY(check_tile(in, tile, entry));
        NphNode nodes[NPH_MAX_NODES];
        int count = nph_tree_nodes(film->chunk_begin, film->chunk_begin + (int64_t)get(in, entry, 8), nodes);
        if (count > film->slots) film->slots = count;
        at += tile_bytes(film, tile, count);
        if (at > in->digest_at) return bad(in, entry, "from this tile on, the nodes are larger than the file");
    }
    if (in->shared) NPH_TRY(check_regions(in, &at));
    return at == in->digest_at ? NPH_OK : bad(in, at, "bytes between the last node and the digest");
}

static NphStatus check_digest(const Input *in) {
    XXH128_canonical_t canonical;
    XXH128_canonicalFromHash(&canonical, XXH3_128bits(in->bytes, (size_t)in->digest_at));
    if (memcmp(canonical.digest, in->bytes + in->digest_at, NPH_PART_DIGEST_BYTES) == 0) return NPH_OK;
    return bad(in, in->digest_at, "the digest is not that of the bytes before it: the file is damaged");
}

static NphStatus check_file(Input *in) {
    if (in->size < 8 || memcmp(in->bytes, NPH_PART_MAGIC, 8) != 0)
        return bad(in, 0, "is no part file, which begins with " NPH_PART_MAGIC);
    if (in->size < NPH_PART_HEADER_BYTES + NPH_PART_DIGEST_BYTES)
        return bad(in, in->size, "the file ends within its header");
    NPH_TRY(check_picture(in));
    NPH_TRY(check_sections(in));
    NPH_TRY(check_digest(in));
    return check_tiles(in);
}

/* One text at *at, which moves behind it. */
static NphStatus read_text(const Input *in, uint64_t *at, NphFilm *film) {
    if (in->tiles_at - *at < 8) return bad(in, *at, "a text begins beyond the end of the texts");
    uint64_t name_bytes = get(in, *at, 4), text_bytes = get(in, *at + 4, 4), begin = *at + 8;
    if (name_bytes + text_bytes > in->tiles_at - begin) return bad(in, *at, "a text is longer than the texts");
    const char *name = (const char *)in->bytes + begin, *text = name + name_bytes;
    if (name_bytes == 0) return bad(in, *at, "a text without a name");
    if (memchr(name, 0, (size_t)(name_bytes + text_bytes))) return bad(in, begin, "a zero byte inside a text");
    char *copy = NULL;
    NPH_TRY(NPH_NEW(in->context, name_bytes + text_bytes + 2, "text", &copy));
    memcpy(copy, name, (size_t)name_bytes);
    memcpy(copy + name_bytes + 1, text, (size_t)text_bytes);
    NphStatus status =
        nph_film_text(film, copy) ? NPH_BAD_USAGE : nph_film_set_text(in->context, film, copy, copy + name_bytes + 1);
    if (status == NPH_BAD_USAGE)
        status = bad(in, *at, "a text whose name occurs twice, or that cannot stand in a film");
    nph_free(in->context, copy);
    *at = begin + name_bytes + text_bytes;
    return status;
}

static NphStatus read_texts(const Input *in, NphFilm *film) {
    uint64_t at = NPH_PART_HEADER_BYTES;
    for (uint64_t i = 0; i < in->text_count; i++) NPH_TRY(read_text(in, &at, film));
    if (in->tiles_at - at >= 8) return bad(in, at, "bytes between the last text and the tiles");
    for (; at < in->tiles_at; at++)
        if (in->bytes[at] != 0) return bad(in, at, "the padding behind the texts is not zero");
    return NPH_OK;
}

static void read_tile(const Input *in, NphFilm *film, int64_t tile) {
    uint64_t entry = in->tiles_at + (uint64_t)tile * NPH_PART_TILE_BYTES;
    film->chunks[tile] = (int64_t)get(in, entry, 8);
    film->nonfinite[tile] = (NphNonfinite){(int64_t)get(in, entry + 8, 8), (int)get(in, entry + 16, 4),
                                           (int)get(in, entry + 20, 4), (int64_t)get(in, entry + 24, 8)};
}

static void read_nodes(const Input *in, NphFilm *film, int64_t tile, uint64_t *at) {
    NphNode nodes[NPH_MAX_NODES];
    int origin[2], inside[4];
    nph_film_tile_rect(film, tile, origin, inside);
    int count = nph_film_tile_nodes(film, tile, nodes);
    for (int plane = 0; plane < count * film->values; plane++)
        for (int y = inside[1]; y < inside[3]; y++)
            for (int x = inside[0]; x < inside[2]; x++, *at += 8) {
                uint64_t bits = get(in, *at, 8);
                int pixel = (y - origin[1]) * NPH_TILE + x - origin[0];
                memcpy(nph_film_node(film, tile, 0) + plane * NPH_TILE_PIXELS + pixel, &bits, sizeof bits);
            }
}

static void read_regions(const Input *in, NphFilm *film, uint64_t *at) {
    for (int level = 0; level < NPH_REGION_LEVELS; level++) {
        NphFilm *coarse = film->regions[level];
        for (int64_t tile = 0; tile < coarse->tile_count; tile++) {
            coarse->chunks[tile] = film->chunks[0];
            read_nodes(in, coarse, tile, at);
        }
    }
}

static NphStatus read_film(Input *in, NphFilm **film) {
    NphFilm *made = NULL;
    NPH_TRY(check_file(in));
    NPH_TRY(nph_film_make(in->context, &in->layout, &made));
    NphStatus status = read_texts(in, made);
    if (status == NPH_OK && in->shared) status = nph_shared_make(in->context, made);
    if (status != NPH_OK) {
        nph_film_free(in->context, made);
        return status;
    }
    uint64_t at = in->nodes_at;
    for (int64_t tile = 0; tile < made->tile_count; tile++) read_tile(in, made, tile);
    for (int64_t tile = 0; tile < made->tile_count; tile++) read_nodes(in, made, tile, &at);
    if (in->shared) read_regions(in, made, &at);
    *film = made;
    return NPH_OK;
}

NphStatus nph_film_read_part(NphContext *context, const char *path, NphFilm **film) {
    Input in = {.context = context, .path = path};
    char *bytes = NULL;
    size_t size = 0;
    NPH_TRY(nph_file_read(context, path, &bytes, &size));
    in.bytes = (const uint8_t *)bytes;
    in.size = size;
    NphStatus status = read_film(&in, film);
    nph_free(context, bytes);
    return status;
}
