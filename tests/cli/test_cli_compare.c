/* SPDX-License-Identifier: Apache-2.0
 *
 * nephos compare from the outside: FLIP, the picture of differences, JUnit XML, and what is said when they fail. */
#include <math.h>
#include <signal.h>
#include <sys/resource.h>

#include "nephos/image.h"
#include "program.h"

enum { WIDTH = 48, HEIGHT = 32 };

/* A picture with error bars: steps of light times a factor. */
static const char *picture(const char *name, int height, double factor, float spoilt) {
    static const char *const names[3][2] = {{"R", "Variance.R"}, {"G", "Variance.G"}, {"B", "Variance.B"}};
    NphContext *context = nph_test_context(1);
    NphImage image;
    float *planes[2];
    const char *path = file_of(name);
    ck_assert_int_eq(nph_image_new(context, WIDTH, height, &image), NPH_OK);
    for (int c = 0; c < 3; c++) {
        for (int k = 0; k < 2; k++)
            ck_assert_int_eq(nph_image_add_channel(context, &image, names[c][k], &planes[k]), NPH_OK);
        for (int i = 0; i < WIDTH * height; i++) {
            planes[0][i] = (float)(factor * ((i * 7 + c) % 32 + 1) / 64.0);
            planes[1][i] = 1e-6f;
        }
        planes[0][50] += spoilt;
    }
    ck_assert_int_eq(nph_exr_write(context, path, &image), NPH_OK);
    nph_image_free(context, &image);
    nph_test_context_close(context);
    return path;
}

static void expect_words(const char *text, const char *words) {
    ck_assert_msg(strstr(text, words) != NULL, "\"%s\" is not in:\n%s", words, text);
}

START_TEST(flip_stands_in_text_and_json_when_it_is_asked_for) {
    const char *a = picture("a.exr", HEIGHT, 1.0, 0.0f), *b = picture("b.exr", HEIGHT, 1.5, 0.0f);
    ck_assert_ptr_null(strstr(RUN("compare", a, b)->out, "FLIP"));
    ck_assert_ptr_null(strstr(RUN("compare", a, b, "--json")->out, "flip"));
    const Ran *run = RUN("compare", a, b, "--flip", "hdr", "--exposure", "-1:2.5:3", "--ppd", "40");
    ck_assert_int_eq(run->status, 1);
    expect_words(run->out, "HDR-FLIP ");
    expect_words(run->out, "3 exposures from -1 to 2.5 stops, 40 pixels per degree");
    run = RUN("compare", a, a, "--flip=ldr", "--json");
    ck_assert_int_eq(run->status, 0);
    expect_words(run->out, "\"kind\": \"LDR\",\n    \"mean\": 0,");
    run = RUN("compare", a, b, "--flip=ldr", "--exposure", "1");
    expect_words(run->out, "one exposure of 1 stops");
}
END_TEST

START_TEST(maps_are_the_same_for_any_number_of_threads) {
    const char *a = picture("a.exr", HEIGHT, 1.0, 0.0f), *b = picture("b.exr", HEIGHT, 1.5, 0.0f);
    const char *exr[2] = {file_of("1.exr"), file_of("3.exr")}, *png[2] = {file_of("1.png"), file_of("3.png")};
    RUN_EXPECT(1, "compare", a, b, "--threads", "1", "--flip-map", exr[0], "--map", png[0]);
    RUN_EXPECT(1, "compare", a, b, "--threads", "3", "--flip-map", exr[1], "--map", png[1]);
    ck_assert(same_files(exr[0], exr[1]));
    ck_assert(same_files(png[0], png[1]));
    expect_words(RUN("info", exr[0], "--json")->out, "\"name\": \"FLIP\"");
}
END_TEST

