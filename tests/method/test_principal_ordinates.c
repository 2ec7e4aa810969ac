/* SPDX-License-Identifier: Apache-2.0
 *
 * Principal-ordinates propagation: its formulas against quadrature, energy, the local cases of the paper, closed forms of thin media,
 * symmetry, and what every stage is for. */
#include "method/pop_case.h"

START_TEST(parts_of_a_lobe_are_its_integrals) {
    static const double cosines[] = {-1.0 + 1e-9, -0.7, -1e-9, 0.0, 1e-12, 0.3, 0.9, 0.999, 1.0 - 1e-9};
    for (size_t k = 0; k < sizeof cosines / sizeof *cosines; k++)
        for (double mu = -1.0; mu <= 1.0; mu += 0.125) {
            double a = cosines[k], sum = 0.0, size = fabs(a);
            int n = 20000;
            for (int i = 0; i < n && size < 0.8; i++) { /* 2 pi f over the cosine from -1 to mu, by midpoints */
                double at = -1.0 + (mu + 1.0) * (i + 0.5) / n;
                sum += 0.5 * (1.0 - a * a) * pow(1.0 + a * a - 2.0 * a * at, -1.5) * (mu + 1.0) / n;
            }
            if (size > 0.8) sum = (1.0 - a * a) / (2.0 * a) * (1.0 / sqrt(1.0 + a * a - 2.0 * a * mu) - 1.0 / (1.0 + a)); /* as printed */
            if (size > 0.9995) sum = (a > 0.0 && mu == 1.0) || (a < 0.0 && mu > -1.0) ? 1.0 : 0.0;                        /* a step */
            ck_assert_double_eq_tol(r_pop_below(mu, a), sum, 1e-6);
        }
    ck_assert_double_eq_tol(r_pop_below(1.0, 0.5), 1.0, 1e-15);
    ck_assert_double_eq_tol(r_pop_below(-1.0, 0.5), 0.0, 1e-15);
    ck_assert_double_eq_tol(1.0 - r_pop_below(sqrt(0.5), 0.0), 0.14644660940672624, 1e-15); /* what the paper's patches hold: front */
    ck_assert_double_eq_tol(0.25 * (r_pop_below(sqrt(0.5), 0.0) - r_pop_below(-sqrt(0.5), 0.0)), 0.17677669529663689, 1e-15); /* side */
}
END_TEST

START_TEST(the_octahedral_map_goes_back_and_its_cells_fill_the_sphere) {
    double sum = 0.0;
    int n = 64;
    for (int y = 0; y < n; y++)
        for (int x = 0; x < n; x++) {
            double u = 2.0 * (x + 0.5) / n - 1.0, v = 2.0 * (y + 0.5) / n - 1.0, d[3], back[2];
            r_octahedron_way(u, v, d);
            r_octahedron(d[0], d[1], d[2], &back[0], &back[1]);
            ck_assert_double_eq_tol(back[0], u, 1e-14);
            ck_assert_double_eq_tol(back[1], v, 1e-14);
            sum += r_octahedron_solid(u, v, n);
        }
    ck_assert_double_eq_tol(sum, 4.0 * PI, 0.002 * 4.0 * PI); /* midpoints: n^-2 */
}
END_TEST

