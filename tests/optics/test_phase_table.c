/* SPDX-License-Identifier: Apache-2.0
 *
 * Tabulated phase functions: exact normalisation, mean cosine and inversion, the sharp peak of the C.1 cloud and peaks
 * almost as narrow as a delta, agreement with Henyey and Greenstein's, and what is refused. */
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "io/phase_rows.h"
#include "phase_checks.h"

static NphArray rows_of(NphContext *context, const double (*rows)[2], int count) {
    NphArray array;
    ck_assert_int_eq(nph_array_new(context, NPH_F64, 2, (int64_t[]){count, 2}, "rows", &array), NPH_OK);
    memcpy(array.data, rows, (size_t)count * sizeof rows[0]);
    return array;
}

static NphStatus tabulate(NphContext *context, const double (*rows)[2], int count, NphPhase *phase) {
    NphArray array = rows_of(context, rows, count);
    NphStatus status = nph_phase_tabulate(context, &array, "table", phase);
    nph_array_free(context, &array);
    return status;
}

static NphPhase cloud(NphContext *context) {
    NphArray rows;
    NphPhase phase;
    ck_assert_msg(nph_phase_rows_read(context, nph_test_path("reference/data/gpl/c1_phase.txt"), &rows) == NPH_OK, "%s",
                  nph_test_messages());
    ck_assert_int_eq(nph_phase_tabulate(context, &rows, "c1", &phase), NPH_OK);
    nph_array_free(context, &rows);
    return phase;
}

/* hg at steps of a degree's part. */
static NphPhase table_of_hg(NphContext *context, double g, int count) {
    double (*rows)[2] = malloc((size_t)count * sizeof *rows);
    NphPhase phase;
    for (int i = 0; i < count; i++) {
        double sine = sin(PI / 2 * i / (count - 1)), rest = 1.0 - g, d = rest * rest + 4.0 * g * sine * sine;
        rows[i][0] = 180.0 * i / (count - 1);
        rows[i][1] = 1e-5 / (d * sqrt(d)); /* at any scale */
    }
    ck_assert_int_eq(tabulate(context, (const double(*)[2])rows, count, &phase), NPH_OK);
    free(rows);
    return phase;
}

static const double spike[][2] = {{0, 3e12}, {0.001, 3e12}, {0.0011, 0}, {60, 0}, {90, 1}, {179.99, 2}, {179.995, 7e9}, {180, 0}};
static const double uneven[][2] = {{0, 1}, {10, 5}, {89.9, 0.1}, {90.2, 4}, {140, 0}, {150, 0}, {180, 0.5}};
static const double flat[][2] = {{0, 7}, {180, 7}};
static const double hidden[][2] = {{0, 0}, {60, 0}, {61, 3}, {62, 0}, {180, 0}};
enum { TABLES = 6 };

static NphPhase table_number(NphContext *context, int number) {
    NphPhase phase = {.kind = NPH_PHASE_ISOTROPIC};
    if (number == 0) ck_assert_int_eq(tabulate(context, spike, 8, &phase), NPH_OK);
    if (number == 1) ck_assert_int_eq(tabulate(context, uneven, 7, &phase), NPH_OK);
    if (number == 2) ck_assert_int_eq(tabulate(context, flat, 2, &phase), NPH_OK);
    if (number == 3) ck_assert_int_eq(tabulate(context, hidden, 5, &phase), NPH_OK);
    if (number == 4) phase = cloud(context);
    if (number == 5) phase = table_of_hg(context, 0.999, 20001);
    return phase;
}

/* Over every interval a sum of Gauss's 2 points is exact, in values as kernels see them. */
static void exact_integral(const NphPhase *phase, double out[2]) {
    out[0] = out[1] = 0.0;
    for (int h = 0; h < 2; h++) {
        const NphPhaseHalf *half = &phase->table->half[h];
        for (int i = 0; i < half->count; i++)
            for (int k = -1; k <= 1; k += 2) {
                double w = half->x[i + 1] - half->x[i], x = half->x[i] + w * (0.5 + k * 0.28867513459481287), y = 2.0 - x, p;
                values(0, phase, h ? &y : &x, h ? &x : &y, &p, 1);
                out[0] += PI * w * p;
                out[1] += PI * w * p * (h ? x - 1.0 : 1.0 - x);
            }
    }
}

