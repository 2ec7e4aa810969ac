/* SPDX-License-Identifier: Apache-2.0
 *
 * Parts merge to the bytes of the unsplit film, for any split; everything else is refused by name. */
#include <math.h>

#include "core/memory.h"
#include "film_samples.h"
#include "io/file.h"

static NphFilm *part_of(NphContext *context, const Shape *whole, const int crop[4], int64_t begin, int64_t end) {
    Shape shape = *whole;
    memcpy(shape.crop, crop, sizeof shape.crop);
    shape.begin = begin;
    shape.end = end;
    return full_film(context, &shape, 32, plain_sample);
}

static const char *const names[16] = {"p0", "p1", "p2", "p3", "p4", "p5", "p6", "p7",
                                      "p8", "p9", "pa", "pb", "pc", "pd", "pe", "pf"};

static void check_merge(NphContext *context, const NphFilm *whole, int count, NphFilm **parts) {
    NphFilm *merged = NULL;
    NphStatus status = nph_film_merge(context, count, parts, names, &merged);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    ck_assert(films_equal(whole, merged));
    nph_film_free(context, merged);
}

START_TEST(every_split_of_128_samples_into_ranges_merges_to_the_unsplit_film) {
    NphContext *context = nph_test_context(1);
    for (int64_t begin = 0; begin <= 80; begin += 80) {
        Shape shape = {3, 2, {0, 0, 3, 2}, 3, begin, begin + 128};
        NphFilm *whole = full_film(context, &shape, 32, plain_sample);
        for (int cuts = 0; cuts < 128; cuts++) { /* bit i: a cut after chunk i */
            NphFilm *parts[8];
            int count = 0;
            int64_t from = begin;
            for (int i = 0; i < 8; i++) {
                if (i < 7 && !(cuts >> i & 1)) continue;
                int64_t to = begin + 16 * (i + 1);
                parts[count++] = part_of(context, &shape, shape.crop, from, to);
                from = to;
            }
            check_merge(context, whole, count, parts);
            for (int i = 0; i < count / 2; i++) { /* the order of the parts does not matter */
                NphFilm *swap = parts[i];
                parts[i] = parts[count - 1 - i];
                parts[count - 1 - i] = swap;
            }
            check_merge(context, whole, count, parts);
            for (int i = 0; i < count; i++) nph_film_free(context, parts[i]);
        }
        nph_film_free(context, whole);
    }
    nph_test_context_close(context);
}
END_TEST

typedef struct Split {
    NphContext *context;
    const Shape *whole;
    uint64_t seed, draws;
    int count;
    NphFilm *parts[16];
} Split;

static int draw(Split *split, int bound) { return (int)(bound * hash_uniform(split->seed, split->draws++, 77)); }

/* Cuts a box of pixels and chunks at a random plane, again and again, and renders what is left as parts. */
static void cut(Split *split, const int low[3], const int high[3], int depth) {
    int axis = draw(split, 3), size = high[axis] - low[axis];
    if (depth == 0 || size < 2 || draw(split, 6) == 0) {
        int crop[4] = {low[0], low[1], high[0], high[1]};
        split->parts[split->count++] = part_of(split->context, split->whole, crop, 16 * low[2], 16 * high[2]);
        return;
    }
    int at = low[axis] + 1 + draw(split, size - 1), low2[3], high2[3];
    memcpy(low2, low, sizeof low2);
    memcpy(high2, high, sizeof high2);
    low2[axis] = high2[axis] = at;
    cut(split, low, high2, depth - 1);
    cut(split, low2, high, depth - 1);
}

START_TEST(random_crops_and_ranges_merge_to_the_unsplit_film) {
    NphContext *context = nph_test_context(1);
    Shape shape = {40, 23, {2, 1, 37, 20}, 1, 48, 48 + 16 * 7};
    NphFilm *whole = full_film(context, &shape, 32, plain_sample);
    int most = 0;
    for (uint64_t seed = 0; seed < 60; seed++) {
        Split split = {.context = context, .whole = &shape, .seed = seed};
        cut(&split, (int[]){2, 1, 3}, (int[]){37, 20, 10}, 4);
        check_merge(context, whole, split.count, split.parts);
        if (split.count > most) most = split.count;
        for (int i = 0; i < split.count; i++) nph_film_free(context, split.parts[i]);
    }
    ck_assert_int_ge(most, 10);
    nph_film_free(context, whole);
    nph_test_context_close(context);
}
END_TEST

