/* SPDX-License-Identifier: Apache-2.0
 *
 * Environment maps and discs in kernels, both precisions: densities against exact solid angles, sampling against
 * densities, looking up what was drawn, orientation, poles and degenerate maps. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/philox.h"
#include "harness.h"
#include "kernel_light.h"

#define PI 3.14159265358979324
#define EXPECT(condition, ...)                       \
    do {                                             \
        if (!(condition)) ck_abort_msg(__VA_ARGS__); \
    } while (0)

enum { BATCH = 4096 };
static LightQuery queries[BATCH];

/* A map whose texel (row, column) has the radiance value(row, column, channel). */
static NphEnvironment make(NphContext *context, int width, int height, float (*value)(int, int, int)) {
    static const char *names[3] = {"R", "G", "B"};
    static const double scale[3] = {1.0, 1.0, 1.0};
    NphImage image;
    NphEnvironment map;
    ck_assert_int_eq(nph_image_new(context, width, height, &image), NPH_OK);
    for (int c = 0; c < 3; c++) {
        float *pixels;
        ck_assert_int_eq(nph_image_add_channel(context, &image, names[c], &pixels), NPH_OK);
        for (int i = 0; i < width * height; i++) pixels[i] = value(i / width, i % width, c);
    }
    ck_assert_int_eq(nph_environment_build(context, &image, scale, "map", &map), NPH_OK);
    nph_image_free(context, &image);
    return map;
}

static float white(int row, int column, int channel) { return row + column + channel < 0 ? 0.0f : 1.0f; }
static float black(int row, int column, int channel) { return row + column + channel < 0 ? 1.0f : 0.0f; }

/* Uneven, a fifth of the texels black, row 3 black. */
static float rough(int row, int column, int channel) {
    NphWords words = nph_philox(9, 0, (uint32_t)row, (uint32_t)column, 0, 0);
    float value = nph_uniformf(words.w0), x = nph_uniformf(words.w1);
    return x < 0.2f || row == 3 ? 0.0f : (0.02f + value * value * value * 50.0f) * (1.0f + 0.3f * (float)channel);
}

static float one_bright(int row, int column, int channel) {
    return row == 5 && column == 11 ? 1e6f : channel < 0 ? 1.0f : 0.0f;
}
static float bright_on_dim(int row, int column, int channel) { return one_bright(row, column, channel) + 1e-3f; }
static float numbered(int row, int column, int channel) {
    return channel == 0 ? (float)(row + 1) : channel == 1 ? (float)(column + 1) : 1.0f;
}
static float seventh(int row, int column, int channel) { return 1.0f + (float)((row + column + channel) % 7); }
static float huge_values(int row, int column, int channel) { return 1e37f * seventh(row, column, channel); }
static float tiny_values(int row, int column, int channel) { return 1e-37f * seventh(row, column, channel); }

static void sample(int single, const NphEnvironment *map, double rotation, uint32_t seed, uint32_t first) {
    for (uint32_t i = 0; i < BATCH; i++) {
        NphWords words = nph_philox(seed, 2, first + i, 0, 0, 0);
        queries[i].u = words.w0;
        queries[i].w = words.w1;
    }
    queries[0].u = queries[0].w = 0; /* the ends too */
    queries[1].u = queries[1].w = 0xffffffffu;
    if (single) light_sample_f32_base(map, rotation, queries, BATCH);
    else light_sample_f64_base(map, rotation, queries, BATCH);
}

static void lookup(int single, const NphEnvironment *map, double rotation, LightQuery *query, int count) {
    if (single) light_lookup_f32_base(map, rotation, query, count);
    else light_lookup_f64_base(map, rotation, query, count);
}

static LightQuery seen(int single, const NphEnvironment *map, double rotation, double x, double y, double z) {
    LightQuery query = {.d = {x, y, z}};
    lookup(single, map, rotation, &query, 1);
    return query;
}

static double luminance(const double rgb[3]) { return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]; }

