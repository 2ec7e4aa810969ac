/* SPDX-License-Identifier: Apache-2.0
 *
 * Stages of principal ordinates one by one, each against a closed form or what it must keep: written after breaking them on purpose. */
#include <stdlib.h>

#include "pop_case.h"

static double lobe(double mu, double a) { return (1.0 - a * a) / (4.0 * PI) * pow(1.0 + a * a - 2.0 * a * mu, -1.5); }

static double *values(void *array) { return array; }

/* Where a cell of a grid lies, and the cosine from its light to the observer. */
static double cell_mu(const Solution *s, const RPopGrid *grid, int64_t i, double p[3], double d[3]) {
    RPopObserver observer = r_pop_observer(&((RPopScene *)s->solver.scene)->local);
    r_pop_cell(grid, (int32_t)(i % grid->n[0]), (int32_t)(i / grid->n[0] % grid->n[1]), (int32_t)(i / grid->n[0] / grid->n[1]), p, d);
    return r_pop_mu(&observer, p, d);
}

#define DOWN "  - {type: sun, direction: [0, 0, 1], irradiance: 1}\n"

/* What the beam loses in a cell is part of what it shows there: 1 - e^-tau along a column. Of that the albedo is sent. */
START_TEST(a_cell_shows_and_sends_what_the_beam_loses_in_it) {
    enum { CELLS = 4 };
    Solution s;
    solution_open(&s, SCENE(CAMERA, CUBE("5", "0.6", "0.7"), DOWN), 1, "pop.cells=4");
    solve(&s, NPH_POP_MEDIUM, NPH_POP_INJECT, 0);
    RPopGrid grid = grid_of(&s, 0);
    for (int column = 0; column < CELLS * CELLS; column++) {
        double lost = 0.0, sent = 0.0;
        for (int z = 0; z < CELLS; z++) {
            int i = z * CELLS * CELLS + column;
            double p[3], d[3], mu = cell_mu(&s, &grid, i, p, d);
            ck_assert_double_eq_tol(values(s.solver.arrays.light)[i], 0.6 * exp(-1.25 * z) * (1.0 - exp(-1.25)), 1e-12);
            lost += 1.25 * values(s.solver.arrays.seen)[i] / lobe(mu, 0.7);
            sent += values(s.solver.arrays.light)[i];
        }
        ck_assert_double_eq_tol(lost, 1.0 - exp(-5.0), 1e-12);
        ck_assert_double_eq_tol(sent, 0.6 * lost, 1e-12);
    }
    solution_close(&s);
}
END_TEST

/* Light of mean cosine a that visits a cell is seen for the length it has there: its depth, to the sides its width; isotropic light as
 * much of that as diffusion has, half the depth in transport lengths; at birth half of it all. */
START_TEST(a_visit_is_seen_for_its_length) {
    Solution s;
    double light[32], cosine[32], seen[32], transport = 3.0 * 0.5 + 3.0 * 0.5 * (1.0 - 0.4), wide = 0.25, deep = 0.5;
    solution_open(&s, SCENE(CAMERA, CUBE("3", "0.5", "0.4"), DOWN), 1, "pop.cells=4 pop.along=2 pop.iterations=9 pop.epsilon_l=0");
    solve(&s, NPH_POP_MEDIUM, NPH_POP_INJECT, 0);
    RPopGrid grid = grid_of(&s, 0);
    double cone = deep / sqrt(deep * deep + wide * wide);
    for (int m = 0; m < 3; m++) {
        memcpy(light, s.solver.arrays.light, sizeof light);
        memcpy(cosine, s.solver.arrays.cosine, sizeof cosine);
        memcpy(seen, s.solver.arrays.seen, sizeof seen);
        s.solver.iteration = m;
        ck_assert_int_eq(nph_pop_step(&s.solver, NPH_POP_PROPAGATE), NPH_OK);
        for (int i = 0; i < 32; i++) {
            double p[3], d[3], mu = cell_mu(&s, &grid, i, p, d), a = cosine[i];
            double beside = r_pop_below(cone, a) - r_pop_below(-cone, a), length = 1.0 - beside + beside * wide / deep;
            double seen_for = (m > 0 ? 1.0 : 0.5) * length * (fabs(a) + (1.0 - fabs(a)) * 0.5 * transport * deep);
            ck_assert_double_eq_tol(values(s.solver.arrays.seen)[i] - seen[i], seen_for * light[i] * lobe(mu, 0.4 * a), 1e-12);
        }
    }
    solution_close(&s);
}
END_TEST

