/* SPDX-License-Identifier: Apache-2.0
 *
 * The extremes: small pictures at the ends of every range give a finite, right answer or a refusal that says why. Each
 * scene has at most 8 x 8 pixels and 16 samples. Hostile files are tested in tests/io and tests/scene. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "harness.h"
#include "render_case.h"

#define CAMERA "nephos: 1\ncamera: {type: perspective, resolution: [8, 8], position: [-2, -1.5, 1.2], look_at: [0.5, 0.5, 0.5], fov: 40}\n"
#define SKY "lights:\n  - {type: constant, radiance: 1}\n"
#define SUN_AND_SKY "lights:\n  - {type: constant, radiance: 1}\n  - {type: sun, direction: [-1, 0.3, 0.2], irradiance: 3}\n"

/* Every value of every channel is finite and not negative; means of R in [lo, hi]. */
static void check(const char *yaml, double lo, double hi) {
    for (int precision = 32; precision <= 64; precision += 32) {
        RenderCase render;
        NphRenderOptions options = render_options(16, precision);
        render_case(&render, yaml, &options, 0);
        for (int c = 0; c < render.image.channel_count; c++) {
            const NphChannel *channel = &render.image.channels[c];
            for (int i = 0; i < render.image.width * render.image.height; i++)
                ck_assert_msg(isfinite(channel->pixels[i]) && channel->pixels[i] >= 0.0f, "%s is %g\n%s", channel->name,
                              (double)channel->pixels[i], yaml);
        }
        double mean = render_mean(&render, "R");
        ck_assert_msg(mean >= lo && mean <= hi, "mean %.9g is not in %g to %g\n%s", mean, lo, hi, yaml);
        render_free(&render);
    }
}

static const char *box(const char *extinction, const char *albedo, const char *g) {
    return render_text("media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: %s, albedo: %s, phase: {type: hg, g: %s}}\n",
                       extinction, albedo, g);
}

START_TEST(extinction_from_nothing_to_opaque) {
    static const char *const thin[] = {"0", "1e-12", "1e-30"};
    for (int i = 0; i < 3; i++) check(render_text(CAMERA "%s" SKY, box(thin[i], "0", "0")), 1.0 - 1e-6, 1.0);
    static const char *const thick[] = {"1e4", "1e6", "1e9"};
    for (int i = 0; i < 3; i++) check(render_text(CAMERA "%s" SKY, box(thick[i], "0", "0")), 0.0, 0.95);
    if (nph_test_long("white and opaque")) check(render_text(CAMERA "%s" SKY, box("1e4", "1", "0")), 1.0, 1.0);
    check(render_text(CAMERA "%s" SKY, box("1e4", "0.5", "0.9")), 0.0, 1.0);
}
END_TEST

START_TEST(a_black_box_hides_exactly_its_silhouette) {
    RenderCase render;
    NphRenderOptions options = render_options(16, 32);
    render_case(&render, render_text("nephos: 1\n"
                                     "camera: {type: orthographic, resolution: [8, 8], position: [0.5, -3, 0.5],"
                                     " direction: [0, 1, 0], extent: 2}\n%s" SKY, box("1e9", "0", "0")), &options, 1);
    const NphChannel *r = nph_image_channel(&render.image, "R");
    for (int y = 0; y < 8; y++)
        for (int x = 0; x < 8; x++)
            ck_assert_float_eq(r->pixels[8 * y + x], x >= 2 && x < 6 && y >= 2 && y < 6 ? 0.0f : 1.0f);
    render_free(&render);
}
END_TEST

START_TEST(asymmetry_near_one_and_minus_one) {
    static const char *const gs[] = {"0.9999", "-0.9999", "0.99999", "-0.99999", "1e-9", "0"};
    for (int i = 0; i < 6; i++) {
        check(render_text(CAMERA "%s" SKY, box("5", "1", gs[i])), 1.0, 1.0);
        check(render_text(CAMERA "%s" SUN_AND_SKY, box("5", "0.9", gs[i])), 0.1, 1e6);
    }
}
END_TEST