static double bad_sample(int x, int y, int64_t sample, int field) {
    int bad = field == 0 && ((x == 9 && y == 2 && sample >= 100) || (x == 3 && y == 2 && sample == 110));
    return bad ? -(double)NAN : plain_sample(x, y, sample, field);
}

START_TEST(files_of_parts_merge_to_the_bytes_of_the_unsplit_file_bad_samples_and_texts_included) {
    NphContext *context = nph_test_context(1);
    Shape whole = {20, 18, {0, 0, 20, 18}, 3, 0, 128};
    static const Shape shapes[3] = {
        {20, 18, {0, 0, 7, 18}, 3, 0, 128}, {20, 18, {7, 0, 20, 18}, 3, 0, 48}, {20, 18, {7, 0, 20, 18}, 3, 48, 128}};
    NphFilm *films[4] = {0}, *read[3] = {0};
    char *bytes[2];
    size_t size[2];
    for (int i = 0; i < 4; i++) {
        films[i] = full_film(context, i < 3 ? &shapes[i] : &whole, 32, bad_sample);
        ck_assert_int_eq(nph_film_set_text(context, films[i], "seed", "3"), NPH_OK);
        ck_assert_int_eq(nph_film_write_part(context, films[i], nph_test_temporary(names[i])), NPH_OK);
        if (i < 3) ck_assert_int_eq(nph_film_read_part(context, nph_test_temporary(names[i]), &read[i]), NPH_OK);
        nph_film_free(context, films[i]);
    }
    NphFilm *merged = NULL;
    ck_assert_int_eq(nph_film_merge(context, 3, read, names, &merged), NPH_OK);
    ck_assert_int_eq(nph_film_write_part(context, merged, nph_test_temporary("merged")), NPH_OK);
    NphNonfinite report;
    nph_film_nonfinite(merged, &report);
    ck_assert(report.count == 29 && report.x == 3 && report.y == 2 && report.sample == 110);
    for (int i = 0; i < 2; i++)
        ck_assert_int_eq(nph_file_read(context, nph_test_temporary(i ? "merged" : names[3]), &bytes[i], &size[i]),
                         NPH_OK);
    ck_assert_uint_eq(size[0], size[1]);
    ck_assert_mem_eq(bytes[0], bytes[1], size[0]);
    for (int i = 0; i < 2; i++) nph_free(context, bytes[i]);
    for (int i = 0; i < 3; i++) nph_film_free(context, read[i]);
    nph_film_free(context, merged);
    nph_test_context_close(context);
}
END_TEST

/* Two or three parts that must be refused, and the words of the refusal. */
static void check_refused(NphContext *context, int count, NphFilm **parts, const char *const words[3]) {
    NphFilm *merged = NULL;
    uint64_t before = nph_context_bytes(context);
    nph_test_messages();
    ck_assert_int_eq(nph_film_merge(context, count, parts, names, &merged), NPH_BAD_INPUT);
    const char *said = nph_test_messages();
    ck_assert_ptr_null(merged);
    ck_assert_uint_eq(nph_context_bytes(context), before);
    for (int i = 0; i < 3; i++)
        ck_assert_msg(strstr(said, words[i]) != NULL, "said \"%s\", not \"%s\"", said, words[i]);
    for (int i = 0; i < count; i++) nph_film_free(context, parts[i]);
}

