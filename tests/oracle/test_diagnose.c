/* SPDX-License-Identifier: Apache-2.0
 *
 * What a diagnosis rests on: fits of a picture to another, noise lent to a picture without error bars, and mistakes made of a
 * finished picture, planted here by other code than that which finds them. */
#include "oracle/diagnose.h"
#include "pictures.h"

enum { SIDE_PIXELS = 64, SQUARE = SIDE_PIXELS * SIDE_PIXELS };
static const NphFitOptions plain = {.alpha = 1e-4};

/* A square, coloured picture without symmetry; Gaussian noise of a tenth of a sample's value, `samples` of them. */
static NphImage square(uint32_t seed, int samples) {
    static Moments moments[SQUARE];
    static double scene[SQUARE];
    NphImage image = synthetic_image(context, SIDE_PIXELS, SIDE_PIXELS, samples);
    for (int c = 0; c < 3; c++) {
        draw_pixels(&gaussian, seed * 4 + (uint32_t)c, SQUARE, samples, moments);
        for (int i = 0; i < SQUARE; i++) {
            double x = (i % SIDE_PIXELS + 0.5) / SIDE_PIXELS, y = (i / SIDE_PIXELS + 0.5) / SIDE_PIXELS;
            double blob = exp(-20.0 * ((x - 0.35) * (x - 0.35) + 2.0 * (y - 0.6) * (y - 0.6)));
            scene[i] = 0.05 + (0.2 + 0.1 * c) * x + (c == 1 ? 0.3 : 0.5) * blob;
        }
        synthetic_fill(&image, c, scene, moments, 0.2, 1.0);
    }
    return image;
}

static void strip(NphImage *image) {
    NphImage bare;
    ck_assert_int_eq(nph_image_new(context, image->width, image->height, &bare), NPH_OK);
    for (int c = 0; c < 3; c++) {
        float *out;
        ck_assert_int_eq(nph_image_add_channel(context, &bare, synthetic_names[c][0], &out), NPH_OK);
        memcpy(out, synthetic_plane(image, synthetic_names[c][0]), sizeof(float) * (size_t)(image->width * image->height));
    }
    nph_image_free(context, image);
    *image = bare;
}

static NphFit fit_once(NphImage a, NphImage b) {
    NphFit fit;
    ck_assert_int_eq(nph_fit(context, &a, &b, &plain, &fit), NPH_OK);
    nph_image_free(context, &a);
    nph_image_free(context, &b);
    return fit;
}

START_TEST(a_picture_of_another_seed_is_not_excluded_and_one_half_a_percent_brighter_is) {
    distribution_make(&gaussian, "Gaussian", gaussian_quantile);
    open_context();
    for (uint32_t seed = 1; seed < 9; seed++) {
        NphFit fit = fit_once(square(seed, 64), square(100 + seed, 32));
        ck_assert_msg(!fit.excluded && !fit.lent, "seed %u: %s", seed, fit.reason);
        ck_assert_double_lt(fabs(fit.ratio[3] - 1.0), 4.0 * fit.ratio_error[3]);
        NphImage brighter = square(seed, 64);
        brighten(&brighter, 1.005);
        ck_assert(fit_once(brighter, square(100 + seed, 32)).excluded);
    }
    close_context();
}
END_TEST

START_TEST(noise_is_lent_as_strong_as_it_is) {
    distribution_make(&gaussian, "Gaussian", gaussian_quantile);
    open_context();
    for (int samples = 8; samples <= 512; samples *= 8) {
        NphImage a = square(1, samples), b = square(2, 64), lent;
        double own = 0.0, estimated = 0.0;
        for (int i = 0; i < SQUARE; i++) own += (double)synthetic_plane(&a, "Variance.G")[i];
        strip(&a);
        ck_assert_int_eq(nph_lend_noise(context, &a, &b, 0.0, &lent), NPH_OK);
        for (int i = 0; i < SQUARE; i++) estimated += (double)synthetic_plane(&lent, "Variance.G")[i];
        nph_image_free(context, &lent);
        /* A - B holds 64 / samples + 1 parts; 3 SQUARE / 4 squares give it to 3%, four standard errors are 10% */
        double part = 64.0 / samples, allowed = 0.1 * (part + 1.0) / part + 0.05;
        ck_assert_msg(fabs(estimated / own - 1.0) < allowed, "%d samples: %g times the noise", samples, estimated / own);
        ck_assert(!fit_once(a, b).excluded);
    }
    close_context();
}
END_TEST

