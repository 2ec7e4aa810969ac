/* SPDX-License-Identifier: Apache-2.0
 *
 * Part files: what is written is read back to the bit, the bytes are those of docs/files.md, and damage is refused. */
#include <math.h>
#include <xxhash.h>

#include "core/memory.h"
#include "film/part.h"
#include "film_samples.h"
#include "io/file.h"

static char *bytes_of(NphContext *context, const char *path, size_t *size) {
    char *bytes = NULL;
    ck_assert_int_eq(nph_file_read(context, path, &bytes, size), NPH_OK);
    return bytes;
}

static void put_bytes(const char *path, const void *bytes, size_t size) {
    remove(path); /* a truncated file would be flushed to the disk each time */
    FILE *file = fopen(path, "wb");
    ck_assert_ptr_nonnull(file);
    ck_assert_uint_eq(fwrite(bytes, 1, size, file), size);
    ck_assert_int_eq(fclose(file), 0);
}

static double odd_sample(int x, int y, int64_t sample, int field) {
    if (x == 6 && y == 3 && sample == 40 && field == 1) return -(double)INFINITY;
    return plain_sample(x, y, sample, field);
}

static NphFilm *with_texts(NphContext *context, NphFilm *film) {
    ck_assert_int_eq(nph_film_set_text(context, film, "seed", "12"), NPH_OK);
    ck_assert_int_eq(nph_film_set_text(context, film, "empty", ""), NPH_OK);
    ck_assert_int_eq(nph_film_set_text(context, film, "knobs", "path.roulette=0.1, \xc3\xa4"), NPH_OK);
    return film;
}

static void check_round_trip(NphContext *context, const NphFilm *film) {
    const char *first = nph_test_temporary("first.part"), *second = nph_test_temporary("second.part");
    NphFilm *read = NULL;
    size_t size_a, size_b;
    ck_assert_int_eq(nph_film_write_part(context, film, first), NPH_OK);
    ck_assert_int_eq(nph_film_read_part(context, first, &read), NPH_OK);
    ck_assert(films_equal(film, read));
    ck_assert_int_eq(read->text_count, film->text_count);
    for (int i = 0; i < film->text_count; i++) {
        ck_assert_str_eq(read->texts[i].name, film->texts[i].name);
        ck_assert_str_eq(read->texts[i].text, film->texts[i].text);
    }
    ck_assert_int_eq(nph_film_write_part(context, read, second), NPH_OK);
    char *a = bytes_of(context, first, &size_a), *b = bytes_of(context, second, &size_b);
    ck_assert_uint_eq(size_a, size_b);
    ck_assert_mem_eq(a, b, size_a);
    nph_free(context, a);
    nph_free(context, b);
    nph_film_free(context, read);
}

START_TEST(a_film_read_back_is_the_film_and_writes_the_same_bytes) {
    static const Shape shapes[] = {
        {1, 1, {0, 0, 1, 1}, 1, 0, 16},
        {40, 30, {0, 0, 40, 30}, 3, 0, 16 * 7},
        {40, 30, {5, 2, 33, 20}, 3, 48, 16 * 9},
        {40, 30, {15, 15, 17, 17}, 1, 16, 16 * 30},
    };
    NphContext *context = nph_test_context(1);
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
        NphFilm *film = full_film(context, &shapes[i], 32, odd_sample);
        check_round_trip(context, film);
        check_round_trip(context, with_texts(context, film));
        nph_film_free(context, film);
    }
    nph_test_context_close(context);
}
END_TEST

START_TEST(an_interrupted_film_keeps_each_tiles_own_count) {
    NphContext *context = nph_test_context(1);
    Shape shape = {60, 16, {0, 0, 60, 16}, 1, 16, 16 * 20};
    NphFilm *film = empty_film(context, &shape);
    check_round_trip(context, film);
    add_samples(film, 0, 16 * 8, 32, odd_sample);
    add_samples(film, 3, 16 * 20, 32, odd_sample);
    check_round_trip(context, film);
    nph_film_free(context, film);
    nph_test_context_close(context);
}
END_TEST

static double sign_of_nan = 1;
static double nan_sample(int x, int y, int64_t sample, int field) {
    return sample == 3 && field == 0 ? copysign((double)NAN, sign_of_nan) : plain_sample(x, y, sample, field);
}

