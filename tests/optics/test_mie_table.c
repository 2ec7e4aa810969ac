/* SPDX-License-Identifier: Apache-2.0
 *
 * Tables of spheres of many sizes: published moments of two clouds, what is left between rows, the norm before and after, the same
 * bytes for any number of threads and any vector level, and what is refused. */
#include "optics/mie_table.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "harness.h"
#include "io/phase_rows.h"
#include "optics/index.h"
#include "optics/legendre.h"

static const double PI = 3.14159265358979323846;

static NphMieRequest request_of(NphSizes sizes, double wavelength_um, double n, double k, double tolerance) {
    NphMieRequest request = {.sizes = sizes, .wavelength_count = 1, .tolerance = tolerance};
    request.wavelength_um[0] = wavelength_um;
    request.index[0][0] = n;
    request.index[0][1] = k;
    return request;
}

static NphMieTable table_of(NphContext *context, const NphMieRequest *request) {
    NphMieTable table = {0};
    ck_assert_msg(nph_mie_table(context, request, "spheres", &table) == NPH_OK, "%s", nph_test_messages());
    return table;
}

/* Haze L and Cloud C.1 of [Deirmendjian69] at 0.7 um, m = 1.33; moments in print [Garcia85] have 4 to 6 digits. */
START_TEST(moments_of_haze_l_and_cloud_c1_are_those_in_print) {
    static const struct { const char *name; NphSizes sizes; double tolerance, off; } cases[] = {
        {"HAZE_L", {NPH_SIZES_MODIFIED_GAMMA, 0.07, 0, 2, 0.5}, 1e-3, 1e-5},
        {"CLOUD_C1", {NPH_SIZES_MODIFIED_GAMMA, 4, 0, 6, 1}, 4e-3, 1.5e-4},
    };
    NphContext *context = nph_test_context(0);
    for (int i = 0; i < 2; i++) {
        NphMieRequest request = request_of(cases[i].sizes, 0.7, 1.33, 0, cases[i].tolerance);
        NphMieTable table = table_of(context, &request);
        NphPhase phase;
        double moment[300], worst = 0;
        char line[256];
        int rows = 0;
        ck_assert_int_eq(nph_phase_tabulate(context, &table.rows, "spheres", &phase), NPH_OK);
        nph_phase_moments(&phase, 300, moment);
        FILE *file = fopen(nph_test_path("reference/tables/phase_moments_GS1985.csv"), "r");
        ck_assert(file != NULL);
        while (fgets(line, sizeof line, file)) {
            char *at = strchr(line, ',');
            if (strncmp(line, cases[i].name, strlen(cases[i].name)) != 0) continue;
            int l = (int)strtol(at + 1, &at, 10);
            worst = fmax(worst, fabs(moment[l] - strtod(at + 1, NULL)));
            rows++;
        }
        fclose(file);
        printf("    %s: %d moments off by at most %.2g; %lld sizes, %lld angles\n", cases[i].name, rows, worst, (long long)table.sizes,
               (long long)table.rows.shape[0]);
        ck_assert(rows > 80 && worst < cases[i].off);
        nph_phase_free(context, &phase);
        nph_mie_table_free(context, &table);
    }
    nph_test_context_close(context);
}
END_TEST

/* Their table is the sum of 300 moments of 5 digits: rounded by 3e-6 each, they leave some 0.002 of 4 pi p, which falls to 0.027. */
START_TEST(the_c1_cloud_of_the_i3rc_comes_out) {
    NphContext *context = nph_test_context(0);
    NphMieRequest request = request_of((NphSizes){NPH_SIZES_MODIFIED_GAMMA, 4, 0, 6, 1}, 0.7, 1.33, 0, 0.004);
    NphMieTable table = table_of(context, &request);
    NphPhase ours, theirs;
    NphArray rows;
    double square = 0, worst = 0;
    ck_assert_int_eq(nph_phase_rows_read(context, nph_test_path("reference/data/gpl/c1_phase.txt"), &rows), NPH_OK);
    ck_assert_int_eq(nph_phase_tabulate(context, &rows, "theirs", &theirs), NPH_OK);
    ck_assert_int_eq(nph_phase_tabulate(context, &table.rows, "ours", &ours), NPH_OK);
    for (int i = 0; i <= 1800; i++) {
        double c = cos(i * PI / 1800), off = nph_phase_value(&ours, c) / nph_phase_value(&theirs, c) - 1;
        square += off * off;
        worst = fmax(worst, fabs(off));
    }
    printf("    root mean square over 1801 angles %.2g, at most %.2g; peak %.6g, theirs %.6g\n", sqrt(square / 1801), worst, 4 * PI * nph_phase_value(&ours, 1),
           4 * PI * nph_phase_value(&theirs, 1));
    ck_assert(sqrt(square / 1801) < 0.01 && worst < 0.06);
    nph_phase_free(context, &ours);
    nph_phase_free(context, &theirs);
    nph_array_free(context, &rows);
    nph_mie_table_free(context, &table);
    nph_test_context_close(context);
}
END_TEST

