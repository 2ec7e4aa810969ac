/* SPDX-License-Identifier: Apache-2.0
 *
 * core/fmath.h against MPFR. Floats: every 2053rd of all bit patterns, so every binade, subnormals, infinities and NaNs;
 * the double precision libm only finds candidates for the worst, MPFR judges them, and every 61st argument besides.
 * Doubles: random and special arguments, all judged by MPFR. NEPHOS_TEST_EFFORT=N tests N times as many.
 * Prints the worst error of each function in units of the last place of the true value, and where it was. */
#include <math.h>
#include <mpfr.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/fmath.h"
#include "core/philox.h"
#include "harness.h"
#include "kernel_fmath.h"

#define PI 3.14159265358979324
enum { BLOCK = 4096 };

static int mpfr_of_sin2pi(mpfr_ptr out, mpfr_srcptr x, mpfr_rnd_t rounding) { return mpfr_sinu(out, x, 1, rounding); }
static int mpfr_of_cos2pi(mpfr_ptr out, mpfr_srcptr x, mpfr_rnd_t rounding) { return mpfr_cosu(out, x, 1, rounding); }
static int mpfr_of_floor(mpfr_ptr out, mpfr_srcptr x, mpfr_rnd_t rounding) {
    (void)rounding;
    return mpfr_floor(out, x);
}
static int mpfr_of_atan2(mpfr_ptr out, mpfr_srcptr x, mpfr_srcptr y, mpfr_rnd_t rounding) {
    return mpfr_atan2(out, y, x, rounding);
}
static double libm_sin2pi(double x) {
    double turn = x - rint(x), quarter = rint(4.0 * turn), r = 2.0 * PI * (turn - 0.25 * quarter);
    return quarter == 0.0 ? sin(r) : quarter == 1.0 ? cos(r) : quarter == -1.0 ? -cos(r) : -sin(r);
}
static double libm_cos2pi(double x) {
    double turn = x - rint(x), quarter = rint(4.0 * turn), r = 2.0 * PI * (turn - 0.25 * quarter);
    return quarter == 0.0 ? cos(r) : quarter == 1.0 ? -sin(r) : quarter == -1.0 ? sin(r) : -cos(r);
}
static double libm_atan2(double x, double y) { return atan2(y, x); }

static const struct {
    const char *name;
    int (*exact)(mpfr_ptr, mpfr_srcptr, mpfr_rnd_t);
    int (*exact2)(mpfr_ptr, mpfr_srcptr, mpfr_srcptr, mpfr_rnd_t);
    double (*libm)(double);
    double (*libm2)(double, double);
    double limit[2]; /* float, double: NaN is due beyond */
} functions[F_COUNT] = {
    [F_EXP] = {"exp", mpfr_exp, NULL, exp, NULL, {INFINITY, INFINITY}},
    [F_EXPM1] = {"expm1", mpfr_expm1, NULL, expm1, NULL, {INFINITY, INFINITY}},
    [F_EXP2] = {"exp2", mpfr_exp2, NULL, exp2, NULL, {INFINITY, INFINITY}},
    [F_LOG] = {"log", mpfr_log, NULL, log, NULL, {INFINITY, INFINITY}},
    [F_LOG1P] = {"log1p", mpfr_log1p, NULL, log1p, NULL, {INFINITY, INFINITY}},
    [F_SIN] = {"sin", mpfr_sin, NULL, sin, NULL, {NPH_TRIG_LIMITF, NPH_TRIG_LIMIT}},
    [F_COS] = {"cos", mpfr_cos, NULL, cos, NULL, {NPH_TRIG_LIMITF, NPH_TRIG_LIMIT}},
    [F_TAN] = {"tan", mpfr_tan, NULL, tan, NULL, {NPH_TRIG_LIMITF, NPH_TRIG_LIMIT}},
    [F_SIN2PI] = {"sin2pi", mpfr_of_sin2pi, NULL, libm_sin2pi, NULL, {INFINITY, INFINITY}},
    [F_COS2PI] = {"cos2pi", mpfr_of_cos2pi, NULL, libm_cos2pi, NULL, {INFINITY, INFINITY}},
    [F_ASIN] = {"asin", mpfr_asin, NULL, asin, NULL, {INFINITY, INFINITY}},
    [F_ACOS] = {"acos", mpfr_acos, NULL, acos, NULL, {INFINITY, INFINITY}},
    [F_CBRT] = {"cbrt", mpfr_cbrt, NULL, cbrt, NULL, {INFINITY, INFINITY}},
    [F_FLOOR] = {"floor", mpfr_of_floor, NULL, floor, NULL, {INFINITY, INFINITY}},
    [F_POW] = {"pow", NULL, mpfr_pow, NULL, pow, {INFINITY, INFINITY}},
    [F_ATAN2] = {"atan2", NULL, mpfr_of_atan2, NULL, libm_atan2, {INFINITY, INFINITY}},
};

