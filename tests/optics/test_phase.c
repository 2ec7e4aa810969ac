/* SPDX-License-Identifier: Apache-2.0
 *
 * Phase functions: normalisation and moments by quadrature, sampling against the value (chi-square) and against the
 * closed inverse, single against double precision, published identities, and the turning of directions. */
#include <stdlib.h>
#include <string.h>

#include "phase_checks.h"

static const double asymmetries[] = {0.0,   1e-8, -1e-8, 1e-3,  -1e-3,  0.5,    -0.5,    0.9,     -0.9,
                                     0.99, -0.99, 0.999, -0.999, 0.9999, -0.9999, 0.99999, -0.99999};
enum { ASYMMETRIES = sizeof asymmetries / sizeof asymmetries[0] };

START_TEST(value_is_normalised_and_its_mean_cosine_is_g) {
    for (int i = 0; i < ASYMMETRIES; i++)
        for (int single = 0; single < 2; single++) {
            NphPhase phase = hg(asymmetries[i]);
            Scale scale = scale_of(&phase);
            double got[2], bound = single ? 1e-6 : 1e-10;
            integrate(single, &phase, scale, (double[]){0.0, scale.top}, 400, got);
            ck_assert_msg(fabs(got[0] - 1.0) < bound, "g %g: norm - 1 = %g", asymmetries[i], got[0] - 1.0);
            /* mean of 1 - |cos towards the peak| is 1 - |g|, relative to itself */
            double rest = 1.0 - fabs(asymmetries[i]);
            ck_assert_msg(fabs(got[1] / rest - 1.0) < bound, "g %g: mean fall %g, not %g", asymmetries[i], got[1], rest);
            ck_assert(nph_phase_mean_cosine(&phase) == asymmetries[i]);
        }
    static const NphPhase others[] = {{.kind = NPH_PHASE_ISOTROPIC, .g = {0, 0}, .weight = 0}, {.kind = NPH_PHASE_RAYLEIGH, .g = {0, 0}, .weight = 0},
                                      {.kind = NPH_PHASE_TWO_LOBE, .g = {0.8, -0.3}, .weight = 0.7}, {.kind = NPH_PHASE_TWO_LOBE, .g = {0.95, 0.1}, .weight = 0.0}};
    for (int i = 0; i < 4; i++) {
        Scale scale = scale_of(&others[i]);
        double got[2], mean = i < 2 ? 0.0 : i == 2 ? 0.7 * 0.8 - 0.3 * 0.3 : 0.1;
        integrate(0, &others[i], scale, (double[]){0.0, scale.top}, 400, got);
        ck_assert(fabs(got[0] - 1.0) < 1e-10 && fabs(1.0 - got[1] - mean) < 1e-10);
        ck_assert(fabs(nph_phase_mean_cosine(&others[i]) - mean) < 1e-15);
    }
}
END_TEST

START_TEST(sampling_follows_the_value) {
    static const double g[] = {-0.999, -0.99, -0.9, -0.5, -1e-3, 0.0, 1e-8, 1e-3, 0.5, 0.9, 0.99, 0.999};
    static const NphPhase others[] = {{.kind = NPH_PHASE_ISOTROPIC, .g = {0, 0}, .weight = 0}, {.kind = NPH_PHASE_RAYLEIGH, .g = {0, 0}, .weight = 0},
                                      {.kind = NPH_PHASE_TWO_LOBE, .g = {0.9, -0.4}, .weight = 0.8}, {.kind = NPH_PHASE_TWO_LOBE, .g = {-0.7, 0.85}, .weight = 0.25}};
    static const char *names[] = {"isotropic", "rayleigh", "two lobes forward", "two lobes backward"};
    for (int single = 0; single < 2; single++) {
        for (size_t i = 0; i < sizeof g / sizeof g[0]; i++) {
            char name[32];
            NphPhase phase = hg(g[i]);
            snprintf(name, sizeof name, "g %g", g[i]);
            chi_square(single, &phase, scale_of(&phase), 100u + (uint32_t)i, name);
        }
        for (int i = 0; i < 4; i++) chi_square(single, &others[i], scale_of(&others[i]), 200u + (uint32_t)i, names[i]);
    }
}
END_TEST