/* OPAC's soot at 0.55 um, median radius 0.0118 um, spread 2: albedo 0.20889, asymmetry 0.33663 in its tables [Hess98]. */
START_TEST(opacs_soot_comes_out) {
    NphContext *context = nph_test_context(0);
    double index[2];
    ck_assert(nph_index_at(NPH_SOOT, 0.55, index));
    NphMieRequest request = request_of((NphSizes){NPH_SIZES_LOGNORMAL, 0.0118, 2, 0, 0}, 0.55, index[0], index[1], 1e-3);
    NphMieTable table = table_of(context, &request);
    double albedo = table.totals.scattering_um2 / table.totals.extinction_um2;
    printf("    albedo %.5f, asymmetry %.5f\n", albedo, table.totals.asymmetry);
    ck_assert(fabs(albedo - 0.20889) < 3e-4 && fabs(table.totals.asymmetry - 0.33663) < 1e-4);
    nph_mie_table_free(context, &table);
    nph_test_context_close(context);
}
END_TEST

/* Angles of no row, against the sum over the same sizes. */
START_TEST(between_rows_the_tolerance_holds) {
    static const NphSizes kinds[] = {{NPH_SIZES_SINGLE, 3, 0, 0, 0}, {NPH_SIZES_LOGNORMAL, 5, 1.3, 0, 0}, {NPH_SIZES_GAMMA, 10, 0.1, 0, 0}};
    enum { ANGLES = 3000 };
    static double distance[ANGLES], value[ANGLES], degrees[ANGLES];
    static unsigned char back[ANGLES];
    NphContext *context = nph_test_context(0);
    for (int i = 0; i < ANGLES; i++) {
        degrees[i] = i < 1000 ? 2.0 * pow(i / 1000.0, 2) + 1e-4 : fmod(i * 61.80339887, 180.0);
        back[i] = degrees[i] > 90;
        double half = sin((back[i] ? 180 - degrees[i] : degrees[i]) * PI / 360);
        distance[i] = 2 * half * half;
    }
    for (int kind = 0; kind < 3; kind++) {
        NphMieRequest request = request_of(kinds[kind], 0.55, 1.333, 2e-9, 0.02);
        NphMieTable table = table_of(context, &request);
        NphMieAngles angles = {ANGLES, distance, back};
        NphMieCloud cloud;
        double worst = 0, *probe = malloc(ANGLES * sizeof *probe);
        ck_assert_int_eq(nph_mie_cloud(context, &request, &angles, "spheres", &cloud, probe), NPH_OK);
        cloud.points = table.sizes; /* as many as the table took */
        if (kind > 0) {
            double range[2];
            nph_sizes_range(&request.sizes, 1e-7, range);
            cloud.step = log(range[1] / range[0]) / (double)(table.sizes - 1);
        }
        cloud.weight_sum = 1;
        ck_assert_int_eq(nph_mie_cloud_values(context, &cloud, &angles, value), NPH_OK);
        const double *rows = table.rows.data;
        double scale = 0, at_zero;
        NphMieAngles forward = {1, (double[]){0}, (unsigned char[]){0}};
        ck_assert_int_eq(nph_mie_cloud_values(context, &cloud, &forward, &at_zero), NPH_OK);
        scale = rows[1] / at_zero;
        for (int i = 0; i < ANGLES; i++) {
            int64_t low = 0, high = table.rows.shape[0] - 1;
            while (high - low > 1) *(rows[2 * ((low + high) / 2)] <= degrees[i] ? &low : &high) = (low + high) / 2;
            double a = 1 - cos(rows[2 * low] * PI / 180), b = 1 - cos(rows[2 * high] * PI / 180), x = 1 - cos(degrees[i] * PI / 180);
            double line = rows[2 * low + 1] + (x - a) / (b - a) * (rows[2 * high + 1] - rows[2 * low + 1]), true_value = value[i] * scale;
            worst = fmax(worst, fabs(line - true_value) / fmax(true_value, 1e-4 / (4 * PI)));
        }
        printf("    kind %d: off by at most %.2g between %lld rows, norm - 1 = %.2g, g off by %.2g\n", kind, worst, (long long)table.rows.shape[0],
               table.norm - 1, table.mean_cosine - table.totals.asymmetry);
        ck_assert(worst < 0.02 && table.angle_error <= 0.02 && fabs(table.norm - 1) < 0.005);
        ck_assert(fabs(table.mean_cosine - table.totals.asymmetry) < 0.001);
        free(probe);
        nph_mie_table_free(context, &table);
    }
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_table_is_the_same_for_any_threads_and_vectors) {
    NphMieRequest request = request_of((NphSizes){NPH_SIZES_GAMMA, 4, 0.1, 0, 0}, 0.55, 1.333, 2e-9, 0.05);
    request.wavelength_count = 2;
    request.wavelength_um[1] = 0.65;
    request.index[1][0] = 1.331;
    NphMieTable first = {0};
    NphContext *kept = nph_test_context(1);
    first = table_of(kept, &request);
    for (int threads = 1; threads <= 5; threads += 2)
        for (int isa = 0; isa <= 2; isa++) {
            NphSettings settings;
            NphContext *context = NULL;
            nph_settings_default(&settings);
            settings.threads = threads;
            settings.isa_limit = (NphIsa)isa;
            ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
            NphMieTable table = table_of(context, &request);
            ck_assert_int_eq(table.rows.shape[0], first.rows.shape[0]);
            ck_assert(memcmp(table.rows.data, first.rows.data, (size_t)first.rows.shape[0] * 16) == 0);
            ck_assert(memcmp(&table.totals, &first.totals, sizeof table.totals) == 0);
            nph_mie_table_free(context, &table);
            nph_context_close(context);
        }
    nph_mie_table_free(kept, &first);
    nph_test_context_close(kept);
}
END_TEST

