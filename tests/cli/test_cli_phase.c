/* SPDX-License-Identifier: Apache-2.0
 *
 * nephos phase: numbers told, tables read back in every form, charts, the same bytes for any number of threads, and what a scene
 * makes of a table. */
#include <math.h>

#include "cli/program.h"
#include "core/memory.h"
#include "nephos/array.h"

static double number_after(const char *text, const char *key) {
    const char *at = strstr(text, key);
    ck_assert_msg(at != NULL, "no %s in\n%s", key, text);
    return strtod(at + strlen(key), NULL);
}

START_TEST(spheres_are_told_with_efficiencies_and_albedo) {
    const Ran *run = RUN("phase", "mie", "--particle", "1.55,0", "--radius", "0.525", "-w", "632.8", "--json");
    ck_assert_int_eq(run->status, 0);
    ck_assert(fabs(number_after(run->out, "\"extinction_efficiency\": ") - 3.10543) < 5e-6); /* [Bohren83 app. A] */
    ck_assert(number_after(run->out, "\"albedo\": ") == 1.0);
    ck_assert(fabs(number_after(run->out, "\"asymmetry\": ") - 0.6331367580409) < 1e-12);
    run = RUN("phase", "rayleigh", "-w", "440", "--json");
    ck_assert(fabs(number_after(run->out, "\"scattering_per_m\": ") / 2.8712e-5 - 1) < 1e-4);
    run = RUN("phase", "hg", "--g", "0.5", "--times", "3", "--json");
    ck_assert(fabs(number_after(strstr(run->out, "\"name\": \"3\""), "\"mean_cosine\": ") - 0.125) < 1e-6);
}
END_TEST

/* What a column of arrays in code holds: numbers between the brackets behind `open`. */
static int numbers_of(const char *path, const char *open, double *out, int most) {
    static char text[1 << 20];
    FILE *file = fopen(path, "rb");
    ck_assert_ptr_nonnull(file);
    text[fread(text, 1, sizeof text - 1, file)] = 0;
    fclose(file);
    char *at = strstr(text, open);
    ck_assert_msg(at != NULL, "%s lacks %s", path, open);
    at += strlen(open);
    int count = 0;
    while (count < most) {
        char *end;
        at += strspn(at, " \n,f");
        out[count] = strtod(at, &end);
        if (end == at) break;
        at = end;
        count++;
    }
    return count;
}

START_TEST(every_form_of_a_table_holds_the_same_numbers) {
    enum { MOST = 4000 };
    static double code[MOST];
    const char *txt = file_of("a.txt"), *npy = file_of("a.npy"), *h = file_of("a.h"), *glsl = file_of("a.glsl"), *wgsl = file_of("a.wgsl");
    RUN_EXPECT(0, "phase", "mie", "--radius", "1.5", "-o", txt, "-o", npy, "-o", h, "-o", glsl, "-o", wgsl, "-o", file_of("a.csv"));
    NphContext *context = nph_test_context(1);
    NphArray rows;
    char open[64];
    ck_assert_int_eq(nph_array_read_npy(context, npy, &rows), NPH_OK);
    int count = (int)rows.shape[0];
    ck_assert(rows.shape[1] == 2 && count > 200 && count < MOST);
    const double *at = rows.data;
    const char *paths[] = {h, glsl, wgsl};
    for (int k = 0; k < 3; k++)
        for (int column = 0; column < 2; column++) {
            const char *what = column ? "per_sr" : "degrees";
            if (k == 1) snprintf(open, sizeof open, "a_%s[%d] = float[%d](", what, count, count);
            else snprintf(open, sizeof open, k ? "a_%s = array<f32, %d>(" : "a_%s[%d] = {", what, count);
            ck_assert_msg(numbers_of(paths[k], open, code, MOST) == count, "%s", paths[k]);
            for (int i = 0; i < count; i++) ck_assert(fabs(code[i] - at[2 * i + column]) <= 1e-8 * fabs(at[2 * i + column]));
        }
    const Ran *run = RUN("info", txt, "--json");
    ck_assert_int_eq(run->status, 0);
    ck_assert(number_after(run->out, "\"rows\": ") == count);
    ck_assert(at[0] == 0 && at[2 * (count - 1)] == 180);
    double told = number_after(run->out, "\"mean_cosine\": ");
    run = RUN("phase", txt, "--json");
    ck_assert(fabs(number_after(run->out, "\"mean_cosine\": ") - told) < 1e-12);
    nph_array_free(context, &rows);
    nph_test_context_close(context);
}
END_TEST

