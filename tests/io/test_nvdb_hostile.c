/* SPDX-License-Identifier: Apache-2.0
 *
 * Damaged, cut and malicious NanoVDB files: refused with the path and the byte, or read to a sound volume where nothing
 * in the file can tell; never a crash, a leak, a hang, or memory out of proportion. Also types and versions of which no
 * sample exists. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <unistd.h>

#include "core/memory.h"
#include "io/volume.h"
#include "nvdb_build.h"

/* xorshift64: the same files on every run. */
static uint64_t random_state;
static uint64_t next_random(void) {
    random_state ^= random_state << 13;
    random_state ^= random_state >> 7;
    return random_state ^= random_state << 17;
}

static NphContext *open_limited(uint64_t bytes) {
    NphContext *context = nph_test_context(1);
    nph_context_close(context); /* for the recorder of messages alone */
    NphSettings settings;
    nph_settings_default(&settings);
    settings.threads = 1;
    settings.memory_limit_bytes = bytes;
    ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
    return context;
}

/* What every consumer relies on, whatever the file. */
static void is_sound(const NphVolume *volume) {
    uint64_t active = 0;
    for (int64_t i = 0; i < volume->leaf_count; i++) {
        const NphLeaf *leaf = &volume->leaves[i];
        for (int axis = 0; axis < 3; axis++) ck_assert_int_eq(leaf->origin[axis] & 7, 0);
        for (int n = 0; n < NPH_LEAF_VOXELS; n++) active += leaf->active[n >> 6] >> (n & 63) & 1;
        if (i) ck_assert_mem_ne(leaf[-1].origin, leaf->origin, sizeof leaf->origin);
    }
    for (int64_t i = 0; i < volume->tile_count; i++) {
        int64_t size = volume->tiles[i].size;
        ck_assert(size == 8 || size == 128 || size == 4096);
        if (volume->tiles[i].active) active += (uint64_t)(size * size * size);
    }
    ck_assert_uint_eq(active, volume->active_voxels);
    for (int i = 0; i < 12; i++) ck_assert(isfinite(volume->world_from_index[i]));
}

/* Overwrites part of a stored file: cheaper than storing it anew for every flip. */
static void patch(const char *path, size_t at, const unsigned char *bytes, size_t size) {
    FILE *file = fopen(path, "r+b");
    ck_assert_ptr_nonnull(file);
    ck_assert_int_eq(fseek(file, (long)at, SEEK_SET), 0);
    ck_assert_uint_eq(fwrite(bytes, 1, size, file), size);
    ck_assert_int_eq(fclose(file), 0);
}

/* Reads a grid (NULL: the default) and lists the file; returns the status of the read. */
static NphStatus try_read(NphContext *context, const char *path, const char *grid) {
    NphVolume volume;
    static int calls;
    NphGridInfo *grids = NULL;
    int count = 0; /* the list shares its checks with the read, so now and then is enough */
    if (calls++ % 8 == 0 && nph_nvdb_list(context, path, &grids, &count) == NPH_OK) nph_free(context, grids);
    NphStatus status = nph_nvdb_read(context, path, grid, &volume);
    ck_assert_msg(status == NPH_OK || status == NPH_BAD_INPUT, "status %d", (int)status);
    if (status == NPH_OK) {
        is_sound(&volume);
        nph_volume_free(context, &volume);
    }
    ck_assert_uint_eq(nph_context_bytes(context), 0);
    return status;
}

/* The read is refused and the message has the path and these words. */
static void refused(const char *path, const char *words) {
    NphContext *context = nph_test_context(1);
    NphStatus status = try_read(context, path, NULL);
    const char *messages = nph_test_messages();
    ck_assert_msg(status == NPH_BAD_INPUT, "was read; expected: %s", words);
    ck_assert_msg(strstr(messages, path) && strstr(messages, words), "no '%s' in: %s", words, messages);
    nph_test_context_close(context);
}

static void refused_build(Built *built, const char *words) {
    refused(store("built.nvdb", built->file, built->size), words);
    free(built->file);
}

/* ---- what is not in the sample files ---- */