typedef struct Worst {
    double error, x, y;
    long tested, judged;
} Worst;

static double effort(void) {
    const char *text = getenv("NEPHOS_TEST_EFFORT");
    return text ? atof(text) : 1.0;
}

/* |got - want| in units of the last place that want has as a float or double; want beyond the range counts as 2^128
 * (2^1024), and so does an infinite got. */
static double error_to(double want, double got, int single) {
    if (isnan(want) || isnan(got)) return isnan(want) && isnan(got) ? 0.0 : INFINITY;
    double top = single ? 0x1p128 : INFINITY;
    want = want > top ? top : want < -top ? -top : want;
    got = got > top ? top : got < -top ? -top : got;
    if (want == got) return 0.0;
    int exponent = want == 0.0 ? -10000 : ilogb(want), least = single ? -126 : -1022;
    exponent = exponent < least ? least : exponent > 127 && single ? 127 : exponent;
    return fabs(want - got) / ldexp(1.0, exponent - (single ? 23 : 52));
}

static double exact_error(int function, double x, double y, double got, int single) {
    static mpfr_t want, a, b;
    static int ready;
    if (!ready) mpfr_inits2(96, want, a, b, (mpfr_ptr)0);
    ready = 1;
    if (fabs(x) > functions[function].limit[!single] && !isinf(x)) return isnan(got) ? 0.0 : INFINITY;
    mpfr_set_d(a, x, MPFR_RNDN);
    mpfr_set_d(b, y, MPFR_RNDN);
    if (functions[function].exact) functions[function].exact(want, a, MPFR_RNDN);
    else functions[function].exact2(want, a, b, MPFR_RNDN);
    if (mpfr_nan_p(want) || mpfr_inf_p(want) || isnan(got)) return error_to(mpfr_get_d(want, MPFR_RNDN), got, single);
    int top = single ? 128 : 1024, least = single ? -126 : -1022;
    mpfr_set_d(a, got, MPFR_RNDN);
    if (mpfr_inf_p(a)) mpfr_set_si_2exp(a, got > 0 ? 1 : -1, top, MPFR_RNDN);
    int exponent = mpfr_zero_p(want) ? least : (int)mpfr_get_exp(want) - 1;
    if (exponent >= top) {
        mpfr_set_si_2exp(want, mpfr_sgn(want), top, MPFR_RNDN);
        exponent = top - 1;
    }
    if (exponent < least) exponent = least;
    mpfr_sub(want, want, a, MPFR_RNDN);
    mpfr_mul_2si(want, want, -(exponent - (single ? 23 : 52)), MPFR_RNDN);
    return fabs(mpfr_get_d(want, MPFR_RNDN));
}

static void judge(int function, double x, double y, double got, int single, Worst *worst) {
    double error = exact_error(function, x, y, got, single);
    worst->judged++;
    if (error > worst->error) *worst = (Worst){error, x, y, worst->tested, worst->judged};
}

