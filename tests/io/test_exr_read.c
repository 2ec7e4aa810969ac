/* SPDX-License-Identifier: Apache-2.0
 *
 * Reading OpenEXR: one picture in all encodings (reference/data/env/exr_variants; its numbers in GROUND_TRUTH.txt),
 * files built by hand for what these do not cover, and every kind that is refused. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "exr_builder.h"
#include "harness.h"
#include "io/half.h"
#include "nephos/image.h"

static const char *variant(const char *name) {
    char relative[200];
    snprintf(relative, sizeof relative, "reference/data/env/exr_variants/sunset256_%s", name);
    return nph_test_path(relative);
}

static float at(const NphImage *image, const char *channel, int x, int y) {
    const NphChannel *c = nph_image_channel(image, channel);
    ck_assert_ptr_nonnull(c);
    return c->pixels[(size_t)y * (size_t)image->width + (size_t)x];
}

static void refused(const char *path, const char *word) {
    NphContext *context = nph_test_context(1);
    NphImage image = {.width = 77};
    ck_assert_int_eq(nph_exr_read(context, path, &image), NPH_BAD_INPUT);
    const char *messages = nph_test_messages();
    ck_assert_msg(strstr(messages, path) && strstr(messages, word), "no path or no '%s' in: %s", word, messages);
    ck_assert_int_eq(image.width, 77);
    nph_test_context_close(context);
}

static const char *const lossless[] = {"float_none.exr", "float_piz.exr", "float_pxr24.exr",     "float_zip.exr",
                                       "half_none.exr",  "half_piz.exr",  "half_pxr24.exr",      "half_rle.exr",
                                       "half_zip.exr",   "half_zips.exr", "half_zip_tiled32.exr"};

START_TEST(every_lossless_encoding_gives_the_same_pixels) {
    NphContext *context = nph_test_context(1);
    NphImage first = {0};
    ck_assert_int_eq(nph_exr_read(context, variant(lossless[0]), &first), NPH_OK);
    for (size_t i = 1; i < sizeof lossless / sizeof *lossless; i++) {
        NphImage image = {0};
        ck_assert_int_eq(nph_exr_read(context, variant(lossless[i]), &image), NPH_OK);
        ck_assert_int_eq(image.channel_count, 3);
        for (int c = 0; c < 3; c++) {
            ck_assert_str_eq(image.channels[c].name, first.channels[c].name);
            ck_assert_int_eq(image.channels[c].was_half, lossless[i][0] == 'h');
            ck_assert_int_eq(image.channels[c].was_uint, 0);
            ck_assert_mem_eq(image.channels[c].pixels, first.channels[c].pixels, sizeof(float) * 256 * 128);
        }
        nph_image_free(context, &image);
    }
    nph_image_free(context, &first);
    ck_assert_str_eq(nph_test_messages(), "");
    nph_test_context_close(context);
}
END_TEST

/* GROUND_TRUTH.txt: minimum, maximum and mean of R, G, B, and probes. Maxima and most probes are exact, the others given
 * to eight digits. Its means were summed in float (held to 1e-5); oiiotool --stats, which sums in double, prints
 * 0.403712 0.416030 0.573074 (held to all six decimals). */
static void check_ground_truth(const NphImage *image) {
    static const char *const names[3] = {"R", "G", "B"};
    static const double minimum[3] = {0.00065947, 0.00061941, 0.00097942}, maximum[3] = {754.5, 118.375, 2.46484375};
    static const double float_mean[3] = {0.40371075, 0.4160297, 0.5730714}, mean[3] = {0.403712, 0.416030, 0.573074};
    static const struct {
        int x, y;
        double rgb[3];
    } probes[] = {{0, 0, {0.234375, 0.395263671875, 0.7353515625}},
                  {128, 64, {1.1494140625, 0.87060546875, 0.74462890625}},
                  {200, 70, {0.2003173828125, 0.1854248046875, 0.1998291015625}},
                  {40, 66, {0.2247314453125, 0.16650390625, 0.15087890625}},
                  {255, 127, {0.0650634765625, 0.0650634765625, 0.0714111328125}},
                  {153, 61, {754.5, 118.375, 0.23144531}}};
    for (int c = 0; c < 3; c++) {
        double lowest = HUGE_VAL, highest = 0, sum = 0;
        for (int y = 0; y < 128; y++)
            for (int x = 0; x < 256; x++) {
                double value = (double)at(image, names[c], x, y);
                if (value < lowest) lowest = value;
                if (value > highest) highest = value;
                sum += value;
            }
        ck_assert_double_eq_tol(lowest, minimum[c], 5e-9);
        ck_assert_double_eq(highest, maximum[c]);
        ck_assert_double_eq_tol(sum / (256 * 128), mean[c], 5e-7);
        ck_assert_double_eq_tol(sum / (256 * 128), float_mean[c], 1e-5 * mean[c]);
        for (size_t i = 0; i < sizeof probes / sizeof *probes; i++)
            ck_assert_double_eq_tol((double)at(image, names[c], probes[i].x, probes[i].y), probes[i].rgb[c], 5e-9);
    }
}