START_TEST(one_pixel_one_voxel_and_the_camera_inside) {
    check(render_text("nephos: 1\ncamera: {type: perspective, resolution: [1, 1], position: [0.5, 0.5, 0.5],"
                      " direction: [1, 0, 0], fov: 90}\n%s" SUN_AND_SKY, box("3", "0.9", "0.5")), 0.1, 100.0);
    check(render_text("nephos: 1\ncamera: {type: perspective, resolution: [1, 8], position: [0.5, 0.5, 0.5],"
                      " direction: [0, 0, 1], up: [0, 1, 0], fov: 179}\n%s" SKY, box("3", "1", "0.5")), 1.0, 1.0);
}
END_TEST

START_TEST(suns_at_the_horizon_straight_up_and_below) {
    static const char *const suns[] = {"elevation: 0, azimuth: 0", "elevation: 90, azimuth: 0", "elevation: -90, azimuth: 0",
                                       "elevation: 1e-9, azimuth: 45", "direction: [1, 0, 0]"};
    for (int i = 0; i < 5; i++)
        for (int disc = 0; disc < 2; disc++)
            check(render_text(CAMERA "%slights:\n  - {type: sun, %s, irradiance: 1, angular_diameter: %s}\n",
                              box("3", "0.9", "0.5"), suns[i], disc ? "0.53" : "0"), 0.0, 1e5);
    check(render_text(CAMERA "media:\n  - {layer: [0, 1], extinction: 1, albedo: 0.9}\n"
                      "lights:\n  - {type: sun, elevation: 0, azimuth: 0, irradiance: 1}\n"), 0.0, 1.0);
}
END_TEST

START_TEST(light_from_1e_minus_30_to_1e30_scales_the_picture) {
    static const double levels[] = {1e-30, 1.0, 1e30};
    double mean[3];
    for (int i = 0; i < 3; i++) {
        RenderCase render;
        NphRenderOptions options = render_options(16, 32);
        render_case(&render, render_text(CAMERA "%slights:\n  - {type: constant, radiance: %g}\n  - {type: sun, direction: "
                                         "[-1, 0.3, 0.2], irradiance: %g}\n", box("3", "0.9", "0.5"), levels[i], levels[i]), &options, 1);
        mean[i] = render_mean(&render, "R") / levels[i];
        ck_assert(isfinite(mean[i]));
        render_free(&render);
    }
    ck_assert_double_eq_tol(mean[0] / mean[1], 1.0, 1e-5);
    ck_assert_double_eq_tol(mean[2] / mean[1], 1.0, 1e-5);
}
END_TEST

/* The same scene at the origin and 1e7 m away: in world space one f32 ulp would be 1 m there. */
/* The box moved by its transform, and written where it is: its edges are no floats. */
START_TEST(ten_million_metres_from_the_origin_is_the_same_picture) {
    static const double far[] = {0.0, 1e7, 1e7};
    RenderCase render[3];
    for (int i = 0; i < 3; i++) {
        NphRenderOptions options = render_options(16, 32);
        double a = far[i], box = i == 2 ? a : 0.0, shift = a - box;
        render_case(&render[i], render_text("nephos: 1\n"
                    "camera: {type: perspective, resolution: [8, 8], position: [%.17g, %.17g, %.17g], look_at: [%.17g, %.17g, %.17g], fov: 40}\n"
                    "media:\n  - {box: [[%.17g, %.17g, %.17g], [%.17g, %.17g, %.17g]], extinction: 4, albedo: 0.9, phase: {type: hg, g: 0.5}, transform: [{translate: [%.17g, %.17g, %.17g]}]}\n"
                    SUN_AND_SKY, a - 2, a - 1.5, a + 1.25, a + 0.5, a + 0.5, a + 0.5, box, box, box, box + 1, box + 1, box + 1,
                    shift, shift, shift), &options, 1);
    }
    const NphChannel *near = nph_image_channel(&render[0].image, "R");
    for (int i = 1; i < 3; i++) {
        const NphChannel *away = nph_image_channel(&render[i].image, "R");
        int equal = 0;
        for (int p = 0; p < 64; p++) equal += fabsf(near->pixels[p] - away->pixels[p]) <= 1e-4f * near->pixels[p];
        ck_assert_int_ge(equal, 60); /* a path may flip where a rounding decides; positions are exact in both */
    }
    for (int i = 0; i < 3; i++) render_free(&render[i]);
}
END_TEST