/* What enters is what leaves, scattered or not: every iteration, and in all. */
START_TEST(with_albedo_1_what_enters_leaves) {
    static const char *const lights[] = {SUN, POINT, "  - {type: point, position: [-0.4, 0.2, 1.3], intensity: 1}\n"};
    static const char *const media[] = {CUBE("4", "1", "0.7"), CUBE("[1, 4, 9]", "1", "0")};
    Solution s;
    for (int m = 0; m < 2; m++) {
        solution_open(&s, render_text("nephos: 1\ncamera: {" CAMERA "}\nmedia:\n  - {%s}\nlights:\n%s", media[m], lights[_i]), 2,
                      "pop.cells=12 pop.iterations=1 pop.epsilon_l=0");
        NphPopSolver *solver = &s.solver;
        solve(&s, NPH_POP_MEDIUM, NPH_POP_INJECT, 0);
        RPopGrid grid = grid_of(&s, 0);
        double entered = (double)grid.n[0] * grid.n[1], cells = (double)nph_pop_cells(grid.n);
        for (int c = 0; c < solver->choice.channels; c++) {
            double *power = solver->arrays.power + c * NPH_POP_POWERS, out = 0.0, through = 0.0;
            for (int i = 0; i < grid.n[0] * grid.n[1]; i++) { /* the beam behind the last cell */
                double depth = solver->choice.points ? grid.core * ((double *)solver->arrays.density)[i] : 0.0;
                for (int z = 0; z < grid.n[2]; z++) {
                    double edge = solver->choice.points ? r_pop_radius(&grid, z + 1) - r_pop_radius(&grid, z) : grid.edge[2];
                    depth += edge * ((double *)solver->arrays.density)[z * grid.n[0] * grid.n[1] + i];
                }
                double share = solver->choice.points ? r_pop_solid(&grid, i % grid.n[0], i / grid.n[0]) : 1.0;
                through += share * exp(-((RPopScene *)solver->scene)->sigma_t[c] * depth);
            }
            ck_assert_double_eq_tol(power[NPH_POP_INJECTED] + through, entered, 1e-10 * entered);
            solver->iteration = 0;
            for (int k = 0; k < 4000 && power[NPH_POP_LEFT] > 1e-7 * power[NPH_POP_INJECTED]; k++) {
                double before = power[NPH_POP_LEFT], leaves = solver->kernels.leaves(solver->scene, &solver->arrays, 0, c, solver->scratch[0]);
                ck_assert_int_eq(nph_pop_step(solver, NPH_POP_PROPAGATE), NPH_OK);
                ck_assert_double_eq_tol(power[NPH_POP_LEFT] + leaves, before, 1e-13 * cells);
                out += leaves;
            }
            if (c == 0)
                printf("    %d cells, channel %d: %.6f scattered out, %.6f through, of %.6f\n", (int)cells, c, out, through, entered);
            if (c == 0) ck_assert_double_eq_tol(out + through, entered, 1e-5 * entered);
        }
        solution_close(&s);
    }
}
END_TEST

/* A grid of 3 x 3 x 3 cells along z, without light but in those around the middle. */
static void local_open(Solution *s, const char *albedo) {
    solution_open(s, render_text("nephos: 1\ncamera: {" CAMERA "}\nmedia:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 3, albedo: %s, phase: {type: hg, g: 0.8}}\n"
                                 "lights:\n  - {type: sun, direction: [0, 0, -1], irradiance: 1}\n", albedo), 1, "pop.cells=3 pop.iterations=1 pop.epsilon_l=0");
    solve(s, NPH_POP_MEDIUM, NPH_POP_INJECT, 0);
    for (int i = 0; i < 27; i++) ((double *)s->solver.arrays.light)[i] = ((double *)s->solver.arrays.cosine)[i] = 0.0;
    s->solver.arrays.power[NPH_POP_LEFT] = s->solver.arrays.power[NPH_POP_INJECTED] = 1.0;
}

static void put(Solution *s, int cell, double light, double cosine) {
    ((double *)s->solver.arrays.light)[cell] = light;
    ((double *)s->solver.arrays.cosine)[cell] = cosine;
}