/* The smaller of P(cos <= c) = (1 - g) rise / (r (1 + g + r)) and 1 - P = (1 + g) fall / (r (1 - g + r)), r = sqrt D,
 * both without cancellation. */
static double hg_tail(double g, double fall, double rise, int upper) {
    double rest = 1.0 - fabs(g), root = sqrt(rest * rest + 2.0 * fabs(g) * (g < 0 ? rise : fall));
    return upper ? (1.0 + g) * fall / (root * (1.0 - g + root)) : (1.0 - g) * rise / (root * (1.0 + g + root));
}

/* The roundings of r_hg_sample add up to at most 13 epsilon of the smaller part. */
START_TEST(sampling_inverts_the_distribution_for_every_g) {
    for (int i = 0; i < ASYMMETRIES; i++)
        for (int single = 0; single < 2; single++)
            for (uint32_t k = 0; k <= 4096; k++) {
                uint32_t word = k == 4096 ? 0xffffff00u : k << 20, lobe = 0;
                double u = word / 4294967296.0, tail = u < 0.5 ? u : 1.0 - u, fall, rise, cosine;
                NphPhase phase = hg(asymmetries[i]);
                double *const out[3] = {&fall, &rise, &cosine};
                if (single) phase_draw_f32_base(&phase, &word, &lobe, out, 1);
                else phase_draw_f64_base(&phase, &word, &lobe, out, 1);
                double back = hg_tail(asymmetries[i], fall, rise, u >= 0.5), epsilon = single ? 0x1p-24 : 0x1p-52;
                EXPECT(fabs(back - tail) <= 16 * epsilon * tail, "g %g: u %.9g, tail %.17g, not %.17g", asymmetries[i],
                       u, back, tail);
            }
}
END_TEST

START_TEST(rayleigh_sampling_inverts_its_distribution_at_both_poles) {
    NphPhase phase = {.kind = NPH_PHASE_RAYLEIGH, .g = {0, 0}, .weight = 0};
    for (int single = 0; single < 2; single++)
        for (uint32_t k = 0; k < 20000; k++) {
            NphWords words = nph_philox(3, 0, k, 0, 0, 0);
            uint32_t word = k % 2 ? words.w0 : words.w0 >> (words.w1 % (single ? 17u : 25u)), lobe = 0;
            if (k % 4 == 2) word = ~word;
            double u = single ? (word >> 8) / 16777216.0 : word / 4294967296.0, fall, rise, cosine;
            double *const out[3] = {&fall, &rise, &cosine};
            if (single) phase_draw_f32_base(&phase, &word, &lobe, out, 1);
            else phase_draw_f64_base(&phase, &word, &lobe, out, 1);
            double n = u > 0.5 ? fall : rise, tail = u > 0.5 ? 1.0 - u : u;
            EXPECT(fabs(n * (6.0 - 3.0 * n + n * n) / 8.0 - tail) <= (single ? 3 * 0x1p-24 : 8 * 0x1p-53) * tail,
                   "u %.9g: n %.9g", u, n);
        }
}
END_TEST

/* The forward peak at g = 0.999: within 8 ulp of the closed form from double g (sources: rest 1, its use as a power -2
 * 2, D^(3/2) 2, products 2). The printed form, 1 + g^2 - 2 g cos in single precision, is off by per cents there. */