START_TEST(the_picture_has_its_recorded_range_mean_and_probes) {
    NphContext *context = nph_test_context(1);
    NphImage image = {0};
    ck_assert_int_eq(nph_exr_read(context, variant("half_zip.exr"), &image), NPH_OK);
    ck_assert_int_eq(image.width, 256);
    ck_assert_int_eq(image.height, 128);
    ck_assert_int_eq(image.full_width, 256);
    ck_assert_int_eq(image.full_height, 128);
    check_ground_truth(&image);
    const NphAttribute *a = nph_image_attribute(&image, "capDate");
    ck_assert(a && a->type == NPH_ATTRIBUTE_STRING);
    ck_assert_str_eq(a->text, "2018:08:17 15:11:14");
    a = nph_image_attribute(&image, "Orientation");
    ck_assert(a && a->type == NPH_ATTRIBUTE_INT && a->number == 1);
    a = nph_image_attribute(&image, "dwaCompressionLevel");
    ck_assert(a && a->type == NPH_ATTRIBUTE_FLOAT && a->number == 45);
    ck_assert_ptr_null(nph_image_attribute(&image, "dataWindow"));
    ck_assert_ptr_null(nph_image_attribute(&image, "pixelAspectRatio"));
    nph_image_free(context, &image);
    nph_test_context_close(context);
}
END_TEST

static int code(float value) { return nph_half_from_float(value); } /* positive halves are ordered like their bits */

/* B44 stores the 15 steps between neighbours of a 4 x 4 block of ordered halves in six bits each (-32 .. 31), in units of
 * the smallest 2^s in which all fit, rounded: with a block's range of r codes 2^s < r / 15, hence errors of at most
 * half of that, r / 30, and one code where s = 0 leaves a rounding. */
START_TEST(b44_is_within_half_its_step_of_the_lossless_picture) {
    NphContext *context = nph_test_context(1);
    NphImage exact = {0};
    ck_assert_int_eq(nph_exr_read(context, variant("half_none.exr"), &exact), NPH_OK);
    static const char *const names[2] = {"half_b44.exr", "half_b44a.exr"};
    for (int i = 0; i < 2; i++) {
        NphImage image = {0};
        int changed = 0;
        ck_assert_int_eq(nph_exr_read(context, variant(names[i]), &image), NPH_OK);
        for (int c = 0; c < 3; c++)
            for (int block = 0; block < 64 * 32; block++) {
                const float *a = exact.channels[c].pixels + block / 64 * 4 * 256 + block % 64 * 4;
                const float *b = image.channels[c].pixels + block / 64 * 4 * 256 + block % 64 * 4;
                int lowest = 1 << 16, highest = 0, worst = 0;
                for (int k = 0; k < 16; k++) {
                    int was = code(a[k / 4 * 256 + k % 4]), is = code(b[k / 4 * 256 + k % 4]);
                    if (was < lowest) lowest = was;
                    if (was > highest) highest = was;
                    if (abs(was - is) > worst) worst = abs(was - is);
                    changed += was != is;
                }
                ck_assert_int_le(worst, (highest - lowest) / 30 + 1);
            }
        ck_assert_int_gt(changed, 1000); /* it is lossy */
        nph_image_free(context, &image);
    }
    nph_image_free(context, &exact);
    nph_test_context_close(context);
}
END_TEST

START_TEST(unreadable_kinds_are_refused_by_name) {
    refused(variant("half_dwaa.exr"), "DWAA");
    refused(variant("half_dwab.exr"), "oiiotool in.exr --compression zip -o out.exr");
    refused(nph_test_path("reference/data/env/exr_variants/sunset256.hdr"), "not OpenEXR, but a Radiance picture");
    refused(variant("float.pfm"), "not OpenEXR, but a portable float map");
    refused(nph_test_path("reference/data/env/exr_variants/GROUND_TRUTH.txt"), "not OpenEXR");
    refused(nph_test_path("reference/data/env"), "is a folder");
    refused(nph_test_temporary("nothing.exr"), "No such file");
    Bytes empty = {.size = 0};
    refused(save(&empty, nph_test_temporary("empty.exr")), "an empty file");
}
END_TEST