/* Isotropic light of a cell 1 x 2 x 3 in size: the next one gets the cone whose base has the area of their face; sides share by angle. */
START_TEST(neighbours_of_a_lopsided_cell_get_their_solid_angles) {
    Solution s;
    solution_open(&s, SCENE(CAMERA, "box: [[0, 0, 0], [3, 6, 9]], extinction: 1, albedo: 1, phase: {type: hg, g: 0}", DOWN), 1, "pop.cells=3 pop.epsilon_l=0 pop.iterations=1");
    solve(&s, NPH_POP_MEDIUM, NPH_POP_INJECT, 0);
    RPopGrid grid = grid_of(&s, 0);
    double cone = 3.0 / sqrt(9.0 + 2.0), *light = s.solver.arrays.light;
    for (int i = 0; i < 27; i++) light[i] = values(s.solver.arrays.cosine)[i] = i == 13;
    values(s.solver.arrays.cosine)[13] = 0.0;
    s.solver.arrays.power[NPH_POP_LEFT] = 1.0;
    ck_assert_int_eq(nph_pop_step(&s.solver, NPH_POP_PROPAGATE), NPH_OK);
    int first = grid.edge[0] < grid.edge[1] ? 1 : 3, second = 4 - first; /* to the neighbour 1 m, and 2 m away */
    for (int way = -1; way <= 1; way += 2) {
        ck_assert_double_eq_tol(light[13 + way * 9], 0.5 * (1.0 - cone), 1e-12);
        ck_assert_double_eq_tol(light[13 + way * first], cone * atan(2.0) / PI, 1e-12);
        ck_assert_double_eq_tol(light[13 + way * second], cone * atan(0.5) / PI, 1e-12);
    }
    solution_close(&s);
}
END_TEST

static double turn_between(const RPopGrid *grid, int64_t i, int64_t j) {
    double p[3], d[3], q[3], e[3];
    r_pop_cell(grid, (int32_t)(i % grid->n[0]), (int32_t)(i / grid->n[0] % grid->n[1]), 0, p, d);
    r_pop_cell(grid, (int32_t)(j % grid->n[0]), (int32_t)(j / grid->n[0] % grid->n[1]), 0, q, e);
    return r_pop_dot(d, e);
}

/* Around a point: light of a cell at the border of the map goes to others near it, and from the innermost shell back through the point. */
START_TEST(cells_around_a_point_have_their_neighbours) {
    enum { N = 8, PLANE = N * N };
    Solution s;
    solution_open(&s, SCENE(CAMERA, CUBE("1", "1", "0"), POINT), 1, "pop.radial=8 pop.epsilon_l=0 pop.iterations=1");
    solve(&s, NPH_POP_MEDIUM, NPH_POP_INJECT, 0);
    RPopGrid grid = grid_of(&s, 0);
    double *light = s.solver.arrays.light;
    for (int from = 0; from < PLANE; from++)
        for (int shell = 0; shell < 4; shell += 3) {
            double sent = 0.0, *own = light + shell * PLANE;
            int near = 0;
            for (int i = 0; i < N * PLANE; i++) light[i] = values(s.solver.arrays.cosine)[i] = 0.0;
            own[from] = s.solver.arrays.power[NPH_POP_LEFT] = 1.0;
            ck_assert_int_eq(nph_pop_step(&s.solver, NPH_POP_PROPAGATE), NPH_OK);
            for (int i = 0; i < PLANE; i++) {
                int through = shell == 0 && turn_between(&grid, from, i) < -0.999999;
                if (through) ck_assert_double_eq_tol(own[i], 0.5 * (1.0 - sqrt(0.5)), 1e-9);
                else if (own[i] > 0.0) {
                    ck_assert_int_ne(i, from);
                    ck_assert_msg(turn_between(&grid, from, i) > 0.6, "cell %d sends to cell %d", from, i);
                    sent += own[i];
                    near++;
                }
            }
            ck_assert_double_eq_tol(sent, sqrt(0.5), 1e-9); /* what lies between the cones */
            ck_assert(near >= 2 && near <= 4);
        }
    solution_close(&s);
}
END_TEST