/* [Elek14 fig. 5]: cell 13 is the middle, 4 behind it, 12 beside. One cell is 1/3 m: depth 1. */
START_TEST(the_local_cases_of_figure_5) {
    Solution s;
    double decay = exp(-0.2), light, cosine, side = 0.25 * (r_pop_below(sqrt(0.5), 0.0) - r_pop_below(-sqrt(0.5), 0.0));
    local_open(&s, "1"); /* strong forward lobes all around: only what comes from behind arrives, and keeps its lobe */
    for (int cell = 0; cell < 27; cell++) put(&s, cell, 1.0, 1.0 - 1e-9);
    ck_assert_int_eq(nph_pop_step(&s.solver, NPH_POP_PROPAGATE), NPH_OK);
    light = ((double *)s.solver.arrays.light)[13];
    cosine = ((double *)s.solver.arrays.cosine)[13];
    ck_assert_double_eq_tol(light, 1.0, 1e-8);
    ck_assert_double_eq_tol(cosine, decay, 1e-8);
    solution_close(&s);
    local_open(&s, "1"); /* isotropic light from beside lowers the lobe, by what it brings */
    put(&s, 4, 1.0, 1.0 - 1e-9);
    put(&s, 12, 1.0, 0.0);
    ck_assert_int_eq(nph_pop_step(&s.solver, NPH_POP_PROPAGATE), NPH_OK);
    light = ((double *)s.solver.arrays.light)[13];
    cosine = ((double *)s.solver.arrays.cosine)[13];
    ck_assert_double_eq_tol(light, 1.0 + side, 1e-8);
    ck_assert_double_eq_tol(cosine, decay / (1.0 + side), 1e-8);
    solution_close(&s);
    local_open(&s, "0.5"); /* what comes from behind is absorbed: that from beside should turn the lobe, which stays aligned and becomes broad */
    ((double *)s.solver.arrays.density)[4] = 40.0;
    put(&s, 4, 1.0, 1.0 - 1e-9);
    put(&s, 12, 1.0, 0.0);
    ck_assert_int_eq(nph_pop_step(&s.solver, NPH_POP_PROPAGATE), NPH_OK);
    light = ((double *)s.solver.arrays.light)[13];
    cosine = ((double *)s.solver.arrays.cosine)[13];
    ck_assert_double_eq_tol(light, side * exp(-0.5) + exp(-0.5 * 0.5 * 41.0), 1e-8);
    ck_assert_double_lt(cosine, 1e-3);
    solution_close(&s);
}
END_TEST

/* Hardly anything scatters: what is seen is the beam, E f(mu, g) of a sun, and of a point I / r^2 f(mu, g) with the mean of r^-2 in a shell. */
START_TEST(thin_media_show_the_beam) {
    Solution s;
    solution_open(&s, SCENE(CAMERA, CUBE("1e-5", "1", "0.6"), SUN POINT), 2, "pop.cells=10 pop.radial=16 pop.inner=0.02 pop.residuum=0");
    solve(&s, NPH_POP_MEDIUM, NPH_POP_PROPAGATE, 0);
    for (int n = 0; n < 2; n++) {
        RPopGrid grid = grid_of(&s, n);
        int64_t first = nph_pop_first(&s.solver.choice, n, 1), cells = nph_pop_cells(grid.n);
        double worst = 0.0;
        for (int64_t i = 0; i < cells; i++) {
            double p[3], d[3], square;
            r_pop_cell(&grid, (int32_t)(i % grid.n[0]), (int32_t)(i / grid.n[0] % grid.n[1]), (int32_t)(i / grid.n[0] / grid.n[1]), p, d);
            double inside = r_pop_radius(&grid, (double)(i / grid.n[0] / grid.n[1])), outside = inside * exp(grid.log_ratio);
            square = n ? (outside * outside + outside * inside + inside * inside) / 3.0 : 1.0; /* 1 over the mean of r^-2 in a shell */
            RPopObserver observer = r_pop_observer(&((RPopScene *)s.solver.scene)->local);
            double mu = r_pop_mu(&observer, p, d), g = 0.6;
            double truth = (1.0 - g * g) / (4.0 * PI) * pow(1.0 + g * g - 2.0 * g * mu, -1.5) / square;
            worst = fmax(worst, fabs(((double *)s.solver.arrays.seen)[first + i] / truth - 1.0));
        }
        printf("    %s: %.2g off at most\n", n ? "point" : "sun", worst);
        ck_assert_double_lt(worst, 1e-4);
    }
    solution_close(&s);
}
END_TEST

