/* SPDX-License-Identifier: Apache-2.0
 *
 * Right scenes become exactly the values they write down; how they are written makes no difference. */
#include <fenv.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "harness.h"
#include "scene/model.h"

static NphScene *parse(NphContext *context, const char *text) {
    NphScene *scene = NULL;
    NphStatus status = nph_scene_parse(context, text, strlen(text), "folder/name.yaml", NULL, &scene);
    ck_assert_msg(status == NPH_OK && scene, "%s\n%s", text, nph_test_messages());
    return scene;
}

static void check3(const double *values, double x, double y, double z) {
    ck_assert_msg(values[0] == x && values[1] == y && values[2] == z, "%.17g %.17g %.17g, not %.17g %.17g %.17g",
                  values[0], values[1], values[2], x, y, z);
}

#define CAMERA "camera: {resolution: [4, 3], position: [0, -4, 0], look_at: [0, 0, 0], fov: 35}\n"
#define HEAD "nephos: 1\n" CAMERA

static const char everything[] =
    "nephos: 1\n"
    "camera:\n"
    "  type: orthographic\n"
    "  resolution: [400, 300]\n"
    "  position: [1, -2, .5]\n"
    "  direction: [0, 3, 0]\n"
    "  extent: 2.0\n"
    "  crop: [10, 20, 30, 40]\n"
    "media:\n"
    "  - name: fog\n"
    "    box: [[-1, -2, -3], [1, 2, +3]]\n"
    "    extinction: [1e1, 20, 30.5]\n"
    "    albedo: [0, .5, 1]\n"
    "    phase: {type: two_lobe, g: 0.85, g2: -0.3, weight: 0.9}\n"
    "  - layer: [100, 200]\n"
    "    scattering: [3, 0, 0]\n"
    "    absorption: [1, 2, 0]\n"
    "    phase: {type: rayleigh}\n"
    "  - box: [[0, 0, 0], [1, 1, 1]]\n"
    "    extinction: 0\n"
    "lights:\n"
    "  - {type: sun, direction: [0, 0, 5], irradiance: [3, 2, 1], angular_diameter: 60}\n"
    "  - {type: constant, radiance: 1e35, hemisphere: lower}\n"
    "  - {type: point, position: [7, 8, 9], intensity: 1e-30}\n"
    "  - {type: sun, elevation: 90, azimuth: 17, irradiance: 1}\n"
    "render: {samples: 100, seed: 4294967295}\n";