static double solid_angle(const NphEnvironment *map, int row) {
    return 2.0 * PI / map->width * (cos(PI * row / map->height) - cos(PI * (row + 1) / map->height));
}

/* The direction of a place in an unrotated map, in texels. */
static void direction(const NphEnvironment *map, double row, double column, double d[3]) {
    double polar = PI * row / map->height, azimuth = 2.0 * PI * (0.5 - column / map->width);
    d[0] = sin(polar) * cos(azimuth);
    d[1] = sin(polar) * sin(azimuth);
    d[2] = cos(polar);
}

START_TEST(white_map_has_one_density_everywhere) {
    static const int sizes[][2] = {{1, 1}, {1, 2}, {2, 1}, {7, 5}, {64, 32}, {3, 200}};
    NphContext *context = nph_test_context(1);
    for (int i = 0; i < 6; i++) {
        NphEnvironment map = make(context, sizes[i][0], sizes[i][1], white);
        ck_assert(fabs(map.total / (4.0 * PI) - 1.0) < 4e-15);
        for (int single = 0; single < 2; single++) {
            double bound = single ? 0x1p-22 : 4e-15;
            sample(single, &map, 0.7, 1, 0);
            for (int k = 0; k < BATCH; k++) {
                LightQuery drawn = queries[k], again = drawn;
                lookup(single, &map, 0.7, &again, 1);
                EXPECT(fabs(drawn.density * 4.0 * PI - 1.0) < bound, "density %.17g", drawn.density);
                EXPECT(drawn.density == again.density && again.radiance[1] == 1.0, "density %.17g", again.density);
            }
        }
        nph_environment_free(context, &map);
    }
    nph_test_context_close(context);
}
END_TEST

START_TEST(density_is_luminance_over_total_and_integrates_to_one) {
    NphContext *context = nph_test_context(1);
    static float (*const values[])(int, int, int) = {rough, bright_on_dim, huge_values, tiny_values};
    for (int i = 0; i < 4; i++)
        for (int single = 0; single < 2; single++) {
            NphEnvironment map = make(context, 24, 13, values[i]);
            double integral = 0.0, total = 0.0;
            for (int row = 0; row < map.height; row++)
                for (int column = 0; column < map.width; column++) {
                    double d[3];
                    direction(&map, row + 0.5, column + 0.5, d);
                    LightQuery query = seen(single, &map, 0.0, d[0], d[1], d[2]);
                    for (int c = 0; c < 3; c++)
                        EXPECT(query.radiance[c] == (double)values[i](row, column, c), "%d, %d", row, column);
                    integral += query.density * solid_angle(&map, row);
                    total += luminance(query.radiance) * solid_angle(&map, row);
                }
            EXPECT(fabs(integral - 1.0) < (single ? 2e-7 : 1e-14), "integral - 1 = %g", integral - 1.0);
            EXPECT(fabs(total / map.total - 1.0) < 1e-14, "total %g, not %g", map.total, total);
            nph_environment_free(context, &map);
        }
    nph_test_context_close(context);
}
END_TEST