START_TEST(junit_is_written_whatever_the_verdict) {
    const char *a = picture("a&b.exr", HEIGHT, 1.0, 0.0f), *b = picture("b.exr", HEIGHT, 1.5, 0.0f), *xml = file_of("v.xml");
    static char text[PROGRAM_OUTPUT];
    RUN_EXPECT(0, "compare", a, a, "--junit", xml, "--quiet");
    program_read(xml, text);
    expect_words(text, "a&amp;b.exr against ");
    expect_words(text, "failures=\"0\"");
    expect_words(text, "same: every pixel is equal\n");
    ck_assert_ptr_null(strstr(text, "<failure"));
    RUN_EXPECT(1, "compare", a, b, "--junit", xml, "--json");
    program_read(xml, text);
    expect_words(text, "tests=\"3\" failures=\"3\"");
    expect_words(text, "<failure type=\"different\" message=\"image, channel ");
    expect_words(text, "name=\"8^2 tiles\"");
}
END_TEST

START_TEST(pictures_that_do_not_compare_are_refused_and_leave_nothing) {
    const char *a = picture("a.exr", HEIGHT, 1.0, 0.0f), *xml = file_of("none.xml"), *png = file_of("none.png");
    const Ran *run = RUN("compare", a, picture("low.exr", 20, 1.0, 0.0f), "--flip=hdr", "--junit", xml, "--map", png);
    ck_assert_int_eq(run->status, 4);
    expect_words(run->err, "only equal sizes compare");
    run = RUN("compare", a, picture("nan.exr", HEIGHT, 1.0, (float)NAN), "--flip=hdr", "--junit", xml, "--map", png);
    ck_assert_int_eq(run->status, 4);
    expect_words(run->err, "is NaN at pixel (2, 1)");
    run = RUN("compare", a, picture("bright.exr", HEIGHT, 3.0, 0.0f), "--flip=ldr", "--junit", xml, "--map", png);
    ck_assert_int_eq(run->status, 4);
    expect_words(run->err, "LDR-FLIP without an exposure takes 0 to 1");
    ck_assert(!exists(xml));
    ck_assert(!exists(png));
    RUN_EXPECT(5, "compare", a, a, "--junit", "/nonexistent/v.xml");
    RUN_EXPECT(5, "compare", a, a, "--map", "/nonexistent/v.png");
}
END_TEST

/* Played by a limit on the size of files, as in tests/io/test_file.c. */
START_TEST(a_full_disk_is_told_and_leaves_nothing) {
    const char *a = picture("a.exr", HEIGHT, 1.0, 0.0f), *b = picture("b.exr", HEIGHT, 1.5, 0.0f);
    const char *options[3] = {"--junit", "--map", "--flip-map"}, *files[3] = {file_of("f.xml"), file_of("f.png"), file_of("f.exr")};
    struct rlimit limit;
    signal(SIGXFSZ, SIG_IGN);
    ck_assert_int_eq(getrlimit(RLIMIT_FSIZE, &limit), 0);
    limit.rlim_cur = 600;
    ck_assert_int_eq(setrlimit(RLIMIT_FSIZE, &limit), 0);
    for (int i = 0; i < 3; i++) {
        const Ran *run = RUN("compare", a, b, options[i], files[i]);
        ck_assert_msg(run->status == 5, "%s: exit status %d\n%s", options[i], run->status, run->err);
        expect_words(run->err, files[i]);
        ck_assert(!exists(files[i]));
    }
}
END_TEST

static void fill(TCase *cases) {
    tcase_set_timeout(cases, 120);
    tcase_add_test(cases, flip_stands_in_text_and_json_when_it_is_asked_for);
    tcase_add_test(cases, maps_are_the_same_for_any_number_of_threads);
    tcase_add_test(cases, junit_is_written_whatever_the_verdict);
    tcase_add_test(cases, pictures_that_do_not_compare_are_refused_and_leave_nothing);
    tcase_add_test(cases, a_full_disk_is_told_and_leaves_nothing);
}

int main(void) { return nph_test_main("cli_compare", fill); }