/* Effective radius and variance of a gamma distribution are its parameters; of a lognormal one, closed forms of its moments
 * [Hansen74]. Cross sections are those of the mean: extinction minus absorption is scattering. */
START_TEST(moments_of_the_sizes_are_closed_forms) {
    NphContext *context = nph_test_context(0);
    NphMieRequest gamma = request_of((NphSizes){NPH_SIZES_GAMMA, 2, 0.15, 0, 0}, 0.55, 1.4, 0.01, 0.01);
    NphMieTable table = table_of(context, &gamma);
    ck_assert(fabs(table.totals.effective_radius_um / 2 - 1) < 1e-5 && fabs(table.totals.effective_variance / 0.15 - 1) < 1e-4);
    ck_assert(fabs(table.totals.extinction_um2 - table.totals.absorption_um2 - table.totals.scattering_um2) < 1e-13 * table.totals.extinction_um2);
    nph_mie_table_free(context, &table);
    double width = log(1.6) * log(1.6);
    NphMieRequest lognormal = request_of((NphSizes){NPH_SIZES_LOGNORMAL, 0.5, 1.6, 0, 0}, 0.55, 1.4, 0.01, 0.01);
    table = table_of(context, &lognormal);
    ck_assert(fabs(table.totals.effective_radius_um / (0.5 * exp(2.5 * width)) - 1) < 1e-5);
    ck_assert(fabs(table.totals.effective_variance / (exp(width) - 1) - 1) < 1e-4);
    ck_assert(fabs(table.totals.geometric_um2 / (PI * 0.25 * exp(2 * width)) - 1) < 1e-4);
    nph_mie_table_free(context, &table);
    nph_test_context_close(context);
}
END_TEST

START_TEST(what_is_out_of_range_is_named) {
    static const struct { NphSizes sizes; double um, n, k; const char *words; } wrong[] = {
        {{NPH_SIZES_SINGLE, 1e5, 0, 0, 0}, 0.55, 1.33, 0, "1e-6 to 1e5"},
        {{NPH_SIZES_SINGLE, 1, 0, 0, 0}, 0.55, 0, 0, "n is above 0"},
        {{NPH_SIZES_SINGLE, 1, 0, 0, 0}, 0.55, 1.3, -1, "k at least 0"},
        {{NPH_SIZES_SINGLE, 0, 0, 0, 0}, 0.55, 1.3, 0, "the radius"},
        {{NPH_SIZES_LOGNORMAL, 1, 1, 0, 0}, 0.55, 1.3, 0, "geometric standard deviation"},
        {{NPH_SIZES_GAMMA, 1, 0.5, 0, 0}, 0.55, 1.3, 0, "effective variance"},
        {{NPH_SIZES_MODIFIED_GAMMA, 1, 0, 0, 1}, 0.55, 1.3, 0, "alpha"},
        {{NPH_SIZES_LOGNORMAL, 1000, 4, 0, 0}, 0.55, 1.3, 0, "1e-6 to 1e5"},
    };
    NphContext *context = nph_test_context(1);
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        NphMieRequest request = request_of(wrong[i].sizes, wrong[i].um, wrong[i].n, wrong[i].k, 0.01);
        NphMieTable table;
        ck_assert_int_eq(nph_mie_table(context, &request, "spheres", &table), NPH_BAD_INPUT);
        const char *said = nph_test_messages();
        ck_assert_msg(strstr(said, wrong[i].words) != NULL, "%zu: %s", i, said);
    }
    nph_test_context_close(context);
}
END_TEST