/* To the bit, also in maps so fine that single precision rounds by a good part of a texel's margin. */
START_TEST(looking_up_what_was_drawn_finds_the_texel_it_was_drawn_with) {
    static const int sizes[][2] = {{24, 13}, {4096, 8}, {8, 4096}, {1, 1}, {1, 2}, {16384, 1}};
    NphContext *context = nph_test_context(1);
    for (int i = 0; i < 6; i++)
        for (int single = 0; single < 2; single++) {
            NphEnvironment map = make(context, sizes[i][0], sizes[i][1], i < 3 ? rough : numbered);
            for (uint32_t batch = 0; batch < 20; batch++) {
                double rotation = batch == 0 ? 0.0 : 20.0 * nph_uniform(nph_philox(4, 0, batch, 0, 0, 0).w0) - 10.0;
                sample(single, &map, rotation, 30u + (uint32_t)i, batch * BATCH);
                for (int k = 0; k < BATCH; k++) {
                    LightQuery drawn = queries[k], again = drawn;
                    double length = drawn.d[0] * drawn.d[0] + drawn.d[1] * drawn.d[1] + drawn.d[2] * drawn.d[2];
                    lookup(single, &map, rotation, &again, 1);
                    EXPECT(memcmp(drawn.radiance, again.radiance, sizeof drawn.radiance) == 0 &&
                               drawn.density == again.density,
                           "%d x %d, f%d: drawn %g, seen %g", map.width, map.height, single ? 32 : 64, drawn.density,
                           again.density);
                    EXPECT(drawn.density > 0.0, "a black texel was drawn");
                    EXPECT(fabs(length - 1.0) < 8 * (single ? 0x1p-24 : 0x1p-53), "length^2 - 1 = %g", length - 1.0);
                }
            }
            nph_environment_free(context, &map);
        }
    nph_test_context_close(context);
}
END_TEST

START_TEST(texels_are_drawn_as_often_as_their_density_says) {
    enum { WIDTH = 24, HEIGHT = 13, BATCHES = 100 };
    NphContext *context = nph_test_context(1);
    NphEnvironment map = make(context, WIDTH, HEIGHT, rough);
    for (int single = 0; single < 2; single++) {
        static double count[WIDTH * HEIGHT][4]; /* quarters of each texel: halves in z, halves in azimuth */
        memset(count, 0, sizeof count);
        for (uint32_t batch = 0; batch < BATCHES; batch++) {
            sample(single, &map, 0.0, 50, batch * BATCH);
            for (int k = 2; k < BATCH; k++) {
                double column = (0.5 - atan2(queries[k].d[1], queries[k].d[0]) / (2.0 * PI)) * WIDTH;
                double row = atan2(hypot(queries[k].d[0], queries[k].d[1]), queries[k].d[2]) / PI * HEIGHT;
                int i = (int)row * WIDTH + (int)column;
                double middle = 0.5 * (cos(PI * floor(row) / HEIGHT) + cos(PI * (floor(row) + 1.0) / HEIGHT));
                count[i][2 * (queries[k].d[2] < middle) + (column - floor(column) >= 0.5)]++;
            }
        }
        double sum = 0.0;
        int degrees = -1;
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            double rgb[3];
            for (int c = 0; c < 3; c++) rgb[c] = (double)map.radiance[3 * i + c];
            double expected = BATCHES * (BATCH - 2) * luminance(rgb) / map.total * solid_angle(&map, i / WIDTH) / 4.0;
            for (int q = 0; q < 4; q++) {
                ck_assert(expected > 0.0 || count[i][q] == 0.0);
                if (expected < 5.0) continue; /* too few: each such texel is left out */
                sum += (count[i][q] - expected) * (count[i][q] - expected) / expected;
                degrees++;
            }
        }
        printf("texels, %s: chi-square %.1f of %d\n", single ? "f32" : "f64", sum, degrees);
        ck_assert_int_gt(degrees, 700);
        ck_assert(sum < degrees + 4.5 * sqrt(2.0 * degrees) && sum > degrees - 4.5 * sqrt(2.0 * degrees));
    }
    nph_environment_free(context, &map);
    nph_test_context_close(context);
}
END_TEST