#define COLOURED "  - {type: sun, direction: [-1, 0.3, 0.2], irradiance: [1, 2, 4]}\n  - {type: sun, direction: [0.2, 0.5, 1], irradiance: [3, 1, 0.5]}\n"

/* What is left goes into one grid with all its power; there a cell sends a sixth to each neighbour, less what is absorbed on the way. */
START_TEST(the_residuum_keeps_power_and_spreads_alike) {
    Solution s;
    solution_open(&s, SCENE(CAMERA, CUBE("6", "0.9", "0.3"), COLOURED POINT), 2, "pop.cells=9 pop.iterations=3 pop.residuum_cells=5");
    solve(&s, NPH_POP_MEDIUM, NPH_POP_JOIN, 0);
    const NphPopSolver *solver = &s.solver;
    const int32_t *n = solver->choice.joined;
    double *from = solver->arrays.residuum[0], *to = solver->arrays.residuum[1], edge = 0.2, cells = 125.0;
    double path = 0.5 * (0.6 + 5.4 * 0.7) * edge; /* of a visit, over an edge */
    ck_assert(n[0] == 5 && n[1] == 5 && n[2] == 5 && solver->choice.transport.film_channels == 3);
    for (int c = 0; c < 3; c++) {
        double before = 0.0, after = 0.0;
        for (int g = 0; g < nph_pop_grids(&solver->choice); g++) {
            RPopGrid grid = grid_of(&s, g);
            double area = grid.radial ? 4.0 * PI / (grid.n[0] * grid.n[1]) : grid.edge[0] * grid.edge[1];
            before += ordinate_of(&s, g)[NPH_POP_VALUE + c] * area * solver->arrays.power[g * NPH_POP_POWERS + NPH_POP_LEFT];
        }
        for (int i = 0; i < 125; i++) after += from[c * 125 + i] * edge * edge;
        ck_assert_double_gt(before, 0.0);
        ck_assert_double_eq_tol(after, before, 1e-12 * before);
    }
    for (int i = 0; i < 375; i++) from[i] = values(solver->arrays.spread)[i] = 0.0;
    from[62] = 1.0;
    ck_assert_int_eq(nph_pop_step(&s.solver, NPH_POP_SPREAD), NPH_OK);
    for (int i = 0; i < 125; i++) {
        int off = abs(i % 5 - 2) + abs(i / 5 % 5 - 2) + abs(i / 25 - 2);
        ck_assert_double_eq_tol(to[i], off == 1 ? exp(-0.6 * path * edge) / 6.0 : 0.0, 1e-12);
        ck_assert_double_eq_tol(values(solver->arrays.spread)[i], path * to[i], 1e-12);
    }
    for (int i = 0; i < 375; i++) values(solver->arrays.spread)[i] = cells;
    for (int64_t i = 0; i < nph_pop_first(&solver->choice, nph_pop_grids(&solver->choice), solver->choice.channels); i++) values(solver->arrays.seen)[i] = 0.0;
    ck_assert_int_eq(nph_pop_step(&s.solver, NPH_POP_MERGE), NPH_OK);
    for (int64_t i = 0; i < nph_pop_cells(solver->choice.merged); i++)
        for (int c = 0; c < 3; c++) ck_assert_double_eq_tol(values(solver->arrays.merged)[i * NPH_POP_CELL + c], cells / (4.0 * PI), 1e-12 * cells);
    solution_close(&s);
}
END_TEST