/* Numbers where something changes: domain ends, switches, limits of the reductions, each with neighbours. */
static double special(uint32_t word, int single) {
    static const double places[] = {
        0.0, 0x1p-149, 0x1p-126, 1e-30, 0x1p-25, 0x1p-24, 0x1p-12, 1e-3, 0.125, 0.25, 0.28, 0.34657359, 0.375, 0.5,
        0.70710678, 0.75, 0.78539816, 1.0, 1.03972077, 1.41421356, 1.5, 1.57079633, 2.0, 2.35619449, 3.14159265, 4.0, 8.0,
        16.6355, 17.33, 36.73, 87.33654, 88.72284, 89.0, 103.97208, 104.0, 127.0, 128.0, 129.0, 149.0, 150.0, 708.3964185,
        709.782712893, 710.0, 744.4400719, 745.1332191, 746.0, 1022.0, 1023.0, 1024.0, 1074.0, 1075.0, 6433.98, 8192.0,
        1048576.0, 0x1p22, 0x1p23, 0x1p24, 0x1p31, 0x1p51, 0x1p52, 0x1p53, 0x1p63, 1e30, 0x1.fffffep127, 0x1p-1074,
        0x1p-1022, 1e-300, 0x1p-54, 0x1p-53, 0x1p-27, 1e300, 0x1.fffffffffffffp1023, INFINITY, NAN};
    double x = places[word % (sizeof places / sizeof places[0])];
    if ((word >> 8 & 3u) == 0) x = PI / 2 * (double)(word >> 16 & 4095u);
    int steps = (int)(word >> 28) - 8;
    if (single) {
        float f = (float)x;
        uint32_t bits = nph_bitsf(f) + (f > 1e-40f && f < 1e38f ? (uint32_t)steps : 0u);
        x = nph_from_bitsf(bits);
    } else if (x > 1e-320 && x < 1e308) {
        x = nph_from_bits(nph_bits(x) + (uint64_t)(int64_t)steps);
    }
    return word >> 10 & 1u ? -x : x;
}

static double any_bits(uint32_t high, uint32_t low, int single) {
    return single ? nph_from_bitsf(high) : nph_from_bits((uint64_t)high << 32 | low);
}

static double narrowed(double x, int single) { return single ? (double)(float)x : x; }

/* Four families: all bits, the middle exponents, special places, and what this function is delicate in. */
static void draw(int function, uint32_t i, int single, double *x, double *y) {
    NphWords w = nph_philox(11, (uint32_t)function, i, 0, 0, 0), v = nph_philox(12, (uint32_t)function, i, 0, 0, 0);
    double sign = v.w0 & 1u ? -1.0 : 1.0, range = single ? 150.0 : 1080.0;
    *x = any_bits(w.w0, w.w1, single);
    *y = any_bits(w.w2, w.w3, single);
    if (i % 4 == 1) *x = narrowed(sign * ldexp(1.0 + nph_uniform(w.w0), (int)(w.w1 % 40u) - 30), single);
    if (i % 4 == 1) *y = narrowed(ldexp(1.0 + nph_uniform(w.w2) + 0x1p-33 * w.w3, (int)(v.w1 % 40u) - 30), single);
    if (i % 4 == 2) *x = special(w.w0, single), *y = special(w.w1, single);
    double width = v.w1 % 3u == 0 ? 1.0 : v.w1 % 3u == 1 ? 10.0 : 750.0;
    double even = nph_uniform(w.w0) + 0x1p-32 * nph_uniform(w.w1);
    if (i % 4 == 3 && functions[function].exact) *x = narrowed(sign * width * even, single);
    if (function == F_POW && i % 4 != 2) {
        double from_one = ldexp(1.0 + nph_uniform(w.w0), -(int)(v.w2 % (single ? 22u : 50u)) - 2);
        if (i % 4 == 1) *x = narrowed(1.0 + sign * from_one, single);
        *x = fabs(*x);
        *y = narrowed(range * (2.0 * nph_uniform(w.w2) - 1.0) / log2(*x), single);
        if (i % 8 == 3) *y = (double)(v.w1 % 41u) - 20.0, *x *= sign;
    }
    if (function == F_ATAN2 && i % 4 == 3) *y = narrowed(*x * (1.0 + nph_uniform(w.w2)), single);
}