START_TEST(overlaps_and_gaps_are_refused_naming_parts_pixels_and_samples) {
    NphContext *context = nph_test_context(1);
    Shape w = {40, 20, {0, 0, 40, 20}, 1, 0, 64};
    static const int all[4] = {0, 0, 40, 20}, left[4] = {0, 0, 19, 20}, right[4] = {19, 0, 40, 20},
                     middle[4] = {18, 3, 22, 20}, far[4] = {25, 0, 40, 20};
    check_refused(context, 2, (NphFilm *[]){part_of(context, &w, all, 0, 32), part_of(context, &w, all, 16, 64)},
                  (const char *const[]){"p0 and p1 overlap", "samples 16:32", "pixels 0,0,40,20"});
    check_refused(context, 3,
                  (NphFilm *[]){part_of(context, &w, left, 0, 32), part_of(context, &w, right, 0, 32),
                                part_of(context, &w, middle, 0, 32)},
                  (const char *const[]){"p0 and p2 overlap", "samples 0:32", "pixels 18,3,19,20"});
    check_refused(context, 2, (NphFilm *[]){part_of(context, &w, all, 0, 32), part_of(context, &w, all, 48, 64)},
                  (const char *const[]){"p0", "samples 32:48", "pixel 0,0"});
    check_refused(context, 2, (NphFilm *[]){part_of(context, &w, left, 0, 32), part_of(context, &w, far, 0, 32)},
                  (const char *const[]){"p0", "samples 0:32", "pixel 19,0"});
    check_refused(context, 2, (NphFilm *[]){part_of(context, &w, left, 0, 64), part_of(context, &w, right, 0, 32)},
                  (const char *const[]){"gap", "samples 32:64", "pixel 19,0"});
    check_refused(context, 3,
                  (NphFilm *[]){part_of(context, &w, left, 0, 64), part_of(context, &w, (int[]){19, 0, 40, 5}, 0, 64),
                                part_of(context, &w, (int[]){20, 5, 40, 20}, 0, 64)},
                  (const char *const[]){"gap", "samples 0:64", "pixel 19,5"});
    nph_test_context_close(context);
}
END_TEST

START_TEST(parts_of_different_runs_are_refused_naming_what_differs) {
    NphContext *context = nph_test_context(1);
    static const int all[4] = {0, 0, 5, 5};
    Shape w = {5, 5, {0, 0, 5, 5}, 1, 0, 64}, wide = {6, 5, {0, 0, 5, 5}, 1, 0, 64},
          colour = {5, 5, {0, 0, 5, 5}, 3, 0, 64};
    check_refused(context, 2, (NphFilm *[]){part_of(context, &w, all, 0, 32), part_of(context, &wide, all, 32, 64)},
                  (const char *const[]){"p0", "5 x 5", "p1 of 6 x 5"});
    check_refused(context, 2, (NphFilm *[]){part_of(context, &w, all, 0, 32), part_of(context, &colour, all, 32, 64)},
                  (const char *const[]){"p0", "1 channels", "p1 has 3"});
    for (int i = 0; i < 3; i++) {
        NphFilm *parts[2] = {part_of(context, &w, all, 0, 32), part_of(context, &w, all, 32, 64)};
        if (i != 2) ck_assert_int_eq(nph_film_set_text(context, parts[0], "seed", "1"), NPH_OK);
        if (i != 1) ck_assert_int_eq(nph_film_set_text(context, parts[1], "seed", "2"), NPH_OK);
        static const char *const words[3][3] = {{"p0: its \"seed\" is \"1\"", "p1", "\"2\""},
                                                {"p0", "missing in p1", "seed"},
                                                {"p1", "missing in p0", "seed"}};
        check_refused(context, 2, parts, words[i]);
    }
    ck_assert_int_eq(nph_film_merge(context, 0, NULL, NULL, NULL), NPH_BAD_USAGE);
    nph_test_context_close(context);
}
END_TEST