/* Grids whose cells show a linear function of place add up to it, times what each one brings. */
START_TEST(merging_keeps_linear_fields) {
    Solution s;
    solution_open(&s, SCENE(CAMERA, CUBE("6", "0.9", "0.3"), COLOURED), 2, "pop.cells=7 pop.residuum=0");
    solve(&s, NPH_POP_MEDIUM, NPH_POP_INJECT, 0);
    const RPopScene *scene = s.solver.scene;
    const int32_t *n = s.solver.choice.merged;
    double slope[3] = {0.3, -0.7, 0.2}, factor[3] = {4.0, 3.0, 4.5};
    for (int g = 0; g < 2; g++) {
        RPopGrid grid = grid_of(&s, g);
        for (int64_t i = 0; i < 343; i++) {
            double p[3], d[3];
            cell_mu(&s, &grid, i, p, d);
            values(s.solver.arrays.seen)[g * 343 + i] = 2.0 + r_pop_dot(slope, p);
        }
    }
    ck_assert_int_eq(nph_pop_step(&s.solver, NPH_POP_MERGE), NPH_OK);
    for (int64_t i = 0; i < nph_pop_cells(n); i++) {
        int at[3] = {(int)(i % n[0]), (int)(i / n[0] % n[1]), (int)(i / n[0] / n[1])}, inner = 1;
        for (int a = 0; a < 3; a++) inner &= at[a] >= 2 && at[a] < n[a] - 2;
        double p[3];
        r_pop_middle(scene, &scene->merged, at[0], at[1], at[2], p);
        for (int c = 0; c < 3 && inner; c++)
            ck_assert_double_eq_tol(values(s.solver.arrays.merged)[i * NPH_POP_CELL + c], factor[c] * (2.0 + r_pop_dot(slope, p)), 1e-12 * factor[c]);
    }
    solution_close(&s);
}
END_TEST

#define BALL "density: {file: ../data/sphere/sphere.npy, box: [[0, 0, 0], [1, 1, 1]]}, extinction: 0.02, albedo: 0.8, phase: {type: hg, g: 0.5}"

/* Where the guide says nothing, a linear field stays itself; where it does, a voxel takes what lies in density like its own. */
START_TEST(upsampling_is_linear_and_heeds_the_guide) {
    Solution s;
    solution_open(&s, SCENE(CAMERA, BALL, SUN), 2, "pop.cells=6 pop.residuum=0 pop.spread_density=0.05");
    solve(&s, NPH_POP_MEDIUM, NPH_POP_INJECT, 0);
    const int32_t *n = s.solver.choice.merged, *fine = s.solver.choice.fine;
    double *merged = s.solver.arrays.merged, *out = s.solver.arrays.fine;
    int64_t seen = 0;
    for (int guided = 0; guided < 2; guided++) {
        for (int64_t i = 0; i < nph_pop_cells(n); i++) {
            int64_t at[3] = {i % n[0], i / n[0] % n[1], i / n[0] / n[1]}, odd = (at[0] + at[1] + at[2]) & 1;
            for (int c = 0; c < 3; c++) merged[i * NPH_POP_CELL + c] = guided ? (double)odd : 1.0 + ((double)at[c] + 0.5) / n[c];
            merged[i * NPH_POP_CELL + 3] = guided ? (double)odd : 0.5;
        }
        ck_assert_int_eq(nph_pop_step(&s.solver, NPH_POP_UPSAMPLE), NPH_OK);
        for (int64_t i = 0; i < nph_pop_cells(fine) && !guided; i++) {
            int64_t at[3] = {i % fine[0], i / fine[0] % fine[1], i / fine[0] / fine[1]};
            int inner = out[i * NPH_POP_CELL + 3] > 0.0;
            for (int a = 0; a < 3; a++) inner &= at[a] * n[a] >= fine[a] && (at[a] + 1) * n[a] <= fine[a] * (n[a] - 1); /* between middles of cells */
            for (int c = 0; c < 3 && inner; c++) /* 1e-6 is added to every share */
                ck_assert_double_eq_tol(out[i * NPH_POP_CELL + c], 1.0 + ((double)at[c] + 0.5) / fine[c], 1e-5);
            seen += inner;
        }
        int64_t middle = ((fine[2] / 2) * fine[1] + fine[1] / 2) * (int64_t)fine[0]; /* of full density there, as the odd cells */
        for (int32_t x = fine[0] / 3; x < 2 * fine[0] / 3 && guided; x++) ck_assert_double_eq_tol(out[(middle + x) * NPH_POP_CELL], 1.0, 1e-5);
    }
    ck_assert_int_gt(seen, nph_pop_cells(fine) / 8);
    solution_close(&s);
}
END_TEST