START_TEST(every_table_is_normalised_and_has_its_mean_cosine) {
    NphContext *context = nph_test_context(1);
    for (int i = 0; i < TABLES; i++) {
        NphPhase phase = table_number(context, i);
        double got[2];
        exact_integral(&phase, got);
        ck_assert_msg(fabs(got[0] - 1.0) < 1e-12, "table %d: norm - 1 = %g", i, got[0] - 1.0);
        ck_assert_msg(fabs(got[1] - nph_phase_mean_cosine(&phase)) < 1e-12, "table %d: %.15g, not %.15g", i, got[1],
                      nph_phase_mean_cosine(&phase));
        const NphPhaseHalf *half = phase.table->half;
        ck_assert(half[0].part[half[0].count] + half[1].part[half[1].count] == 1.0);
        for (int h = 0; h < 2; h++)
            for (int k = 0; k < half[h].count; k++) ck_assert(half[h].part[k] <= half[h].part[k + 1] && half[h].x[k] < half[h].x[k + 1]);
        nph_phase_free(context, &phase);
    }
    nph_test_context_close(context);
}
END_TEST

/* Facts of the file, found with another program: the mean over the sphere 1.00045, the trapezoid in cos of the file as
 * printed; mean cosine 0.84807; 1712.88 at 0, 0.02689 at 105.2 degrees, 0.650 at 180. */
START_TEST(the_c1_cloud_keeps_its_peak) {
    NphContext *context = nph_test_context(1);
    NphPhase phase = cloud(context);
    double at[3] = {0.0, 105.2, 180.0}, want[3] = {1712.88, 0.02689, 0.650};
    for (int single = 0; single < 2; single++)
        for (int i = 0; i < 3; i++) {
            double half = sin(at[i] * PI / 360), other = cos(at[i] * PI / 360), fall = 2 * half * half, rise = 2 * other * other, p;
            values(single, &phase, &fall, &rise, &p, 1);
            ck_assert_msg(fabs(4 * PI * 1.00045 * p / want[i] - 1.0) < 3e-4, "at %g: %g", at[i], 4 * PI * p);
        }
    ck_assert_double_eq_tol(nph_phase_mean_cosine(&phase), 0.84807, 2e-5);
    ck_assert_double_eq_tol(nph_phase_peak(&phase) * 4 * PI * 1.00045, 1712.88, 0.5);
    nph_phase_free(context, &phase);
    nph_test_context_close(context);
}
END_TEST

/* Draws counted in eighths of the table's intervals against integrals of the value, exact by the 2 points; neighbours
 * are joined until 50 draws are expected. */