START_TEST(ordinates_have_all_of_the_sky) {
    static const char *const skies[] = {"  - {type: constant, radiance: [1, 2, 3]}\n", "  - {type: constant, radiance: 1, hemisphere: upper}\n  - {type: constant, radiance: [0, 0, 2]}\n"};
    static const double truth[2][3] = {{4.0 * PI, 8.0 * PI, 12.0 * PI}, {2.0 * PI, 2.0 * PI, 10.0 * PI}};
    static const int counts[] = {1, 7, 64, 1024};
    for (int sky = 0; sky < 2; sky++)
        for (size_t k = 0; k < sizeof counts / sizeof *counts; k++)
            for (int regions = 0; regions < 2; regions++) {
                Solution s;
                char knobs[128];
                double sum[3] = {0.0}, solid = 0.0;
                snprintf(knobs, sizeof knobs, "pop.ordinates=%d pop.cells=2 pop.importance=0 pop.regions=%d", counts[k], regions);
                solution_open(&s, render_text("nephos: 1\ncamera: {" CAMERA "}\nmedia:\n  - {" CUBE("3", "1", "0.5") "}\nlights:\n%s", skies[sky]), 1, knobs);
                solve(&s, NPH_POP_MEDIUM, NPH_POP_ORDINATES, 0);
                for (int n = 0; n < nph_pop_grids(&s.solver.choice); n++) {
                    const double *row = ordinate_of(&s, n);
                    ck_assert_double_eq_tol(row[0] * row[0] + row[1] * row[1] + row[2] * row[2], 1.0, 1e-12);
                    ck_assert(row[NPH_POP_COSINE] >= 0.0 && row[NPH_POP_COSINE] <= 1.0);
                    for (int c = 0; c < 3; c++) sum[c] += row[NPH_POP_VALUE + c];
                    solid += row[NPH_POP_SOLID_ANGLE];
                }
                for (int c = 0; c < 3; c++) ck_assert_double_eq_tol(sum[c], truth[sky][c], 1e-9 * truth[sky][c]);
                if (sky == 0) ck_assert_double_eq_tol(solid, 4.0 * PI, 1e-9);
                solution_close(&s);
            }
}
END_TEST

/* Turning everything by a third around the cube's diagonal turns the solution. */
START_TEST(axes_are_alike) {
    static const char *const suns[] = {"[-1, 0.3, 0.2]", "[0.2, -1, 0.3]", "[0.3, 0.2, -1]"};
    static const char *const cameras[] = {"[-2, -1, 0.5]", "[0.5, -2, -1]", "[-1, 0.5, -2]"};
    double first[8][3] = {{0.0}};
    for (int k = 0; k < 3; k++) {
        Solution s;
        solution_open(&s, render_text("nephos: 1\ncamera: {resolution: [4, 4], position: %s, look_at: [0.5, 0.5, 0.5], up: [0.3, 0.4, 0.5], fov: 30}\nmedia:\n  - {" CUBE("5", "0.9", "0.7") "}\n"
                                      "lights:\n  - {type: sun, direction: %s, irradiance: 2}\n", cameras[k], suns[k]), 1,
                      "pop.cells=8 pop.merged=0.25 pop.residuum_cells=8");
        solve(&s, NPH_POP_MEDIUM, NPH_POP_MERGE, 6);
        for (int i = 0; i < 8; i++) {
            int bits[3] = {i & 1, i >> 1 & 1, i >> 2}, at = bits[(3 - k) % 3] | bits[(4 - k) % 3] << 1 | bits[(5 - k) % 3] << 2;
            double value = ((double *)s.solver.arrays.merged)[at * NPH_POP_CELL];
            if (k == 0) first[i][0] = value;
            else ck_assert_double_eq_tol(value, first[i][0], 1e-9 * first[i][0]);
        }
        solution_close(&s);
    }
}
END_TEST