/* ---- built by hand ---- */

static float sample(int x, int y) { return 1 + (float)x + 100 * (float)y; }

/* Scanlines of one part from its table on; decreasing: the file holds them from the bottom, the table from the top. */
static void put_scanlines(Bytes *b, const ExrHeader *h, int part) {
    int width = h->data[2] - h->data[0] + 1, height = h->data[3] - h->data[1] + 1;
    size_t table = b->size, chunk = 4u * (size_t)width + 8 + (part >= 0 ? 4 : 0);
    for (int y = 0; y < height; y++)
        put_little(b, table + 8 * (size_t)height + chunk * (size_t)(h->line_order == 1 ? height - 1 - y : y), 8);
    for (int i = 0; i < height; i++) {
        int y = h->line_order == 1 ? height - 1 - i : i;
        if (part >= 0) put_int(b, part);
        put_int(b, h->data[1] + y);
        put_int(b, 4 * width);
        for (int x = 0; x < width; x++) put_float(b, sample(x, y));
    }
}

static ExrHeader plain_header(int width, int height) {
    ExrHeader h = {.channel = "Y", .pixel_type = 2, .sampling = 1};
    h.data[2] = h.display[2] = width - 1;
    h.data[3] = h.display[3] = height - 1;
    return h;
}

static void check_samples(const char *path, int width, int height) {
    NphContext *context = nph_test_context(1);
    NphImage image = {0};
    NphStatus status = nph_exr_read(context, path, &image);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    ck_assert_int_eq(image.width, width);
    ck_assert_int_eq(image.height, height);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) ck_assert_float_eq(at(&image, "Y", x, y), sample(x, y));
    nph_image_free(context, &image);
    nph_test_context_close(context);
}

START_TEST(both_line_orders_put_the_first_line_on_top) {
    for (int order = 0; order < 2; order++) {
        Bytes b = {.size = 0};
        ExrHeader h = plain_header(5, 7);
        h.line_order = order;
        put_magic(&b, 0);
        put_header(&b, &h);
        put_scanlines(&b, &h, -1);
        check_samples(save(&b, nph_test_temporary("order.exr")), 5, 7);
    }
}
END_TEST

START_TEST(windows_are_kept_relative_to_the_display_window) {
    NphContext *context = nph_test_context(1);
    Bytes b = {.size = 0};
    ExrHeader h = plain_header(5, 7);
    static const int data[4] = {-3, 12, 1, 18}, display[4] = {-10, 10, 89, 59};
    memcpy(h.data, data, sizeof data);
    memcpy(h.display, display, sizeof display);
    put_magic(&b, 0);
    put_header(&b, &h);
    put_scanlines(&b, &h, -1);
    NphImage image = {0};
    ck_assert_int_eq(nph_exr_read(context, save(&b, nph_test_temporary("window.exr")), &image), NPH_OK);
    ck_assert_int_eq(image.x0, 7);
    ck_assert_int_eq(image.y0, 2);
    ck_assert_int_eq(image.full_width, 100);
    ck_assert_int_eq(image.full_height, 50);
    ck_assert_float_eq(at(&image, "Y", 4, 6), sample(4, 6));
    nph_image_free(context, &image);
    nph_test_context_close(context);
}
END_TEST

/* Compression that does not pay is left out chunk by chunk; the chunk's size alone says so. */
START_TEST(a_chunk_as_large_as_its_pixels_is_raw_for_every_compression) {
    for (int compression = 0; compression < 8; compression++) {
        NphContext *context = nph_test_context(1);
        Bytes b = {.size = 0};
        ExrHeader h = plain_header(5, 2);
        h.compression = compression;
        h.pixel_type = 1;
        put_magic(&b, 0);
        put_header(&b, &h);
        int chunks = compression == 0 || compression == 1 || compression == 2 ? 2 : 1; /* one line each, or all */
        for (int i = 0; i < chunks; i++) put_little(&b, b.size + 8 * (size_t)(chunks - i) + (size_t)i * 18, 8);
        for (int i = 0; i < chunks; i++) {
            put_int(&b, i);
            put_int(&b, 20 / chunks);
            for (int k = 0; k < 10 / chunks; k++) put_little(&b, 0x3c00u + (unsigned)(100 * (10 / chunks * i + k)), 2);
        }
        NphImage image = {0};
        NphStatus status = nph_exr_read(context, save(&b, nph_test_temporary("raw.exr")), &image);
        ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
        for (int i = 0; i < 10; i++)
            ck_assert_float_eq(image.channels[0].pixels[i], nph_float_from_half((uint16_t)(0x3c00 + 100 * i)));
        nph_image_free(context, &image);
        nph_test_context_close(context);
    }
}
END_TEST