START_TEST(the_camera_is_what_the_scene_writes) {
    NphContext *context = nph_test_context(1);
    NphScene *scene = parse(context, everything);
    ck_assert_str_eq(scene->name, "name.yaml");
    const NphSensor *s = &scene->sensor;
    ck_assert_int_eq(s->kind, NPH_SENSOR_ORTHOGRAPHIC);
    ck_assert(s->width == 400 && s->height == 300);
    ck_assert(s->crop[0] == 10 && s->crop[1] == 20 && s->crop[2] == 30 && s->crop[3] == 40);
    check3(s->position, 1, -2, 0.5);
    check3(s->forward, 0, 1, 0);
    check3(s->right, 1, 0, 0);
    check3(s->up, 0, 0, 1);
    ck_assert(s->half_size[1] == 1 && s->half_size[0] == 1 * (400.0 / 300.0));
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(sensors_and_periods_are_what_the_scene_writes) {
    static const char *const head = "nephos: 1\ncamera: {resolution: [6, 3], position: [1, 2, 3], direction: [0, 0, -2], up: [0, 1, 0], ";
    NphContext *context = nph_test_context(1);
    char text[512];
    snprintf(text, sizeof text, "%stype: fisheye, fov: 180}\nperiodic: {y: [-1, 3]}\n", head);
    NphScene *fish = parse(context, text);
    ck_assert_int_eq(fish->sensor.kind, NPH_SENSOR_FISHEYE);
    ck_assert_double_eq_tol(fish->sensor.half_size[1], 1.5707963267948966, 1e-15);
    ck_assert_double_eq_tol(fish->sensor.half_size[0], 3.1415926535897931, 1e-15);
    ck_assert(!fish->period.on[0] && fish->period.on[1] && fish->period.lo[1] == -1 && fish->period.hi[1] == 3);
    snprintf(text, sizeof text, "%stype: fluence, extent: 5}\nperiodic: {x: [0, 1], y: [2, 4]}\n", head);
    NphScene *fluence = parse(context, text);
    ck_assert_int_eq(fluence->sensor.kind, NPH_SENSOR_FLUENCE);
    ck_assert(fluence->sensor.half_size[0] == 5 && fluence->sensor.half_size[1] == 2.5);
    ck_assert(fluence->period.on[0] && fluence->period.hi[0] == 1 && fluence->period.lo[1] == 2);
    snprintf(text, sizeof text, "%stype: radiance, extent: 5, seen: [3, 0, 4]}\n", head);
    NphScene *radiance = parse(context, text);
    ck_assert_int_eq(radiance->sensor.kind, NPH_SENSOR_RADIANCE);
    ck_assert_double_eq_tol(radiance->sensor.seen[0], 0.6, 1e-15);
    ck_assert_double_eq_tol(radiance->sensor.seen[2], 0.8, 1e-15);
    check3(radiance->sensor.forward, 0, 0, -1);
    ck_assert(!radiance->period.on[0] && !radiance->period.on[1]);
    nph_scene_free(context, fish);
    nph_scene_free(context, fluence);
    nph_scene_free(context, radiance);
    nph_test_context_close(context);
}
END_TEST

/* What changes the picture changes the digest: the direction seen, and each end of each period. */
START_TEST(periods_and_the_direction_seen_enter_the_digest) {
    static const char *const ends[] = {"seen: [0, 0, 1]}\n", "seen: [0, 1, 1]}\n", "seen: [0, 0, 1]}\nperiodic: {x: [0, 1]}\n",
                                       "seen: [0, 0, 1]}\nperiodic: {y: [0, 1]}\n", "seen: [0, 0, 1]}\nperiodic: {x: [0, 2]}\n",
                                       "seen: [0, 0, 1]}\nperiodic: {x: [-1, 1]}\n",
                                       "seen: [0, 0, 1]}\nperiodic: {x: [0, 1], y: [0, 1]}\n"};
    enum { MANY = sizeof ends / sizeof *ends };
    NphContext *context = nph_test_context(1);
    NphScene *scenes[MANY];
    for (int i = 0; i < MANY; i++) {
        char text[512];
        snprintf(text, sizeof text, "nephos: 1\ncamera: {type: radiance, resolution: [6, 3], position: [1, 2, 3], "
                 "direction: [0, 1, 0], extent: 2, %s", ends[i]);
        scenes[i] = parse(context, text);
        for (int j = 0; j < i; j++) ck_assert(memcmp(scenes[i]->digest, scenes[j]->digest, 16) != 0);
    }
    for (int i = 0; i < MANY; i++) nph_scene_free(context, scenes[i]);
    nph_test_context_close(context);
}
END_TEST

START_TEST(the_media_are_what_the_scene_writes) {
    NphContext *context = nph_test_context(1);
    NphScene *scene = parse(context, everything);
    ck_assert_int_eq(scene->medium_count, 3);
    const NphMedium *m = scene->media;
    ck_assert_str_eq(m[0].name, "fog");
    ck_assert_str_eq(m[1].name, "medium1");
    ck_assert(m[0].shape == NPH_SHAPE_BOX && m[1].shape == NPH_SHAPE_LAYER && m[2].shape == NPH_SHAPE_BOX);
    check3(m[0].lo, -1, -2, -3);
    check3(m[0].hi, 1, 2, 3);
    check3(m[0].extinction_per_m, 10, 20, 30.5);
    check3(m[0].albedo, 0, 0.5, 1);
    ck_assert(m[0].phase.kind == NPH_PHASE_TWO_LOBE && m[0].phase.g[0] == 0.85 && m[0].phase.g[1] == -0.3);
    ck_assert(m[0].phase.weight == 0.9);
    check3(m[1].lo, -HUGE_VAL, -HUGE_VAL, 100);
    check3(m[1].hi, HUGE_VAL, HUGE_VAL, 200);
    check3(m[1].extinction_per_m, 4, 2, 0);
    check3(m[1].albedo, 0.75, 0, 1);
    ck_assert_int_eq(m[1].phase.kind, NPH_PHASE_RAYLEIGH);
    check3(m[2].extinction_per_m, 0, 0, 0);
    check3(m[2].albedo, 1, 1, 1);
    ck_assert_int_eq(m[2].phase.kind, NPH_PHASE_ISOTROPIC);
    for (int i = 0; i < 12; i++) ck_assert(m[0].world_from_medium[i] == (i == 0 || i == 5 || i == 10));
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(phase_functions_are_what_the_scene_writes) {
    NphContext *context = nph_test_context(1);
    NphScene *scene = parse(context, HEAD "media:\n- {layer: [0, 1], extinction: 1, phase: {type: draine, g: -0.25, alpha: 37}}\n");
    const NphPhase *phase = &scene->media[0].phase;
    ck_assert(phase->kind == NPH_PHASE_DRAINE && phase->g[0] == -0.25 && phase->alpha == 37 && phase->table == NULL);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(wavelengths_spread_rgb_keys_over_spectra) {
    NphContext *context = nph_test_context(1);
    NphScene *scene = parse(context, HEAD
        "media:\n"
        "- {layer: [0, 1], extinction: [8, 4, 2, 1], albedo: 0.5}\n"
        "- {layer: [2, 3], scattering: [1, 1, 3, 1], absorption: [1, 3, 1, 0]}\n"
        "lights:\n- {type: sun, elevation: 3, azimuth: 0, irradiance: [1, 2, 3, 4]}\n- {type: constant, radiance: 7}\n"
        "- {type: point, position: [0, 0, 0], intensity: [0, 0, 0, 1e-30]}\n"
        "surfaces: [{plane: 0, albedo: [0, .1, .2, .3]}]\n"
        "wavelengths: [400, 500.5, 600, 830]\n"); /* read before the others wherever it stands */
    ck_assert_int_eq(scene->wavelength_count, 4);
    ck_assert(scene->wavelengths_nm[1] == 500.5 && scene->wavelengths_nm[3] == 830);
    const NphMedium *m = scene->media;
    static const double extinction[] = {8, 4, 2, 1}, sum[] = {2, 4, 4, 1}, share[] = {0.5, 0.25, 0.75, 1}, E[] = {1, 2, 3, 4};
    static const double reflected[] = {0, .1, .2, .3};
    for (int i = 0; i < 4; i++) {
        ck_assert(m[0].extinction_spectrum[i] == extinction[i] && m[0].albedo_spectrum[i] == 0.5);
        ck_assert(m[1].extinction_spectrum[i] == sum[i] && m[1].albedo_spectrum[i] == share[i]);
        ck_assert(scene->lights[0].spectrum[i] == E[i] && scene->lights[1].spectrum[i] == 7);
        ck_assert(scene->surfaces[0].albedo_spectrum[i] == reflected[i]);
    }
    check3(m[0].extinction_per_m, 1.5, 3, 6); /* upper, middle, lower third, overlapping: not a whole number each */
    ck_assert(scene->lights[2].intensity[0] > 0); /* black only where all of it is */
    double channels[3];
    nph_scene_channels(scene, 1, m[0].extinction_per_m, m[0].extinction_spectrum, channels);
    check3(channels, 4, 1, 1); /* of two groups the second: wavelengths 1 and 3, the latter repeated */
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(one_wavelength_is_a_grey_scene) {
    NphContext *context = nph_test_context(1);
    NphScene *scene = parse(context, HEAD "wavelengths: [550]\nmedia: [{layer: [0, 1], extinction: [3]}]\n");
    check3(scene->media[0].extinction_per_m, 3, 3, 3);
    ck_assert(!nph_scene_is_spectral(scene));
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(the_digest_sees_wavelengths_and_spectra) {
    NphContext *context = nph_test_context(1);
    static const char *const texts[] = {
        HEAD "media: [{layer: [0, 1], extinction: 1}]\n", HEAD "media: [{layer: [0, 1], extinction: 1}]\nwavelengths: [500, 600]\n",
        HEAD "media: [{layer: [0, 1], extinction: 1}]\nwavelengths: [500, 601]\n",
        HEAD "media: [{layer: [0, 1], extinction: [1, 1.5]}]\nwavelengths: [500, 600]\n",
        HEAD "media: [{layer: [0, 1], extinction: [1, 1]}]\nwavelengths: [500, 600]\n"};
    uint8_t digest[5][16];
    for (int i = 0; i < 5; i++) {
        NphScene *scene = parse(context, texts[i]);
        memcpy(digest[i], scene->digest, 16);
        nph_scene_free(context, scene);
    }
    for (int i = 0; i < 5; i++)
        for (int k = 0; k < i; k++) ck_assert((memcmp(digest[i], digest[k], 16) == 0) == (i == 4 && k == 1));
    nph_test_context_close(context);
}
END_TEST

START_TEST(the_lights_and_the_run_are_what_the_scene_writes) {
    NphContext *context = nph_test_context(1);
    NphScene *scene = parse(context, everything);
    ck_assert_int_eq(scene->light_count, 4);
    const NphLight *l = scene->lights;
    ck_assert_int_eq(l[0].kind, NPH_LIGHT_SUN);
    check3(l[0].direction, 0, 0, 1);
    check3(l[0].irradiance, 3, 2, 1);
    ck_assert_double_eq_tol(l[0].half_angle_rad, 0.52359877559829887, 1e-16);
    ck_assert_int_eq(l[1].kind, NPH_LIGHT_CONSTANT);
    check3(l[1].radiance, 1e35, 1e35, 1e35);
    ck_assert_int_eq(l[1].hemisphere, -1);
    ck_assert_int_eq(l[2].kind, NPH_LIGHT_POINT);
    check3(l[2].position, 7, 8, 9);
    check3(l[2].intensity, 1e-30, 1e-30, 1e-30);
    check3(l[3].direction, 0, 0, 1);
    ck_assert(l[3].half_angle_rad == 0);
    ck_assert(scene->default_spp == 100 && scene->default_seed == 4294967295u);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(planes_are_what_the_scene_writes) {
    NphContext *context = nph_test_context(1);
    double lo[3], hi[3], origin[3];
    NphScene *scene = parse(context, HEAD "surfaces:\n- {name: ground, plane: -2.5, albedo: [.1, .2, .3]}\n- plane: 7.5\n");
    ck_assert_int_eq(scene->surface_count, 2);
    const NphSurface *s = scene->surfaces;
    ck_assert_str_eq(s[0].name, "ground");
    ck_assert_str_eq(s[1].name, "surface1");
    ck_assert(s[0].is_plane && s[0].height_m == -2.5 && s[1].is_plane && s[1].height_m == 7.5);
    check3(s[0].albedo, .1, .2, .3);
    check3(s[1].albedo, .5, .5, .5);
    ck_assert_ptr_null(scene->bvh.nodes);
    nph_scene_bounds(scene, lo, hi);
    ck_assert(lo[0] > hi[0] && lo[1] > hi[1] && lo[2] == -2.5 && hi[2] == 7.5);
    nph_scene_origin(scene, origin);
    check3(origin, 0, -4, 2.5); /* the sensor's position along the plane */
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(left_out_keys_take_their_defaults) {
    NphContext *context = nph_test_context(1);
    NphScene *scene = parse(context, HEAD "media: []\nlights:\n- {type: constant, radiance: 1}\n");
    ck_assert_int_eq(scene->sensor.kind, NPH_SENSOR_PERSPECTIVE);
    ck_assert(scene->sensor.crop[0] == 0 && scene->sensor.crop[1] == 0 && scene->sensor.crop[2] == 4 &&
              scene->sensor.crop[3] == 3);
    ck_assert(scene->medium_count == 0 && scene->light_count == 1);
    ck_assert_int_eq(scene->lights[0].hemisphere, 0);
    ck_assert(scene->default_spp == 64 && scene->default_seed == 1);
    double lo[3], hi[3];
    nph_scene_bounds(scene, lo, hi);
    for (int i = 0; i < 3; i++) ck_assert(lo[i] > hi[i]);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(the_frame_is_orthonormal_and_the_field_of_view_is_that_of_the_shorter_side) {
    NphContext *context = nph_test_context(1);
    NphScene *scene =
        parse(context, "nephos: 1\ncamera: {resolution: [300, 600], position: [1, 2, 3], look_at: [-4, 1, 0.5], "
                       "up: [0.1, 0.2, 1], fov: 90}\n");
    const NphSensor *s = &scene->sensor;
    const double *axes[3] = {s->right, s->up, s->forward};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double dot = axes[i][0] * axes[j][0] + axes[i][1] * axes[j][1] + axes[i][2] * axes[j][2];
            ck_assert_double_eq_tol(dot, i == j, 4e-16);
        }
    double length = sqrt(25 + 1 + 6.25);
    ck_assert_double_eq_tol(s->forward[0], -5 / length, 2e-16);
    ck_assert_double_eq_tol(s->forward[2], -2.5 / length, 2e-16);
    ck_assert(s->up[2] > 0); /* right = forward x up: seen from the camera, up is up and right is right */
    const double *f = s->forward, cross[3] = {f[1] - f[2] * 0.2, f[2] * 0.1 - f[0], f[0] * 0.2 - f[1] * 0.1};
    double length_of_cross = sqrt(cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]);
    for (int i = 0; i < 3; i++) ck_assert_double_eq_tol(s->right[i], cross[i] / length_of_cross, 4e-16);
    ck_assert_double_eq_tol(s->half_size[0], 1, 2e-16);
    ck_assert_double_eq_tol(s->half_size[1], 2, 4e-16);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(directions_far_from_unit_length_are_normalised_without_loss) {
    NphContext *context = nph_test_context(1);
    NphScene *scene = parse(context, HEAD "lights:\n- {type: sun, direction: [3e-300, 0, 4e-300], irradiance: 1}\n"
                                          "- {type: sun, direction: [3e11, 4e11, 0], irradiance: 1}\n");
    check3(scene->lights[0].direction, 0.6, 0, 0.8);
    check3(scene->lights[1].direction, 0.6, 0.8, 0);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(azimuth_runs_from_x_to_y) {
    NphContext *context = nph_test_context(1);
    NphScene *scene = parse(context, HEAD "lights:\n- {type: sun, elevation: 0, azimuth: 0, irradiance: 1}\n"
                                          "- {type: sun, elevation: 0, azimuth: 90, irradiance: 1}\n"
                                          "- {type: sun, elevation: 30, azimuth: -60, irradiance: 1}\n");
    check3(scene->lights[0].direction, 1, 0, 0);
    check3(scene->lights[1].direction, 0, 1, 0);
    const double *d = scene->lights[2].direction;
    ck_assert_double_eq_tol(d[0], sqrt(3) / 4, 2e-16);
    ck_assert_double_eq_tol(d[1], -0.75, 2e-16);
    ck_assert_double_eq_tol(d[2], 0.5, 2e-16);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(transform_steps_apply_in_the_order_they_are_written) {
    NphContext *context = nph_test_context(1);
    NphScene *scene = parse(context, HEAD
        "media:\n"
        "- box: [[0, 0, 0], [1, 2, 3]]\n"
        "  extinction: 1\n"
        "  transform: [{scale: 2}, {rotate: {axis: [0, 0, 7], angle: 90}}, {translate: [10, 20, 30]}]\n"
        "- box: [[0, 0, 0], [1, 2, 3]]\n"
        "  extinction: 1\n"
        "  transform: [{translate: [10, 20, 30]}, {rotate: {axis: [0, 0, 7], angle: 90}}, {scale: [2, -1, 1]}]\n"
        "- box: [[0, 0, 0], [1, 2, 3]]\n"
        "  extinction: 1\n"
        "  transform:\n"
        "  - matrix: [0, -2, 0, 10,\n"
        "             2,  0, 0, 20,\n"
        "             0,  0, 2, 30]\n"
        "- layer: [1, 2]\n"
        "  extinction: 1\n"
        "  transform: [{rotate: {axis: [0, 0, -1], angle: 33}}, {scale: 3}, {translate: [5, 5, 100]}]\n");
    double lo[3], hi[3];
    /* x' = -2 y + 10, y' = 2 x + 20, z' = 2 z + 30 */
    nph_medium_bounds(&scene->media[0], lo, hi);
    check3(lo, 6, 20, 30);
    check3(hi, 10, 22, 36);
    for (int i = 0; i < 12; i++)
        ck_assert_double_eq(scene->media[0].world_from_medium[i], scene->media[2].world_from_medium[i]);
    /* x' = -2 (y + 20), y' = -(x + 10), z' = z + 30 */
    nph_medium_bounds(&scene->media[1], lo, hi);
    check3(lo, -44, -11, 30);
    check3(hi, -40, -10, 33);
    nph_medium_bounds(&scene->media[3], lo, hi);
    check3(lo, -HUGE_VAL, -HUGE_VAL, 103);
    check3(hi, HUGE_VAL, HUGE_VAL, 106);
    nph_scene_bounds(scene, lo, hi);
    check3(lo, -44, -11, 30);
    check3(hi, 10, 22, 106);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(rotation_follows_the_right_hand_rule_about_any_axis) {
    NphContext *context = nph_test_context(1);
    NphScene *scene = parse(context, HEAD "media:\n- box: [[0, 0, 0], [1, 1, 1]]\n  extinction: 1\n"
                                          "  transform: [{rotate: {axis: [1, 1, 1], angle: 120}}]\n"
                                          "- box: [[0, 0, 0], [1, 1, 1]]\n  extinction: 1\n"
                                          "  transform: [{rotate: {axis: [1, 2, 2], angle: 77}}]\n");
    static const double cyclic[9] = {0, 0, 1, 1, 0, 0, 0, 1, 0}; /* x -> y -> z -> x */
    const double *map = scene->media[0].world_from_medium, *other = scene->media[1].world_from_medium;
    for (int i = 0; i < 9; i++) ck_assert_double_eq_tol(map[i / 3 * 4 + i % 3], cyclic[i], 4e-16);
    for (int i = 0; i < 3; i++) /* the axis stays */
        ck_assert_double_eq_tol(other[i * 4] + 2 * other[i * 4 + 1] + 2 * other[i * 4 + 2], i ? 2 : 1, 1e-15);
    ck_assert_double_eq_tol(other[0] + other[5] + other[10], 1 + 2 * cos(77 * 3.14159265358979323846 / 180), 1e-15);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(an_inverse_undoes_its_map_and_singular_maps_have_none) {
    double map[12] = {2, 1, 0, 5, 0, -3, 1, 7, 1, 0, 4, -9}, inverse[12], product[12];
    ck_assert(nph_affine_invert(map, inverse));
    nph_affine_multiply(map, inverse, product);
    for (int i = 0; i < 12; i++) ck_assert_double_eq_tol(product[i], i % 5 == 0, 8e-15); /* sums near 30 */
    double tiny[12] = {1e-9, 0, 0, 0, 0, 1e9, 0, 0, 0, 0, 1, 0};
    ck_assert(nph_affine_invert(tiny, inverse));
    ck_assert_double_eq(inverse[0], 1e9);
    double flat[12] = {1, 2, 3, 0, 2, 4, 7, 0, 3, 6, 1, 0}, kept = inverse[5];
    ck_assert(!nph_affine_invert(flat, inverse));
    ck_assert(inverse[5] == kept);
    double nearly[12] = {1, 1, 0, 0, 1, 1 + 1e-13, 0, 0, 0, 0, 1, 0},
           barely[12] = {1, 1, 0, 0, 1, 1 + 1e-11, 0, 0, 0, 0, 1, 0};
    ck_assert(!nph_affine_invert(nearly, inverse));
    ck_assert(inverse[5] == kept);
    ck_assert(nph_affine_invert(barely, inverse));
    kept = inverse[5];
    double endless[12] = {HUGE_VAL, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    ck_assert(!nph_affine_invert(endless, inverse));
}
END_TEST

static void check_same_digest(NphContext *context, const char *a, const char *b, int same) {
    NphScene *first = parse(context, a), *second = parse(context, b);
    int equal = memcmp(first->digest, second->digest, sizeof first->digest) == 0;
    ck_assert_msg(equal == same, "%s\n%s", a, b);
    nph_scene_free(context, first);
    nph_scene_free(context, second);
}

#define SUN "lights:\n- {type: sun, direction: [0, 0, 1], irradiance: 3}\n"
#define BOX "media:\n- box: [[0, 0, 0], [1, 1, 1]]\n  extinction: 2\n"
#define PLAIN HEAD BOX SUN

/* The scene PLAIN in other words. */
static const char reordered[] =
    "lights:\r\n- {irradiance: [3.0, 3e0, 30e-1], direction: [-0, 0, 2], type: \"sun\", angular_diameter: 0}\r\n"
    "camera:\r\n  fov: 35\r\n  up: [0, 0, 1]\r\n  type: perspective\r\n  direction: [0, 5, 0]\r\n  position: [0, -4, "
    "0]\r\n"
    "  resolution: [4, 3]\r\n  crop: [0, 0, 4, 3]\r\nnephos: 1\r\n"
    "media:\r\n- {name: other, scattering: 2, box: [[0, 0, 0], [1, 1, 1]], phase: {type: isotropic}, transform: "
    "[]}\r\n";
static const char json[] = "{\"nephos\": 1, \"camera\": {\"resolution\": [4, 3], \"position\": [0, -4, "
                           "0],\n\t\"look_at\": [0, 0, 0], \"fov\": 35},\n"
                           "\"media\": [{\"box\": [[0, 0, 0], [1, 1, 1]], \"extinction\": 2, \"albedo\": 1.0}],\n"
                           "\"lights\": [{\"type\": \"sun\", \"direction\": [0, 0, 1], \"irradiance\": 3}]}";
static const char aliases[] =
    "nephos: 1\nlights:\n- {type: sun, direction: [0, &o 0, &n 1], irradiance: &i [3, 3, 3]}\n" CAMERA
    "media:\n- box: [[0, 0, 0], [1, 1, *n]]\n  extinction: [2, 2, 2]\n";
static const char commented[] = "# comment\n" PLAIN "render: {samples: 1000, seed: 9}\n";
static const char marked[] = "\xEF\xBB\xBF" PLAIN;
static const char framed[] = "%YAML 1.1\n---\n" PLAIN "...\n";

/* Scenes that differ from PLAIN in one value. */
static const char brighter[] = HEAD BOX "lights:\n- {type: sun, direction: [0, 0, 1], irradiance: 4}\n";
static const char darker[] = HEAD BOX "  albedo: 0.5\n" SUN;
static const char larger[] = HEAD BOX "  transform: [{scale: 2}]\n" SUN;
static const char unlit[] = HEAD BOX;
static const char empty[] = HEAD SUN;
static const char ground[] = PLAIN "surfaces: [{plane: 0}]\n";
static const char no_surfaces[] = PLAIN "surfaces: []\n";
static const char wider[] =
    "nephos: 1\ncamera: {resolution: [4, 3], position: [0, -4, 0], look_at: [0, 0, 0], fov: 36}\n" BOX SUN;

START_TEST(the_digest_sees_values_and_not_how_they_are_written) {
    NphContext *context = nph_test_context(1);
    static const char *const alike[] = {commented, marked, framed, reordered, json, aliases, no_surfaces};
    static const char *const unlike[] = {brighter, darker, larger, unlit, empty, wider, ground};
    for (size_t i = 0; i < sizeof alike / sizeof alike[0]; i++) check_same_digest(context, PLAIN, alike[i], 1);
    for (size_t i = 0; i < sizeof unlike / sizeof unlike[0]; i++) check_same_digest(context, PLAIN, unlike[i], 0);
    check_same_digest(context, ground, PLAIN "surfaces: [{name: g, albedo: .5, plane: 0.0}]\n", 1);
    check_same_digest(context, ground, PLAIN "surfaces: [{plane: 1}]\n", 0);
    check_same_digest(context, ground, PLAIN "surfaces: [{plane: 0, albedo: 0.4}]\n", 0);
    check_same_digest(context, ground, PLAIN "surfaces: [{plane: 0}, {plane: 0}]\n", 0);
    nph_test_context_close(context);
}
END_TEST

/* XXH3's canonical form of this scene's values: any change of what enters, or of the byte order, shows here. */
START_TEST(the_digest_of_a_scene_stays_what_it_was) {
    NphContext *context = nph_test_context(1);
    NphScene *scene = parse(context, PLAIN);
    char text[33];
    for (int i = 0; i < 16; i++) snprintf(text + 2 * i, 3, "%02x", scene->digest[i]);
    ck_assert_str_eq(text, "20cb81502405edf4729c50bef3f71dd6");
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(the_callers_rounding_changes_nothing_and_stays) {
    NphContext *context = nph_test_context(1);
    static const char text[] =
        HEAD "media:\n- box: [[0.1, 0.1, 0.1], [0.3, 0.7, 0.9]]\n  scattering: 0.1\n  absorption: 0.7\n"
             "  transform: [{rotate: {axis: [1, 2, 3], angle: 77}}]\n"
             "lights:\n- {type: sun, elevation: 31, azimuth: 7, irradiance: 0.1, angular_diameter: 0.53}\n";
    NphScene *nearest = parse(context, text);
    fesetround(FE_UPWARD);
    NphScene *upward = parse(context, text);
    ck_assert_int_eq(fegetround(), FE_UPWARD);
    fesetround(FE_TONEAREST);
    ck_assert_mem_eq(nearest->digest, upward->digest, sizeof nearest->digest);
    nph_scene_free(context, nearest);
    nph_scene_free(context, upward);
    nph_test_context_close(context);
}
END_TEST

START_TEST(aliases_that_contain_themselves_are_refused_not_followed) {
    NphContext *context = nph_test_context(1);
    NphScene *scene = NULL;
    static const char text[] = HEAD "media: &m [*m]\n";
    ck_assert_int_eq(nph_scene_parse(context, text, strlen(text), "s", NULL, &scene), NPH_BAD_SCENE);
    ck_assert_str_eq(nph_test_messages(), "s:3:8: a medium: a list where a mapping (key: value) is expected\n");
    nph_test_context_close(context);
}
END_TEST

START_TEST(text_without_a_terminating_nul_is_read_to_its_size_only) {
    NphContext *context = nph_test_context(1);
    NphScene *scene = NULL;
    static const char text[] = HEAD "render: {samples: 7}\nnonsense";
    ck_assert_int_eq(nph_scene_parse(context, text, strlen(text) - 8, "s", NULL, &scene), NPH_OK);
    ck_assert_int_eq(scene->default_spp, 7);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, the_camera_is_what_the_scene_writes);
    tcase_add_test(cases, the_media_are_what_the_scene_writes);
    tcase_add_test(cases, phase_functions_are_what_the_scene_writes);
    tcase_add_test(cases, sensors_and_periods_are_what_the_scene_writes);
    tcase_add_test(cases, periods_and_the_direction_seen_enter_the_digest);
    tcase_add_test(cases, wavelengths_spread_rgb_keys_over_spectra);
    tcase_add_test(cases, one_wavelength_is_a_grey_scene);
    tcase_add_test(cases, the_digest_sees_wavelengths_and_spectra);
    tcase_add_test(cases, the_lights_and_the_run_are_what_the_scene_writes);
    tcase_add_test(cases, planes_are_what_the_scene_writes);
    tcase_add_test(cases, left_out_keys_take_their_defaults);
    tcase_add_test(cases, the_frame_is_orthonormal_and_the_field_of_view_is_that_of_the_shorter_side);
    tcase_add_test(cases, directions_far_from_unit_length_are_normalised_without_loss);
    tcase_add_test(cases, azimuth_runs_from_x_to_y);
    tcase_add_test(cases, transform_steps_apply_in_the_order_they_are_written);
    tcase_add_test(cases, rotation_follows_the_right_hand_rule_about_any_axis);
    tcase_add_test(cases, an_inverse_undoes_its_map_and_singular_maps_have_none);
    tcase_add_test(cases, the_digest_sees_values_and_not_how_they_are_written);
    tcase_add_test(cases, the_digest_of_a_scene_stays_what_it_was);
    tcase_add_test(cases, the_callers_rounding_changes_nothing_and_stays);
    tcase_add_test(cases, aliases_that_contain_themselves_are_refused_not_followed);
    tcase_add_test(cases, text_without_a_terminating_nul_is_read_to_its_size_only);
}

int main(void) { return nph_test_main("scene_values", fill); }