/* Irradiance on a plane, E = integral of L max(0, n . d): the estimator L cos / density against 6 x 6 points a texel. */
START_TEST(estimated_irradiance_is_that_of_quadrature) {
    static const double n[3] = {0.48, -0.64, 0.6};
    static float (*const values[])(int, int, int) = {rough, bright_on_dim, white};
    NphContext *context = nph_test_context(1);
    for (int i = 0; i < 3; i++) {
        NphEnvironment map = make(context, 24, 13, values[i]);
        double want = 0.0;
        for (int row = 0; row < map.height; row++)
            for (int k = 0; k < map.width * 36; k++) {
                double d[3], top = cos(PI * row / map.height), bottom = cos(PI * (row + 1) / map.height);
                double polar = acos(top + (bottom - top) * (k % 36 / 6 + 0.5) / 6.0);
                direction(&map, polar / PI * map.height, k / 36 + (k % 6 + 0.5) / 6.0, d);
                double cosine = n[0] * d[0] + n[1] * d[1] + n[2] * d[2];
                cosine = cosine > 0.0 ? cosine : 0.0;
                want += cosine * (double)values[i](row, k / 36, 1) * solid_angle(&map, row) / 36.0;
            }
        for (int single = 0; single < 2; single++) {
            double sum = 0.0, squares = 0.0, count = 0.0;
            for (uint32_t batch = 0; batch < 50; batch++) {
                sample(single, &map, 0.0, 60, batch * BATCH);
                for (int k = 2; k < BATCH; k++) {
                    double cosine = n[0] * queries[k].d[0] + n[1] * queries[k].d[1] + n[2] * queries[k].d[2];
                    double value = (cosine > 0.0 ? cosine : 0.0) * queries[k].radiance[1] / queries[k].density;
                    sum += value;
                    squares += value * value;
                    count++;
                }
            }
            double mean = sum / count, deviation = sqrt((squares / count - mean * mean) / count);
            printf("irradiance %s: %.6g +- %.2g, quadrature %.6g\n", single ? "f32" : "f64", mean, deviation, want);
            ck_assert(fabs(mean - want) < 4.0 * deviation + 1e-4 * want); /* 1e-4: the midpoint rule */
        }
        nph_environment_free(context, &map);
    }
    nph_test_context_close(context);
}
END_TEST

START_TEST(orientation_and_rotation_are_the_stated_ones) {
    NphContext *context = nph_test_context(1);
    NphEnvironment map = make(context, 8, 4, numbered); /* R: row + 1, G: column + 1 */
    for (int single = 0; single < 2; single++) {
        ck_assert(seen(single, &map, 0.0, 0.1, 0.1, 0.98).radiance[0] == 1.0); /* row 0 looks up */
        ck_assert(seen(single, &map, 0.0, 0.1, 0.1, -0.98).radiance[0] == 4.0);
        /* the middle looks along +x, columns to its right towards -y, the left edge along -x */
        ck_assert(seen(single, &map, 0.0, 1.0, -0.1, 0.1).radiance[1] == 5.0);
        ck_assert(seen(single, &map, 0.0, 1.0, 0.1, 0.1).radiance[1] == 4.0);
        ck_assert(seen(single, &map, 0.0, 0.1, -1.0, 0.1).radiance[1] == 6.0);
        ck_assert(seen(single, &map, 0.0, -1.0, 0.1, 0.1).radiance[1] == 1.0);
        /* turned by +90 degrees, counterclockwise from above: what was along +x is along +y, for rotations with
         * whole turns added too */
        for (int turns = -2; turns < 3; turns++) {
            double rotation = (turns + 0.25) * 2.0 * PI;
            ck_assert(seen(single, &map, rotation, 0.1, 1.0, 0.1).radiance[1] == 5.0);
            ck_assert(seen(single, &map, rotation, -0.1, 1.0, 0.1).radiance[1] == 4.0);
            ck_assert(seen(single, &map, rotation, 1.0, 0.1, 0.1).radiance[1] == 6.0);
        }
    }
    nph_environment_free(context, &map);
    nph_test_context_close(context);
}
END_TEST