START_TEST(single_precision_keeps_the_forward_peak) {
    double worst = 0.0, worst_printed = 0.0;
    for (int k = 0; k < 4000; k++) {
        double fall = (double)(float)(2.0 * pow(10.0, -9.0 * k / 4000.0)), rise = 2.0 - fall, got;
        static const double g[] = {0.999, -0.999, 0.99999, 0.9, 0.3};
        for (int i = 0; i < 5; i++) {
            NphPhase phase = hg(g[i]);
            double rest = 1.0 - fabs(g[i]), d = rest * rest + 2.0 * fabs(g[i]) * fall;
            double exact = (1.0 - g[i] * g[i]) / (4.0 * PI * d * sqrt(d));
            values(1, &phase, g[i] < 0 ? &rise : &fall, g[i] < 0 ? &fall : &rise, &got, 1);
            double error = fabs(got - exact) / ldexp(1.0, ilogb(exact) - 23);
            worst = error > worst ? error : worst;
            if (i > 0) continue;
            float gf = 0.999f, c = 1.0f - (float)fall, printed = 1.0f + gf * gf - 2.0f * gf * c;
            printed = (1.0f - gf * gf) / (12.5663706f * printed * sqrtf(printed));
            error = fabs(printed / exact - 1.0);
            worst_printed = error > worst_printed ? error : worst_printed;
        }
    }
    printf("f32 value: %.2f ulp; the printed form is off by %.3f\n", worst, worst_printed);
    ck_assert(worst < 8.0);
    ck_assert(worst_printed > 0.01);
}
END_TEST

START_TEST(short_forms_agree_where_they_may_be_used) {
    for (int i = 0; i < ASYMMETRIES; i++)
        for (int k = 0; k < 200; k++) {
            double fall = (double)(float)(2.0 * pow(10.0, -8.0 * k / 200.0)), rise = 2.0 - fall, a, b;
            NphPhase phase = hg(asymmetries[i]);
            values(1, &phase, &fall, NULL, &a, 1);
            rise = (double)(2.0f - (float)fall);
            values(1, &phase, &fall, &rise, &b, 1);
            EXPECT(a == b, "%g, not %g", a, b);
            values(0, &phase, &fall, NULL, &a, 1);
            b = nph_phase_value(&phase, 1.0 - fall);
            EXPECT(fabs(a - b) <= 1e-4 * b, "%g, not %g", a, b); /* 1 - cos has lost digits at 2e-8 */
        }
}
END_TEST

static double row_value(const char *quantity, double g, double argument) {
    NphPhase phase = hg(g);
    Scale scale = scale_of(&phase);
    double got[2], fall, rise, cosine;
    if (strncmp(quantity, "p_per_sr", 8) == 0 || strncmp(quantity, "spherical", 9) == 0)
        return nph_phase_value(&phase, argument);
    if (strncmp(quantity, "inverse", 7) == 0) {
        uint32_t u = (uint32_t)(argument * 4294967296.0 + 0.5), lobe = 0;
        phase_draw_f64_base(&phase, &u, &lobe, (double *[]){&fall, &rise, &cosine}, 1);
        return cosine;
    }
    if (strncmp(quantity, "backward", 8) == 0) {
        double middle = log(1.0 / scale.a + 1.0);
        integrate(0, &phase, scale, scale.backward ? (double[]){0.0, middle} : (double[]){middle, scale.top}, 400, got);
        return got[0];
    }
    integrate(0, &phase, scale, (double[]){0.0, scale.top}, 400, got);
    if (strncmp(quantity, "norm", 4) == 0) return got[0];
    if (strncmp(quantity, "mean", 4) == 0) return copysign(1.0 - got[1], g);
    return strncmp(quantity, "legendre_moment_2", 17) == 0 ? g * g : NAN;
}

START_TEST(published_identities_hold) {
    FILE *file = fopen(nph_test_path("reference/tables/hg_identities.csv"), "r");
    ck_assert_ptr_nonnull(file);
    char line[300];
    int rows = 0;
    while (fgets(line, sizeof line, file)) {
        char *field[4] = {line}, *end;
        int fields = 1;
        if (line[0] == '#' || strncmp(line, "quantity", 8) == 0) continue;
        for (char *at = line; *at && fields < 4; at++)
            if (*at == ',') *at = 0, field[fields++] = at + 1;
        ck_assert_int_eq(fields, 4);
        double g = strtod(field[1], &end), argument = strtod(field[2], NULL), want = strtod(field[3], NULL);
        if (*end == '*') g *= strtod(end + 1, NULL);
        double got = row_value(field[0], g, argument);
        /* 13 digits are printed; u is a multiple of 2^-32, and the slope of cos(u) reaches 2e2 here */
        double bound = strncmp(field[0], "inverse", 7) == 0 ? 3e-8 : 2e-12 * (1.0 + fabs(want));
        ck_assert_msg(fabs(got - want) <= bound, "%s, g %g, %g: %.13g, not %.13g", field[0], g, argument, got, want);
        rows++;
    }
    fclose(file);
    ck_assert_int_ge(rows, 90);
}
END_TEST

