/* SPDX-License-Identifier: Apache-2.0
 *
 * Single rays of truth/single against closed forms, tables and brute force, to its tolerance. */
#include "single_case.h"

/* ---- optical depths ---- */

static int by_size(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

/* Every plane that the line may cross, sorted; between them the lookup of the kernels at two Gauss points. */
static double brute_depth(const RMedium *medium, const double p[3], const double d[3]) {
    static double cuts[20000];
    NphLine line;
    int count = 0;
    if (!nph_line_clip(medium, p, d, 0.0, 1e30, &line)) return 0.0;
    cuts[count++] = line.near;
    cuts[count++] = line.far;
    for (int a = 0; a < 3; a++)
        for (int plane = 0; plane < 2 * medium->grid.n[a]; plane++) {
            double t = (0.5 * plane - line.o[a]) / line.d[a];
            if (t > line.near && t < line.far) cuts[count++] = t;
        }
    qsort(cuts, (size_t)count, sizeof *cuts, by_size);
    double sum = 0.0;
    for (int i = 0; i + 1 < count; i++)
        for (int g = -1; g <= 1; g += 2) {
            double t = 0.5 * (cuts[i] + cuts[i + 1]) + g * 0.5 * (cuts[i + 1] - cuts[i]) / sqrt(3.0), u[3];
            for (int a = 0; a < 3; a++) u[a] = fmin(fmax(line.o[a] + t * line.d[a], medium->lo[a]), medium->hi[a]);
            sum += 0.5 * (cuts[i + 1] - cuts[i]) * r_grid_value(&medium->grid, u[0], u[1], u[2]);
        }
    return sum;
}

static const char *const densities[] = {
    "{file: ../data/cumulus/cumulus_300.zip.nvdb}",
    "{file: ../data/cumulus/cumulus_300.zip.nvdb, lookup: nearest}",
    "{file: ../data/cumulus/cumulus_300.zip.nvdb, centring: cell}",
};

START_TEST(optical_depths_are_those_of_brute_force_to_rounding) {
    Case c;
    begin(&c, text(CAMERA "media:\n  - {density: %s, extinction: 20, albedo: 0.5, transform: [{scale: 0.4}, {rotate: {axis: [1, 2, 3], "
                          "angle: 40}}, {translate: [0.5, 0.4, 0.5]}]}\nlights: [{type: constant, radiance: 1}]\n", densities[_i]), 1e-4, 0);
    int through = 0;
    NphWalked walked = {0, 0};
    for (int i = 0; i < 400; i++) {
        double p[3], d[3], density[NPH_SINGLE_FIELDS], tau[3];
        some_ray(i, p, d);
        for (int a = 0; a < 3; a++) p[a] -= c.single->local.origin[a];
        double depth = nph_single_depth(&c.single->local.media[0], p, d, 1e30, 1e300, &walked);
        double truth = brute_depth(&c.single->local.media[0], p, d);
        ck_assert_double_le(fabs(depth - truth), 1e-12 + 1e-11 * truth);
        through += truth > 0.01;
        /* and the profile's: piece by piece, at its end and where a place says */
        NphPiece *pieces = malloc((NPH_SINGLE_PIECES + 1) * sizeof *pieces);
        NphProfile profile = {.end = 0.0};
        profile.pieces[0] = pieces;
        nph_profile_build(&profile, c.single, p, d, 1e30, &walked);
        NphPlace place;
        nph_profile_seek(&profile, 2.0, &place);
        nph_profile_move(&profile, &place, 2.0, 1e30);
        nph_profile_at(&profile, &place, 2.0, density, tau);
        double half = nph_single_depth(&c.single->local.media[0], p, d, 2.0, 1e300, &walked);
        if (!profile.opaque) ck_assert_double_le(fabs(profile.total[0] - truth), 1e-12 + 1e-11 * truth);
        if (profile.end > 2.0) ck_assert_double_le(fabs(tau[0] - 20.0 * half), 1e-10 + 1e-11 * tau[0]);
        free(pieces);
    }
    ck_assert_int_gt(through, 60);
    end(&c);
}
END_TEST

/* A row of reference/tables/transmittance_heterogeneous.csv: a trilinear cell; the other rows are no trilinear grids. */
START_TEST(transmittance_through_a_trilinear_cell_is_the_tables) {
    static const float corner[8] = {0.1f, 2.0f, 0.7f, 0.0f, 1.3f, 0.4f, 5.0f, 0.9f};
    const char *path = nph_test_temporary("cell.npy");
    NphContext *context = nph_test_context(1);
    NphArray array;
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 3, (int64_t[]){2, 2, 2}, "cell", &array), NPH_OK);
    memcpy(array.data, corner, sizeof corner);
    ck_assert_int_eq(nph_npy_write(context, path, &array), NPH_OK);
    nph_array_free(context, &array);
    nph_test_context_close(context);
    Case c;
    double fields[NPH_SAMPLE_FIELDS];
    begin(&c, text(CAMERA "media:\n  - {density: {file: %s, box: [[0, 0, 0], [1, 1, 1]], centring: point}, extinction: 1, albedo: 0}\n"
                          "lights: [{type: constant, radiance: 1}]\n", path), 1e-4, 0);
    shoot(&c, (double[]){0.1 - 0.8, 0.2 - 0.4, -1.0}, (double[]){0.8, 0.4, 1.0}, fields);
    ck_assert_double_le(fabs(fields[NPH_SAMPLE_T0] - 0.2466515779207), 2e-8); /* corners are floats: 0.1f */
    ck_assert_double_eq(fields[NPH_SAMPLE_L0], fields[NPH_SAMPLE_T0]);
    end(&c);
}
END_TEST