START_TEST(rows_can_be_evenly_spaced_and_columns_stand_side_by_side) {
    NphContext *context = nph_test_context(1);
    NphArray rows;
    const char *npy = file_of("b.npy");
    RUN_EXPECT(0, "phase", "two_lobe", "--g", "0.8", "--g2", "-0.3", "--weight", "0.9", "--times", "4", "--rows", "181", "-o", npy);
    ck_assert_int_eq(nph_array_read_npy(context, npy, &rows), NPH_OK);
    ck_assert(rows.shape[0] == 181 && rows.shape[1] == 5);
    const double *at = rows.data;
    for (int i = 0; i < 181; i++) ck_assert(fabs(at[5 * i] - i) < 1e-12);
    ck_assert(at[1] > at[2] && at[2] > at[3] && at[3] > at[4]);
    nph_array_free(context, &rows);
    nph_test_context_close(context);
}
END_TEST

/* F of Henyey and Greenstein's function of g^n [Riley04 eq. 23]. */
START_TEST(code_holds_what_is_scattered_forwards) {
    enum { TIMES = 5 };
    static const char *const opens[] = {"f_forward[5] = {", "f_forward[5] = float[5](", "f_forward = array<f32, 5>("};
    const char *paths[] = {file_of("f.h"), file_of("f.glsl"), file_of("f.wgsl")};
    RUN_EXPECT(0, "phase", "hg", "--g", "0.8", "--times", "5", "--rows", "91", "-o", paths[0], "-o", paths[1], "-o", paths[2]);
    for (int k = 0; k < 3; k++) {
        double forward[TIMES + 1];
        ck_assert_int_eq(numbers_of(paths[k], opens[k], forward, TIMES + 1), TIMES);
        for (int n = 1; n <= TIMES; n++) {
            double g = pow(0.8, n), truth = (1 - g * g) / (2 * g) * (1 / (1 - g) - 1 / sqrt(1 + g * g));
            ck_assert_msg(fabs(forward[n - 1] - truth) < 2e-6, "after %d: %.9f, not %.9f", n, forward[n - 1], truth);
        }
    }
}
END_TEST

START_TEST(charts_and_tables_are_the_same_for_any_threads) {
    static const char *const plots[] = {"log", "linear", "polar"};
    const char *first[2] = {file_of("c1.svg"), file_of("c1.png")}, *second[2] = {file_of("c2.svg"), file_of("c2.png")};
    for (int k = 0; k < 3; k++) {
        RUN_EXPECT(0, "phase", "ice", "--rays", "20000", "--plot", plots[k], "-w", "650", "-w", "450", "-t", "1", "-o", first[0], "-o", first[1]);
        RUN_EXPECT(0, "phase", "ice", "--rays", "20000", "--plot", plots[k], "-w", "650", "-w", "450", "-t", "3", "-o", second[0], "-o", second[1]);
        ck_assert(same_files(first[0], second[0]) && same_files(first[1], second[1]));
    }
    RUN_EXPECT(0, "phase", "ice", "--rays", "20000", "--seed", "2", "--plot", "polar", "-w", "650", "-w", "450", "-o", second[0]);
    ck_assert(!same_files(first[0], second[0]));
    char head[64] = "";
    FILE *svg = fopen(first[0], "rb"), *png = fopen(first[1], "rb");
    ck_assert(svg && png && fgets(head, sizeof head, svg) && strncmp(head, "<svg xmlns=", 11) == 0);
    ck_assert(fread(head, 1, 8, png) == 8 && memcmp(head, "\211PNG\r\n\032\n", 8) == 0);
    fclose(svg);
    fclose(png);
}
END_TEST

START_TEST(what_cannot_be_computed_or_written_is_named) {
    const Ran *run = RUN("phase", "mie", "--radius", "1e5");
    ck_assert(run->status == 4 && strstr(run->err, "size parameters") && !*run->out);
    run = RUN("phase", "mie", "--particle", "ice", "--radius", "1", "-w", "20000");
    ck_assert_int_eq(run->status, 0);
    run = RUN("phase", "mie", "--particle", "soot", "--radius", "1", "-w", "200");
    ck_assert(run->status == 4 && strstr(run->err, "soot has no refractive index in the table at 200 nm"));
    run = RUN("phase", "rayleigh", "-o", "/nowhere/at/all.txt");
    ck_assert(run->status == 5 && strstr(run->err, "/nowhere/at/all.txt"));
    run = RUN("phase", "none/such.txt");
    ck_assert(run->status == 4 && strstr(run->err, "none/such.txt"));
}
END_TEST

static void fill(TCase *tcase) {
    tcase_set_timeout(tcase, 120);
    tcase_add_test(tcase, spheres_are_told_with_efficiencies_and_albedo);
    tcase_add_test(tcase, every_form_of_a_table_holds_the_same_numbers);
    tcase_add_test(tcase, rows_can_be_evenly_spaced_and_columns_stand_side_by_side);
    tcase_add_test(tcase, code_holds_what_is_scattered_forwards);
    tcase_add_test(tcase, charts_and_tables_are_the_same_for_any_threads);
    tcase_add_test(tcase, what_cannot_be_computed_or_written_is_named);
}

int main(void) { return nph_test_main("cli_phase", fill); }