static void turn(int single, double d[3], const double *fall, const double *rise, const double *azimuth, int count) {
    if (single) phase_turn_f32_base(d, fall, rise, azimuth, count);
    else phase_turn_f64_base(d, fall, rise, azimuth, count);
}

START_TEST(length_does_not_drift_in_a_million_scatterings) {
    enum { STEPS = 1000000 };
    static double fall[STEPS], rise[STEPS], azimuth[STEPS];
    static const double g[] = {0.0, 0.9, -0.999};
    for (int i = 0; i < 3; i++)
        for (int single = 0; single < 2; single++) {
            NphPhase phase = hg(g[i]);
            draw(single, &phase, 5u + (uint32_t)i, STEPS, (double *[]){fall, rise, azimuth});
            for (uint32_t k = 0; k < STEPS; k++) azimuth[k] = nph_uniform(nph_philox(8, 0, k, 0, 0, 0).w0);
            double d[3] = {0.0, 0.6, -0.8}, epsilon = single ? 0x1p-24 : 0x1p-53;
            for (int part = 0; part < 100; part++) {
                int first = part * (STEPS / 100);
                turn(single, d, fall + first, rise + first, azimuth + first, STEPS / 100);
                ck_assert(fabs(d[0] * d[0] + d[1] * d[1] + d[2] * d[2] - 1.0) < 6 * epsilon);
            }
        }
}
END_TEST

/* Around d at 64 azimuths: the angle is the given one, and the sum is 64 cos d, so the frame is orthonormal. */
START_TEST(turning_keeps_its_angle_at_poles_too) {
    static const double directions[][3] = {
        {0, 0, 1},      {0, 0, -1},   {1, 0, 0.0},       {1, 0, -0.0},       {0.6, 0, 0.8},
        {0, -0.8, -0.6}, {1e-6, 0, 1}, {1e-4, -1e-4, -1}, {0.48, 0.64, -0.6}, {-1, 1, 0}};
    static const double falls[] = {0.0, 1e-8, 1e-4, 0.1, 1.0, 1.7, 1.9999, 2.0};
    for (size_t i = 0; i < sizeof directions / sizeof directions[0]; i++)
        for (size_t k = 0; k < sizeof falls / sizeof falls[0]; k++)
            for (int single = 0; single < 2; single++) {
                double fall = single ? (double)(float)falls[k] : falls[k], rise = 2.0 - fall;
                double epsilon = single ? 0x1p-24 : 0x1p-53;
                long double sum[3] = {0};
                double from[3];
                const double *given = directions[i];
                double length = sqrt(given[0] * given[0] + given[1] * given[1] + given[2] * given[2]);
                for (int a = 0; a < 3; a++) from[a] = single ? (double)(float)(given[a] / length) : given[a] / length;
                length = sqrt(from[0] * from[0] + from[1] * from[1] + from[2] * from[2]);
                for (int turns = 0; turns < 64; turns++) {
                    double d[3] = {from[0], from[1], from[2]}, azimuth = turns / 64.0, apart = 0.0, together = 0.0;
                    turn(single, d, &fall, &rise, &azimuth, 1);
                    for (int a = 0; a < 3; a++) {
                        sum[a] += d[a];
                        apart += 0.5 * (d[a] - from[a] / length) * (d[a] - from[a] / length);
                        together += 0.5 * (d[a] + from[a] / length) * (d[a] + from[a] / length);
                    }
                    /* components carry an error of about epsilon, so |a - b|^2 / 2 one of some |a - b| epsilon */
                    EXPECT(fabs(apart - fall) <= 10 * epsilon * (sqrt(2.0 * fall) + epsilon), "%g, not %g", apart,
                           fall);
                    EXPECT(fabs(together - rise) <= 10 * epsilon * (sqrt(2.0 * rise) + epsilon), "%g, not %g", together,
                           rise);
                }
                for (int a = 0; a < 3; a++) {
                    double miss = (double)(sum[a] / 64) - (1.0 - fall) * from[a] / length;
                    EXPECT(fabs(miss) <= 4 * epsilon, "axis %d, fall %g: off by %g epsilon", a, fall, miss / epsilon);
                }
            }
}
END_TEST