/* ---- closed forms ---- */

typedef struct Row {
    char phase[32], level[16];
    double ssa, tau, mu0, mu, phi, value;
} Row;

static int read_rows(Row *rows, int most) {
    FILE *file = fopen(nph_test_path("reference/tables/single_scatter_slab.csv"), "r");
    ck_assert_ptr_nonnull(file);
    char line[1024];
    int count = 0;
    while (count < most && fgets(line, sizeof line, file)) {
        Row *r = &rows[count];
        count += sscanf(line, "%31[^,],%lf,%lf,%lf,%lf,%lf,%15[^,],%lf", r->phase, &r->ssa, &r->tau, &r->mu0, &r->mu, &r->phi,
                        r->level, &r->value) == 8;
    }
    fclose(file);
    return count;
}

static const char *phase_text(const char *phase) {
    return strncmp(phase, "HG", 2) == 0 ? text("{type: hg, g: %s}", phase + 2)
           : phase[0] == 'r' || phase[0] == 'R' ? "{type: rayleigh}" : "{type: isotropic}";
}

/* All rows, by quadrature to 1e-7 and in Blinn's mode by his closed form to the table's digits. */
START_TEST(single_scattering_of_slabs_is_the_tables) {
    static Row rows[1024];
    int count = read_rows(rows, 1024), mode = _i;
    double worst = 0.0;
    ck_assert_int_gt(count, 300);
    for (int i = 0; i < count; i++) {
        const Row *r = &rows[i];
        double s = sqrt(1.0 - r->mu * r->mu), phi = r->phi * PI / 180.0, height = r->mu > 0.0 ? 1.5 : -0.5;
        Case c;
        begin(&c, text(CAMERA "media:\n  - {layer: [0, 1], extinction: %.17g, albedo: %.17g, phase: %s}\n"
                              "lights:\n  - {type: sun, direction: [%.17g, 0, %.17g], irradiance: 1}\n",
                       r->tau, r->ssa, phase_text(r->phase), -sqrt(1.0 - r->mu0 * r->mu0), r->mu0), 1e-7, mode);
        double value = radiance(&c, (double[]){0.0, 0.0, height}, (double[]){-s * cos(phi), -s * sin(phi), -r->mu});
        double off = fabs(value - r->value) / r->value;
        if (off > (mode ? 1e-10 : 1e-7)) printf("    %s ssa %g tau %g mu0 %g mu %g phi %g: %.12g for %.12g\n", r->phase, r->ssa, r->tau, r->mu0, r->mu, r->phi, value, r->value);
        worst = off > worst ? off : worst;
        ck_assert_int_eq(nph_single_tally(c.scratch)->unconverged, 0);
        ck_assert_int_eq(nph_single_tally(c.scratch)->integrals, mode ? 0 : 1);
        end(&c);
    }
    printf("    %d rows, mode %d: largest relative difference %.2g\n", count, mode, worst);
    ck_assert_double_le(worst, mode ? 1e-10 : 1e-7);
}
END_TEST