static NphVolume read_build(NphContext *context, Built *built) {
    NphVolume volume = {0};
    const char *path = store("built.nvdb", built->file, built->size);
    NphStatus status = nph_nvdb_read(context, path, NULL, &volume);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    is_sound(&volume);
    free(built->file);
    return volume;
}

START_TEST(half_values_of_every_kind_are_exact) {
    static const uint16_t bits[] = {0x0000, 0x8000, 0x3c00, 0xc000, 0x0001, 0x83ff, 0x0400, 0x7bff,
                                    0x7c00, 0xfc00, 0x3555};
    static const float values[] = {0, -0.0f, 1, -2, 5.9604644775390625e-8f, -6.0975551605224609e-5f, 6.103515625e-5f,
                                   65504, INFINITY, -INFINITY, 0.333251953125f};
    NphContext *context = nph_test_context(1);
    Built built = build(BUILD_HALF, 1120, 1);
    for (int i = 0; i < 11; i++) put_u16(built.grid + built.leaf + LEAF_TABLE + 2 * i, bits[i]);
    put_u16(built.grid + built.leaf + LEAF_TABLE + 22, 0x7e01);
    put_u16(built.grid + ROOT_AT + 28, 0x3800); /* background 0.5 */
    seal(&built, 1, 0);
    NphVolume volume = read_build(context, &built);
    ck_assert_str_eq(volume.type, "half");
    ck_assert(volume.background == 0.5f);
    for (int i = 0; i < 11; i++) ck_assert_mem_eq(&volume.leaves[0].values[i], &values[i], sizeof(float));
    ck_assert(isnan(volume.leaves[0].values[11]));
    nph_volume_free(context, &volume);
    nph_test_context_close(context);
}
END_TEST

START_TEST(variable_codes_of_every_width_are_unpacked) {
    NphContext *context = nph_test_context(1);
    for (uint32_t log_bits = 0; log_bits <= 5; log_bits++) {
        uint32_t bits = 1u << log_bits;
        Built built = build(BUILD_FPN, 96 + 64 * bits, 1);
        unsigned char *leaf = built.grid + built.leaf;
        leaf[15] = (unsigned char)(log_bits << 5);
        put_f32(leaf + 80, -1.0f);
        put_f32(leaf + 84, 0.25f);
        for (uint32_t n = 0; n < 512 && bits <= 16; n++) {
            uint32_t code = (n * 2654435761u >> 8) & ((1u << bits) - 1u), at = n * bits;
            for (uint32_t b = 0; b < bits; b++)
                leaf[96 + ((at + b) >> 3)] |= (unsigned char)((code >> b & 1u) << ((at + b) & 7));
        }
        seal(&built, 1, 0);
        if (log_bits == 5) {
            refused_build(&built, "the leaf's codes exceed the grid"); /* 32 bits do not exist */
            continue;
        }
        NphVolume volume = read_build(context, &built);
        for (uint32_t n = 0; n < 512; n++) {
            float code = (float)((n * 2654435761u >> 8) & ((1u << bits) - 1u));
            ck_assert(volume.leaves[0].values[n] == code * 0.25f - 1.0f);
        }
        nph_volume_free(context, &volume);
    }
    Built built = build(BUILD_FPN, 96 + 64, 1);
    built.grid[built.leaf + 15] = 3 << 5; /* eight bits announced, one there */
    seal(&built, 1, 0);
    refused_build(&built, "the leaf's codes exceed the grid");
    nph_test_context_close(context);
}
END_TEST

START_TEST(later_versions_are_read_and_their_checksums_checked) {
    NphContext *context = nph_test_context(1);
    for (int damage = 0; damage < 3; damage++) {
        Built built = build(BUILD_FLOAT, 2144, 3);
        memcpy(built.file, "NanoVDB2", 8);
        memcpy(built.grid, "NanoVDB1", 8);
        put_u32(built.file + 8, 32u << 21 | 7u << 10);
        put_u32(built.grid + VERSION_AT, 32u << 21 | 7u << 10);
        put_f32(built.grid + built.leaf + LEAF_TABLE, 0.75f);
        seal(&built, 3, 1);
        if (damage == 1) built.grid[built.leaf + LEAF_TABLE + 40] ^= 1;
        if (damage == 2) built.grid[41] ^= 1; /* the grid's name */
        if (damage == 1) refused_build(&built, "the checksum of the nodes does not match");
        else if (damage == 2) refused_build(&built, "the checksum of the grid's header does not match");
        if (damage) continue;
        NphVolume volume = read_build(context, &built);
        ck_assert(volume.leaves[0].values[0] == 0.75f);
        ck_assert_int_eq(volume.tile_count, 2);
        ck_assert_int_eq(volume.tiles[1].origin[0], 8192);
        nph_volume_free(context, &volume);
    }
    nph_test_context_close(context);
}
END_TEST