static void run(int function, int single, double *x, double *y, double *out, int count) {
    static float fx[BLOCK], fy[BLOCK], fout[BLOCK];
    if (!single) {
        fmath_lanes_f64_base(function, x, y, out, count);
        return;
    }
    for (int i = 0; i < count; i++) fx[i] = (float)x[i], fy[i] = (float)y[i];
    fmath_lanes_f32_base(function, fx, fy, fout, count);
    for (int i = 0; i < count; i++) out[i] = (double)fout[i];
}

static Worst worst_of_drawn(int function, int single, double normal_count) {
    static double x[BLOCK], y[BLOCK], out[BLOCK];
    Worst worst = {-1.0, 0.0, 0.0, 0, 0};
    uint32_t count = (uint32_t)(normal_count * effort());
    for (uint32_t first = 0; first < count; first += BLOCK) {
        for (uint32_t i = 0; i < BLOCK; i++) draw(function, first + i, single, &x[i], &y[i]);
        run(function, single, x, y, out, BLOCK);
        worst.tested += BLOCK;
        for (int i = 0; i < BLOCK; i++) judge(function, x[i], y[i], out[i], single, &worst);
    }
    return worst;
}

static Worst worst_of_all_floats(int function, double stride) {
    static double x[BLOCK], y[BLOCK], out[BLOCK];
    Worst worst = {-1.0, 0.0, 0.0, 0, 0};
    double limit = functions[function].limit[0];
    for (double at = 0; at < 4294967296.0;) {
        int count = 0;
        for (; count < BLOCK && at < 4294967296.0; at += stride) x[count++] = nph_from_bitsf((uint32_t)at);
        run(function, 1, x, y, out, count);
        for (int i = 0; i < count; i++) {
            double want = fabs(x[i]) > limit ? NAN : functions[function].libm(x[i]);
            worst.tested++;
            if (error_to(want, out[i], 1) > worst.error + 1e-4 || worst.tested % 61 == 0)
                judge(function, x[i], y[i], out[i], 1, &worst);
        }
    }
    return worst;
}

static void report(int function, int single, const char *how, Worst worst) {
    const char *name = functions[function].name, *precision = single ? "f32" : "f64";
    printf("%-7s %s %-6s worst %.3f ulp at %.17g", name, precision, how, worst.error, worst.x);
    if (functions[function].exact2) printf(", %.17g", worst.y);
    printf(" of %ld, %ld against MPFR\n", worst.tested, worst.judged);
    ck_assert_msg(worst.error <= (function == F_FLOOR ? 0.0 : 2.0), "%s (%s): %g ulp at %.17g, %.17g", name, precision,
                  worst.error, worst.x, worst.y);
}

START_TEST(floats_over_all_bit_patterns_are_within_2_ulp) {
    double stride = 2053.0 / effort();
    for (int function = 0; function < F_POW; function++)
        report(function, 1, "dense", worst_of_all_floats(function, stride < 1.0 ? 1.0 : stride));
}
END_TEST

START_TEST(floats_drawn_at_their_delicate_places_are_within_2_ulp) {
    for (int function = 0; function < F_COUNT; function++)
        report(function, 1, "drawn", worst_of_drawn(function, 1, function >= F_POW ? 40000 : 8000));
}
END_TEST

START_TEST(doubles_drawn_at_their_delicate_places_are_within_2_ulp) {
    for (int function = 0; function < F_COUNT; function++)
        report(function, 0, "drawn", worst_of_drawn(function, 0, function >= F_POW ? 40000 : 24000));
}
END_TEST

static int same(double a, double b) { return isnan(a) ? isnan(b) : a == b && signbit(a) == signbit(b); }