/* Rays of length 3 are the difference of two endless ones, the second seen through the first 3 m. */
START_TEST(airlight_of_a_point_light_is_the_tables) {
    FILE *file = fopen(nph_test_path("reference/tables/airlight_point_light.csv"), "r");
    ck_assert_ptr_nonnull(file);
    char line[1024], phase[32], length[16];
    double sigma, albedo, x, y, truth, worst = 0.0;
    int count = 0;
    while (fgets(line, sizeof line, file)) {
        if (sscanf(line, "%31[^,],%lf,%lf,(0;0),(1;0),(%lf;%lf),%15[^,],%lf", phase, &sigma, &albedo, &x, &y, length, &truth) != 7)
            continue;
        Case c;
        begin(&c, text(CAMERA "media:\n  - {box: [[-2000, -2000, -2000], [2000, 2000, 2000]], extinction: %.17g, albedo: %.17g, phase: %s}\n"
                              "lights:\n  - {type: point, position: [%.17g, %.17g, 0], intensity: 1}\n",
                       sigma, albedo, phase_text(phase), x, y), 1e-9, 0);
        double value = radiance(&c, (double[]){0, 0, 0}, (double[]){1, 0, 0});
        if (strcmp(length, "inf") != 0)
            value -= exp(-3.0 * sigma) * radiance(&c, (double[]){3, 0, 0}, (double[]){1, 0, 0});
        double off = fabs(value - truth) / truth;
        worst = off > worst ? off : worst;
        if (off > 1e-8) printf("    %s", line);
        count++;
        end(&c);
    }
    fclose(file);
    printf("    %d rows, largest relative difference %.2g\n", count, worst);
    ck_assert_int_ge(count, 20);
    ck_assert_double_le(worst, 1e-8); /* the table has 10 to 11 digits, the difference of two loses some */
}
END_TEST

/* A square between sun and medium: the ray along x is lit outside (0.3, 0.7). */
START_TEST(a_shadow_of_a_surface_is_cut_at_its_edge) {
    const char *path = nph_test_temporary("square.obj");
    FILE *file = fopen(path, "w");
    ck_assert_ptr_nonnull(file);
    fputs("v 0.3 -5 0\nv 0.7 -5 0\nv 0.7 5 0\nv 0.3 5 0\nf 1 2 3\nf 1 3 4\n", file);
    fclose(file);
    Case c;
    begin(&c, text(CAMERA "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 2, albedo: 0.25}\n"
                          "surfaces:\n  - {mesh: %s, transform: [{translate: [0, 0, 1.5]}]}\n"
                          "lights:\n  - {type: sun, direction: [0, 0, 1], irradiance: 1}\n", path), 1e-9, 0);
    double value = radiance(&c, (double[]){-1, 0.5, 0.5}, (double[]){1, 0, 0});
    double lit = (1.0 - exp(-0.6)) + (exp(-1.4) - exp(-2.0)), truth = 0.25 / (4.0 * PI) * exp(-1.0) * lit;
    ck_assert_double_le(fabs(value - truth), 1e-9 * truth);
    ck_assert_int_eq(nph_single_tally(c.scratch)->unconverged, 0);
    end(&c);
}
END_TEST