/* Moves the values of every layer: pixel (x, y) shows what was at where(x, y). */
typedef void Where(int x, int y, int from[2]);
static void move(NphImage *image, Where *where) {
    static float kept[SQUARE];
    for (int k = 0; k < image->channel_count; k++) {
        float *plane = image->channels[k].pixels;
        memcpy(kept, plane, sizeof kept);
        for (int i = 0; i < SQUARE; i++) {
            int from[2];
            where(i % SIDE_PIXELS, i / SIDE_PIXELS, from);
            plane[i] = kept[from[1] * SIDE_PIXELS + from[0]];
        }
    }
}
static void from_mirror(int x, int y, int from[2]) { from[0] = SIDE_PIXELS - 1 - x, from[1] = y; }
static void from_below(int x, int y, int from[2]) { from[0] = x, from[1] = SIDE_PIXELS - 1 - y; }
static void from_transpose(int x, int y, int from[2]) { from[0] = y, from[1] = x; }
static void from_left(int x, int y, int from[2]) { from[0] = x > 0 ? x - 1 : 0, from[1] = y; }
/* A turn clockwise puts the lower left corner at the upper left. */
static void from_clockwise(int x, int y, int from[2]) { from[0] = y, from[1] = SIDE_PIXELS - 1 - x; }

static void exchange(NphImage *image) {
    for (int k = 0; k < 2; k++) {
        float *red = synthetic_plane(image, synthetic_names[0][k]), *blue = synthetic_plane(image, synthetic_names[2][k]);
        for (int i = 0; i < SQUARE; i++) {
            float red_was = red[i];
            red[i] = blue[i];
            blue[i] = red_was;
        }
    }
}

static void scale(NphImage *image, const double factor[3]) {
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < SQUARE; i++) {
            synthetic_plane(image, synthetic_names[c][0])[i] *= (float)factor[c];
            synthetic_plane(image, synthetic_names[c][1])[i] *= (float)(factor[c] * factor[c]);
        }
}

/* Finds what was done to the picture; returns the best. */
static NphTransform find(NphImage a) {
    static NphTransform found[NPH_MAX_TRANSFORMS];
    static const NphConstant albedo = {"the albedo of fog", {0.9, 0.8, 0.5}};
    NphFitOptions options = plain;
    options.constant_count = 1;
    options.constants = &albedo;
    NphImage right = square(50, 64);
    int count = 0;
    ck_assert_int_eq(nph_fit_transforms(context, &a, &right, &options, &count, found), NPH_OK);
    ck_assert_int_gt(count, 0);
    nph_image_free(context, &a);
    nph_image_free(context, &right);
    return found[0];
}

START_TEST(what_was_done_to_a_finished_picture_is_named_first) {
    static const struct {
        Where *where;
        const char *name;
    } moves[] = {{from_mirror, "mirrored: left is right"}, {from_below, "upside down"}, {from_transpose, "rows are columns"},
                 {from_clockwise, "turned by 90 degrees clockwise"}};
    distribution_make(&gaussian, "Gaussian", gaussian_quantile);
    open_context();
    for (int i = 0; i < 4; i++) {
        NphImage a = square(3, 64);
        move(&a, moves[i].where);
        ck_assert_str_eq(find(a).name, moves[i].name);
    }
    NphImage a = square(3, 64);
    exchange(&a);
    ck_assert_str_eq(find(a).name, "red and blue exchanged");
    close_context();
}
END_TEST

START_TEST(a_factor_is_fitted_with_its_error_bar_and_named) {
    static const double pi4 = 12.566370614359172;
    static const struct {
        double factor[3];
        int factors;
        const char *known;
    } cases[] = {{{pi4, pi4, pi4}, 1, "4 pi"}, {{0.5, 0.5, 0.5}, 1, "1 / 2"}, {{0.9, 0.8, 0.5}, 3, "the albedo of fog"}, {{1.7, 1.7, 1.7}, 1, ""}};
    distribution_make(&gaussian, "Gaussian", gaussian_quantile);
    open_context();
    for (int i = 0; i < 4; i++) {
        NphImage a = square(3, 64);
        scale(&a, cases[i].factor);
        NphTransform found = find(a);
        ck_assert_str_eq(found.name, "a factor");
        ck_assert_str_eq(found.known, cases[i].known);
        ck_assert_int_eq(found.factors, cases[i].factors);
        for (int c = 0; c < 3; c++) ck_assert_double_lt(fabs(found.factor[c] - cases[i].factor[c]), 4.0 * found.factor_error[c]);
        ck_assert_double_lt(found.factor_error[1], 0.005 * found.factor[1]);
    }
    close_context();
}
END_TEST