static int levels_of(int size) { return size < 2 ? 1 : 1 + levels_of(size / 2); }

/* All levels, rounding down; level (0, 0) holds samples, the others -1. */
static int put_tiles(Bytes *b, const ExrHeader *h, int dry) {
    int width = h->data[2] + 1, height = h->data[3] + 1, size = h->tile_size, count = 0;
    int levels_x = h->tile_mode ? levels_of(h->tile_mode == 1 && height > width ? height : width) : 1;
    int levels_y = h->tile_mode == 2 ? levels_of(height) : 1;
    size_t table = b->size;
    if (!dry) {
        int chunks = put_tiles(b, h, 1);
        for (int i = 0; i < chunks; i++) put_little(b, 0, 8);
    }
    for (int ly = 0; ly < levels_y; ly++)
        for (int lx = 0; lx < levels_x; lx++) {
            int level_y = h->tile_mode == 2 ? ly : lx;
            int w = width >> lx > 0 ? width >> lx : 1, hh = height >> level_y > 0 ? height >> level_y : 1;
            for (int ty = 0; ty * size < hh; ty++)
                for (int tx = 0; tx * size < w; tx++, count++) {
                    if (dry) continue;
                    int tw = w - tx * size < size ? w - tx * size : size,
                        th = hh - ty * size < size ? hh - ty * size : size;
                    size_t here = b->size;
                    b->size = table + 8 * (size_t)count;
                    put_little(b, here, 8);
                    b->size = here;
                    put_int(b, tx);
                    put_int(b, ty);
                    put_int(b, lx);
                    put_int(b, level_y);
                    put_int(b, 4 * tw * th);
                    for (int y = 0; y < th; y++)
                        for (int x = 0; x < tw; x++)
                            put_float(b, lx + level_y ? -1 : sample(tx * size + x, ty * size + y));
                }
        }
    return count;
}

START_TEST(tiles_of_one_level_mip_and_rip_levels_read_their_full_picture) {
    for (int mode = 0; mode < 3; mode++)
        for (int size = 4; size <= 64; size *= 2) {
            Bytes b = {.size = 0};
            ExrHeader h = plain_header(21, 13);
            h.tile_size = size;
            h.tile_mode = mode;
            put_magic(&b, 0x200);
            put_header(&b, &h);
            put_tiles(&b, &h, 0);
            check_samples(save(&b, nph_test_temporary("tiled.exr")), 21, 13);
        }
}
END_TEST

START_TEST(of_several_parts_the_first_is_read_and_that_is_said) {
    Bytes b = {.size = 0};
    ExrHeader left = plain_header(4, 3), right = plain_header(4, 3);
    left.name = "left";
    right.name = "right";
    left.type = right.type = "scanlineimage";
    left.chunks = right.chunks = 3;
    put_magic(&b, 0x1000);
    put_header(&b, &left);
    put_header(&b, &right);
    put_little(&b, 0, 1);
    /* Tables come first, then chunks: the second part's table is empty, its chunks are never asked for. */
    size_t table = b.size;
    Bytes part = {.size = 0};
    part.size = table + 24; /* so that the offsets count the second table in */
    put_scanlines(&part, &left, 0);
    put_bytes(&b, part.data + table + 24, 24);
    for (int i = 0; i < 3; i++) put_little(&b, 0, 8);
    put_bytes(&b, part.data + table + 48, part.size - table - 48);
    NphContext *context = nph_test_context(1);
    NphImage image = {0};
    NphStatus status = nph_exr_read(context, save(&b, nph_test_temporary("parts.exr")), &image);
    const char *messages = nph_test_messages();
    ck_assert_msg(status == NPH_OK, "%s", messages);
    ck_assert_msg(strstr(messages, "2 parts; the first is read") != NULL, "%s", messages);
    ck_assert_float_eq(at(&image, "Y", 3, 2), sample(3, 2));
    nph_image_free(context, &image);
    nph_test_context_close(context);
}
END_TEST