/* ---- trees that lie ---- */

START_TEST(a_leaf_reached_twice_is_refused_so_that_small_files_stay_small) {
    Built built = build(BUILD_FLOAT, 2144, 1);
    for (int n = 0; n < 4096; n++) {
        built.grid[built.lower + LOWER_CHILDREN + n / 8] |= (unsigned char)(1 << n % 8);
        put_u64(built.grid + built.lower + LOWER_TABLE + 8 * n, LOWER_BYTES);
    }
    seal(&built, 1, 0);
    refused_build(&built, "the tree holds more leaves than the 1 announced");
    built = build(BUILD_FLOAT, 2144, 1);
    for (int n = 0; n < 32768; n++) {
        built.grid[built.upper + UPPER_CHILDREN + n / 8] |= (unsigned char)(1 << n % 8);
        put_u64(built.grid + built.upper + UPPER_TABLE + 8 * n, UPPER_BYTES);
    }
    seal(&built, 1, 0);
    refused_build(&built, "the tree holds more lower nodes than announced");
}
END_TEST

START_TEST(roots_with_one_key_twice_or_children_outside_are_refused) {
    static const uint64_t offsets[] = {UINT64_MAX, (uint64_t)1 << 63, (uint64_t)1 << 40, UPPER_BYTES + LOWER_BYTES - 8};
    Built built = build(BUILD_FLOAT, 2144, 4);
    put_u64(built.grid + ROOT_TILE_AT + 3 * ROOT_TILE_BYTES, (uint64_t)1 << 42);
    seal(&built, 4, 0);
    refused_build(&built, "two entries of the root have one key");
    built = build(BUILD_FLOAT, 2144, 2);
    put_u64(built.grid + ROOT_TILE_AT + ROOT_TILE_BYTES, (uint64_t)1 << 20);
    seal(&built, 2, 0);
    refused_build(&built, "the root's entry 1 has no valid key");
    for (int i = 0; i < 4; i++) {
        built = build(BUILD_FLOAT, 2144, 1);
        put_u64(built.grid + ROOT_TILE_AT + 8, offsets[i]);
        seal(&built, 1, 0);
        refused_build(&built, i == 0 ? "grid 'density', byte" : "a child node lies outside the grid");
        built = build(BUILD_FLOAT, 2144, 1);
        put_u64(built.grid + built.upper + UPPER_TABLE, offsets[i]);
        seal(&built, 1, 0);
        refused_build(&built, "grid 'density', byte");
        built = build(BUILD_FLOAT, 2144, 1);
        put_u64(built.grid + built.lower + LOWER_TABLE, i < 3 ? offsets[i] : LOWER_BYTES + 1);
        seal(&built, 1, 0);
        refused_build(&built, "grid 'density', byte");
    }
}
END_TEST