/* Light of sun and point on a plane through a medium, and the medium in front of it. */
START_TEST(a_surface_behind_a_medium_is_lit_and_seen_through_it) {
    Case c;
    double fields[NPH_SAMPLE_FIELDS];
    begin(&c, CAMERA "media:\n  - {layer: [0, 1], extinction: 0.7, albedo: 0}\nsurfaces:\n  - {plane: -1, albedo: 0.4}\n"
                     "lights:\n  - {type: sun, direction: [0, 0.6, 0.8], irradiance: 3}\n"
                     "  - {type: point, position: [0, 0, 2], intensity: 5}\n", 1e-6, 0);
    shoot(&c, (double[]){0.0, 0.0, 3.0}, (double[]){0.0, 0.0, -1.0}, fields);
    double sun = 3.0 * 0.8 * exp(-0.7 / 0.8), point = 5.0 / 9.0 * exp(-0.7);
    double truth = 0.4 / PI * exp(-0.7) * (sun + point);
    ck_assert_double_le(fabs(fields[NPH_SAMPLE_L0] - truth), 1e-12);
    ck_assert_double_eq(fields[NPH_SAMPLE_T0], 0.0);
    ck_assert_double_le(fabs(fields[NPH_SAMPLE_COLLIDED] - 1.0), 1e-12);
    /* absorbed at 2 m to 3 m, else at 4 m */
    double mean = 2.0 + (1.0 - exp(-0.7) * 1.7) / 0.7 + exp(-0.7) * 4.0 - 2.0 * exp(-0.7);
    ck_assert_double_le(fabs(fields[NPH_SAMPLE_DISTANCE] - mean), 1e-9);
    end(&c);
}
END_TEST

/* ---- what must not depend on how things are said ---- */

START_TEST(mirrored_scenes_are_mirrored) {
    Case a, b;
    begin(&a, CAMERA "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 3, albedo: 0.9, phase: {type: hg, g: 0.7}}\n"
                     "  - {box: [[0.2, 0.1, 0.3], [0.6, 0.5, 0.9]], extinction: 6, albedo: 0.8, phase: {type: rayleigh}}\n"
                     "lights:\n  - {type: sun, direction: [-1, 0.3, 0.8], irradiance: 1}\n  - {type: point, position: [0.9, 0.3, 1.5], intensity: 1}\n", 1e-7, 0);
    begin(&b, CAMERA "media:\n  - {box: [[-1, 0, 0], [0, 1, 1]], extinction: 3, albedo: 0.9, phase: {type: hg, g: 0.7}}\n"
                     "  - {box: [[-0.6, 0.1, 0.3], [-0.2, 0.5, 0.9]], extinction: 6, albedo: 0.8, phase: {type: rayleigh}}\n"
                     "lights:\n  - {type: sun, direction: [1, 0.3, 0.8], irradiance: 1}\n  - {type: point, position: [-0.9, 0.3, 1.5], intensity: 1}\n", 1e-7, 0);
    for (int i = 0; i < 40; i++) {
        double p[3], d[3];
        some_ray(i, p, d);
        double one = radiance(&a, p, d);
        p[0] = -p[0];
        d[0] = -d[0];
        ck_assert_double_le(fabs(radiance(&b, p, d) - one), 1e-12 + 2e-7 * one);
    }
    end(&a);
    end(&b);
}
END_TEST

START_TEST(a_box_and_a_grid_of_ones_are_one_medium) {
    const char *path = nph_test_temporary("ones.npy");
    NphContext *context = nph_test_context(1);
    NphArray array;
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 3, (int64_t[]){11, 13, 17}, "ones", &array), NPH_OK);
    for (int i = 0; i < 11 * 13 * 17; i++) ((float *)array.data)[i] = 1.0f;
    ck_assert_int_eq(nph_npy_write(context, path, &array), NPH_OK);
    nph_array_free(context, &array);
    nph_test_context_close(context);
    static const char *const scene = CAMERA "media:\n  - {%s, extinction: [4, 1, 9], albedo: [0.9, 0.5, 1], phase: {type: hg, g: 0.5}}\n"
        "lights:\n  - {type: sun, direction: [-1, 0.2, 0.3], irradiance: 3}\n  - {type: point, position: [0.5, 0.5, 1.4], intensity: [1, 2, 3]}\n";
    Case box, grid;
    begin(&box, text(scene, "box: [[0, 0, 0], [1, 1, 1]]"), 1e-6, 0);
    begin(&grid, text(scene, text("density: {file: %s, box: [[0, 0, 0], [1, 1, 1]], centring: %s}", path, _i ? "cell, lookup: nearest" : "point")), 1e-6, 0);
    int lit = 0;
    for (int i = 0; i < 60; i++) {
        double p[3], d[3], a[NPH_SAMPLE_FIELDS], b[NPH_SAMPLE_FIELDS];
        some_ray(i, p, d);
        shoot(&box, p, d, a);
        shoot(&grid, p, d, b);
        for (int f = 0; f < NPH_SAMPLE_FIELDS; f++) ck_assert_double_le(fabs(a[f] - b[f]), 1e-9 + 2e-6 * fabs(a[f]));
        lit += a[0] > 1e-3;
    }
    ck_assert_int_gt(lit, 20);
    end(&box);
    end(&grid);
}
END_TEST