START_TEST(deep_and_subsampled_files_are_refused_by_name) {
    Bytes deep = {.size = 0}, sub = {.size = 0};
    ExrHeader h = plain_header(4, 4);
    h.type = "deepscanline";
    h.name = "deep";
    h.version = 1;
    h.chunks = 4;
    put_magic(&deep, 0x800);
    put_header(&deep, &h);
    for (int i = 0; i < 200; i++) put_little(&deep, 0, 8);
    refused(save(&deep, nph_test_temporary("deep.exr")), "deep samples");
    h = plain_header(4, 4);
    h.channel = "BY";
    h.sampling = 2;
    put_magic(&sub, 0);
    put_header(&sub, &h);
    for (int i = 0; i < 200; i++) put_little(&sub, 0, 8);
    refused(save(&sub, nph_test_temporary("sub.exr")), "\"BY\" is subsampled (2 x 2)");
}
END_TEST

START_TEST(a_header_that_promises_more_than_its_file_is_refused_before_allocation) {
    static const int sizes[][2] = {
        {1000000000, 1000000000}, {1000000000, 1}, {1, 1000000000}, {2000, 1000}, {46341, 46341}};
    for (int compression = 0; compression < 8; compression++)
        for (int tiled = 0; tiled < 2; tiled++)
            for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
                Bytes b = {.size = 0};
                ExrHeader h = plain_header(sizes[i][0], sizes[i][1]);
                h.compression = compression;
                h.tile_size = tiled ? 64 : 0;
                put_magic(&b, tiled ? 0x200 : 0);
                put_header(&b, &h);
                while (b.size < 1024) put_little(&b, 0, 1);
                const char *path = save(&b, nph_test_temporary("huge.exr"));
                NphContext *context = nph_test_context(1);
                NphImage image = {0};
                ck_assert_int_eq(nph_exr_read(context, path, &image), NPH_BAD_INPUT);
                ck_assert_uint_lt(nph_context_peak_bytes(context), 20000);
                ck_assert_ptr_nonnull(strstr(nph_test_messages(), path));
                nph_test_context_close(context);
            }
}
END_TEST

START_TEST(integers_beyond_a_floats_precision_are_rounded_and_that_is_said) {
    NphContext *context = nph_test_context(1);
    Bytes b = {.size = 0};
    ExrHeader h = plain_header(3, 1);
    h.pixel_type = 0;
    put_magic(&b, 0);
    put_header(&b, &h);
    put_little(&b, b.size + 8, 8);
    put_int(&b, 0);
    put_int(&b, 12);
    put_little(&b, 7, 4);
    put_little(&b, 16777217, 4);
    put_little(&b, 0xffffff00u, 4);
    NphImage image = {0};
    ck_assert_int_eq(nph_exr_read(context, save(&b, nph_test_temporary("uint.exr")), &image), NPH_OK);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "1 integers above 2^24"));
    ck_assert_int_eq(image.channels[0].was_uint, 1);
    ck_assert_float_eq(image.channels[0].pixels[0], 7);
    ck_assert_float_eq(image.channels[0].pixels[1], 16777216);
    ck_assert_float_eq(image.channels[0].pixels[2], 4294967040.0f);
    nph_image_free(context, &image);
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, every_lossless_encoding_gives_the_same_pixels);
    tcase_add_test(cases, the_picture_has_its_recorded_range_mean_and_probes);
    tcase_add_test(cases, b44_is_within_half_its_step_of_the_lossless_picture);
    tcase_add_test(cases, unreadable_kinds_are_refused_by_name);
    tcase_add_test(cases, both_line_orders_put_the_first_line_on_top);
    tcase_add_test(cases, windows_are_kept_relative_to_the_display_window);
    tcase_add_test(cases, a_chunk_as_large_as_its_pixels_is_raw_for_every_compression);
    tcase_add_test(cases, tiles_of_one_level_mip_and_rip_levels_read_their_full_picture);
    tcase_add_test(cases, of_several_parts_the_first_is_read_and_that_is_said);
    tcase_add_test(cases, deep_and_subsampled_files_are_refused_by_name);
    tcase_add_test(cases, a_header_that_promises_more_than_its_file_is_refused_before_allocation);
    tcase_add_test(cases, integers_beyond_a_floats_precision_are_rounded_and_that_is_said);
}

int main(void) { return nph_test_main("exr_read", fill); }
