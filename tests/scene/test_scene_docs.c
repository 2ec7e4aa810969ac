/* SPDX-License-Identifier: Apache-2.0
 *
 * docs/scene.md and docs/scene.schema.json are what the table of keys says. With NEPHOS_UPDATE_DOCS=1 they are written
 * anew instead. Also: the table itself holds together. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/text.h"
#include "harness.h"
#include "scene/scene_keys.h"
#include "scene/scene_read.h"

typedef struct Text {
    char bytes[1 << 18];
    size_t size;
} Text;

static Text made, kept;

static void collect(void *user, const char *text, size_t size) {
    Text *into = user;
    ck_assert_uint_lt(into->size + size, sizeof into->bytes);
    memcpy(into->bytes + into->size, text, size);
    into->size += size;
}

static void check_page(const char *relative, void (*make)(NphTextFn, void *)) {
    const char *path = nph_test_path(relative);
    made.size = 0;
    make(collect, &made);
    if (getenv("NEPHOS_UPDATE_DOCS")) {
        FILE *file = fopen(path, "wb");
        ck_assert_ptr_nonnull(file);
        ck_assert_uint_eq(fwrite(made.bytes, 1, made.size, file), made.size);
        ck_assert_int_eq(fclose(file), 0);
    }
    FILE *file = fopen(path, "rb");
    ck_assert_msg(file != NULL, "%s is missing; run this test with NEPHOS_UPDATE_DOCS=1", relative);
    kept.size = fread(kept.bytes, 1, sizeof kept.bytes, file);
    fclose(file);
    ck_assert_msg(kept.size == made.size && memcmp(kept.bytes, made.bytes, made.size) == 0,
                  "%s is out of date; run this test with NEPHOS_UPDATE_DOCS=1", relative);
}

START_TEST(the_page_about_scenes_is_what_the_table_says) { check_page("docs/scene.md", nph_scene_keys_markdown); }
END_TEST

START_TEST(the_schema_is_what_the_table_says) { check_page("docs/scene.schema.json", nph_scene_keys_json); }
END_TEST

START_TEST(every_row_of_the_table_is_sound) {
    for (int i = 0; i < nph_scene_key_count; i++) {
        const NphSceneKey *key = &nph_scene_keys[i];
        const NphSceneSectionInfo *info = nph_scene_section_info(key->section);
        ck_assert_msg(info != NULL, "%s", key->section);
        ck_assert(key->min <= key->max);
        char variant[64];
        for (int n = 0; key->applies && nph_words_get(key->applies, n, variant, sizeof variant); n++)
            ck_assert_msg(nph_words_index(info->variants, variant) >= 0, "%s.%s: %s", key->section, key->key, variant);
        if (key->type == NPH_KEY_SECTION || key->type == NPH_KEY_LIST)
            ck_assert_ptr_nonnull(nph_scene_section_info(key->words));
        NphSceneValue value = {0};
        nph_value_default(key, &value);
        ck_assert_int_eq(value.valid, key->fallback != NULL && key->fallback != nph_key_required);
        if (value.valid && key->type == NPH_KEY_WORD) ck_assert_int_ge(value.word, 0);
    }
    for (int i = 0; i < nph_scene_section_count; i++) {
        int count;
        const NphSceneKey *keys = nph_scene_section_keys(nph_scene_sections[i].name, &count);
        ck_assert_int_gt(count, 0);
        ck_assert_int_le(count, NPH_SECTION_KEYS);
        for (int k = 0; k < count; k++) ck_assert_str_eq(keys[k].section, nph_scene_sections[i].name); /* contiguous */
    }
}
END_TEST

START_TEST(distances_count_edits_and_swapped_neighbours) {
    ck_assert_int_eq(nph_edit_distance("albedo", "albedo"), 0);
    ck_assert_int_eq(nph_edit_distance("albdo", "albedo"), 1);
    ck_assert_int_eq(nph_edit_distance("albeod", "albedo"), 1);
    ck_assert_int_eq(nph_edit_distance("", "abc"), 3);
    ck_assert_int_eq(nph_edit_distance("kitten", "sitting"), 3);
    ck_assert(nph_edit_close("exctinction", "extinction"));
    ck_assert(!nph_edit_close("colour", "camera"));
    ck_assert(!nph_edit_close("g", "h"));
}
END_TEST

START_TEST(limits_read_as_people_write_them) {
    char text[NPH_DOUBLE_TEXT];
    ck_assert_str_eq(nph_limit_text(1e9, text), "1e9");
    ck_assert_str_eq(nph_limit_text(-1e12, text), "-1e12");
    ck_assert_str_eq(nph_limit_text(1e35, text), "1e35");
    ck_assert_str_eq(nph_limit_text(1e-9, text), "1e-9");
    ck_assert_str_eq(nph_limit_text(0, text), "0");
    ck_assert_str_eq(nph_limit_text(25000000, text), "25e6");
    ck_assert_str_eq(nph_limit_text(65536, text), "65536");
    ck_assert_str_eq(nph_limit_text(-0.99999, text), "-0.99999");
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, the_page_about_scenes_is_what_the_table_says);
    tcase_add_test(cases, the_schema_is_what_the_table_says);
    tcase_add_test(cases, every_row_of_the_table_is_sound);
    tcase_add_test(cases, distances_count_edits_and_swapped_neighbours);
    tcase_add_test(cases, limits_read_as_people_write_them);
}

int main(void) { return nph_test_main("scene_docs", fill); }
