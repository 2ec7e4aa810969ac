/* SPDX-License-Identifier: Apache-2.0
 *
 * The comparator's own error rates, measured: 500 pairs of pictures of four sample distributions, 64 samples a pixel,
 * with equal expectations (verdicts must not be different) and 0.2% too bright (they must be). The printed table is the
 * one of docs/compare.md. NEPHOS_CALIBRATION_TIMES=6 takes six times as many pairs. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "nephos/compare.h"
#include "synthetic.h"

enum { WIDTH = 104, HEIGHT = 24, PIXELS = WIDTH * HEIGHT, SAMPLES = 64, MANY = 512, PAIRS = 500, FEW = 100 };

/* Noise of the three channels: one and the same, or each its own. Renderers lie between. */
typedef enum Noise { GREY, COLOURS } Noise;

static Distribution distributions[4];
static int times = 1;
static double scenes[3][PIXELS];
static NphContext *context;

/* How one kind of pair is made from the moments of its two pictures. Counts are of verdicts. */
typedef struct Scenario {
    const char *title;
    int pairs;
    double error_a, error_b; /* relative, of the mean, as the pictures state them; 0: as drawn; < 0: none, exact */
    double bias;
    int most_different, least_different, most_same, least_same;
} Scenario;

static const Scenario scenarios[] = {
    {"equal, noise as drawn", PAIRS, 0, 0, 0, 5, 0, PAIRS, 0},
    {"equal, standard errors 0.03%", FEW, 3e-4, 3e-4, 0, 1, 0, FEW, 0},
    {"equal, standard errors 0.001%", FEW, 1e-5, 1e-5, 0, 0, 0, FEW, FEW},
    {"0.2% brighter, 0.03% against 0.003%", PAIRS, 3e-4, 3e-5, 0.002, PAIRS, 495, 5, 0},
    {"0.2% brighter, both 0.03%", FEW, 3e-4, 3e-4, 0.002, FEW, 80, 1, 0},
    {"0.2% brighter, both 0.1%", FEW, 1e-3, 1e-3, 0.002, FEW, 0, 1, 0},
    {"0.3% brighter, both 0.001%", FEW, 1e-5, 1e-5, 0.003, FEW, FEW, 0, 0},
    {"equal, A against the exact picture", FEW, 0, -1, 0, FEW, 0, FEW, 0},
};
enum { SCENARIOS = sizeof scenarios / sizeof *scenarios };

/* The relative standard error of its mean that a picture with the noise as drawn states. */
static double stated_error(const Moments *moments) {
    double sum = 0.0, square = 0.0;
    for (int i = 0; i < PIXELS; i++) {
        sum += scenes[0][i];
        square += scenes[0][i] * scenes[0][i] * moments[i].variance_of_mean;
    }
    return sqrt(square) / sum;
}

/* Part of the pixels whose 95% Student interval holds their expectation. */
static double coverage(const Moments *moments) {
    double quantile = nph_student_quantile(0.975, SAMPLES - 1.0);
    int covered = 0;
    for (int i = 0; i < PIXELS; i++) {
        covered += fabs(moments[i].mean - 1.0) <= quantile * sqrt(moments[i].variance_of_mean);
    }
    return (double)covered / PIXELS;
}

static NphVerdict judge(const NphImage *a, const NphImage *b) {
    NphCompareOptions options;
    NphComparison comparison;
    nph_compare_options_default(&options);
    ck_assert_int_eq(nph_compare(context, a, b, &options, &comparison, NULL), NPH_OK);
    return comparison.verdict;
}

/* The two pictures of a scenario from the moments [picture][channel]. */
static NphVerdict judge_scenario(const Scenario *scenario, Noise noise, Moments moments[2][3][PIXELS],
                                 NphImage pictures[2]) {
    const double errors[2] = {scenario->error_a, scenario->error_b};
    for (int k = 0; k < 2; k++) {
        double factor = errors[k] < 0.0 ? 0.0 : errors[k] > 0.0 ? errors[k] / stated_error(moments[k][0]) : 1.0;
        for (int c = 0; c < 3; c++) {
            synthetic_fill(&pictures[k], c, scenes[noise == GREY ? 0 : c], moments[k][noise == GREY ? 0 : c], factor,
                           k == 0 ? 1.0 + scenario->bias : 1.0);
        }
    }
    return judge(&pictures[0], &pictures[1]);
}

static void print_counts(const char *title, int counts[3], int pairs) {
    printf("  %-38s different %5.1f%%  same %5.1f%%  inconclusive %5.1f%%  of %d\n", title,
           100.0 * counts[NPH_NOT_SAME] / pairs, 100.0 * counts[NPH_SAME] / pairs,
           100.0 * counts[NPH_INCONCLUSIVE] / pairs, pairs);
    fflush(stdout); /* a failing assertion ends the process */
}