START_TEST(a_stage_or_knob_is_for_something) {
    static const char *const knobs[] = {"pop.variant=1", "pop.ordinates=5", "pop.cells=5", "pop.along=4", "pop.radial=5", "pop.inner=0.2", "pop.iterations=4", "pop.iterations=0",
                                        "pop.paths=0", "pop.regions=1", "pop.prefilter=0", "pop.prefilter=2", "pop.beta=3", "pop.importance=0", "pop.residuum=0",
                                        "pop.residuum_cells=5", "pop.residuum_iterations=2", "pop.merged=1", "pop.mips=0", "pop.upsampling=0", "pop.spread_density=1",
                                        "pop.steps=20", "pop.exit=0.5", "pop.epsilon_l=0.9"};
    const char *yaml = SCENE(CAMERA, PLUME, SUN WHITE POINT);
    RenderCase plain;
    render(yaml, 32, 2, "pop.cells=10 pop.ordinates=12 pop.iterations=8", &plain);
    for (size_t k = 0; k < sizeof knobs / sizeof *knobs; k++) {
        RenderCase other;
        char words[256];
        double difference = 0.0;
        snprintf(words, sizeof words, "pop.cells=10 pop.ordinates=12 pop.iterations=8 %s", knobs[k]);
        render(yaml, 32, 2, words, &other);
        for (int i = 0; i < 256; i++)
            difference += fabs((double)nph_image_channel(&other.image, "R")->pixels[i] - (double)nph_image_channel(&plain.image, "R")->pixels[i]) / 256.0;
        ck_assert_msg(difference > 1e-6 * mean_of(&plain.image, "R"), "%s changes nothing", knobs[k]);
        render_free(&other);
    }
    render_free(&plain);
}
END_TEST

START_TEST(threads_and_precisions_agree) {
    const char *yaml = SCENE(CAMERA, PLUME, SUN WHITE POINT), *knobs = "pop.cells=9 pop.ordinates=6 pop.iterations=5";
    RenderCase one, three, wide;
    render(yaml, 32, 1, knobs, &one);
    render(yaml, 32, 3, knobs, &three);
    render(yaml, 64, 2, knobs, &wide);
    ck_assert_int_eq(memcmp(nph_image_channel(&one.image, "R")->pixels, nph_image_channel(&three.image, "R")->pixels, 256 * sizeof(float)), 0);
    for (int i = 0; i < 256; i++) {
        double a = (double)nph_image_channel(&one.image, "R")->pixels[i], b = (double)nph_image_channel(&wide.image, "R")->pixels[i];
        ck_assert_double_eq_tol(a, b, 2e-4 * b);
    }
    render_free(&one);
    render_free(&three);
    render_free(&wide);
}
END_TEST

/* A grey medium is one channel; three are the same picture to the bit. */
START_TEST(a_full_plan_is_the_same_picture) {
    static const char *const knobs[] = {"pop.cells=8", "pop.ordinates=6", "pop.iterations=4"};
    const char *yaml = SCENE(CAMERA, PLUME, "  - {type: sun, direction: [-1, 0.3, 0.2], irradiance: [1, 2, 3]}\n" WHITE);
    NphRenderOptions options = render_options(16, 32);
    RenderCase some, all;
    options.method = "principal_ordinates";
    options.knobs = knobs;
    options.knob_count = 3;
    render_case(&some, yaml, &options, 2);
    options.plan_full = 1;
    render_case(&all, yaml, &options, 2);
    for (int c = 0; c < 3; c++)
        ck_assert_int_eq(memcmp(nph_image_channel(&some.image, c == 0 ? "R" : c == 1 ? "G" : "B")->pixels,
                                nph_image_channel(&all.image, c == 0 ? "R" : c == 1 ? "G" : "B")->pixels, 256 * sizeof(float)), 0);
    render_free(&some);
    render_free(&all);
}
END_TEST