START_TEST(poles_and_directions_that_are_none_stay_inside_the_map) {
    NphContext *context = nph_test_context(1);
    NphEnvironment map = make(context, 8, 4, numbered);
    for (int single = 0; single < 2; single++) {
        static const double off[] = {0.0, -0.0, 1e-30, -1e-30, 1e-4};
        for (int i = 0; i < 25; i++) {
            LightQuery up = seen(single, &map, 1.0, off[i % 5], off[i / 5], 1.0);
            LightQuery down = seen(single, &map, 1.0, off[i % 5], off[i / 5], -1.0);
            ck_assert(up.radiance[0] == 1.0 && down.radiance[0] == 4.0);
            ck_assert(up.radiance[1] >= 1.0 && up.radiance[1] <= 8.0 && down.density > 0.0);
        }
        ck_assert(seen(single, &map, 0.0, NAN, NAN, NAN).radiance[0] == 1.0);
        /* the seam at -x */
        ck_assert(seen(single, &map, 0.0, -1.0, 0.0, 0.1).radiance[1] == 1.0);
        ck_assert(seen(single, &map, 0.0, -1.0, -0.0, 0.1).radiance[1] >= 1.0);
    }
    nph_environment_free(context, &map);
    nph_test_context_close(context);
}
END_TEST

START_TEST(black_map_and_single_texel_are_drawn_rightly) {
    NphContext *context = nph_test_context(1);
    NphEnvironment none = make(context, 16, 8, black), one = make(context, 16, 8, one_bright);
    ck_assert(none.total == 0.0);
    for (int single = 0; single < 2; single++) {
        double sum[3] = {0};
        sample(single, &none, 0.3, 70, 0);
        for (int k = 0; k < BATCH; k++) {
            EXPECT(queries[k].density == 0.0 && queries[k].radiance[0] == 0.0, "density %g", queries[k].density);
            for (int a = 0; a < 3; a++) sum[a] += queries[k].d[a] / BATCH;
        }
        for (int a = 0; a < 3; a++) ck_assert(fabs(sum[a]) < 0.05); /* still all over the sphere */
        ck_assert(seen(single, &none, 0.0, 0.6, 0.0, 0.8).density == 0.0);
        sample(single, &one, 0.3, 71, 0);
        for (int k = 0; k < BATCH; k++) {
            EXPECT(queries[k].radiance[0] == 1e6, "radiance %g", queries[k].radiance[0]);
            EXPECT(fabs(queries[k].density * solid_angle(&one, 5) - 1.0) < 4e-7, "density %g", queries[k].density);
        }
    }
    nph_environment_free(context, &none);
    nph_environment_free(context, &one);
    nph_test_context_close(context);
}
END_TEST

static void draw_disc(int single, const double axis[3], double half_angle) {
    if (single) light_disc_f32_base(axis, half_angle, queries, BATCH);
    else light_disc_f64_base(axis, half_angle, queries, BATCH);
}