START_TEST(contradictions_between_header_and_nodes_are_refused) {
    Built built = build(BUILD_FLOAT, 2144, 1);
    put_u32(built.grid + built.leaf, 8);
    seal(&built, 1, 0);
    refused_build(&built, "the leaf at (0, 0, 0) says that it is elsewhere");
    built = build(BUILD_FLOAT, 2144, 1);
    built.grid[built.leaf + LEAF_MASK + 5] = 254;
    seal(&built, 1, 0);
    refused_build(&built, "512 active voxels are announced, but the masks hold 511");
    built = build(BUILD_FLOAT, 2144, 1);
    put_u32(built.grid + FLAGS_AT, 2); /* has a box, which is 0 to 0 here */
    seal(&built, 1, 0);
    refused_build(&built, "the active box is announced as 0 to 0 along x, but the masks span 0 to 7");
    built = build(BUILD_FLOAT, 2144, 1);
    put_u32(built.grid + FLAGS_AT, 4); /* has ranges, all 0 here */
    put_f32(built.grid + built.leaf + LEAF_TABLE + 4 * 83, 2.5f);
    seal(&built, 1, 0);
    refused_build(&built, "voxel (1, 2, 3) holds 2.5, outside the range its leaf states");
    built = build(BUILD_FLOAT, 2144, 1);
    put_u32(built.grid + FLAGS_AT, 4 | 8); /* has averages, all 0 here */
    put_f32(built.grid + built.leaf + 84, 1.0f); /* the leaf's maximum */
    put_f32(built.grid + built.leaf + LEAF_TABLE + 4 * 83, 0.01f);
    seal(&built, 1, 0);
    refused_build(&built, "the leaf at (0, 0, 0) do not have the average it states");
    built = build(BUILD_FLOAT, 2144, 2);
    put_u32(built.grid + FLAGS_AT, 4); /* the root's range is 0 to 0, its tile holds 1 */
    seal(&built, 2, 0);
    refused_build(&built, "the tile at (4096, 0, 0) holds a value outside the range the root states");
    built = build(BUILD_FLOAT, 2144, 1);
    put_u32(built.grid + COUNTS_AT, 0);
    seal(&built, 1, 0);
    refused_build(&built, "the tree holds more leaves than the 0 announced");
    built = build(BUILD_FLOAT, 2 * 2144, 1);
    put_u32(built.grid + COUNTS_AT, 2);
    seal(&built, 1, 0);
    refused_build(&built, "the tree announces 2 leaves");
    built = build(BUILD_FLOAT, 2144, 1);
    for (int i = 0; i < 3; i++) put_f64(built.grid + MAP_AT + 32 * i, i == 1 ? 0.0 : 1.0);
    seal(&built, 1, 0);
    refused_build(&built, "not invertible");
    built = build(BUILD_FLOAT, 2144, 1);
    put_f64(built.grid + MAP_AT + 144, NAN);
    seal(&built, 1, 0);
    refused_build(&built, "not invertible");
}
END_TEST

/* Every field of the container, grid, tree and root, and the heads of the nodes, set to the values that overflow. */
START_TEST(huge_and_negative_fields_are_refused_or_harmless) {
    static const uint64_t words[] = {0, 1, 0x7fffffffu, 0x80000000u, 0xffffffffu, 0x7fffffffffffffffu,
                                     0x8000000000000000u, UINT64_MAX - 31};
    Built built = build(BUILD_FLOAT, 2144, 2);
    seal(&built, 2, 0);
    NphContext *context = open_limited(32 << 20);
    const char *path = store("fields.nvdb", built.file, built.size);
    const size_t ranges[][2] = {{0, GRID_AT + 40}, {GRID_AT + MAP_AT, GRID_AT + MAP_AT + 8},
                                {GRID_AT + MAP_AT + 144, GRID_AT + MAP_AT + 152},
                                {GRID_AT + 560, GRID_AT + built.upper + 40},
                                {GRID_AT + built.upper + UPPER_CHILDREN, GRID_AT + built.upper + UPPER_CHILDREN + 8},
                                {GRID_AT + built.lower, GRID_AT + built.lower + 40},
                                {GRID_AT + built.leaf, GRID_AT + built.leaf + 32}};
    int read = 0, all = 0;
    for (int r = 0; r < 7; r++)
        for (size_t at = ranges[r][0]; at + 8 <= ranges[r][1]; at += 4)
            for (int w = 0; w < 8; w++) {
                unsigned char before[8];
                if (w >= 5 && at % 8) continue;
                memcpy(before, built.file + at, 8);
                if (w < 5) put_u32(built.file + at, (uint32_t)words[w]);
                else put_u64(built.file + at, words[w]);
                if (at < GRID_AT + CHECKSUM_AT || at >= GRID_AT + 16) seal(&built, 2, 0);
                patch(path, at, built.file + at, 8);
                if (at >= GRID_AT + 16) patch(path, GRID_AT + CHECKSUM_AT, built.grid + CHECKSUM_AT, 8);
                read += try_read(context, path, NULL) == NPH_OK;
                all++;
                memcpy(built.file + at, before, 8);
                patch(path, at, before, 8);
            }
    ck_assert_int_gt(read, 0);
    ck_assert_int_lt(read, all);
    ck_assert_uint_lt(nph_context_peak_bytes(context), 4 << 20);
    nph_context_close(context);
    free(built.file);
}
END_TEST