/* Rays along the box's axis in steps that do not divide it: J within, 1 behind. Grey, and of three colours. */
START_TEST(a_ray_collects_what_it_loses) {
    enum { PLANE = NPH_TILE_PIXELS * NPH_CHUNK };
    static double samples[NPH_SAMPLE_FIELDS * PLANE];
    static const char *const media[] = {CUBE("3", "0.8", "0.3"), CUBE("[3, 1, 6]", "[0.8, 0.5, 1]", "0.3")};
    static const double extinction[2][3] = {{3.0, 3.0, 3.0}, {3.0, 1.0, 6.0}}, albedo[2][3] = {{0.8, 0.8, 0.8}, {0.8, 0.5, 1.0}};
    Solution s;
    int64_t steps = 0;
    solution_open(&s, render_text("nephos: 1\ncamera: {type: orthographic, resolution: [4, 4], position: [0.5, 0.5, 3], look_at: [0.5, 0.5, 0], up: [0, 1, 0], extent: 0.9}\n"
                                  "media:\n  - {%s}\nlights:\n" WHITE, media[_i]), 1, "pop.cells=3 pop.ordinates=2 pop.steps=7 pop.exit=0");
    solve(&s, NPH_POP_MEDIUM, NPH_POP_MERGE, 0);
    for (int64_t i = 0; i < nph_pop_cells(s.solver.choice.merged) * NPH_POP_CELL; i++) values(s.solver.arrays.merged)[i] = 5.0;
    s.solver.kernels.march(s.solver.scene, &s.solver.arrays, (int[]){0, 0, 4, 4}, 0, samples, &steps);
    for (int i = 0; i < 4 * 4 * NPH_CHUNK; i++)
        for (int c = 0; c < 3; c++) {
            const double *out = samples + i / (4 * NPH_CHUNK) * NPH_TILE * NPH_CHUNK + i % (4 * NPH_CHUNK);
            double T = exp(-extinction[_i][c]);
            ck_assert_double_eq_tol(out[(NPH_SAMPLE_T0 + c) * PLANE], T, 1e-12);
            ck_assert_double_eq_tol(out[(NPH_SAMPLE_L0 + c) * PLANE], albedo[_i][c] * (1.0 - T) * 5.0 + T, 1e-12);
        }
    solution_close(&s);
}
END_TEST

/* Empty space is passed, and nothing else: opacities are those of `single`, whose pixels have the same samples, but for the midpoints of
 * steps, whose error falls with the square of the step. */
START_TEST(opacities_are_those_of_quadrature) {
    static const char *const steps[] = {"pop.steps=2000", "pop.steps=200"};
    static const double tolerances[] = {1e-5, 1e-3};
    const char *knobs[] = {"pop.cells=4", "pop.ordinates=2", "pop.iterations=1", "pop.exit=0", steps[_i]}, *yaml = SCENE(CAMERA, BALL, WHITE);
    NphRenderOptions options = render_options(16, 64);
    RenderCase ours, theirs;
    double worst = 0.0;
    options.method = "single";
    render_case(&theirs, yaml, &options, 2);
    options.method = "principal_ordinates";
    options.knobs = knobs;
    options.knob_count = 5;
    render_case(&ours, yaml, &options, 2);
    for (int i = 0; i < 256; i++)
        worst = fmax(worst, fabs((double)nph_image_channel(&ours.image, "A")->pixels[i] - (double)nph_image_channel(&theirs.image, "A")->pixels[i]));
    printf("    opacities differ by %.2g at most\n", worst);
    ck_assert_double_lt(worst, tolerances[_i]);
    render_free(&ours);
    render_free(&theirs);
}
END_TEST

/* Caps: the mean cosine is 1 - Omega / 4 pi, so 1 less it adds up to 1. A hemisphere's is 1/2, a disc's half of 1 and that of its rim. */
START_TEST(prefiltering_knows_mean_cosines) {
    Solution s;
    double sum = 0.0;
    solution_open(&s, SCENE(CAMERA, CUBE("3", "1", "0.5"), WHITE), 1, "pop.ordinates=50 pop.cells=2 pop.importance=0");
    solve(&s, NPH_POP_MEDIUM, NPH_POP_ORDINATES, 0);
    for (int n = 0; n < 50; n++) sum += 1.0 - ordinate_of(&s, n)[NPH_POP_COSINE];
    ck_assert_double_eq_tol(sum, 1.0, 1e-12);
    solution_close(&s);
    solution_open(&s, SCENE(CAMERA, CUBE("3", "1", "0.5"), "  - {type: constant, radiance: 2, hemisphere: upper}\n"), 1,
                  "pop.ordinates=1 pop.cells=2 pop.importance=0 pop.regions=1 pop.prefilter=2");
    solve(&s, NPH_POP_MEDIUM, NPH_POP_ORDINATES, 0);
    ck_assert_double_eq_tol(ordinate_of(&s, 0)[NPH_POP_COSINE], 0.5, 0.002); /* texels: 1/32 of the polar angle */
    ck_assert_double_lt(ordinate_of(&s, 0)[NPH_POP_WAY + 2], -1.0 + 1e-9);
    solution_close(&s);
    solution_open(&s, SCENE(CAMERA, CUBE("3", "1", "0.5"), "  - {type: sun, direction: [0, 0, 1], irradiance: 1, angular_diameter: 120}\n"), 1, "pop.cells=2");
    solve(&s, NPH_POP_MEDIUM, NPH_POP_ORDINATES, 0);
    ck_assert_double_eq_tol(ordinate_of(&s, 0)[NPH_POP_COSINE], 0.75, 1e-12);
    ck_assert_double_eq_tol(ordinate_of(&s, 0)[NPH_POP_SOLID_ANGLE], PI, 1e-12);
    solution_close(&s);
}
END_TEST