START_TEST(discs_are_drawn_evenly_and_hold_what_was_drawn) {
    static const double half_angles[] = {1e-5, 1e-4, 4.65e-3, 0.5, 1.5, 3.0};
    static const double axes[][3] = {{0, 0, 1}, {0.48, 0.64, -0.6}, {0, -1, 0}};
    for (int i = 0; i < 18; i++)
        for (int single = 0; single < 2; single++) {
            enum { RINGS = 32 };
            double half = half_angles[i / 3], width = 2.0 * pow(sin(0.5 * half), 2.0), count[RINGS] = {0}, sum = 0.0;
            const double *axis = axes[i % 3];
            double epsilon = single ? 0x1p-24 : 0x1p-53, mean[3] = {0};
            for (uint32_t k = 0; k < BATCH; k++) {
                NphWords words = nph_philox(81, 0, k, 0, 0, 0);
                queries[k].u = 0xffffffffu - (words.w0 >> (k % 32));
                queries[k].w = words.w1;
            }
            draw_disc(single, axis, half);
            for (int k = 0; k < BATCH; k++) EXPECT(queries[k].held, "half angle %g: drawn outside of the disc", half);
            for (uint32_t k = 0; k < BATCH; k++) {
                NphWords words = nph_philox(80, 0, k, 0, 0, 0);
                queries[k].u = k == 1 ? 0xffffffffu : (uint32_t)(((uint64_t)k << 32) / BATCH) + (words.w0 >> 13);
                queries[k].w = words.w1;
            }
            draw_disc(single, axis, half);
            for (int k = 0; k < BATCH; k++) {
                double from[3], fall = 0.0;
                for (int a = 0; a < 3; a++) {
                    from[a] = queries[k].d[a] - (single ? (double)(float)axis[a] : axis[a]);
                    mean[a] += queries[k].d[a] / BATCH;
                    fall += 0.5 * from[a] * from[a];
                }
                EXPECT(queries[k].held, "half angle %g, f%d: a drawn direction is outside", half, single ? 32 : 64);
                EXPECT(fabs(queries[k].density * 2.0 * PI * width - 1.0) < 4 * epsilon, "density %g", queries[k].density);
                int ring = (int)(fall / width * RINGS);
                count[ring < RINGS ? ring : RINGS - 1]++;
                sum += fall / width / BATCH;
            }
            /* u is stratified, so only what rounding moves over a ring's edge is missing: components carry 2 epsilon */
            double moved = 8.0 * epsilon / sqrt(width) * BATCH + 3.0;
            for (int ring = 0; ring < RINGS; ring++)
                EXPECT(fabs(count[ring] - BATCH / RINGS) <= moved, "half angle %g ring %d: %g", half, ring, count[ring]);
            EXPECT(fabs(sum - 0.5) < 1e-3 + 8.0 * epsilon / sqrt(width), "half angle %g: mean %g", half, sum);
            /* azimuths even: five standard errors of sin / sqrt(2 N) */
            double bound = 5.0 * sqrt(0.5 * width / BATCH) + 1e-3 * width + 4 * epsilon;
            for (int a = 0; a < 3; a++)
                EXPECT(fabs(mean[a] - axis[a] * (1.0 - 0.5 * width)) < bound, "half angle %g axis %d: %g", half, a, mean[a]);
        }
}
END_TEST

START_TEST(every_vector_level_gives_the_same_bits) {
    static LightQuery base[BATCH];
    NphContext *context = nph_test_context(1);
    NphEnvironment map = make(context, 24, 13, rough);
    if (nph_cpu_isa() < NPH_ISA_AVX512) nph_test_skip("a vector level this processor lacks");
    for (int bits = 32; bits <= 64; bits += 32)
        for (int isa = NPH_ISA_BASE; isa <= (int)nph_cpu_isa(); isa++) {
            void (*draw)(const NphEnvironment *, double, LightQuery *, int);
            void (*look)(const NphEnvironment *, double, LightQuery *, int);
            NPH_KERNEL_PICK(draw, light_sample, isa, bits);
            NPH_KERNEL_PICK(look, light_lookup, isa, bits);
            sample(0, &map, 0.0, 90, 0); /* the words */
            draw(&map, 1.25, queries, BATCH);
            for (int k = 0; k < BATCH; k += 2) queries[k].d[k / 2 % 3] *= -1.0;
            look(&map, 1.25, queries, BATCH / 2);
            if (isa == NPH_ISA_BASE) memcpy(base, queries, sizeof base);
            else ck_assert_int_eq(memcmp(base, queries, sizeof base), 0);
        }
    nph_environment_free(context, &map);
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, white_map_has_one_density_everywhere);
    tcase_add_test(cases, density_is_luminance_over_total_and_integrates_to_one);
    tcase_add_test(cases, looking_up_what_was_drawn_finds_the_texel_it_was_drawn_with);
    tcase_add_test(cases, texels_are_drawn_as_often_as_their_density_says);
    tcase_add_test(cases, estimated_irradiance_is_that_of_quadrature);
    tcase_add_test(cases, orientation_and_rotation_are_the_stated_ones);
    tcase_add_test(cases, poles_and_directions_that_are_none_stay_inside_the_map);
    tcase_add_test(cases, black_map_and_single_texel_are_drawn_rightly);
    tcase_add_test(cases, discs_are_drawn_evenly_and_hold_what_was_drawn);
    tcase_add_test(cases, every_vector_level_gives_the_same_bits);
}

int main(void) { return nph_test_main("environment", fill); }