/* A period that a box fills is a layer; a box in half of it is a row of boxes. */
START_TEST(sides_that_repeat_are_what_they_say) {
    static const char *const light = "lights:\n  - {type: sun, direction: [-0.7, 0.4, 0.3], irradiance: 3}\n"
                                     "  - {type: sun, direction: [0.3, 0.2, -0.9], irradiance: [1, 2, 3]}\n";
    char row[2048] = "media:\n";
    for (int i = -12; i <= 12; i++)
        snprintf(row + strlen(row), sizeof row - strlen(row), "  - {box: [[%d, -20, 0], [%g, 20, 1]], extinction: 2, albedo: 0.9}\n", i, i + 0.5);
    const char *all = text("%s%smedia:\n  - {layer: [0, 1], extinction: 2, albedo: 0.9}\n", CAMERA, light);
    const char *one = text("%s%speriodic: {x: [0, 1], y: [0, 1]}\nmedia:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 2, albedo: 0.9}\n", CAMERA, light);
    const char *half = text("%s%speriodic: {x: [0, 1], y: [0, 1]}\nmedia:\n  - {box: [[0, 0, 0], [0.5, 1, 1]], extinction: 2, albedo: 0.9}\n", CAMERA, light);
    Case a, b;
    for (int pair = 0; pair < 2; pair++) {
        begin(&a, pair ? text("%s%s%s", CAMERA, light, row) : all, 1e-5, 0);
        begin(&b, pair ? half : one, 1e-5, 0);
        int lit = 0;
        for (int i = 0; i < (pair ? 12 : 40); i++) {
            double p[3], d[3], x[NPH_SAMPLE_FIELDS], y[NPH_SAMPLE_FIELDS];
            some_ray(i, p, d);
            if (fabs(d[2]) < 0.4) continue; /* the row has an end */
            shoot(&a, p, d, x);
            shoot(&b, p, d, y);
            for (int f = 0; f < NPH_SAMPLE_FIELDS; f++) ck_assert_double_le(fabs(x[f] - y[f]), 1e-9 + 2e-5 * fabs(x[f]));
            lit += x[0] > 1e-3;
        }
        ck_assert_int_gt(lit, 4);
        end(&a);
        end(&b);
    }
}
END_TEST

/* j (1 - e^-sigma L) / sigma, in a box, in a grid of ones, times its density; and j L without extinction. */
START_TEST(emission_is_integrated_as_it_is_absorbed) {
    const char *path = nph_test_temporary("glow.npy");
    NphContext *context = nph_test_context(1);
    NphArray array;
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 3, (int64_t[]){5, 6, 7}, "glow", &array), NPH_OK);
    for (int i = 0; i < 5 * 6 * 7; i++) ((float *)array.data)[i] = 1.0f;
    ck_assert_int_eq(nph_npy_write(context, path, &array), NPH_OK);
    nph_array_free(context, &array);
    nph_test_context_close(context);
    const char *grid = text("density: {file: %s, box: [[0, 0, 0], [1, 1, 1]], centring: point}", path), *box = "box: [[0, 0, 0], [1, 1, 1]]";
    for (int way = 0; way < 4; way++) {
        double s = way < 2 ? 3.0 : 0.0, fields[NPH_SAMPLE_FIELDS];
        Case c;
        begin(&c, text(CAMERA "media:\n  - {%s, extinction: %g, albedo: 0, emission: {type: volume, radiance: [1, 2, 3]}}\n", way % 2 ? grid : box, s), 1e-4, 0);
        shoot(&c, (double[]){-1, 0.5, 0.5}, (double[]){2, 0.2, 0.1}, fields);
        double length = sqrt(1.0 + 0.01 + 0.0025), truth = s > 0.0 ? (1.0 - exp(-s * length)) / s : length;
        for (int k = 0; k < 3; k++) ck_assert_double_le(fabs(fields[k] - (k + 1) * truth), 1e-9);
        end(&c);
    }
}
END_TEST