/* The way towards a texel of the map, and its weight in it; dark: towards -y, else 1 + 0.8 of the cosine to +y. */
static double importance_at(int i, int dark) {
    double polar = PI * (i / NPH_POP_MAP_WIDTH + 0.5) / NPH_POP_MAP_HEIGHT, azimuth = PI - 2.0 * PI * (i % NPH_POP_MAP_WIDTH + 0.5) / NPH_POP_MAP_WIDTH;
    double y = sin(polar) * sin(azimuth);
    return dark ? y > 0.0 : 1.0 + 0.8 * y;
}

/* Ordinates go where importance is, and on average they have the light of the sky wherever they go. */
START_TEST(importance_moves_ordinates_and_no_light) {
    enum { ORDINATES = 16, SEEDS = 200 };
    Solution s;
    double sum = 0.0, squares = 0.0;
    int there = 0;
    solution_open(&s, SCENE(CAMERA, CUBE("3", "1", "0.5"), "  - {type: constant, radiance: 3}\n"), 1, "pop.ordinates=16 pop.cells=2");
    solve(&s, NPH_POP_MEDIUM, NPH_POP_IMPORTANCE, 0);
    for (int dark = 1; dark >= 0; dark--) {
        for (int i = 0; i < NPH_POP_MAP_WIDTH * NPH_POP_MAP_HEIGHT; i++) values(s.solver.arrays.importance)[i] = importance_at(i, dark);
        for (int seed = 0; seed < (dark ? 1 : SEEDS); seed++) {
            double all = 0.0;
            s.solver.job.seed = (uint64_t)seed;
            ck_assert_int_eq(nph_pop_step(&s.solver, NPH_POP_ORDINATES), NPH_OK);
            for (int n = 0; n < ORDINATES; n++) {
                all += ordinate_of(&s, n)[NPH_POP_VALUE];
                there += dark && ordinate_of(&s, n)[NPH_POP_WAY + 1] < 0.0;
            }
            if (dark) continue;
            sum += all;
            squares += all * all;
        }
    }
    double mean = sum / SEEDS, error = sqrt((squares / SEEDS - mean * mean) / (SEEDS - 1));
    printf("    %d of %d ordinates lie where importance is; light: %.4f, standard error %.4f, of the sky %.4f\n", there, ORDINATES, mean, error, 12.0 * PI);
    ck_assert_int_ge(there, ORDINATES - 1); /* a hundredth of the mean importance is everywhere */
    ck_assert_double_eq_tol(mean, 12.0 * PI, 4.0 * error);
    ck_assert_double_lt(error, 0.01 * mean);
    solution_close(&s);
}
END_TEST

/* All importance that a cube sends out, and its mean cosine to the camera's view. */
static double importance_of(const char *medium, double *cosine) {
    Solution s;
    double mean = 0.0, all = 0.0;
    solution_open(&s, render_text("nephos: 1\ncamera: {resolution: [8, 8], position: [-3, 0.5, 0.5], look_at: [0.5, 0.5, 0.5], fov: 15}\nmedia:\n  - {%s}\nlights:\n" WHITE, medium), 1,
                  "pop.ordinates=4 pop.cells=4");
    solve(&s, NPH_POP_MEDIUM, NPH_POP_IMPORTANCE, 0);
    for (int i = 0; i < NPH_POP_MAP_WIDTH * NPH_POP_MAP_HEIGHT; i++) {
        double polar = PI * (i / NPH_POP_MAP_WIDTH + 0.5) / NPH_POP_MAP_HEIGHT, azimuth = PI - 2.0 * PI * (i % NPH_POP_MAP_WIDTH + 0.5) / NPH_POP_MAP_WIDTH;
        double value = values(s.solver.arrays.importance)[i] * sin(polar);
        mean += value * sin(polar) * cos(azimuth);
        all += value;
    }
    solution_close(&s);
    *cosine = mean / all;
    return all;
}