/* Every picture is finite and not negative, and where nothing is to be seen there is nothing. */
START_TEST(extremes_are_survived) {
    static const struct {
        const char *medium, *lights, *knobs;
        int black;
    } runs[] = {
        {CUBE("4", "1", "0"), SUN WHITE, "", 0},
        {CUBE("4", "1", "0.99999"), SUN WHITE, "", 0},
        {CUBE("4", "1", "-0.9"), SUN WHITE, "", 0},
        {CUBE("4", "0", "0.5"), SUN, "", 1},
        {CUBE("8e-6", "1", "0.5"), SUN, "", 0},
        {CUBE("8e4", "1", "0.9"), SUN WHITE POINT, "", 0},
        {CUBE("8e4", "0.5", "0"), SUN WHITE POINT, "", 0},
        {CUBE("4", "1", "0.5"), "  - {type: constant, radiance: 0}\n", "", 1},
        {CUBE("4", "1", "0.5"), SUN WHITE, "pop.ordinates=1 pop.cells=1", 0},
        {CUBE("4", "1", "0.5"), WHITE, "pop.ordinates=1024 pop.cells=2", 0},
        {CUBE("4", "1", "0.5"), "  - {type: sun, direction: [0, 0, 1], irradiance: 1}\n", "", 0},
        {CUBE("4", "1", "0.5"), "  - {type: sun, direction: [1, 1, 1], irradiance: 1e6}\n", "", 0},
        {CUBE("4", "1", "0.5"), "  - {type: point, position: [0, 0, 0], intensity: 1}\n", "pop.radial=1", 0},
        {CUBE("4", "1", "0.5"), "  - {type: point, position: [0.5, 0.5, 0.5625], intensity: 1}\n", "", 0},
        {CUBE("4", "1", "0.5"), "  - {type: point, position: [900, 0, 0], intensity: 1e6}\n", "", 0},
        {PLUME, SUN WHITE, "pop.variant=1", 0},
        {CUBE("4", "1", "0"), SUN WHITE, "pop.variant=1", 0},
    };
    for (size_t r = 0; r < sizeof runs / sizeof *runs; r++)
        for (int precision = 32; precision <= 64; precision += 32) {
            RenderCase seen;
            char knobs[256];
            snprintf(knobs, sizeof knobs, "pop.ordinates=8 pop.cells=8 pop.iterations=6 %s", runs[r].knobs);
            render(render_text("nephos: 1\ncamera: {" CAMERA "}\nmedia:\n  - {%s}\nlights:\n%s", runs[r].medium, runs[r].lights), precision, 2, knobs, &seen);
            for (int i = 0; i < 256; i++) {
                double value = (double)nph_image_channel(&seen.image, "R")->pixels[i];
                ck_assert_msg(value >= 0.0 && value < 1e12, "run %d, f%d, pixel %d: %g", (int)r, precision, i, value);
            }
            ck_assert_msg((mean_of(&seen.image, "R") > 0.0) == !runs[r].black, "run %d: mean %g", (int)r, mean_of(&seen.image, "R"));
            render_free(&seen);
        }
}
END_TEST

/* The map of a medium that hardly turns light has its importance ahead; of a dense one towards the camera. */
START_TEST(importance_goes_where_light_would_come_from) {
    static const char *const media[] = {CUBE("1", "1", "0.95"), CUBE("200", "1", "0")};
    for (int m = 0; m < 2; m++) {
        Solution s;
        double mean = 0.0, all = 0.0;
        solution_open(&s, render_text("nephos: 1\ncamera: {resolution: [8, 8], position: [-3, 0.5, 0.5], look_at: [0.5, 0.5, 0.5], fov: 15}\nmedia:\n  - {%s}\nlights:\n" WHITE, media[m]), 1,
                      "pop.ordinates=4 pop.cells=4");
        solve(&s, NPH_POP_MEDIUM, NPH_POP_IMPORTANCE, 0);
        for (int i = 0; i < NPH_POP_MAP_WIDTH * NPH_POP_MAP_HEIGHT; i++) {
            double polar = PI * (i / NPH_POP_MAP_WIDTH + 0.5) / NPH_POP_MAP_HEIGHT, azimuth = PI - 2.0 * PI * (i % NPH_POP_MAP_WIDTH + 0.5) / NPH_POP_MAP_WIDTH;
            double value = ((double *)s.solver.arrays.importance)[i] * sin(polar);
            ck_assert(value >= 0.0);
            mean += value * sin(polar) * cos(azimuth); /* along +x, where the camera looks */
            all += value;
        }
        printf("    mean cosine of importance: %.3f\n", mean / all);
        ck_assert(m == 0 ? mean > 0.5 * all : mean < -0.3 * all);
        solution_close(&s);
    }
}
END_TEST

