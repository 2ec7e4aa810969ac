/* SPDX-License-Identifier: Apache-2.0
 *
 * Surfaces in principal ordinates: shadows, reflective shadow maps, virtual point lights, and what the camera sees of them. */
#include "pop_case.h"

/* A square of 2 x 2 across z, its middle at x, y, z. */
static const char *square(const char *name, double x, double y, double z) {
    char text[400];
    snprintf(text, sizeof text, "v %g %g %g\nv %g %g %g\nv %g %g %g\nv %g %g %g\nf 1 2 3 4\n", x - 1, y - 1, z, x + 1, y - 1, z, x + 1, y + 1, z, x - 1, y + 1, z);
    return nph_test_write(name, text);
}

/* With surfaces in front of the lights. */
static const char *scene_of(const char *medium, const char *surfaces, const char *lights) {
    return render_text("nephos: 1\ncamera: {" CAMERA "}\nmedia:\n  - {%s}\nsurfaces:\n%s\nlights:\n%s", medium, surfaces, lights);
}

/* A square over the low half in x: within the medium, or above it. Cells behind it are dark, those in front and beside are lit. */
START_TEST(a_square_shades_what_lies_behind_it) {
    static const double heights[] = {0.5, 50.0, -50.0};
    const char *path = square("half.obj", -0.5, 0.5, heights[_i]);
    char surfaces[600];
    Solution s;
    snprintf(surfaces, sizeof surfaces, "  - {mesh: %s}\n  - {plane: -60}", path);
    solution_open(&s, scene_of(CUBE("1", "1", "0"), surfaces, "  - {type: sun, direction: [0, 0, 1], irradiance: 1}\n"), 2, "pop.cells=8 pop.vpls=3");
    solve(&s, NPH_POP_MEDIUM, NPH_POP_SHADOWS, 0);
    RPopGrid grid = grid_of(&s, 0);
    const double *lit = s.solver.arrays.lit;
    int dark = 0;
    for (int i = 0; i < 512; i++) {
        RScene *local = &((RPopScene *)s.solver.scene)->local;
        double p[3], d[3];
        r_pop_cell(&grid, i % 8, i / 8 % 8, i / 64, p, d);
        int behind = p[0] + local->origin[0] < 0.5 && p[2] + local->origin[2] < heights[_i];
        ck_assert_double_eq_tol(lit[i], behind ? 0.0 : 1.0, 1e-9);
        dark += behind;
    }
    ck_assert_int_eq(dark, _i == 0 ? 128 : _i == 1 ? 256 : 0);
    solution_close(&s);
}
END_TEST

