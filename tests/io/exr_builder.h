/* SPDX-License-Identifier: Apache-2.0
 *
 * Builds small OpenEXR files byte by byte from the format's description (openexr.com, "OpenEXR File Layout"): kinds that
 * nph_exr_write does not make, and kinds that must be refused. Uncompressed samples only. */
#ifndef NPH_TESTS_EXR_BUILDER_H
#define NPH_TESTS_EXR_BUILDER_H

#include <check.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

typedef struct Bytes {
    unsigned char data[1 << 16];
    size_t size;
} Bytes;

static void put_bytes(Bytes *b, const void *from, size_t size) {
    ck_assert_uint_le(b->size + size, sizeof b->data);
    memcpy(b->data + b->size, from, size);
    b->size += size;
}

static void put_little(Bytes *b, uint64_t value, int bytes) {
    for (int i = 0; i < bytes; i++) {
        unsigned char byte = (unsigned char)(value >> 8 * i & 255);
        put_bytes(b, &byte, 1);
    }
}

static void put_int(Bytes *b, int64_t value) { put_little(b, (uint64_t)value & 0xffffffffu, 4); }
static void put_word(Bytes *b, const char *word) { put_bytes(b, word, strlen(word) + 1); }

static void put_float(Bytes *b, float value) {
    uint32_t bits;
    memcpy(&bits, &value, 4);
    put_little(b, bits, 4);
}

static void put_attribute(Bytes *b, const char *name, const char *type, int size) {
    put_word(b, name);
    put_word(b, type);
    put_int(b, size);
}

static void put_window(Bytes *b, const char *name, const int box[4]) {
    put_attribute(b, name, "box2i", 16);
    for (int i = 0; i < 4; i++) put_int(b, box[i]);
}

static void put_text_attribute(Bytes *b, const char *name, const char *text) {
    put_attribute(b, name, "string", (int)strlen(text));
    put_bytes(b, text, strlen(text));
}

typedef struct ExrHeader {
    const char *channel;
    int pixel_type; /* 0 uint, 1 half, 2 float */
    int sampling;
    int compression, line_order;
    int data[4], display[4];  /* xmin, ymin, xmax, ymax */
    const char *name, *type;  /* NULL: left out, as in single parts */
    int tile_size, tile_mode; /* 0 size: no tiles; mode 0 one level, 1 mip, 2 rip */
    int chunks, version;      /* 0: left out; version is 1 in deep parts */
} ExrHeader;

/* Attributes of one part and the zero byte that ends them. */
static void put_header(Bytes *b, const ExrHeader *h) {
    put_attribute(b, "channels", "chlist", (int)strlen(h->channel) + 1 + 16 + 1);
    put_word(b, h->channel);
    put_int(b, h->pixel_type);
    put_int(b, 0);
    put_int(b, h->sampling);
    put_int(b, h->sampling);
    put_little(b, 0, 1);
    put_attribute(b, "compression", "compression", 1);
    put_little(b, (uint64_t)h->compression, 1);
    put_window(b, "dataWindow", h->data);
    put_window(b, "displayWindow", h->display);
    put_attribute(b, "lineOrder", "lineOrder", 1);
    put_little(b, (uint64_t)h->line_order, 1);
    put_attribute(b, "pixelAspectRatio", "float", 4);
    put_float(b, 1);
    put_attribute(b, "screenWindowCenter", "v2f", 8);
    put_float(b, 0);
    put_float(b, 0);
    put_attribute(b, "screenWindowWidth", "float", 4);
    put_float(b, 1);
    if (h->name) put_text_attribute(b, "name", h->name);
    if (h->type) put_text_attribute(b, "type", h->type);
    if (h->tile_size) {
        put_attribute(b, "tiles", "tiledesc", 9);
        put_int(b, h->tile_size);
        put_int(b, h->tile_size);
        put_little(b, (uint64_t)h->tile_mode, 1);
    }
    if (h->version) {
        put_attribute(b, "version", "int", 4);
        put_int(b, h->version);
    }
    if (h->chunks) {
        put_attribute(b, "chunkCount", "int", 4);
        put_int(b, h->chunks);
    }
    put_little(b, 0, 1);
}

/* Magic and version 2; flags 0x200 one tiled part, 0x800 deep, 0x1000 several parts. */
static void put_magic(Bytes *b, uint32_t flags) {
    put_little(b, 20000630, 4);
    put_little(b, 2 | flags, 4);
}

static const char *save(const Bytes *b, const char *path) {
    FILE *file = fopen(path, "wb");
    ck_assert_ptr_nonnull(file);
    ck_assert_uint_eq(fwrite(b->data, 1, b->size, file), b->size);
    ck_assert_int_eq(fclose(file), 0);
    return path;
}

#endif