/* Each channel is the grey scene of its extinction, however opaque another one is. */
START_TEST(a_channel_may_be_opaque_where_another_passes) {
    static const double extinction[3] = {0.0, 1.0, 1e6};
    static const char *const scene = CAMERA "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: %s, albedo: 0.5}\n"
        "lights:\n  - {type: sun, direction: [-1, 0.2, 0.1], irradiance: 3}\n  - {type: point, position: [0.5, 0.5, 1.2], intensity: 3}\n";
    Case all, one;
    begin(&all, text(scene, "[0, 1, 1e6]"), 1e-6, 0);
    for (int c = 0; c < 3; c++) {
        begin(&one, text(scene, text("%g", extinction[c])), 1e-6, 0);
        for (int i = 0; i < 12; i++) {
            double p[3], d[3], a[NPH_SAMPLE_FIELDS], b[NPH_SAMPLE_FIELDS];
            some_ray(i, p, d);
            shoot(&all, p, d, a);
            shoot(&one, p, d, b);
            ck_assert_double_le(fabs(a[c] - b[0]), 1e-12 + 2e-6 * b[0]);
            ck_assert_double_le(fabs(a[NPH_SAMPLE_T0 + c] - b[NPH_SAMPLE_T0]), 1e-12);
        }
        end(&one);
    }
    end(&all);
}
END_TEST

/* A layer of a Rayleigh atmosphere whose depth goes with the fourth power, each wavelength in closed form. */
START_TEST(wavelengths_become_the_colour_of_their_closed_forms) {
    enum { COUNT = 7 };
    static const double nm[COUNT] = {400, 440, 490, 540, 580, 630, 700};
    double weight[NPH_MAX_WAVELENGTHS][3], xyz[3] = {0, 0, 0}, rgb[3], fields[NPH_SAMPLE_FIELDS], T = 0.0;
    char list[512] = "", thick[512] = "";
    nph_wavelength_weights(nm, COUNT, weight);
    for (int i = 0; i < COUNT; i++) {
        double tau = 0.3 * pow(550.0 / nm[i], 4.0);
        snprintf(list + strlen(list), sizeof list - strlen(list), "%s%g", i ? ", " : "", nm[i]);
        snprintf(thick + strlen(thick), sizeof thick - strlen(thick), "%s%.17g", i ? ", " : "", tau);
        for (int k = 0; k < 3; k++)
            xyz[k] += weight[i][k] * 0.5 * (3.0 / (16.0 * PI)) * 1.25 * 2.0 / 3.0 * (1.0 - exp(-3.0 * tau));
        T += exp(-tau) / (double)COUNT;
    }
    nph_rgb_from_xyz(xyz, rgb);
    for (int mode = 0; mode < 2; mode++) {
        Case c;
        begin(&c, text("nephos: 1\nwavelengths: [%s]\ncamera: {resolution: [4, 4], position: [0, 0, 3], look_at: [0, 1, 0], fov: 40}\n"
                       "media:\n  - {layer: [0, 1], extinction: [%s], albedo: 0.5, phase: {type: rayleigh}}\n"
                       "lights:\n  - {type: sun, elevation: 30, azimuth: 0, irradiance: 2}\n", list, thick), 1e-6, mode);
        shoot(&c, (double[]){0, 0, 3}, (double[]){0, 0, -1}, fields);
        for (int k = 0; k < 3; k++) ck_assert_double_le(fabs(fields[k] - rgb[k]), 1e-6 * rgb[1]);
        ck_assert_double_le(fabs(fields[NPH_SAMPLE_T0] - T), 0.05 * T); /* groups of three: one wavelength counts twice */
        end(&c);
    }
}
END_TEST

/* ---- tolerance ---- */

static const char *const cloud = CAMERA
    "media:\n  - {density: {file: ../data/cumulus/cumulus_300.zip.nvdb}, extinction: 20, albedo: 0.9, phase: {type: hg, g: 0.8},\n"
    "     transform: [{scale: 0.4}, {translate: [0.5, 0.5, 0.4]}]}\n"
    "lights:\n  - {type: sun, direction: [-1, 0.2, 0.7], irradiance: 3}\n";