/* A sun below a plane shines on nothing; a point within a closed mesh on what lies in it. */
START_TEST(light_stays_on_its_side) {
    Solution s;
    solution_open(&s, scene_of(CUBE("1", "1", "0"), "  - {plane: -1}", "  - {type: sun, direction: [0.1, 0, -1], irradiance: 1}\n"), 2, "pop.cells=6");
    solve(&s, NPH_POP_MEDIUM, NPH_POP_SHADOWS, 0);
    for (int i = 0; i < 216; i++) ck_assert_double_eq(((double *)s.solver.arrays.lit)[i], 0.0);
    solution_close(&s);
    const char *cube = nph_test_write("cube.obj", "v 0.3 0.3 0.3\nv 0.7 0.3 0.3\nv 0.7 0.7 0.3\nv 0.3 0.7 0.3\nv 0.3 0.3 0.7\nv 0.7 0.3 0.7\nv 0.7 0.7 0.7\nv 0.3 0.7 0.7\n"
                                             "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
    char surfaces[600];
    snprintf(surfaces, sizeof surfaces, "  - {mesh: %s}", cube);
    solution_open(&s, scene_of(CUBE("1", "1", "0"), surfaces, POINT), 2, "pop.radial=16 pop.vpls=0");
    solve(&s, NPH_POP_MEDIUM, NPH_POP_SHADOWS, 0);
    RPopGrid grid = grid_of(&s, 0);
    int within = 0, beyond = 0;
    for (int i = 0; i < 16 * 16 * 16; i++) {
        double p[3], d[3], most = 0.0, r = r_pop_radius(&grid, i / 256 + 1) / r_pop_radius(&grid, i / 256 + 0.5);
        r_pop_cell(&grid, i % 16, i / 16 % 16, i / 256, p, d);
        for (int a = 0; a < 3; a++) most = fmax(most, fabs(p[a] - grid.middle[a]));
        double lit = ((double *)s.solver.arrays.lit)[i];
        if (most * r < 0.2 * 0.85) { /* rays to corners of the cell come nearer to a side */
            ck_assert_double_eq(lit, 1.0);
            within++;
        } else if (most / r > 0.2 * 1.15) {
            ck_assert_double_eq(lit, 0.0);
            beyond++;
        }
    }
    ck_assert_int_gt(within, 500);
    ck_assert_int_gt(beyond, 500);
    solution_close(&s);
}
END_TEST

/* All light that comes down around the medium is in the map; behind a medium, what that leaves of it. Half of a point's sphere meets a plane. */
START_TEST(maps_have_all_light_that_meets_surfaces) {
    static const char *const lights[] = {"  - {type: sun, direction: [0, 0, 1], irradiance: 2}\n", "  - {type: sun, direction: [0.3, 0.4, 0.05], irradiance: 2}\n",
                                         "  - {type: point, position: [0.5, 0.5, 3], intensity: 5}\n", "  - {type: sun, direction: [0, 0, 1], irradiance: 2}\n"};
    Solution s;
    double power = 0.0, area = 0.0, lost = 0.0;
    solution_open(&s, scene_of(_i == 3 ? CUBE("2", "1", "0") : CUBE("1e-5", "1", "0"), "  - {plane: -1, albedo: 0.7}", lights[_i]), 2, "pop.cells=4 pop.rsm=65"); /* odd: no direction is level */
    solve(&s, NPH_POP_MEDIUM, NPH_POP_REFLECT, 0);
    const double *texel = s.solver.arrays.rsm, edge = 22.0 * sqrt(0.75);
    for (int i = 0; i < 65 * 65; i++, texel += NPH_POP_TEXEL) {
        power += texel[NPH_POP_TEXEL_POWER];
        area += texel[NPH_POP_TEXEL_AREA];
        lost += 0.7 * 2.0 * texel[NPH_POP_TEXEL_AREA] - texel[NPH_POP_TEXEL_POWER];
        if (texel[NPH_POP_TEXEL_AREA] > 0.0) ck_assert_double_eq_tol(texel[NPH_POP_TEXEL_NORMAL + 2], 1.0, 1e-12);
    }
    if (_i == 3) { /* texels under the cube add up to its face but for the half of them at its rim: 35 of 0.029 along an edge */
        ck_assert_double_eq_tol(lost, 0.7 * 2.0 * (1.0 - exp(-2.0)), 0.06 * lost);
        solution_close(&s);
        return;
    }
    double slope = 0.05 / sqrt(0.3 * 0.3 + 0.4 * 0.4 + 0.05 * 0.05);
    ck_assert_double_eq_tol(power, 0.7 * (_i < 2 ? 2.0 * edge * edge : 5.0 * 2.0 * PI), (_i < 2 ? 1e-4 : 2e-3) * power);
    if (_i < 2) ck_assert_double_eq_tol(area, edge * edge / (_i == 0 ? 1.0 : slope), 1e-6 * area);
    solution_close(&s);
}
END_TEST

/* A sheet of uniform radiance L brings the fluence L times its solid angle; virtual point lights bring the same, for any draw. */
START_TEST(virtual_points_bring_what_the_surface_does) {
    Solution s;
    double half = 11.0 * sqrt(0.75), h = 1.5, L = 0.7 * 2.0 / PI, expected = L * 4.0 * atan(half * half / (h * sqrt(h * h + 2.0 * half * half)));
    for (int seed = 0; seed < 4; seed++) {
        double sum = 0.0, area = 0.0;
        solution_open(&s, scene_of(CUBE("1e-5", "1", "0"), "  - {plane: -1, albedo: 0.7}", "  - {type: sun, direction: [0, 0, 1], irradiance: 2}\n"), 2,
                      "pop.cells=4 pop.rsm=128 pop.vpls=2000");
        s.solver.job.seed = (uint32_t)seed;
        solve(&s, NPH_POP_MEDIUM, NPH_POP_VPLS, 0);
        RPopScene *scene = s.solver.scene;
        for (int n = 1; n <= 2000; n++) {
            const double *row = ordinate_of(&s, n);
            double squared = 0.0, off[3];
            for (int a = 0; a < 3; a++) {
                off[a] = scene->middle[a] - row[NPH_POP_WAY + a];
                squared += off[a] * off[a];
            }
            sum += row[NPH_POP_VALUE] * off[2] / (squared * sqrt(squared));
            area += row[NPH_POP_AREA];
            ck_assert_double_eq_tol(row[NPH_POP_COSINE], 1.0 - row[NPH_POP_SOLID_ANGLE] / (4.0 * PI), 1e-12);
        }
        printf("    seed %d: fluence %.6f, of a sheet %.6f; area %.6g of %.6g\n", seed, sum, expected, area, 4.0 * half * half);
        ck_assert_double_eq_tol(sum, expected, 5e-3 * expected);
        ck_assert_double_eq_tol(area, 4.0 * half * half, 5e-2 * area);
        solution_close(&s);
    }
}
END_TEST

/* What a virtual point light sends, pi times its intensity along the normal, is scattered or goes through; half of the sphere stays dark; and
 * the fluence of thin media is that of its cosine. */
START_TEST(a_virtual_point_sends_its_power) {
    static const char *const extinctions[] = {"4", "1e-6"};
    Solution s;
    solution_open(&s, scene_of(render_text("box: [[0, 0, 0], [1, 1, 1]], extinction: %s, albedo: 1, phase: {type: hg, g: 0}", extinctions[_i]), "  - {plane: 0.3, albedo: 1}",
                               "  - {type: sun, direction: [0, 0, 1], irradiance: 2}\n"), 2, "pop.vpl_cells=12 pop.shadows=0 pop.clamp=0 pop.vpls=1 pop.cells=4");
    solve(&s, NPH_POP_MEDIUM, NPH_POP_INJECT, 0);
    RPopGrid grid = grid_of(&s, 1);
    const double *density = (double *)s.solver.arrays.density + nph_pop_first(&s.solver.choice, 1, 1);
    const double *light = (double *)s.solver.arrays.light + nph_pop_first(&s.solver.choice, 1, 1), *seen = (double *)s.solver.arrays.seen + (light - (double *)s.solver.arrays.light);
    double through = 0.0, all = 0.0, scale = 0.0, sigma = ((RPopScene *)s.solver.scene)->sigma_t[0];
    int cells = grid.n[0] * grid.n[1], shown = 0;
    for (int i = 0; i < cells; i++) {
        double p[3], d[3];
        r_pop_cell(&grid, i % grid.n[0], i / grid.n[0], 0, p, d);
        scale += fmax(d[2], 0.0) * r_pop_solid(&grid, i % grid.n[0], i / grid.n[0]);
    }
    scale = 0.25 * cells / scale;
    ck_assert_double_eq_tol(scale, 1.0, 0.02);
    for (int i = 0; i < cells; i++) {
        double p[3], d[3], depth = grid.core * density[i];
        r_pop_cell(&grid, i % grid.n[0], i / grid.n[0], 0, p, d);
        double share = scale * fmax(d[2], 0.0) * r_pop_solid(&grid, i % grid.n[0], i / grid.n[0]);
        for (int z = 0; z < grid.n[2]; z++) {
            int k = z * cells + i;
            double r = r_pop_radius(&grid, z + 0.5), thick = r_pop_radius(&grid, z + 1) - r_pop_radius(&grid, z);
            depth += thick * density[k];
            if (d[2] < 1e-9) ck_assert_double_eq(light[k], 0.0);
            if (_i == 0 || d[2] < 1e-9) continue;
            ck_assert_double_eq_tol(seen[k], d[2] / (r * r) / (4.0 * PI), 0.05 * seen[k]);
            shown++;
        }
        through += share * exp(-sigma * depth);
        all += share;
    }
    ck_assert(_i == 0 || shown > 500);
    ck_assert_double_eq_tol(all * 4.0 * PI / cells, PI, 1e-12);
    ck_assert_double_eq_tol(s.solver.arrays.power[NPH_POP_POWERS + NPH_POP_INJECTED] + through, all, 1e-10 * all);
    solution_close(&s);
}
END_TEST

#define DOWN "resolution: [16, 16], position: [0, 0, 6], look_at: [0, 0, 0], up: [0, 1, 0], fov: 10"

static double pixel(const RenderCase *render, int x, int y) { return (double)nph_image_channel(&render->image, "R")->pixels[y * 16 + x]; }

/* A plane far below a medium that is hardly there: Lambert's law for a sun and for a point, half of it in a square's shadow. */
START_TEST(surfaces_are_lit_as_lambert_says) {
    const char *path = square("shade.obj", 1.0, 0.0, 3.0); /* behind the second camera */
    RenderCase seen;
    for (int precision = 32; precision <= 64; precision += 32) {
        const char *medium = "box: [[30, 0, 0], [31, 1, 1]], extinction: 1e-6, albedo: 1";
        render(render_text("nephos: 1\ncamera: {" DOWN "}\nmedia:\n  - {%s}\nsurfaces:\n  - {plane: 0, albedo: 0.6}\n"
                           "lights:\n  - {type: sun, direction: [0.6, 0, 0.8], irradiance: 2}\n", medium), precision, 2, "pop.cells=4 pop.vpls=0", &seen);
        for (int i = 0; i < 256; i++) ck_assert_double_eq_tol(pixel(&seen, i % 16, i / 16), 0.6 / PI * 2.0 * 0.8, 1e-6);
        ck_assert_double_eq_tol((double)nph_image_channel(&seen.image, "Z")->pixels[136], 6.0, 0.02);
        render_free(&seen);
        render(render_text("nephos: 1\ncamera: {resolution: [16, 16], position: [0, 0, 2], look_at: [0, 0, 0], up: [0, 1, 0], fov: 10}\nmedia:\n  - {%s}\n"
                           "surfaces:\n  - {plane: 0, albedo: 0.6}\n  - {mesh: %s, albedo: 0}\nlights:\n  - {type: point, position: [0, 0, 4], intensity: 3}\n",
                           medium, path), precision, 2, "pop.cells=4 pop.vpls=0", &seen);
        ck_assert_double_eq_tol(pixel(&seen, 3, 8), 0.6 / PI * 3.0 / 16.0, 1e-3); /* the cosine's part is (0.1 / 4)^2 */
        ck_assert_double_eq(pixel(&seen, 12, 8), 0.0);
        render_free(&seen);
    }
    render(render_text("nephos: 1\ncamera: {" DOWN "}\nmedia:\n  - {box: [[30, 0, 0], [31, 1, 1]], extinction: 1e-6}\nsurfaces:\n  - {plane: 0, albedo: 0.6}\n"
                       "lights:\n  - {type: constant, radiance: 1, hemisphere: upper}\n"), 32, 2, "pop.cells=4 pop.vpls=0 pop.regions=1 pop.importance=0 pop.ordinates=256", &seen);
    printf("    under a white sky: %.5f of 0.6\n", render_mean(&seen, "R"));
    ck_assert_double_eq_tol(render_mean(&seen, "R"), 0.6, 0.01);
    render_free(&seen);
}
END_TEST

/* Sunlight on a plane behind a slab that only absorbs; and what a small square far above a sunlit plane gets of it from below, pi L but for
 * what lies beyond the maps (0.1%) and its own shadow: by 2000 lights some 3 m apart where they count, 20 m below. */
START_TEST(surfaces_are_lit_through_media_and_by_each_other) {
    RenderCase seen;
    render("nephos: 1\ncamera: {resolution: [16, 16], position: [0, 0, 2], look_at: [0, 0, 0], up: [0, 1, 0], fov: 10}\n"
           "media:\n  - {box: [[-5, -5, 3], [5, 5, 4]], extinction: 2, albedo: 0}\nsurfaces:\n  - {plane: 0, albedo: 0.6}\n"
           "lights:\n  - {type: sun, direction: [0, 0, 1], irradiance: 2}\n", 64, 2, "pop.cells=4 pop.vpls=0", &seen);
    for (int i = 0; i < 256; i++) ck_assert_double_eq_tol(pixel(&seen, i % 16, i / 16), 0.6 / PI * 2.0 * exp(-2.0), 1e-6);
    render_free(&seen);
    const char *path = square("above.obj", 0.0, 0.0, 20.0);
    render(render_text("nephos: 1\ncamera: {resolution: [16, 16], position: [0, 0, 10], look_at: [0, 0, 20], up: [0, 1, 0], fov: 8}\n"
                       "media:\n  - {box: [[-30, -30, 30], [30, 30, 70]], extinction: 1e-7}\nsurfaces:\n  - {plane: 0, albedo: 0.6}\n  - {mesh: %s, albedo: 0.5}\n"
                       "lights:\n  - {type: sun, direction: [0.6, 0, 0.8], irradiance: 2}\n", path), 64, 2, "pop.cells=4 pop.vpls=2000 pop.rsm=128 pop.vpl_cells=2 pop.clamp=0", &seen);
    double expected = 0.5 * 0.6 * 2.0 * 0.8 / PI;
    printf("    a square above a plane: %.5f of %.5f\n", render_mean(&seen, "R"), expected);
    ck_assert_double_eq_tol(render_mean(&seen, "R"), expected, 0.02 * expected);
    render_free(&seen);
}
END_TEST

#define ROOM "  - {plane: -0.2, albedo: 0.6}\n  - {mesh: ../data/mesh/teapot.obj, albedo: [0.2, 0.5, 0.9], transform: [{scale: 0.2}, {translate: [0.3, 0, -0.2]}]}\n"

START_TEST(a_knob_of_surfaces_is_for_something) {
    static const char *const knobs[] = {"pop.vpls=0", "pop.vpls=5", "pop.vpl_cells=4", "pop.rsm=9", "pop.clamp=0", "pop.shadows=0", "pop.shadows=1", "pop.variant=1"};
    const char *yaml = scene_of(PLUME, ROOM, SUN WHITE POINT);
    RenderCase plain;
    render(yaml, 32, 2, "pop.cells=8 pop.ordinates=6 pop.iterations=4 pop.vpls=30", &plain);
    for (size_t k = 0; k < sizeof knobs / sizeof *knobs; k++) {
        RenderCase other;
        double difference = 0.0;
        render(yaml, 32, 2, render_text("pop.cells=8 pop.ordinates=6 pop.iterations=4 pop.vpls=30 %s", knobs[k]), &other);
        for (int i = 0; i < 256; i++) difference += fabs(pixel(&other, i % 16, i / 16) - pixel(&plain, i % 16, i / 16)) / 256.0;
        ck_assert_msg(difference > 1e-4 * render_mean(&plain, "R"), "%s changes nothing", knobs[k]);
        render_free(&other);
    }
    render_free(&plain);
}
END_TEST

START_TEST(threads_precisions_and_plans_agree) {
    static const char *const knobs[] = {"pop.cells=8", "pop.ordinates=6", "pop.iterations=4", "pop.vpls=20"};
    const char *yaml = scene_of(PLUME, ROOM, "  - {type: sun, direction: [-1, 0.3, 0.2], irradiance: [1, 2, 3]}\n" WHITE POINT);
    RenderCase one, three, wide, all;
    NphRenderOptions options = render_options(16, 32);
    render(yaml, 32, 1, "pop.cells=8 pop.ordinates=6 pop.iterations=4 pop.vpls=20", &one);
    render(yaml, 32, 3, "pop.cells=8 pop.ordinates=6 pop.iterations=4 pop.vpls=20", &three);
    render(yaml, 64, 2, "pop.cells=8 pop.ordinates=6 pop.iterations=4 pop.vpls=20", &wide);
    options.method = "principal_ordinates";
    options.knobs = knobs;
    options.knob_count = 4;
    options.plan_full = 1;
    render_case(&all, yaml, &options, 2);
    for (int c = 0; c < 3; c++) {
        const char *name = c == 0 ? "R" : c == 1 ? "G" : "B";
        const float *a = nph_image_channel(&one.image, name)->pixels;
        ck_assert_int_eq(memcmp(a, nph_image_channel(&three.image, name)->pixels, 256 * sizeof(float)), 0);
        ck_assert_int_eq(memcmp(a, nph_image_channel(&all.image, name)->pixels, 256 * sizeof(float)), 0);
        ck_assert_double_eq_tol(mean_of(&one.image, name), mean_of(&wide.image, name), 1e-3 * mean_of(&wide.image, name));
    }
    render_free(&one);
    render_free(&three);
    render_free(&wide);
    render_free(&all);
}
END_TEST

/* Every picture is finite and not negative. */
START_TEST(extremes_of_surfaces_are_survived) {
    static const struct {
        const char *surfaces, *lights, *knobs;
    } runs[] = {
        {ROOM, "  - {type: sun, direction: [1, 0.3, 1e-7], irradiance: 2}\n", ""},
        {ROOM, "  - {type: sun, direction: [1, 0, 0], irradiance: 2}\n", ""},
        {ROOM, "  - {type: sun, direction: [1, 0, -0.5], irradiance: 2}\n", ""},
        {ROOM, "  - {type: point, position: [0.3, 0, -0.1], intensity: 1}\n", "pop.clamp=0"},
        {ROOM, "  - {type: point, position: [0.5, 0.5, -0.1999999], intensity: 1}\n", "pop.clamp=0"},
        {ROOM, SUN WHITE, "pop.vpls=1 pop.rsm=1 pop.vpl_cells=1 pop.shadows=16"},
        {"  - {plane: 0.5, albedo: 1}", SUN WHITE, "pop.vpls=1024 pop.clamp=0"},
        {"  - {plane: -1e6, albedo: 1}", SUN WHITE, ""},
        {"  - {plane: 0, albedo: 1}\n  - {plane: 1, albedo: 1}", SUN WHITE POINT, ""},
        {"  - {plane: 0, albedo: 0}", SUN WHITE, ""},
    };
    for (size_t r = 0; r < sizeof runs / sizeof *runs; r++)
        for (int precision = 32; precision <= 64; precision += 32) {
            RenderCase seen;
            render(scene_of(CUBE("4", "1", "0.5"), runs[r].surfaces, runs[r].lights), precision, 2,
                   render_text("pop.ordinates=8 pop.cells=6 pop.iterations=4 pop.vpls=20 %s", runs[r].knobs), &seen);
            for (int i = 0; i < 256; i++)
                ck_assert_msg(pixel(&seen, i % 16, i / 16) >= 0.0 && pixel(&seen, i % 16, i / 16) < 1e4, "run %d, f%d, pixel %d: %g", (int)r, precision, i,
                              pixel(&seen, i % 16, i / 16));
            render_free(&seen);
        }
}
END_TEST

START_TEST(memory_of_surfaces_is_planned_and_may_fail) {
    static const char *const knobs[] = {"pop.cells=4", "pop.ordinates=3", "pop.iterations=2", "pop.vpls=3"};
    NphRenderOptions options = render_options(16, 32);
    options.method = "principal_ordinates";
    options.knobs = knobs;
    options.knob_count = 4;
    render_without_memory(scene_of(CUBE("4", "1", "0.5"), "  - {plane: -1}", SUN WHITE), &options);
    options.knob_count = 0;
    render_as_planned(scene_of(PLUME, ROOM, SUN WHITE), &options);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_loop_test(cases, a_square_shades_what_lies_behind_it, 0, 3);
    tcase_add_test(cases, light_stays_on_its_side);
    tcase_add_loop_test(cases, maps_have_all_light_that_meets_surfaces, 0, 4);
    tcase_add_test(cases, virtual_points_bring_what_the_surface_does);
    tcase_add_loop_test(cases, a_virtual_point_sends_its_power, 0, 2);
    tcase_add_test(cases, surfaces_are_lit_as_lambert_says);
    tcase_add_test(cases, surfaces_are_lit_through_media_and_by_each_other);
    tcase_add_test(cases, a_knob_of_surfaces_is_for_something);
    tcase_add_test(cases, threads_precisions_and_plans_agree);
    tcase_add_test(cases, extremes_of_surfaces_are_survived);
    tcase_add_test(cases, memory_of_surfaces_is_planned_and_may_fail);
}

int main(void) { return nph_test_main("pop_surfaces", fill); }