/* A camera that turns: the map of frame 2 is the mean of those of frames 0, 1 and 2. */
START_TEST(importance_is_averaged_over_frames) {
    static const char *const positions[] = {"{frames: [0, 1, 2], values: [[-3, 0.5, 0.5], [0.5, -3, 0.5], [3, 0.5, 0.5]]}", "[-3, 0.5, 0.5]", "[0.5, -3, 0.5]", "[3, 0.5, 0.5]"};
    double map[4][NPH_POP_MAP_WIDTH * NPH_POP_MAP_HEIGHT], apart = 0.0;
    for (int k = 0; k < 4; k++) {
        Solution s;
        solution_open(&s, render_text("nephos: 1\ncamera: {resolution: [8, 8], position: %s, look_at: [0.5, 0.5, 0.5], fov: 15}\nmedia:\n  - {" CUBE("1", "1", "0.9")
                                      "}\nlights:\n" WHITE, positions[k]), 1, "pop.ordinates=4 pop.cells=4 pop.frames=3");
        if (k == 0) { /* solved at its frame 2 */
            NphScene *last = NULL;
            nph_pop_solver_close(&s.solver);
            ck_assert_int_eq(nph_scene_at_frame(s.context, s.scene, 2, &last), NPH_OK);
            nph_scene_free(s.context, s.scene);
            s.job.scene = s.scene = last;
            ck_assert_int_eq(nph_pop_solver_open(&s.job, &s.solver), NPH_OK);
        }
        solve(&s, NPH_POP_MEDIUM, NPH_POP_IMPORTANCE, 0);
        memcpy(map[k], s.solver.arrays.importance, sizeof map[k]);
        solution_close(&s);
    }
    for (int i = 0; i < NPH_POP_MAP_WIDTH * NPH_POP_MAP_HEIGHT; i++) {
        double mean = (map[1][i] + map[2][i] + map[3][i]) / 3.0;
        ck_assert_double_eq_tol(map[0][i], mean, 1e-12 * mean + 1e-15);
        apart += fabs(map[0][i] - map[3][i]);
    }
    ck_assert_double_gt(apart, 1e-3);
}
END_TEST

/* [Elek14 eq. 10]: in a homogeneous medium all light has the same mean cosine, that of its first scattering times the decay of every
 * iteration; they end with the first that brings the beam's own below epsilon_a, and not before light can have crossed the grid. */
START_TEST(iterations_end_when_light_is_isotropic_to_epsilon_a) {
    static const struct {
        const char *knobs;
        double g, epsilon, rate; /* rate: of the decay, over s_s */
    } runs[] = {
        {"pop.epsilon_a=0.5", 0.8, 0.5, 0.2},  {"pop.epsilon_a=0.1", 0.8, 0.1, 0.2},  {"pop.epsilon_a=1e-6", 0.8, 1e-6, 0.2},
        {"pop.epsilon_a=0.1", -0.5, 0.1, 1.5}, {"pop.epsilon_a=0.9", 0.8, 0.9, 0.2}, {"pop.epsilon_a=0.1 pop.variant=1", 0.8, 0.1, 0.22314355131420976},
    };
    enum { CELLS = 5 };
    for (size_t r = 0; r < sizeof runs / sizeof *runs; r++) {
        Solution s;
        char knobs[128];
        double decay = exp(-runs[r].rate * 3.0 / CELLS), begins = strstr(runs[r].knobs, "variant") ? 1.0 : runs[r].g, least = INFINITY, most = -INFINITY;
        snprintf(knobs, sizeof knobs, "pop.cells=5 pop.iterations=0 pop.epsilon_l=0 %s", runs[r].knobs);
        solution_open(&s, render_text("nephos: 1\ncamera: {" CAMERA "}\nmedia:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 4, albedo: 0.75, phase: {type: hg, g: %g}}\n"
                                      "lights:\n  - {type: sun, direction: [0, 0, -1], irradiance: 1}\n", runs[r].g), 2, knobs);
        solve(&s, NPH_POP_MEDIUM, NPH_POP_PROPAGATE, 0);
        int done = s.solver.iterations;
        for (int64_t i = 0; i < CELLS * CELLS * CELLS; i++) {
            double cosine = ((double *)s.solver.arrays.cosine)[i];
            least = fmin(least, cosine);
            most = fmax(most, cosine);
        }
        printf("    g %g, epsilon_a %g: %d iterations\n", runs[r].g, runs[r].epsilon, done);
        ck_assert_double_eq_tol(least, begins * pow(decay, done), 1e-12);
        ck_assert_double_eq_tol(most, begins * pow(decay, done), 1e-12);
        ck_assert_double_lt(pow(decay, done), runs[r].epsilon);
        ck_assert(done >= CELLS && (done == CELLS || pow(decay, done - 1) >= runs[r].epsilon));
        solution_close(&s);
    }
}
END_TEST