START_TEST(an_interrupted_part_merges_at_the_end_and_is_refused_before_others) {
    NphContext *context = nph_test_context(1);
    Shape w = {40, 16, {0, 0, 40, 16}, 1, 0, 128}, first = {40, 16, {0, 0, 40, 16}, 1, 0, 64},
          last = {40, 16, {0, 0, 40, 16}, 1, 64, 128};
    NphFilm *wanted = empty_film(context, &w),
            *parts[2] = {full_film(context, &first, 32, plain_sample), empty_film(context, &last)};
    static const int64_t ends[3] = {96, 64, 128};
    for (int tile = 0; tile < 3; tile++) {
        add_samples(wanted, tile, ends[tile], 32, plain_sample);
        add_samples(parts[1], tile, ends[tile], 32, plain_sample);
    }
    check_merge(context, wanted, 2, parts);
    check_merge(context, wanted, 1, &wanted);
    nph_film_free(context, wanted);
    nph_film_free(context, parts[0]);
    nph_film_free(context, parts[1]);
    parts[0] = empty_film(context, &first);
    parts[1] = full_film(context, &last, 32, plain_sample);
    add_samples(parts[0], 0, 64, 32, plain_sample);
    add_samples(parts[0], 1, 48, 32, plain_sample);
    add_samples(parts[0], 2, 64, 32, plain_sample);
    check_refused(context, 2, parts,
                  (const char *const[]){"p0: was interrupted", "samples 48:64 of pixel 16,0", "before those of p1"});
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_tile_cut_between_a_whole_and_an_interrupted_part_is_refused) {
    NphContext *context = nph_test_context(1);
    Shape a = {16, 16, {0, 0, 9, 16}, 1, 0, 64}, b = {16, 16, {9, 0, 16, 16}, 1, 0, 64};
    NphFilm *parts[2] = {full_film(context, &a, 32, plain_sample), empty_film(context, &b)};
    add_samples(parts[1], 0, 32, 32, plain_sample);
    check_refused(context, 2, parts,
                  (const char *const[]){"pixel 9,0 has 32 samples", "0,0 in the same tile has 64", "finish"});
    nph_test_context_close(context);
}
END_TEST

START_TEST(every_failing_allocation_is_reported_and_leaks_nothing) {
    NphContext *maker = nph_test_context(1);
    Shape w = {20, 5, {0, 0, 20, 5}, 1, 0, 64};
    NphFilm *parts[2] = {part_of(maker, &w, w.crop, 0, 16), part_of(maker, &w, w.crop, 16, 64)};
    for (int i = 0; i < 2; i++) ck_assert_int_eq(nph_film_set_text(maker, parts[i], "seed", "1"), NPH_OK);
    NphSettings settings;
    nph_settings_default(&settings);
    settings.threads = 1;
    for (settings.fail_allocation = 1;; settings.fail_allocation++) {
        NphContext *context = NULL;
        NphFilm *merged = NULL;
        ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
        NphStatus status = nph_film_merge(context, 2, parts, names, &merged);
        int done = nph_context_allocations(context) < settings.fail_allocation;
        ck_assert_int_eq(status, done ? NPH_OK : NPH_NO_MEMORY);
        nph_film_free(context, merged);
        nph_test_context_close(context);
        if (done) break;
    }
    ck_assert_uint_ge(settings.fail_allocation, 8);
    for (int i = 0; i < 2; i++) nph_film_free(maker, parts[i]);
    nph_test_context_close(maker);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, every_split_of_128_samples_into_ranges_merges_to_the_unsplit_film);
    tcase_add_test(cases, random_crops_and_ranges_merge_to_the_unsplit_film);
    tcase_add_test(cases, files_of_parts_merge_to_the_bytes_of_the_unsplit_file_bad_samples_and_texts_included);
    tcase_add_test(cases, overlaps_and_gaps_are_refused_naming_parts_pixels_and_samples);
    tcase_add_test(cases, parts_of_different_runs_are_refused_naming_what_differs);
    tcase_add_test(cases, an_interrupted_part_merges_at_the_end_and_is_refused_before_others);
    tcase_add_test(cases, a_tile_cut_between_a_whole_and_an_interrupted_part_is_refused);
    tcase_add_test(cases, every_failing_allocation_is_reported_and_leaks_nothing);
}

int main(void) { return nph_test_main("merge", fill); }