static void calibrate(const Distribution *distribution, Noise noise) {
    if (!nph_test_statistics("calibration of the comparator")) return;
    static Moments moments[2][3][PIXELS];
    int counts[SCENARIOS][3] = {{0}};
    double covered = 0.0;
    NphImage pictures[2];
    context = nph_test_context(1);
    for (int k = 0; k < 2; k++) pictures[k] = synthetic_image(context, WIDTH, HEIGHT, SAMPLES);
    for (int pair = 0; pair < PAIRS * times; pair++) {
        for (int k = 0; k < 2; k++) {
            for (int c = 0; c < (noise == GREY ? 1 : 3); c++) {
                draw_pixels(distribution, (uint32_t)(pair * 8 + k * 4 + c), PIXELS, SAMPLES, moments[k][c]);
            }
        }
        covered += coverage(moments[0][0]) / (PAIRS * times);
        for (int s = 0; s < SCENARIOS; s++) {
            if (pair < scenarios[s].pairs * times) counts[s][judge_scenario(&scenarios[s], noise, moments, pictures)]++;
        }
    }
    printf("%s, %s: a pixel's 95%% interval covers %.1f%%\n", distribution->name,
           noise == GREY ? "grey" : "colours", 100.0 * covered);
    for (int s = 0; s < SCENARIOS; s++) print_counts(scenarios[s].title, counts[s], scenarios[s].pairs * times);
    for (int s = 0; s < SCENARIOS; s++) {
        ck_assert_int_le(counts[s][NPH_NOT_SAME], scenarios[s].most_different * times);
        ck_assert_int_ge(counts[s][NPH_NOT_SAME], scenarios[s].least_different * times);
        ck_assert_int_le(counts[s][NPH_SAME], scenarios[s].most_same * times);
        ck_assert_int_ge(counts[s][NPH_SAME], scenarios[s].least_same * times);
    }
    for (int k = 0; k < 2; k++) nph_image_free(context, &pictures[k]);
    nph_test_context_close(context);
}

START_TEST(gaussian_samples_keep_the_promised_rates) { calibrate(&distributions[0], GREY); }
END_TEST
START_TEST(colours_keep_the_promised_rates) { calibrate(&distributions[0], COLOURS); }
END_TEST
START_TEST(exponential_samples_keep_the_promised_rates) { calibrate(&distributions[1], GREY); }
END_TEST
START_TEST(lognormal_samples_keep_the_promised_rates) { calibrate(&distributions[2], GREY); }
END_TEST
START_TEST(fireflies_keep_the_promised_rates) { calibrate(&distributions[3], GREY); }
END_TEST

/* Few samples miss the tail that many have seen: their mean is mostly low, and so is their own error bar. */
START_TEST(few_samples_against_many_raise_no_false_alarm) {
    if (!nph_test_statistics("comparator, few samples against many")) return;
    static Moments few[PIXELS], many[PIXELS];
    context = nph_test_context(1);
    int counts[3] = {0}, brighter[3] = {0};
    NphImage a = synthetic_image(context, WIDTH, HEIGHT, SAMPLES), b = synthetic_image(context, WIDTH, HEIGHT, MANY);
    for (int pair = 0; pair < FEW; pair++) {
        draw_pixels(&distributions[2], (uint32_t)(2 * pair), PIXELS, SAMPLES, few);
        draw_pixels(&distributions[2], (uint32_t)(2 * pair + 1), PIXELS, MANY, many);
        double noise = 3e-4 / stated_error(few);
        for (int c = 0; c < 3; c++) {
            synthetic_fill(&a, c, scenes[0], few, 1.0, 1.0);
            synthetic_fill(&b, c, scenes[0], many, 1.0, 1.0);
        }
        counts[judge(&a, &b)]++;
        for (int c = 0; c < 3; c++) {
            synthetic_fill(&a, c, scenes[0], few, noise, 1.002);
            synthetic_fill(&b, c, scenes[0], many, noise, 1.0);
        }
        brighter[judge(&a, &b)]++;
    }
    printf("lognormal, grey, 64 samples against 512\n");
    print_counts("equal, noise as drawn", counts, FEW);
    print_counts("0.2% brighter, A 0.03%", brighter, FEW);
    ck_assert_int_le(counts[NPH_NOT_SAME], 1);
    ck_assert_int_ge(brighter[NPH_NOT_SAME], 93);
    ck_assert_int_le(brighter[NPH_SAME], 1);
    nph_image_free(context, &a);
    nph_image_free(context, &b);
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    const char *more = getenv("NEPHOS_CALIBRATION_TIMES");
    if (more) times = atoi(more) > 1 ? atoi(more) : 1;
    for (int c = 0; c < 3; c++) synthetic_scene(WIDTH, HEIGHT, c, scenes[c]);
    distribution_make(&distributions[0], "gaussian", gaussian_quantile);
    distribution_make(&distributions[1], "exponential", exponential_quantile);
    distribution_make(&distributions[2], "lognormal", lognormal_quantile);
    distribution_make(&distributions[3], "fireflies", firefly_quantile);
    tcase_add_test(cases, gaussian_samples_keep_the_promised_rates);
    tcase_add_test(cases, colours_keep_the_promised_rates);
    tcase_add_test(cases, exponential_samples_keep_the_promised_rates);
    tcase_add_test(cases, lognormal_samples_keep_the_promised_rates);
    tcase_add_test(cases, fireflies_keep_the_promised_rates);
    tcase_add_test(cases, few_samples_against_many_raise_no_false_alarm);
}

int main(void) { return nph_test_main("calibration", fill); }