START_TEST(zeros_infinities_and_domain_ends_are_those_of_annex_f) {
    static const struct {
        int function;
        double x, y, want;
    } rows[] = {
        {F_EXP, -INFINITY, 0, 0.0},     {F_EXP, INFINITY, 0, INFINITY},  {F_EXP, -0.0, 0, 1.0},
        {F_EXPM1, -INFINITY, 0, -1.0},  {F_EXPM1, -0.0, 0, -0.0},        {F_EXPM1, INFINITY, 0, INFINITY},
        {F_EXP2, 0.0, 0, 1.0},          {F_EXP2, 3.0, 0, 8.0},           {F_EXP2, -INFINITY, 0, 0.0},
        {F_LOG, 0.0, 0, -INFINITY},     {F_LOG, -0.0, 0, -INFINITY},     {F_LOG, 1.0, 0, 0.0},
        {F_LOG, -1.0, 0, NAN},          {F_LOG, INFINITY, 0, INFINITY},  {F_LOG, -INFINITY, 0, NAN},
        {F_LOG1P, -0.0, 0, -0.0},       {F_LOG1P, -1.0, 0, -INFINITY},   {F_LOG1P, -1.5, 0, NAN},
        {F_LOG1P, INFINITY, 0, INFINITY}, {F_SIN, -0.0, 0, -0.0},        {F_SIN, INFINITY, 0, NAN},
        {F_COS, -0.0, 0, 1.0},          {F_COS, -INFINITY, 0, NAN},      {F_TAN, -0.0, 0, -0.0},
        {F_SIN2PI, 0.25, 0, 1.0},       {F_SIN2PI, -0.25, 0, -1.0},      {F_COS2PI, 0.5, 0, -1.0},
        {F_COS2PI, 1e9, 0, 1.0},        {F_SIN2PI, INFINITY, 0, NAN},    {F_COS2PI, NAN, 0, NAN},
        {F_ASIN, -0.0, 0, -0.0},        {F_ASIN, 1.0000002, 0, NAN},     {F_ACOS, 1.0, 0, 0.0},
        {F_ACOS, -1.0000002, 0, NAN},   {F_CBRT, -0.0, 0, -0.0},         {F_CBRT, -27.0, 0, -3.0},
        {F_CBRT, -INFINITY, 0, -INFINITY}, {F_FLOOR, -0.0, 0, -0.0},     {F_FLOOR, -0.5, 0, -1.0},
        {F_FLOOR, 0.5, 0, 0.0},         {F_FLOOR, -INFINITY, 0, -INFINITY}, {F_FLOOR, 2.5, 0, 2.0},
        {F_POW, NAN, 0.0, 1.0},         {F_POW, 1.0, NAN, 1.0},          {F_POW, -1.0, INFINITY, 1.0},
        {F_POW, -0.0, -3.0, -INFINITY}, {F_POW, -0.0, -2.0, INFINITY},   {F_POW, -0.0, 3.0, -0.0},
        {F_POW, 0.5, -INFINITY, INFINITY}, {F_POW, 2.0, -INFINITY, 0.0}, {F_POW, -INFINITY, 3.0, -INFINITY},
        {F_POW, -INFINITY, 0.5, INFINITY}, {F_POW, -8.0, 0.5, NAN},      {F_POW, -2.0, 3.0, -8.0},
        {F_POW, -INFINITY, -3.0, -0.0}, {F_POW, 2.0, NAN, NAN},          {F_POW, NAN, 2.0, NAN},
        {F_ATAN2, 1.0, -0.0, -0.0},     {F_ATAN2, 0.0, 0.0, 0.0},        {F_ATAN2, 1.0, NAN, NAN},
        {F_ATAN2, INFINITY, 5.0, 0.0},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        for (int single = 0; single < 2; single++) {
            double x = rows[i].x, y = rows[i].y, got = 0.0;
            run(rows[i].function, single, &x, &y, &got, 1);
            ck_assert_msg(same(got, rows[i].want), "%s(%g, %g) = %g, not %g", functions[rows[i].function].name, x, y, got,
                          rows[i].want);
        }
    ck_assert(nph_pow(-0.0, -1.0 + 0x1p-53) == INFINITY && nph_powf(-0.0f, -1.0f + 0x1p-24f) == INFINITY);
    ck_assert(nph_atan2(0.0, -0.0) == nph_acos(-1.0) && nph_atan2f(-0.0f, -0.0f) == -nph_acosf(-1.0f));
    ck_assert(nph_atan2(INFINITY, -INFINITY) > 2.356 && nph_atan2f(-INFINITY, -INFINITY) < -2.356f);
    ck_assert(isnan(nph_sinf(8193.0f)) && isnan(nph_tan(1048577.0)) && !isnan(nph_cosf(8192.0f)));
}
END_TEST

static uint64_t mix(uint64_t hash, double value) {
    return (hash ^ nph_bits(isnan(value) ? (double)NAN : value)) * 1099511628211u; /* FNV-1a, by words */
}

typedef void (*Lanes)(int function, const void *x, const void *y, void *out, int count);

/* A digest of all functions at their drawn arguments, as computed at a vector level. */
static uint64_t digest(int single, NphIsa isa) {
    static double x[BLOCK], y[BLOCK], out[BLOCK];
    static float fx[BLOCK], fy[BLOCK], fout[BLOCK];
    Lanes lanes;
    NPH_KERNEL_PICK(lanes, fmath_lanes, isa, single ? 32 : 64);
    uint64_t hash = 14695981039346656037u;
    for (int function = 0; function < F_COUNT; function++) {
        for (uint32_t i = 0; i < BLOCK; i++) {
            draw(function, i, single, &x[i], &y[i]);
            fx[i] = (float)x[i];
            fy[i] = (float)y[i];
        }
        if (single) lanes(function, fx, fy, fout, BLOCK);
        else lanes(function, x, y, out, BLOCK);
        for (int i = 0; i < BLOCK; i++) hash = mix(hash, single ? (double)fout[i] : out[i]);
    }
    return hash;
}

/* Levels are compared among each other: the arguments of pow come from the libm here. */
START_TEST(every_vector_level_gives_the_same_bits) {
    for (int single = 0; single < 2; single++) {
        uint64_t base = digest(single, NPH_ISA_BASE);
        for (int isa = NPH_ISA_AVX2; isa <= NPH_ISA_AVX512; isa++) {
            if ((NphIsa)isa > nph_cpu_isa()) nph_test_skip("a vector level this processor lacks");
            else ck_assert_uint_eq(digest(single, (NphIsa)isa), base);
        }
    }
}
END_TEST

/* Recorded once with gcc 12; any compiler, optimisation and processor must meet it. */
START_TEST(bits_are_the_recorded_ones) {
    static const uint64_t recorded[2] = {0x20f9bba5b61979c6u, 0x2b1bdff185b62325u};
    for (int single = 0; single < 2; single++) {
        uint64_t hash = 14695981039346656037u;
        for (int function = 0; function < F_COUNT; function++)
            for (uint32_t i = 0; i < BLOCK; i++) {
                NphWords w = nph_philox(21, (uint32_t)function, i, 0, 0, 0);
                double x = any_bits(w.w0, w.w1, single), y = any_bits(w.w2, w.w3, single), out;
                if (i % 2) x = nph_uniformf(w.w0) * (double)(i % 32) - 8.0, y = nph_uniformf(w.w1) * 4.0 - 2.0;
                if (single) x = (float)x, y = (float)y;
                run(function, single, &x, &y, &out, 1);
                hash = mix(hash, out);
            }
        printf("digest of the %s functions: 0x%016llx\n", single ? "f32" : "f64", (unsigned long long)hash);
        ck_assert_uint_eq(hash, recorded[single]);
    }
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, floats_over_all_bit_patterns_are_within_2_ulp);
    tcase_add_test(cases, floats_drawn_at_their_delicate_places_are_within_2_ulp);
    tcase_add_test(cases, doubles_drawn_at_their_delicate_places_are_within_2_ulp);
    tcase_add_test(cases, zeros_infinities_and_domain_ends_are_those_of_annex_f);
    tcase_add_test(cases, every_vector_level_gives_the_same_bits);
    tcase_add_test(cases, bits_are_the_recorded_ones);
}

int main(void) { return nph_test_main("fmath", fill); }