/* ---- damage to the sample files ---- */

static const char *const samples[][2] = {{"reference/data/smoke/smoke_0024.none.nvdb", NULL},
                                         {"reference/data/smoke/smoke_0024.zip.nvdb", NULL},
                                         {"reference/data/smoke/smoke_0024.blosc.nvdb", NULL},
                                         {"reference/data/smoke/smoke_0048.fpN.nvdb", NULL},
                                         {"reference/data/tiles/tiles.zip.nvdb", "tiles"}};
enum { SAMPLES = 5, FLIPS = 500, CUTS = 100 };

START_TEST(every_cut_is_refused_with_the_byte) {
    size_t size;
    unsigned char *bytes = load(nph_test_path(samples[_i][0]), &size);
    NphContext *context = nph_test_context(1);
    const char *path = store("cut.nvdb", bytes, size);
    for (size_t n = 0; n < 2 * CUTS; n++) { /* falling: first over the whole file, then byte by byte in its head */
        size_t cut = n < CUTS ? (size - 1) - n * (size - 500) / CUTS : 3 * (2 * CUTS - 1 - n);
        ck_assert_int_eq(truncate(path, (off_t)cut), 0);
        ck_assert_msg(try_read(context, path, samples[_i][1]) == NPH_BAD_INPUT, "cut at %zu was read", cut);
        const char *messages = nph_test_messages();
        ck_assert_ptr_nonnull(strstr(messages, path));
        ck_assert_ptr_nonnull(strstr(messages, cut ? "byte" : "is empty"));
    }
    nph_test_context_close(context);
    free(bytes);
}
END_TEST

/* Zip data carry a checksum of all bytes: a flip is refused, or it hit a field of the description that is not used.
 * Elsewhere a flipped value can only be refused where it leaves its leaf's range. */
START_TEST(flipped_bits_are_refused_or_give_a_sound_volume) {
    size_t size;
    unsigned char *bytes = load(nph_test_path(samples[_i][0]), &size);
    NphContext *context = open_limited(64 << 20);
    random_state = 88172645463325252u + (uint64_t)_i;
    const char *path = store("flip.nvdb", bytes, size);
    int read = 0, zip = strstr(samples[_i][0], ".zip.") != NULL;
    for (int n = 0; n < FLIPS; n++) {
        /* half of them where the structure is: the description and the first node */
        size_t bit = next_random() % (8 * (n % 2 || zip ? size : 2048));
        bytes[bit >> 3] ^= (unsigned char)(1 << (bit & 7));
        patch(path, bit >> 3, bytes + (bit >> 3), 1);
        int good = try_read(context, path, samples[_i][1]) == NPH_OK;
        if (good && zip && !samples[_i][1]) ck_assert_msg(bit >> 3 < 2048, "a flip at byte %zu was not seen", bit >> 3);
        read += good;
        bytes[bit >> 3] ^= (unsigned char)(1 << (bit & 7));
        patch(path, bit >> 3, bytes + (bit >> 3), 1);
    }
    ck_assert_int_lt(read, FLIPS);
    ck_assert_uint_lt(nph_context_peak_bytes(context), 12 << 20);
    nph_context_close(context);
    free(bytes);
}
END_TEST