static void count_draws(int single, const NphPhase *phase, uint32_t seed, const char *what) {
    enum { SAMPLES = 200000, PARTS = 8 };
    static double fall[SAMPLES], rise[SAMPLES], cosine[SAMPLES];
    double sum = 0.0, waiting = 0.0, expected = 0.0;
    int degrees = -1;
    draw(single, phase, seed, SAMPLES, (double *[]){fall, rise, cosine});
    for (int h = 0; h < 2; h++) {
        const NphPhaseHalf *half = &phase->table->half[h];
        double *count = calloc((size_t)half->count * PARTS, sizeof *count);
        for (int i = 0; i < SAMPLES; i++) {
            double x = h ? rise[i] : fall[i];
            if (h ? rise[i] >= fall[i] : fall[i] > rise[i]) continue;
            int low = 0, high = half->count;
            while (high - low > 1) *(half->x[(low + high) / 2] <= x ? &low : &high) = (low + high) / 2;
            int piece = (int)(PARTS * (x - half->x[low]) / (half->x[low + 1] - half->x[low]));
            count[low * PARTS + (piece < PARTS ? piece : PARTS - 1)]++;
        }
        for (int i = 0; i < half->count * PARTS; i++) {
            double w = (half->x[i / PARTS + 1] - half->x[i / PARTS]) / PARTS, middle = half->x[i / PARTS] + w * (i % PARTS + 0.5);
            for (int k = -1; k <= 1; k += 2) {
                double x = middle + k * w * 0.28867513459481287, y = 2.0 - x, p;
                values(0, phase, h ? &y : &x, h ? &x : &y, &p, 1);
                expected += SAMPLES * PI * w * p;
            }
            waiting += count[i];
            EXPECT(count[i] == 0 || expected > 0, "%s: drawn where the value is 0", what);
            if (expected < 50) continue;
            sum += (waiting - expected) * (waiting - expected) / expected;
            waiting = expected = 0.0;
            degrees++;
        }
        free(count);
    }
    printf("%s %s: chi-square %.1f of %d\n", what, single ? "f32" : "f64", sum, degrees);
    ck_assert_int_ge(degrees, 8);
    ck_assert_msg(sum < degrees + 4.5 * sqrt(2.0 * degrees), "%s: chi-square %g of %d", what, sum, degrees);
}

START_TEST(sampling_follows_the_value) {
    NphContext *context = nph_test_context(1);
    for (int i = 0; i < TABLES; i++) {
        NphPhase phase = table_number(context, i);
        char name[32];
        snprintf(name, sizeof name, "table %d", i);
        for (int single = 0; single < 2; single++) count_draws(single, &phase, 600u + (uint32_t)i, name);
        nph_phase_free(context, &phase);
    }
    nph_test_context_close(context);
}
END_TEST

/* The part of the distribution between a drawn angle and its pole, integrated with the table's own values. */
static double tail_of(const NphPhaseHalf *half, double x) {
    int i = 0;
    while (i + 1 < half->count && half->x[i + 1] <= x) i++;
    double w = half->x[i + 1] - half->x[i], t = (x - half->x[i]) / w, a = half->value[i], b = half->value[i + 1];
    return half->part[i] + 2 * PI * w * t * (a + 0.5 * t * (b - a));
}

START_TEST(sampling_inverts_the_distribution) {
    NphContext *context = nph_test_context(1);
    for (int n = 0; n < TABLES; n++) {
        NphPhase phase = table_number(context, n);
        for (uint32_t k = 0; k <= 4096; k++) {
            uint32_t word = k == 4096 ? 0xffffffffu : k << 20, lobe = 0;
            double u = word / 4294967296.0, fall, rise, cosine, p;
            phase_draw_f64_base(&phase, &word, &lobe, (double *[]){&fall, &rise, &cosine}, 1);
            int front = !(u < phase.table->half[1].part[phase.table->half[1].count]);
            EXPECT(front ? fall <= rise : rise <= fall, "table %d: u %.9g: fall %g", n, u, fall);
            double tail = front ? 1.0 - u : u, back = tail_of(&phase.table->half[!front], front ? fall : rise);
            EXPECT(fabs(back - tail) <= 1e-12 * tail + 1e-15, "table %d: u %.9g, tail %.17g, not %.17g", n, u, back, tail);
            values(0, &phase, &fall, &rise, &p, 1);
            EXPECT(p > 0.0 || k == 0 || k == 4096, "table %d: u %.9g drew a direction of density 0", n, u);
        }
        nph_phase_free(context, &phase);
    }
    nph_test_context_close(context);
}
END_TEST