START_TEST(the_sign_of_a_nan_does_not_reach_the_file) {
    NphContext *context = nph_test_context(1);
    Shape shape = {2, 2, {0, 0, 2, 2}, 1, 0, 64};
    char *bytes[2];
    size_t size[2];
    for (int i = 0; i < 2; i++) {
        sign_of_nan = i ? -1 : 1;
        NphFilm *film = full_film(context, &shape, 64, nan_sample);
        ck_assert_int_eq(nph_film_write_part(context, film, nph_test_temporary("nan.part")), NPH_OK);
        bytes[i] = bytes_of(context, nph_test_temporary("nan.part"), &size[i]);
        nph_film_free(context, film);
    }
    ck_assert_uint_eq(size[0], size[1]);
    ck_assert_mem_eq(bytes[0], bytes[1], size[0]);
    nph_free(context, bytes[0]);
    nph_free(context, bytes[1]);
    nph_test_context_close(context);
}
END_TEST

/* A small file: one tile, two nodes, one text. */
static char *small_file(NphContext *context, size_t *size) {
    Shape shape = {20, 10, {3, 1, 4, 2}, 1, 16, 64};
    NphFilm *film = full_film(context, &shape, 32, plain_sample);
    ck_assert_int_eq(nph_film_set_text(context, film, "seed", "12345"), NPH_OK);
    ck_assert_int_eq(nph_film_write_part(context, film, nph_test_temporary("small.part")), NPH_OK);
    nph_film_free(context, film);
    return bytes_of(context, nph_test_temporary("small.part"), size);
}

static uint64_t word_at(const char *bytes, size_t at, int count) {
    uint64_t value = 0;
    for (int i = 0; i < count; i++) value |= (uint64_t)(unsigned char)bytes[at + (size_t)i] << (8 * i);
    return value;
}

START_TEST(the_bytes_are_those_of_the_description) {
    NphContext *context = nph_test_context(1);
    size_t size;
    char *bytes = small_file(context, &size);
    static const struct {
        int at, bytes;
        uint64_t value;
    } fields[] = {
        {8, 4, 1},  {12, 4, 1}, {16, 4, 20}, {20, 4, 10}, {24, 4, 3},  {28, 4, 1},
        {32, 4, 4}, {36, 4, 2}, {40, 8, 16}, {48, 8, 64}, {56, 8, 24}, {64, 8, 1},
        {80, 4, 4}, {84, 4, 5}, {97, 7, 0},  {104, 8, 3}, {112, 8, 0}, {120, 8, 0},
    };
    ck_assert_mem_eq(bytes, "NPHPART1", 8);
    for (size_t i = 0; i < sizeof fields / sizeof *fields; i++)
        ck_assert_msg(word_at(bytes, (size_t)fields[i].at, fields[i].bytes) == fields[i].value, "byte %d",
                      fields[i].at);
    ck_assert_mem_eq(bytes + 88, "seed12345", 9);
    ck_assert_uint_eq(size, 136 + 2 * 8 * 8 + 16);
    ck_assert_uint_eq(word_at(bytes, 72, 8), size);
    long double exact[4]; /* the first node holds samples 16 to 32; its first value is the mean */
    double mean;
    exact_moments(3, 1, 0, 16, 32, 32, plain_sample, exact);
    memcpy(&mean, bytes + 136, sizeof mean);
    ck_assert_double_eq_tol(mean, (double)exact[0], 1e-15 * mean);
    XXH128_canonical_t digest;
    XXH128_canonicalFromHash(&digest, XXH3_128bits(bytes, size - 16));
    ck_assert_mem_eq(bytes + size - 16, digest.digest, 16);
    nph_free(context, bytes);
    nph_test_context_close(context);
}
END_TEST

/* Samples by + - * / alone, so that compiler, optimisation and vector level have nothing to differ by but the film. */
START_TEST(the_file_has_the_same_bytes_with_every_compiler_and_vector_level) {
    NphContext *context = nph_test_context(1);
    Shape shape = {50, 40, {3, 2, 44, 35}, 3, 80, 16 * 60};
    NphFilm *film = with_texts(context, full_film(context, &shape, 32, odd_sample));
    size_t size;
    char text[40] = "";
    ck_assert_int_eq(nph_film_write_part(context, film, nph_test_temporary("golden.part")), NPH_OK);
    char *bytes = bytes_of(context, nph_test_temporary("golden.part"), &size);
    for (int i = 0; i < 16; i++)
        snprintf(text + 2 * i, 3, "%02x", (unsigned)(unsigned char)bytes[size - 16 + (size_t)i]);
    ck_assert_str_eq(text, "7abb5c7551408e5e68b70f9ba0df49f8");
    nph_free(context, bytes);
    nph_film_free(context, film);
    nph_test_context_close(context);
}
END_TEST