START_TEST(a_shift_by_a_pixel_and_an_encoding_are_found) {
    distribution_make(&gaussian, "Gaussian", gaussian_quantile);
    open_context();
    NphImage a = square(3, 256);
    move(&a, from_left);
    NphImage right = square(50, 64);
    NphShift whole;
    ck_assert_int_eq(nph_fit_shift(context, &a, &right, &whole), NPH_OK);
    nph_image_free(context, &right);
    ck_assert_double_lt(fabs(whole.pixels[0] - 1.0), 4.0 * whole.error[0] + 0.05); /* the picture is curved */
    ck_assert_double_lt(fabs(whole.pixels[1]), 4.0 * whole.error[1] + 0.05);
    NphTransform found = find(a);
    ck_assert_str_eq(found.name, "shifted");
    ck_assert_msg(fabs(found.shift.pixels[0] - 1.0) < 4.0 * found.shift.error[0] && fabs(found.shift.pixels[1]) < 4.0 * found.shift.error[1],
                  "shifted by (%g +- %g, %g +- %g)", found.shift.pixels[0], found.shift.error[0], found.shift.pixels[1], found.shift.error[1]);
    ck_assert_double_lt(found.shift.error[0], 0.2);
    a = square(3, 256);
    strip(&a);
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < SQUARE; i++) {
            float *value = &synthetic_plane(&a, synthetic_names[c][0])[i];
            *value = *value <= 0.0031308f ? 12.92f * *value : 1.055f * powf(*value, 1.0f / 2.4f) - 0.055f;
        }
    ck_assert_str_eq(find(a).name, "encoded as sRGB");
    close_context();
}
END_TEST

START_TEST(the_picture_that_a_is_of_leads_over_one_with_the_same_noise_that_it_is_not_of) {
    distribution_make(&gaussian, "Gaussian", gaussian_quantile);
    open_context();
    NphImage a = square(3, 256), b = square(4, 64), other = square(4, 64);
    const NphImage *pictures[2] = {&b, &other};
    NphLead lead;
    mark_paired(&b, &other);
    brighten(&other, 1.02);
    ck_assert_int_eq(nph_fit_lead(context, &a, pictures, &plain, &lead), NPH_OK);
    NphFit fit = {0};
    ck_assert_int_eq(nph_fit(context, &a, &b, &plain, &fit), NPH_OK);
    ck_assert_msg(lead.score > 13.0 + 4.0 * lead.noise && lead.noise < 0.3 * fit.score_noise, "lead %g, noise %g of %g", lead.score, lead.noise,
                  fit.score_noise);
    nph_image_free(context, &a);
    nph_image_free(context, &b);
    nph_image_free(context, &other);
    close_context();
}
END_TEST

/* Mean lead and mean reach of pictures over one that is brighter by 0.3%, seen in a pair that shares its noise. */
static void lead_by(int samples, int pictures, int samples_of_pair, double *score, double *reach) {
    NphImage same = square(4, samples_of_pair), other = square(4, samples_of_pair);
    const NphImage *both[2] = {&same, &other};
    brighten(&other, 1.003);
    *score = *reach = 0.0;
    for (int i = 0; i < pictures; i++) {
        NphImage a = square(20 + (uint32_t)i, samples);
        NphLead lead;
        ck_assert_int_eq(nph_fit_lead(context, &a, both, &plain, &lead), NPH_OK);
        *score += lead.score / pictures;
        *reach += lead.reach / pictures;
        nph_image_free(context, &a);
    }
    nph_image_free(context, &same);
    nph_image_free(context, &other);
}

START_TEST(reach_bounds_the_mean_lead_and_grows_with_the_samples) {
    distribution_make(&gaussian, "Gaussian", gaussian_quantile);
    open_context();
    double score[3], reach[3];
    lead_by(4, 4, 4096, &score[0], &reach[0]);
    lead_by(16, 16, 4096, &score[1], &reach[1]);
    lead_by(16, 16, 16, &score[2], &reach[2]);
    /* Near 0 the score of Gaussian differences grows by 0.45 z^2 in the mean, the reach by 9/16 z^2; a lead's standard deviation is
     * sqrt(2 / 3 lead), three channels being independent here, and 16 pictures have a quarter of it. */
    ck_assert_msg(score[1] < 1.05 * reach[1] && score[1] > 0.6 * reach[1], "lead %g, reach %g", score[1], reach[1]);
    /* Four times the samples: 4, but for the floor of 0.2% beside a noise of 0.6% and of 0.3%. */
    ck_assert_msg(reach[1] > 2.5 * reach[0] && reach[1] < 4.0 * reach[0], "reach %g with 4 samples, %g with 16", reach[0], reach[1]);
    /* The noise of both pictures lowers the lead, not the reach. */
    ck_assert_msg(fabs(reach[2] / reach[1] - 1.0) < 0.15, "reach %g with noisy pictures, %g without", reach[2], reach[1]);
    close_context();
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, a_picture_of_another_seed_is_not_excluded_and_one_half_a_percent_brighter_is);
    tcase_add_test(cases, noise_is_lent_as_strong_as_it_is);
    tcase_add_test(cases, what_was_done_to_a_finished_picture_is_named_first);
    tcase_add_test(cases, a_factor_is_fitted_with_its_error_bar_and_named);
    tcase_add_test(cases, a_shift_by_a_pixel_and_an_encoding_are_found);
    tcase_add_test(cases, the_picture_that_a_is_of_leads_over_one_with_the_same_noise_that_it_is_not_of);
    tcase_add_test(cases, reach_bounds_the_mean_lead_and_grows_with_the_samples);
}

int main(void) { return nph_test_main("diagnose", fill); }