/* Linear interpolation of hg at steps of h errs by h^2 p'' / 8 at most. */
START_TEST(a_table_of_henyey_greenstein_is_henyey_greenstein) {
    NphContext *context = nph_test_context(1);
    NphPhase table = table_of_hg(context, 0.85, 18001), exact = hg(0.85);
    ck_assert_double_eq_tol(nph_phase_mean_cosine(&table), 0.85, 1e-6);
    for (int k = 0; k <= 1000; k++) {
        double fall = 2.0 * pow(10.0, -0.006 * k), rise = 2.0 - fall, a, b;
        values(k & 1, &table, &fall, &rise, &a, 1);
        values(0, &exact, &fall, &rise, &b, 1);
        ck_assert_msg(fabs(a / b - 1.0) < 1e-5, "fall %g: %g, not %g", fall, a, b);
    }
    nph_phase_free(context, &table);
    nph_test_context_close(context);
}
END_TEST

static void expect_refusal(const double (*rows)[2], int count, const char *words) {
    NphContext *context = nph_test_context(1);
    NphPhase phase = {.weight = 0.25};
    ck_assert_int_eq(tabulate(context, rows, count, &phase), NPH_BAD_INPUT);
    const char *messages = nph_test_messages();
    ck_assert_msg(strstr(messages, words) != NULL, "'%s' lacks '%s'", messages, words);
    ck_assert(phase.weight == 0.25 && phase.table == NULL);
    nph_test_context_close(context);
}

START_TEST(what_is_no_distribution_is_refused) {
    expect_refusal(flat, 1, "fewer than two rows");
    expect_refusal((const double[][2]){{0, 0}, {180, 0}}, 2, "all values are 0");
    expect_refusal((const double[][2]){{0, 1}, {180, -1}}, 2, "row 2");
    expect_refusal((const double[][2]){{0, 1}, {180.5, 1}}, 2, "row 2");
    expect_refusal((const double[][2]){{-1, 1}, {180, 1}}, 2, "row 1");
    expect_refusal((const double[][2]){{0, 1}, {30, 1}, {30, 2}, {180, 1}}, 4, "row 3");
    expect_refusal((const double[][2]){{0, 1}, {30, (double)NAN}, {180, 1}}, 3, "row 2");
    expect_refusal((const double[][2]){{0, 1}, {(double)NAN, 1}, {180, 1}}, 3, "row 2");
    expect_refusal((const double[][2]){{0, 1}, {1e-4, 0}, {180, 0}}, 3, "peak of");
}
END_TEST

/* Below 90 degrees steps of the angle's last digit are narrower than those of the sine: some pairs coincide. */
START_TEST(angles_of_equal_cosines_are_refused) {
    NphContext *context = nph_test_context(1);
    double angle = 89.99;
    int refused = 0;
    for (int k = 0; k < 20; k++, angle = nextafter(angle, 180.0)) {
        NphPhase phase = {.kind = NPH_PHASE_ISOTROPIC};
        NphStatus status = tabulate(context, (const double[][2]){{0, 1}, {angle, 1}, {nextafter(angle, 180.0), 2}, {180, 1}}, 4, &phase);
        if (status != NPH_OK) {
            ck_assert(strstr(nph_test_messages(), "so close") != NULL);
            refused++;
        } else {
            ck_assert(phase.table->half[0].x[1] < phase.table->half[0].x[2]);
        }
        nph_phase_free(context, &phase);
    }
    ck_assert_int_gt(refused, 0);
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_table_that_does_not_reach_the_poles_goes_on_and_says_so) {
    NphContext *context = nph_test_context(1);
    static const double short_rows[][2] = {{20, 3}, {100, 1}}, whole[][2] = {{0, 3}, {20, 3}, {100, 1}, {180, 1}};
    static const double one_side[][2] = {{120, 2}, {150, 1}}, other[][2] = {{0, 2}, {120, 2}, {150, 1}, {180, 1}};
    for (int i = 0; i < 2; i++) {
        NphPhase a, b;
        ck_assert_int_eq(tabulate(context, i ? one_side : short_rows, 2, &a), NPH_OK);
        const char *messages = nph_test_messages();
        ck_assert(strstr(messages, i ? "begins at 120 degrees" : "begins at 20 degrees") != NULL);
        ck_assert(strstr(messages, i ? "ends at 150 degrees" : "ends at 100 degrees") != NULL);
        ck_assert_int_eq(tabulate(context, i ? other : whole, 4, &b), NPH_OK);
        ck_assert_str_eq(nph_test_messages(), "");
        for (int k = 0; k <= 50; k++) {
            double c = 1.0 - k / 25.0;
            ck_assert_double_eq_tol(nph_phase_value(&a, c), nph_phase_value(&b, c), 1e-15);
        }
        nph_phase_free(context, &a);
        nph_phase_free(context, &b);
    }
    nph_test_context_close(context);
}
END_TEST