/* Writes the bytes, expects a refusal that names file and byte. */
static const char *check_refused(NphContext *context, const void *bytes, size_t size, const char *what, long which) {
    const char *path = nph_test_temporary("bad.part");
    NphFilm *film = NULL;
    uint64_t before = nph_context_bytes(context);
    put_bytes(path, bytes, size);
    nph_test_messages();
    NphStatus status = nph_film_read_part(context, path, &film);
    const char *said = nph_test_messages();
    ck_assert_msg(status == NPH_BAD_INPUT && !film, "%s %ld: status %d", what, which, (int)status);
    ck_assert_msg(strstr(said, "bad.part: byte ") != NULL, "%s %ld said: %s", what, which, said);
    ck_assert_uint_eq(nph_context_bytes(context), before);
    return said;
}

START_TEST(every_truncation_and_every_flipped_bit_is_refused) {
    NphContext *context = nph_test_context(1);
    size_t size;
    char *bytes = small_file(context, &size);
    for (size_t length = 0; length < size; length++) check_refused(context, bytes, length, "length", (long)length);
    for (size_t bit = 0; bit < 8 * size; bit++) {
        bytes[bit / 8] = (char)(bytes[bit / 8] ^ (1 << bit % 8));
        check_refused(context, bytes, size, "bit", (long)bit);
        bytes[bit / 8] = (char)(bytes[bit / 8] ^ (1 << bit % 8));
    }
    char longer[1024] = {0};
    memcpy(longer, bytes, size);
    check_refused(context, longer, size + 8, "longer by", 8);
    nph_free(context, bytes);
    nph_test_context_close(context);
}
END_TEST

START_TEST(foreign_and_random_bytes_are_refused) {
    NphContext *context = nph_test_context(1);
    unsigned char bytes[300];
    for (int trial = 0; trial < 200; trial++) {
        for (int i = 0; i < 300; i++) bytes[i] = (unsigned char)(256 * hash_uniform(7, (uint64_t)trial, (uint64_t)i));
        if (trial % 2) memcpy(bytes, NPH_PART_MAGIC, 8);
        check_refused(context, bytes, sizeof bytes, "random file", trial);
    }
    ck_assert_ptr_nonnull(strstr(check_refused(context, "\x76\x2f\x31\x01\x02", 5, "EXR", 0), "is no part file"));
    NphFilm *film = NULL;
    ck_assert_int_eq(nph_film_read_part(context, nph_test_temporary("absent.part"), &film), NPH_BAD_INPUT);
    ck_assert_int_eq(nph_film_read_part(context, nph_test_temporary(""), &film), NPH_BAD_INPUT);
    nph_test_context_close(context);
}
END_TEST

/* A field changed, the digest made to fit: only the field itself can tell. */
static void check_field(NphContext *context, const char *bytes, size_t size, int at, int count, uint64_t value) {
    char changed[1024], label[64];
    XXH128_canonical_t digest;
    memcpy(changed, bytes, size);
    for (int i = 0; i < count; i++) changed[at + i] = (char)(value >> (8 * i));
    XXH128_canonicalFromHash(&digest, XXH3_128bits(changed, size - 16));
    memcpy(changed + size - 16, digest.digest, 16);
    snprintf(label, sizeof label, "value %llx at", (unsigned long long)value);
    check_refused(context, changed, size, label, at);
}