/* Camera rays are moved to the box of all media before they become floats: a layer begins before it. */
START_TEST(a_box_behind_a_layer_hides_nothing_of_the_layer) {
    RenderCase render;
    NphRenderOptions options = render_options(256, 32);
    render_case(&render, "nephos: 1\n"
                "camera: {type: orthographic, resolution: [16, 16], position: [0, 0, 2], direction: [1, 0, -1], extent: 0.01}\n"
                "media:\n  - {layer: [0, 1], extinction: 1, albedo: 0}\n"
                "  - {box: [[10, -1, -10], [12, 1, -8]], extinction: 1e-9, albedo: 0}\n"
                "lights:\n  - {type: constant, radiance: 1}\n", &options, 0);
    double mean = render_mean(&render, "R"), truth = exp(-sqrt(2.0)), error = sqrt(truth * (1.0 - truth) / (256.0 * 256.0));
    printf("    %.5f, closed form %.5f, z %+.2f\n", mean, truth, (mean - truth) / error);
    ck_assert_double_le(fabs(mean - truth), 4.0 * error);
    render_free(&render);
}
END_TEST

/* The shadow of an opaque box of 2 m, nine metres above a flux sensor of 6 m: light samples start at the sensor. */
START_TEST(a_flux_sensor_sees_the_sharp_shadow_of_what_is_far_above_it) {
    RenderCase render;
    NphRenderOptions options = render_options(16, 32);
    render_case(&render, "nephos: 1\n"
                "camera: {type: flux, resolution: [6, 6], position: [0, 0, 0], direction: [0, 0, 1], up: [0, 1, 0], extent: 6}\n"
                "media:\n  - {box: [[-1, -1, 9], [1, 1, 10]], extinction: 1000, albedo: 0}\n"
                "lights:\n  - {type: sun, direction: [0, 0, 1], irradiance: 2}\n", &options, 0);
    const NphChannel *r = nph_image_channel(&render.image, "R");
    for (int p = 0; p < 36; p++) {
        int dark = p % 6 >= 2 && p % 6 < 4 && p / 6 >= 2 && p / 6 < 4;
        ck_assert_msg(fabsf(r->pixels[p] - (dark ? 0.0f : 2.0f)) < 1e-6f, "pixel %d,%d is %g", p % 6, p / 6, (double)r->pixels[p]);
    }
    render_free(&render);
}
END_TEST

static void refuse(const char *yaml, NphStatus expected, const char *word) {
    RenderCase render;
    NphRenderOptions options = render_options(16, 32);
    NphStatus status = render_try(&render, yaml, &options, 1);
    const char *messages = nph_test_messages();
    ck_assert_msg(status == expected, "%s instead of %s: %s\n%s", nph_status_name(status), nph_status_name(expected), messages, yaml);
    ck_assert_msg(strstr(messages, word) != NULL, "no '%s' in: %s", word, messages);
    render_free(&render);
}