/* The sizes and the header of the packed data, which stand behind the description of the only grid. */
START_TEST(packed_blocks_that_lie_are_refused) {
    enum { BLOCK_SIZE_AT = GRID_AT, BLOCK_AT = GRID_AT + 8 };
    static const struct {
        const char *file;
        size_t at;
        int bytes;
        uint64_t value;
        const char *words;
    } cases[] = {{"blosc", BLOCK_SIZE_AT, 8, UINT64_MAX, "byte 200: a blosc block exceeds its grid"},
                 {"blosc", BLOCK_SIZE_AT, 8, 154142, "byte 200: a blosc block exceeds its grid"},
                 {"blosc", BLOCK_SIZE_AT, 8, 15, "byte 208: the blosc block is damaged"},
                 {"blosc", BLOCK_AT + 2, 1, 0x41, "byte 208: the blosc block is damaged"}, /* snappy */
                 {"blosc", BLOCK_AT + 4, 4, 613823, "byte 208: the blosc block is damaged"},
                 {"blosc", BLOCK_AT + 8, 4, 0, "byte 208: the blosc block is damaged"},
                 {"blosc", BLOCK_AT + 12, 4, 0x7fffffff, "byte 208: the blosc block is damaged"},
                 {"blosc", META_AT, 8, 613824 * 2, "byte 208: the blosc block is damaged"},
                 {"blosc", META_AT, 8, (uint64_t)1 << 62, "byte 16: 154149 bytes of blosc data cannot unpack to"},
                 {"zip", META_AT, 8, (uint64_t)1 << 40, "byte 16: 130675 bytes of zip data cannot unpack to"},
                 {"zip", META_AT, 8, 613823, "byte 208: the zip data are damaged"},
                 {"zip", META_AT, 8, 613825, "byte 208: the zip data unpack to another size"},
                 {"zip", BLOCK_SIZE_AT, 8, 130666, "byte 200: the size of the zip data does not agree"},
                 {"zip", META_AT + 8, 8, 7, "byte 16: 7 bytes of zip data cannot unpack to"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char relative[64];
        size_t size;
        snprintf(relative, sizeof relative, "reference/data/smoke/smoke_0024.%s.nvdb", cases[i].file);
        unsigned char *bytes = load(nph_test_path(relative), &size);
        for (int b = 0; b < cases[i].bytes; b++) bytes[cases[i].at + (size_t)b] = (unsigned char)(cases[i].value >> 8 * b);
        if (cases[i].at == META_AT + 8) size = GRID_AT + 7;
        refused(store("packed.nvdb", bytes, size), cases[i].words);
        free(bytes);
    }
}
END_TEST

START_TEST(garbage_is_refused) {
    unsigned char *bytes = malloc(70000);
    NphContext *context = open_limited(8 << 20);
    random_state = 1;
    for (int n = 0; n < 300; n++) {
        size_t size = next_random() % (n % 3 ? 400 : 70000);
        for (size_t i = 0; i < size; i++) bytes[i] = (unsigned char)next_random();
        if (size > 16 && n % 2) {
            memcpy(bytes, "NanoVDB0", 8);
            put_u32(bytes + 8, 32u << 21);
            put_u16(bytes + 14, (uint32_t)n % 4);
        }
        ck_assert_int_eq(try_read(context, store("garbage.nvdb", bytes, size), NULL), NPH_BAD_INPUT);
    }
    nph_context_close(context);
    free(bytes);
    refused(store("words.nvdb", (const unsigned char *)"a text, no volume", 17), "no NanoVDB segment starts here");
    refused(store("vdb.nvdb", (const unsigned char *)" BDV\0\0\0\0\340\0\0\0\x0a\0\0\0", 16), "is an OpenVDB file");
    refused(store("big.nvdb", (const unsigned char *)"0BDVonaN\4\0\4\2\0\1\0\0", 16), "big-endian");
    refused(store("old.nvdb", (const unsigned char *)"NanoVDB0\2\4\240\3\1\0\0\0", 16), "NanoVDB version 29");
    refused(store("none.nvdb", (const unsigned char *)"", 0), "is empty");
    refused(nph_test_temporary("missing.nvdb"), "No such file");
    refused(nph_test_temporary(""), "is a folder");
}
END_TEST

/* Names are shown without control characters and matched in full. */
START_TEST(names_cannot_write_to_a_terminal) {
    Built built = build(BUILD_FLOAT, 2144, 1);
    memcpy(built.file + NAME_AT, "\x1b[2Jabc", 7);
    seal(&built, 1, 0);
    built.grid[0] = 'X';
    refused_build(&built, "grid '?[2Jabc', byte 200: no NanoVDB grid starts here");
}
END_TEST

START_TEST(files_in_a_row_are_one_file_with_several_segments) {
    Built one = build(BUILD_FLOAT, 2144, 1), two = build(BUILD_FLOAT, 2144, 1);
    memcpy(two.file + NAME_AT, "flamed", 7);
    put_f32(two.grid + two.leaf + LEAF_TABLE, 3.0f);
    seal(&one, 1, 0);
    seal(&two, 1, 0);
    unsigned char *both = malloc(one.size + two.size + 5);
    memcpy(both, one.file, one.size);
    memcpy(both + one.size, two.file, two.size);
    memcpy(both + one.size + two.size, "tail.", 5);
    NphContext *context = nph_test_context(1);
    const char *path = store("both.nvdb", both, one.size + two.size);
    NphVolume volume;
    ck_assert_int_eq(nph_nvdb_read(context, path, NULL, &volume), NPH_OK);
    ck_assert(volume.leaves[0].values[0] == 0.0f);
    nph_volume_free(context, &volume);
    ck_assert_int_eq(nph_nvdb_read(context, path, "flamed", &volume), NPH_OK);
    ck_assert(volume.leaves[0].values[0] == 3.0f);
    nph_volume_free(context, &volume);
    ck_assert_int_eq(nph_nvdb_read(context, path, "flame", &volume), NPH_BAD_INPUT);
    memcpy(both + one.size + NAME_AT, "density", 8);
    path = store("both.nvdb", both, one.size + two.size);
    ck_assert_int_eq(nph_nvdb_read(context, path, NULL, &volume), NPH_BAD_INPUT);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "has 2 grids named 'density'"));
    nph_test_context_close(context);
    refused(store("tail.nvdb", both, one.size + two.size + 5), "a segment's header goes beyond the file's end");
    free(both);
    free(one.file);
    free(two.file);
}
END_TEST