/* Spheres, moments and two scatterings with the n-th allocation failing, for every n: told as that, and nothing is left. */
static NphStatus all_of_it(NphContext *context) {
    NphMieRequest request = request_of((NphSizes){NPH_SIZES_LOGNORMAL, 0.2, 1.2, 0, 0}, 0.55, 1.4, 0.01, 0.05);
    NphMieTable table = {.rows = {.rank = 0}};
    NphPhase phase = {.kind = NPH_PHASE_ISOTROPIC};
    NphConvolutions made = {.count = 0};
    double *moment = NULL;
    int count = 0;
    NphStatus status = nph_mie_table(context, &request, "spheres", &table);
    if (status == NPH_OK) status = nph_phase_tabulate(context, &table.rows, "spheres", &phase);
    if (status == NPH_OK) status = nph_phase_all_moments(context, &phase, 1e-4, &count, &moment);
    if (status == NPH_OK) status = nph_phase_convolve(context, count, moment, 2, "spheres", &made);
    nph_convolutions_free(context, &made);
    nph_free(context, moment);
    nph_phase_free(context, &phase);
    nph_mie_table_free(context, &table);
    return status;
}

START_TEST(running_out_of_memory_leaves_nothing_behind) {
    NphSettings settings;
    nph_settings_default(&settings);
    settings.threads = 2;
    for (settings.fail_allocation = 1;; settings.fail_allocation++) {
        NphContext *context = NULL;
        if (nph_context_open(&context, &settings) != NPH_OK) continue;
        NphStatus status = all_of_it(context);
        int done = nph_context_allocations(context) < settings.fail_allocation;
        ck_assert_int_eq(status, done ? NPH_OK : NPH_NO_MEMORY);
        ck_assert_uint_eq(nph_context_bytes(context), 0);
        nph_context_close(context);
        if (done) break;
    }
    ck_assert_uint_ge(settings.fail_allocation, 40);
}
END_TEST

/* Every row of the files lies on the tables, halfway between two n is their mean of logarithms, beyond the ends there is nothing. */
START_TEST(refractive_indices_are_those_of_their_files) {
    static const char *const files[] = {"reference/data/optics/segelstein81_index.txt", "reference/data/optics/IOP_2008_ASCIItable.dat",
                                        "reference/data/gpl/opac_soot_index.txt"};
    for (int i = 0; i < NPH_INDEX_MATERIALS; i++) {
        FILE *file = fopen(nph_test_path(files[i]), "r");
        ck_assert_msg(file != NULL, "%s", files[i]);
        static char text[200000];
        size_t size = fread(text, 1, sizeof text - 1, file);
        int rows = 0;
        fclose(file);
        text[size] = 0;
        double last = 0;
        for (char *line = strtok(text, "\r\n"); line; line = strtok(NULL, "\r\n")) {
            double um, n, k, index[2];
            if (sscanf(line, "%lf %lf %lf", &um, &n, &k) != 3 || um < 0.2 || um > 20 || um <= last) continue;
            ck_assert(nph_index_at((NphMaterial)i, um, index));
            ck_assert_msg(fabs(index[0] - n) < 1e-12 && fabs(index[1] / fabs(k) - 1) < 1e-12, "%s: %g um", files[i], um);
            last = um;
            rows++;
        }
        ck_assert_int_eq(rows, nph_index_tables[i].count);
        const NphIndexRow *row = nph_index_tables[i].rows;
        double index[2];
        ck_assert(nph_index_at((NphMaterial)i, sqrt(row[3].wavelength_um * row[4].wavelength_um), index));
        ck_assert(fabs(index[1] / sqrt(row[3].k * row[4].k) - 1) < 1e-12 && fabs(index[0] - 0.5 * (row[3].n + row[4].n)) < 1e-12);
        ck_assert(!nph_index_at((NphMaterial)i, 0.19, index) && !nph_index_at((NphMaterial)i, 20.1, index));
    }
}
END_TEST

static void fill(TCase *tcase) {
    tcase_set_timeout(tcase, 300);
    tcase_add_test(tcase, moments_of_haze_l_and_cloud_c1_are_those_in_print);
    tcase_add_test(tcase, the_c1_cloud_of_the_i3rc_comes_out);
    tcase_add_test(tcase, opacs_soot_comes_out);
    tcase_add_test(tcase, between_rows_the_tolerance_holds);
    tcase_add_test(tcase, a_table_is_the_same_for_any_threads_and_vectors);
    tcase_add_test(tcase, moments_of_the_sizes_are_closed_forms);
    tcase_add_test(tcase, what_is_out_of_range_is_named);
    tcase_add_test(tcase, running_out_of_memory_leaves_nothing_behind);
    tcase_add_test(tcase, refractive_indices_are_those_of_their_files);
}

int main(void) { return nph_test_main("mie_table", fill); }