START_TEST(values_out_of_range_are_refused_by_line) {
    refuse(render_text(CAMERA "%s" SKY, box("3", "1", "2")), NPH_BAD_SCENE, "test.yaml:4:");
    refuse(render_text(CAMERA "%s" SKY, box("-3", "1", "0")), NPH_BAD_SCENE, "test.yaml:4:");
    refuse(render_text(CAMERA "%s" SKY, box("1e10", "1", "0")), NPH_BAD_SCENE, "test.yaml:4:");
    refuse(render_text(CAMERA "%s" SKY, box("3", "1.0001", "0")), NPH_BAD_SCENE, "test.yaml:4:");
    refuse(render_text(CAMERA "%s" SKY, box(".nan", "1", "0")), NPH_BAD_SCENE, "test.yaml:4:");
    refuse(render_text(CAMERA "%s" SKY, box(".inf", "1", "0")), NPH_BAD_SCENE, "test.yaml:4:");
    refuse(CAMERA "media:\n  - {box: [[0, 0, 0], [1, 0, 1]], extinction: 1}\n", NPH_BAD_SCENE, "test.yaml:4:");
    refuse(CAMERA "media:\n  - {box: [[0, 0, 2], [1, 1, 1]], extinction: 1}\n", NPH_BAD_SCENE, "test.yaml:4:");
    refuse(CAMERA "media:\n  - {layer: [1, 1], extinction: 1}\n", NPH_BAD_SCENE, "test.yaml:4:");
    refuse("nephos: 1\ncamera: {type: perspective, resolution: [0, 8], position: [0, 0, 0], look_at: [1, 0, 0], fov: 40}\n", NPH_BAD_SCENE, "test.yaml:2:");
    refuse("nephos: 1\ncamera: {type: perspective, resolution: [-4, 8], position: [0, 0, 0], look_at: [1, 0, 0], fov: 40}\n", NPH_BAD_SCENE, "test.yaml:2:");
    refuse("nephos: 1\ncamera: {type: perspective, resolution: [99999999999, 8], position: [0, 0, 0], look_at: [1, 0, 0], fov: 40}\n", NPH_BAD_SCENE, "test.yaml:2:");
}
END_TEST

START_TEST(a_memory_limit_is_kept_before_the_run) {
    NphSettings settings;
    nph_settings_default(&settings);
    settings.threads = 1;
    settings.memory_limit_bytes = 2 << 20;
    NphContext *context = NULL;
    ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
    const char *yaml = render_text("nephos: 1\ncamera: {type: perspective, resolution: [4096, 4096], position: [-2, -1.5, 1.2],"
                                   " look_at: [0.5, 0.5, 0.5], fov: 40}\n%s" SKY, box("3", "1", "0"));
    NphScene *scene = NULL;
    NphFilm *film = NULL;
    ck_assert_int_eq(nph_scene_parse(context, yaml, strlen(yaml), "test.yaml", ".", &scene), NPH_OK);
    NphRenderOptions options = render_options(16, 32);
    ck_assert_int_eq(nph_render(context, scene, &options, &film, NULL), NPH_NO_MEMORY);
    ck_assert_ptr_null(film);
    nph_scene_free(context, scene);
    ck_assert_uint_eq(nph_context_bytes(context), 0);
    nph_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, extinction_from_nothing_to_opaque);
    tcase_add_test(cases, a_black_box_hides_exactly_its_silhouette);
    tcase_add_test(cases, asymmetry_near_one_and_minus_one);
    tcase_add_test(cases, one_pixel_one_voxel_and_the_camera_inside);
    tcase_add_test(cases, suns_at_the_horizon_straight_up_and_below);
    tcase_add_test(cases, light_from_1e_minus_30_to_1e30_scales_the_picture);
    tcase_add_test(cases, ten_million_metres_from_the_origin_is_the_same_picture);
    tcase_add_test(cases, a_box_behind_a_layer_hides_nothing_of_the_layer);
    tcase_add_test(cases, a_flux_sensor_sees_the_sharp_shadow_of_what_is_far_above_it);
    tcase_add_test(cases, values_out_of_range_are_refused_by_line);
    tcase_add_test(cases, a_memory_limit_is_kept_before_the_run);
}

int main(void) { return nph_test_main("extremes", fill); }