START_TEST(every_failing_allocation_is_reported_and_nothing_leaks) {
    static const char *const files[] = {"reference/data/tiles/tiles.zip.nvdb",
                                        "reference/data/smoke/smoke_0024.none.nvdb"};
    for (int i = 0; i < 2; i++) {
        NphStatus status = NPH_NO_MEMORY;
        uint64_t nth = 0;
        while (status == NPH_NO_MEMORY && nth < 100) {
            NphSettings settings;
            nph_settings_default(&settings);
            settings.threads = 1;
            settings.fail_allocation = ++nth;
            NphContext *context = NULL;
            ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
            NphVolume volume;
            status = nph_nvdb_read(context, nph_test_path(files[i]), i ? NULL : "tiles", &volume);
            if (status == NPH_OK) nph_volume_free(context, &volume);
            nph_test_context_close(context);
        }
        ck_assert_int_eq(status, NPH_OK);
        ck_assert_uint_ge(nth, 5);
    }
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, half_values_of_every_kind_are_exact);
    tcase_add_test(cases, variable_codes_of_every_width_are_unpacked);
    tcase_add_test(cases, later_versions_are_read_and_their_checksums_checked);
    tcase_add_test(cases, a_leaf_reached_twice_is_refused_so_that_small_files_stay_small);
    tcase_add_test(cases, roots_with_one_key_twice_or_children_outside_are_refused);
    tcase_add_test(cases, contradictions_between_header_and_nodes_are_refused);
    tcase_add_test(cases, huge_and_negative_fields_are_refused_or_harmless);
    tcase_add_loop_test(cases, every_cut_is_refused_with_the_byte, 0, SAMPLES);
    tcase_add_loop_test(cases, flipped_bits_are_refused_or_give_a_sound_volume, 0, SAMPLES);
    tcase_add_test(cases, packed_blocks_that_lie_are_refused);
    tcase_add_test(cases, garbage_is_refused);
    tcase_add_test(cases, names_cannot_write_to_a_terminal);
    tcase_add_test(cases, files_in_a_row_are_one_file_with_several_segments);
    tcase_add_test(cases, every_failing_allocation_is_reported_and_nothing_leaks);
}

int main(void) { return nph_test_main("nvdb_hostile", fill); }