START_TEST(errors_are_below_the_tolerance) {
    static const double tolerances[] = {1e-2, 1e-3, 1e-4, 1e-5};
    double truth[24], worst[4] = {0.0, 0.0, 0.0, 0.0};
    int64_t points[4];
    Case c;
    begin(&c, cloud, 1e-7, 0);
    for (int i = 0; i < 24; i++) {
        double p[3], d[3];
        some_ray(i, p, d);
        truth[i] = radiance(&c, p, d);
    }
    end(&c);
    for (int k = 0; k < 4; k++) {
        begin(&c, cloud, tolerances[k], 0);
        for (int i = 0; i < 24; i++) {
            double p[3], d[3];
            some_ray(i, p, d);
            double off = fabs(radiance(&c, p, d) - truth[i]);
            worst[k] = truth[i] > 0.0 && off / truth[i] > worst[k] ? off / truth[i] : worst[k];
        }
        points[k] = nph_single_tally(c.scratch)->points;
        ck_assert_int_eq(nph_single_tally(c.scratch)->unconverged, 0);
        printf("    tolerance %g: largest error %.2g, %lld optical depths\n", tolerances[k], worst[k], (long long)points[k]);
        ck_assert_double_le(worst[k], tolerances[k]);
        if (k > 0) ck_assert_int_gt(points[k], points[k - 1]);
        end(&c);
    }
}
END_TEST

START_TEST(what_does_not_reach_its_tolerance_is_counted_and_told) {
    NphContext *context = nph_test_context(0);
    NphScene *scene = NULL;
    NphFilm *film = NULL;
    NphRenderStatistics statistics;
    NphRenderOptions options;
    ck_assert_int_eq(nph_scene_parse(context, cloud, strlen(cloud), "test.yaml", nph_test_path("reference/scenes"), &scene), NPH_OK);
    nph_render_options_default(&options);
    options.method = "single";
    options.samples = 16;
    options.knobs = (const char *[]){"single.tolerance=1e-9"};
    options.knob_count = 1;
    ck_assert_int_eq(nph_render(context, scene, &options, &film, &statistics), NPH_OK);
    ck_assert_int_gt(statistics.unconverged, 0);
    ck_assert_int_le(statistics.unconverged, statistics.integrals);
    ck_assert_double_gt(statistics.worst_residual, 1e-9);
    ck_assert_double_lt(statistics.worst_residual, 1e-4);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "did not reach their tolerance"));
    nph_film_free(context, film);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

/* ---- the run ---- */

typedef struct Told {
    int lines;
    double result;
} Told;

static void listen(void *user, const char *line) {
    Told *told = user;
    told->lines++;
    if (strncmp(line, "result: ", 8) == 0) told->result = atof(line + 8);
}