START_TEST(what_is_not_modelled_is_refused) {
    static const struct {
        const char *yaml, *says;
    } refused[] = {
        {SCENE("type: flux, resolution: [2, 2], position: [0, 0, 2], direction: [0, 0, -1], up: [0, 1, 0], extent: 1", CUBE("1", "1", "0"), SUN), "one observer"},
        {SCENE(CAMERA, "layer: [0, 1], extinction: 1, albedo: 1", SUN), "layer"},
        {SCENE(CAMERA, CUBE("1", "1", "0") "}\n  - {" CUBE("2", "1", "0"), SUN), "second"},
        {"nephos: 1\ncamera: {" CAMERA "}\nsurfaces:\n  - {plane: -1}\nlights:\n" SUN, "surface"},
    };
    for (size_t r = 0; r < sizeof refused / sizeof *refused; r++) {
        NphContext *context = nph_test_context(1);
        NphScene *scene = NULL;
        NphFilm *film = NULL;
        NphRenderOptions options = render_options(16, 32);
        options.method = "principal_ordinates";
        ck_assert_int_eq(nph_scene_parse(context, refused[r].yaml, strlen(refused[r].yaml), "test.yaml", ".", &scene), NPH_OK);
        ck_assert_int_eq(nph_render(context, scene, &options, &film, NULL), NPH_BAD_SCENE);
        ck_assert_msg(strstr(nph_test_messages(), refused[r].says) != NULL, "%s", nph_test_messages());
        nph_scene_free(context, scene);
        nph_test_context_close(context);
    }
}
END_TEST

/* Injected memory failures, and the plan against what is taken. */
START_TEST(memory_is_planned_and_may_fail) {
    static const char *const knobs[] = {"pop.cells=4", "pop.ordinates=3", "pop.iterations=2"};
    NphRenderOptions options = render_options(16, 32);
    options.method = "principal_ordinates";
    options.knobs = knobs;
    options.knob_count = 3;
    render_without_memory(SCENE(CAMERA, CUBE("4", "1", "0.5"), SUN WHITE), &options);
    options.knob_count = 0;
    render_as_planned(SCENE(CAMERA, PLUME, SUN WHITE), &options);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, parts_of_a_lobe_are_its_integrals);
    tcase_add_test(cases, the_octahedral_map_goes_back_and_its_cells_fill_the_sphere);
    tcase_add_loop_test(cases, with_albedo_1_what_enters_leaves, 0, 3);
    tcase_add_test(cases, the_local_cases_of_figure_5);
    tcase_add_test(cases, thin_media_show_the_beam);
    tcase_add_test(cases, ordinates_have_all_of_the_sky);
    tcase_add_test(cases, axes_are_alike);
    tcase_add_test(cases, a_stage_or_knob_is_for_something);
    tcase_add_test(cases, threads_and_precisions_agree);
    tcase_add_test(cases, a_full_plan_is_the_same_picture);
    tcase_add_test(cases, extremes_are_survived);
    tcase_add_test(cases, importance_goes_where_light_would_come_from);
    tcase_add_test(cases, importance_is_averaged_over_frames);
    tcase_add_test(cases, iterations_end_when_light_is_isotropic_to_epsilon_a);
    tcase_add_test(cases, what_is_not_modelled_is_refused);
    tcase_add_test(cases, memory_is_planned_and_may_fail);
}

int main(void) { return nph_test_main("principal_ordinates", fill); }