START_TEST(every_failing_allocation_is_reported_and_leaks_nothing) {
    NphSettings settings;
    nph_settings_default(&settings);
    settings.threads = 1;
    for (settings.fail_allocation = 2;; settings.fail_allocation++) { /* the first one is the array's here */
        NphContext *context = NULL;
        NphPhase phase = {.weight = 0.25};
        ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
        NphArray array = rows_of(context, uneven, 7);
        NphStatus status = nph_phase_tabulate(context, &array, "table", &phase);
        int done = nph_context_allocations(context) < settings.fail_allocation;
        ck_assert_int_eq(status, done ? NPH_OK : NPH_NO_MEMORY);
        ck_assert(done || (phase.weight == 0.25 && phase.table == NULL));
        nph_phase_free(context, &phase);
        nph_array_free(context, &array);
        nph_test_context_close(context);
        if (done) break;
    }
    ck_assert_uint_ge(settings.fail_allocation, 6);
}
END_TEST

START_TEST(every_vector_level_gives_the_same_bits) {
    enum { COUNT = 1000 };
    static double results[2][4][COUNT];
    NphContext *context = nph_test_context(1);
    uint32_t u[COUNT], lobe[COUNT];
    for (uint32_t i = 0; i < COUNT; i++) {
        u[i] = nph_philox(23, 0, i, 0, 0, 0).w0;
        lobe[i] = 0;
    }
    if (nph_cpu_isa() < NPH_ISA_AVX512) nph_test_skip("a vector level this processor lacks");
    for (int i = 0; i < 2 * TABLES; i++) {
        NphPhase phase = table_number(context, i / 2);
        for (int isa = NPH_ISA_BASE; isa <= (int)nph_cpu_isa(); isa++) {
            int bits = i % 2 ? 32 : 64;
            double (*r)[COUNT] = results[isa != NPH_ISA_BASE];
            void (*draws)(const NphPhase *, const uint32_t *, const uint32_t *, double *const *, int);
            void (*value)(const NphPhase *, const double *, const double *, double *, int);
            NPH_KERNEL_PICK(draws, phase_draw, isa, bits);
            NPH_KERNEL_PICK(value, phase_value, isa, bits);
            draws(&phase, u, lobe, (double *[]){r[0], r[1], r[2]}, COUNT);
            value(&phase, r[0], r[1], r[3], COUNT);
            if (isa != NPH_ISA_BASE) ck_assert_int_eq(memcmp(results[0], results[1], sizeof results[0]), 0);
        }
        nph_phase_free(context, &phase);
    }
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, every_table_is_normalised_and_has_its_mean_cosine);
    tcase_add_test(cases, the_c1_cloud_keeps_its_peak);
    tcase_add_test(cases, sampling_follows_the_value);
    tcase_add_test(cases, sampling_inverts_the_distribution);
    tcase_add_test(cases, a_table_of_henyey_greenstein_is_henyey_greenstein);
    tcase_add_test(cases, what_is_no_distribution_is_refused);
    tcase_add_test(cases, angles_of_equal_cosines_are_refused);
    tcase_add_test(cases, a_table_that_does_not_reach_the_poles_goes_on_and_says_so);
    tcase_add_test(cases, every_failing_allocation_is_reported_and_leaks_nothing);
    tcase_add_test(cases, every_vector_level_gives_the_same_bits);
}

int main(void) { return nph_test_main("phase_table", fill); }