START_TEST(the_replay_of_its_samples_is_the_pixel) {
    NphContext *context = nph_test_context(0);
    NphScene *scene = NULL;
    NphFilm *film = NULL;
    NphImage image;
    NphRenderOptions options;
    ck_assert_int_eq(nph_scene_parse(context, cloud, strlen(cloud), "test.yaml", nph_test_path("reference/scenes"), &scene), NPH_OK);
    nph_render_options_default(&options);
    options.method = "single";
    options.samples = 16;
    ck_assert_int_eq(nph_render(context, scene, &options, &film, NULL), NPH_OK);
    ck_assert_int_eq(nph_film_image(context, film, &image), NPH_OK);
    double sum = 0.0;
    for (int s = 0; s < 16; s++) {
        Told told = {0, 0.0};
        ck_assert_int_eq(nph_replay(context, scene, &options, 2, 2, s, listen, &told), NPH_OK);
        ck_assert_int_ge(told.lines, 4);
        sum += told.result;
    }
    float pixel = nph_image_channel(&image, "R")->pixels[2 * 4 + 2];
    ck_assert_double_gt(sum, 0.01);
    ck_assert_double_le(fabs((double)pixel - sum / 16.0), 1e-7 * sum / 16.0);
    nph_image_free(context, &image);
    nph_film_free(context, film);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(threads_and_precision_change_no_bit) {
    float first[48];
    for (int run = 0; run < 3; run++) {
        NphContext *context = nph_test_context(run == 1 ? 1 : 3);
        NphScene *scene = NULL;
        NphFilm *film = NULL;
        NphImage image;
        NphRenderOptions options;
        ck_assert_int_eq(nph_scene_parse(context, cloud, strlen(cloud), "test.yaml", nph_test_path("reference/scenes"), &scene), NPH_OK);
        nph_render_options_default(&options);
        options.method = "single";
        options.samples = 32;
        options.precision = run == 2 ? 64 : 32;
        ck_assert_int_eq(nph_render(context, scene, &options, &film, NULL), NPH_OK);
        ck_assert_int_eq(nph_film_image(context, film, &image), NPH_OK);
        const float *pixels = nph_image_channel(&image, "Variance.R")->pixels;
        if (run == 0) memcpy(first, pixels, 16 * sizeof(float));
        ck_assert_int_eq(memcmp(first, pixels, 16 * sizeof(float)), 0);
        nph_image_free(context, &image);
        nph_film_free(context, film);
        nph_scene_free(context, scene);
        nph_test_context_close(context);
    }
}
END_TEST

START_TEST(a_long_way_through_many_voxels_is_taken_in_stretches) {
    enum { N = 3000 };
    const char *path = nph_test_temporary("long.npy");
    NphContext *context = nph_test_context(1);
    NphArray array;
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 3, (int64_t[]){1, 1, N}, "long", &array), NPH_OK);
    for (int i = 0; i < N; i++) ((float *)array.data)[i] = 1.0f;
    ck_assert_int_eq(nph_npy_write(context, path, &array), NPH_OK);
    nph_array_free(context, &array);
    nph_test_context_close(context);
    static const char *const scene = CAMERA "media:\n  - {%s, extinction: 3, albedo: 0.9}\nlights:\n  - {type: sun, direction: [0, 0, 1], irradiance: 1}\n";
    Case box, grid;
    double a[NPH_SAMPLE_FIELDS], b[NPH_SAMPLE_FIELDS];
    begin(&box, text(scene, "box: [[0, 0, 0], [1, 1, 1]]"), 1e-6, 0);
    begin(&grid, text(scene, text("density: {file: %s, box: [[0, 0, 0], [1, 1, 1]], centring: cell, lookup: nearest}", path)), 1e-6, 0);
    shoot(&box, (double[]){-1, 0.4, 0.3}, (double[]){1, 0.01, 0.02}, a);
    shoot(&grid, (double[]){-1, 0.4, 0.3}, (double[]){1, 0.01, 0.02}, b);
    ck_assert_int_ge(nph_single_tally(grid.scratch)->integrals, 3);
    for (int f = 0; f < NPH_SAMPLE_FIELDS; f++) ck_assert_double_le(fabs(a[f] - b[f]), 1e-9 + 2e-6 * fabs(a[f]));
    end(&box);
    end(&grid);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_loop_test(cases, optical_depths_are_those_of_brute_force_to_rounding, 0, 3);
    tcase_add_test(cases, transmittance_through_a_trilinear_cell_is_the_tables);
    tcase_add_loop_test(cases, single_scattering_of_slabs_is_the_tables, 0, 2);
    tcase_add_test(cases, airlight_of_a_point_light_is_the_tables);
    tcase_add_test(cases, a_shadow_of_a_surface_is_cut_at_its_edge);
    tcase_add_test(cases, a_surface_behind_a_medium_is_lit_and_seen_through_it);
    tcase_add_test(cases, mirrored_scenes_are_mirrored);
    tcase_add_loop_test(cases, a_box_and_a_grid_of_ones_are_one_medium, 0, 2);
    tcase_add_test(cases, sides_that_repeat_are_what_they_say);
    tcase_add_test(cases, emission_is_integrated_as_it_is_absorbed);
    tcase_add_test(cases, a_channel_may_be_opaque_where_another_passes);
    tcase_add_test(cases, wavelengths_become_the_colour_of_their_closed_forms);
    tcase_add_test(cases, errors_are_below_the_tolerance);
    tcase_add_test(cases, what_does_not_reach_its_tolerance_is_counted_and_told);
    tcase_add_test(cases, the_replay_of_its_samples_is_the_pixel);
    tcase_add_test(cases, threads_and_precision_change_no_bit);
    tcase_add_test(cases, a_long_way_through_many_voxels_is_taken_in_stretches);
}

int main(void) { return nph_test_main("single", fill); }