/* What begins forward comes back from a dense medium; where half of it is absorbed at every scattering hardly any does. */
START_TEST(importance_is_scattered_and_absorbed) {
    double cosine, unused, all = importance_of(CUBE("100", "1", "0.8"), &cosine), some = importance_of(CUBE("100", "0.5", "0.8"), &unused);
    double thin = importance_of(CUBE("0.01", "1", "0.8"), &unused), grey = importance_of(CUBE("0.01", "0.5", "0.8"), &unused);
    printf("    mean cosine %.3f; of what albedo 1 sends out 0.5 sends %.3f, in a thin medium %.3f\n", cosine, some / all, grey / thin);
    ck_assert_double_lt(cosine, 0.0);
    ck_assert_double_lt(some, 0.1 * all);
    ck_assert_double_eq_tol(grey, 0.5 * thin, 0.01 * thin);
}
END_TEST

/* A grid that lies askew has the medium's volume; coarse cells have its mean density; Eq. 10 counts by that. */
START_TEST(grids_have_the_mediums_density) {
    Solution s;
    double sum = 0.0;
    solution_open(&s, SCENE(CAMERA, CUBE("1", "1", "0.5"), "  - {type: sun, direction: [1, 2, 3], irradiance: 1}\n"), 2, "pop.cells=40");
    solve(&s, NPH_POP_MEDIUM, NPH_POP_GRIDS, 0);
    RPopGrid grid = grid_of(&s, 0);
    for (int i = 0; i < 64000; i++) sum += values(s.solver.arrays.density)[i] * grid.edge[0] * grid.edge[1] * grid.edge[2];
    printf("    volume %.4f\n", sum);
    ck_assert_double_eq_tol(sum, 1.0, 0.02); /* cells at the border are covered as their boxes are */
    solution_close(&s);
    solution_open(&s, SCENE(CAMERA, BALL, DOWN), 2, "pop.cells=6 pop.iterations=0 pop.epsilon_a=0.01");
    solve(&s, NPH_POP_MEDIUM, NPH_POP_PROPAGATE, 0);
    const int32_t *n = s.solver.choice.mips;
    double mean = 0.0;
    ck_assert(n[0] == 6 && n[1] == 6 && n[2] == 6);
    for (int i = 0; i < 216; i++) mean += values(s.solver.arrays.medium)[i] / 216.0;
    ck_assert_double_eq_tol(mean, s.solver.choice.mean_density, 1e-9 * mean);
    ck_assert_int_eq(s.solver.iterations, (int)(log(100.0) / (0.5 * 0.016 * mean / 6.0)) + 1);
    solution_close(&s);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, a_cell_shows_and_sends_what_the_beam_loses_in_it);
    tcase_add_test(cases, a_visit_is_seen_for_its_length);
    tcase_add_test(cases, neighbours_of_a_lopsided_cell_get_their_solid_angles);
    tcase_add_test(cases, cells_around_a_point_have_their_neighbours);
    tcase_add_test(cases, the_residuum_keeps_power_and_spreads_alike);
    tcase_add_test(cases, merging_keeps_linear_fields);
    tcase_add_test(cases, upsampling_is_linear_and_heeds_the_guide);
    tcase_add_loop_test(cases, a_ray_collects_what_it_loses, 0, 2);
    tcase_add_loop_test(cases, opacities_are_those_of_quadrature, 0, 2);
    tcase_add_test(cases, prefiltering_knows_mean_cosines);
    tcase_add_test(cases, importance_moves_ordinates_and_no_light);
    tcase_add_test(cases, importance_is_scattered_and_absorbed);
    tcase_add_test(cases, grids_have_the_mediums_density);
}

int main(void) { return nph_test_main("pop_stages", fill); }