START_TEST(fields_that_contradict_each_other_are_refused_although_the_digest_fits) {
    static const struct {
        int at, bytes;
    } fields[] = {{8, 4},  {12, 4}, {16, 4}, {20, 4}, {24, 4}, {28, 4}, {32, 4}, {36, 4},
                  {40, 8}, {48, 8}, {56, 8}, {64, 8}, {72, 8}, {80, 4}, {84, 4}};
    NphContext *context = nph_test_context(1);
    size_t size;
    char *bytes = small_file(context, &size);
    for (size_t i = 0; i < sizeof fields / sizeof *fields; i++) {
        check_field(context, bytes, size, fields[i].at, fields[i].bytes, UINT64_MAX);
        check_field(context, bytes, size, fields[i].at, fields[i].bytes, (uint64_t)1 << (8 * fields[i].bytes - 1));
        check_field(context, bytes, size, fields[i].at, fields[i].bytes,
                    ((uint64_t)1 << (8 * fields[i].bytes - 1)) - 1);
        int any = fields[i].at == NPH_PART_WIDTH || fields[i].at == NPH_PART_HEIGHT; /* nothing else tells them */
        if (!any) check_field(context, bytes, size, fields[i].at, fields[i].bytes, 99);
    }
    static const struct {
        int at, bytes;
        uint64_t value;
    } cases[] = {
        {8, 4, 2},   {12, 4, 0},           {12, 4, 2},  {16, 4, 0},           {16, 4, 3},  {20, 4, 1},
        {24, 4, 4},  {32, 4, 21},          {32, 4, 5},  {40, 8, 24},          {40, 8, 64}, {48, 8, 16},
        {48, 8, 48}, {56, 8, 16},          {56, 8, 32}, {64, 8, 0},           {64, 8, 2},  {80, 4, 0},
        {80, 4, 10}, {84, 4, 4},           {84, 4, 15}, {88, 1, 0},           {97, 1, 1},  {104, 8, 1},
        {104, 8, 4}, {104, 8, UINT64_MAX}, {112, 8, 1}, {112, 8, UINT64_MAX}, {120, 4, 3}, {128, 8, 16},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        check_field(context, bytes, size, cases[i].at, cases[i].bytes, cases[i].value);
    nph_free(context, bytes);
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_part_that_cannot_be_written_is_reported_and_leaves_no_file) {
    NphContext *context = nph_test_context(1);
    Shape shape = {4, 4, {0, 0, 4, 4}, 1, 0, 16};
    NphFilm *film = full_film(context, &shape, 32, plain_sample);
    ck_assert_int_eq(nph_film_write_part(context, film, nph_test_temporary("no/such/folder.part")), NPH_BAD_OUTPUT);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "folder.part"));
    nph_film_free(context, film);
    nph_test_context_close(context);
}
END_TEST

START_TEST(every_failing_allocation_is_reported_and_leaks_nothing) {
    NphContext *maker = nph_test_context(1);
    Shape shape = {20, 20, {0, 0, 20, 20}, 3, 0, 48};
    NphFilm *film = with_texts(maker, full_film(maker, &shape, 32, plain_sample));
    NphSettings settings;
    nph_settings_default(&settings);
    settings.threads = 1;
    for (settings.fail_allocation = 1;; settings.fail_allocation++) {
        NphContext *context = NULL;
        NphFilm *read = NULL;
        ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
        NphStatus status = nph_film_write_part(context, film, nph_test_temporary("memory.part"));
        if (status == NPH_OK) status = nph_film_read_part(context, nph_test_temporary("memory.part"), &read);
        int done = nph_context_allocations(context) < settings.fail_allocation;
        ck_assert_int_eq(status, done ? NPH_OK : NPH_NO_MEMORY);
        ck_assert(done == (read != NULL));
        nph_film_free(context, read);
        nph_test_context_close(context);
        if (done) break;
    }
    ck_assert_uint_ge(settings.fail_allocation, 15);
    nph_film_free(maker, film);
    nph_test_context_close(maker);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, a_film_read_back_is_the_film_and_writes_the_same_bytes);
    tcase_add_test(cases, an_interrupted_film_keeps_each_tiles_own_count);
    tcase_add_test(cases, the_sign_of_a_nan_does_not_reach_the_file);
    tcase_add_test(cases, the_bytes_are_those_of_the_description);
    tcase_add_test(cases, the_file_has_the_same_bytes_with_every_compiler_and_vector_level);
    tcase_add_test(cases, every_truncation_and_every_flipped_bit_is_refused);
    tcase_add_test(cases, foreign_and_random_bytes_are_refused);
    tcase_add_test(cases, fields_that_contradict_each_other_are_refused_although_the_digest_fits);
    tcase_add_test(cases, a_part_that_cannot_be_written_is_reported_and_leaves_no_file);
    tcase_add_test(cases, every_failing_allocation_is_reported_and_leaks_nothing);
}

int main(void) { return nph_test_main("part", fill); }