/* Words of all levels for the same draws, values and turns: compared with those of base. */
START_TEST(every_vector_level_gives_the_same_bits) {
    enum { COUNT = 1000 };
    static double results[2][5][COUNT];
    static const NphPhase phases[] = {{.kind = NPH_PHASE_HG, .g = {0.9, 0}, .weight = 0}, {.kind = NPH_PHASE_HG, .g = {-0.999, 0}, .weight = 0},
                                      {.kind = NPH_PHASE_RAYLEIGH, .g = {0, 0}, .weight = 0}, {.kind = NPH_PHASE_TWO_LOBE, .g = {0.9, -0.4}, .weight = 0.8}};
    uint32_t u[COUNT], lobe[COUNT];
    double azimuth[COUNT];
    for (uint32_t i = 0; i < COUNT; i++) {
        NphWords words = nph_philox(17, 0, i, 0, 0, 0);
        u[i] = words.w0;
        lobe[i] = words.w1;
        azimuth[i] = nph_uniform(words.w2);
    }
    if (nph_cpu_isa() < NPH_ISA_AVX512) nph_test_skip("a vector level this processor lacks");
    for (int i = 0; i < 8; i++)
        for (int isa = NPH_ISA_BASE; isa <= (int)nph_cpu_isa(); isa++) {
            const NphPhase *phase = &phases[i % 4];
            int bits = i < 4 ? 32 : 64;
            double (*r)[COUNT] = results[isa != NPH_ISA_BASE], d[3] = {0.6, 0.0, 0.8};
            void (*draws)(const NphPhase *, const uint32_t *, const uint32_t *, double *const *, int);
            void (*value)(const NphPhase *, const double *, const double *, double *, int);
            void (*turns)(double *, const double *, const double *, const double *, int);
            NPH_KERNEL_PICK(draws, phase_draw, isa, bits);
            NPH_KERNEL_PICK(value, phase_value, isa, bits);
            NPH_KERNEL_PICK(turns, phase_turn, isa, bits);
            draws(phase, u, lobe, (double *[]){r[0], r[1], r[2]}, COUNT);
            value(phase, r[0], r[1], r[3], COUNT);
            turns(d, r[0], r[1], azimuth, COUNT);
            memcpy(r[4], d, sizeof d);
            if (isa != NPH_ISA_BASE) ck_assert_int_eq(memcmp(results[0], results[1], sizeof results[0]), 0);
        }
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, value_is_normalised_and_its_mean_cosine_is_g);
    tcase_add_test(cases, sampling_follows_the_value);
    tcase_add_test(cases, sampling_inverts_the_distribution_for_every_g);
    tcase_add_test(cases, rayleigh_sampling_inverts_its_distribution_at_both_poles);
    tcase_add_test(cases, single_precision_keeps_the_forward_peak);
    tcase_add_test(cases, short_forms_agree_where_they_may_be_used);
    tcase_add_test(cases, published_identities_hold);
    tcase_add_test(cases, length_does_not_drift_in_a_million_scatterings);
    tcase_add_test(cases, turning_keeps_its_angle_at_poles_too);
    tcase_add_test(cases, every_vector_level_gives_the_same_bits);
}

int main(void) { return nph_test_main("phase", fill); }
