/* SPDX-License-Identifier: Apache-2.0
 *
 * Files are told by their content. */
#include "io/describe.h"

#include <stdio.h>
#include <string.h>

#include "harness.h"

#define KIND(text) nph_file_kind_of_bytes((text), sizeof(text) - 1)

START_TEST(signatures_name_the_binary_formats) {
    ck_assert_int_eq(KIND("\x76\x2f\x31\x01\x02\0\0\0"), NPH_FILE_EXR);
    ck_assert_int_eq(KIND("\x89PNG\r\n\x1a\n"), NPH_FILE_PNG);
    ck_assert_int_eq(KIND("NanoVDB0\1\2"), NPH_FILE_NVDB);
    ck_assert_int_eq(KIND("NanoVDB2\1\2"), NPH_FILE_NVDB);
    ck_assert_int_eq(KIND(" BDV\0\0\0\0\xe0\0\0\0"), NPH_FILE_VDB);
    ck_assert_int_eq(KIND("\x93NUMPY\1\0"), NPH_FILE_NPY);
    ck_assert_int_eq(KIND(NPH_PART_MAGIC "\0\0"), NPH_FILE_PART);
    ck_assert_int_eq(KIND("#?RADIANCE\n"), NPH_FILE_HDR);
    ck_assert_int_eq(KIND("PF\n2 2\n-1.0\n"), NPH_FILE_PFM);
    ck_assert_int_eq(KIND("VOL\3\1\0\0\0"), NPH_FILE_VOL);
    ck_assert_int_eq(KIND("VOL\2\1\0\0\0"), NPH_FILE_UNKNOWN);
    ck_assert_int_eq(KIND("\x76\x2f\x31"), NPH_FILE_UNKNOWN);
    ck_assert_int_eq(KIND(""), NPH_FILE_EMPTY);
}
END_TEST

START_TEST(les_text_begins_with_three_sizes) {
    ck_assert_int_eq(KIND("# a cloud\n32,37,26      # nx,ny,nz\n0.020,0.020 # dx\n"), NPH_FILE_LES);
    ck_assert_int_eq(KIND("# a cloud\n64 64 16\n0.055 0.055 0.438\n"), NPH_FILE_LES);
    ck_assert_int_eq(KIND("# one\r\n# two\r\n\r\n 4\t4  2 \r\n1 1 1 2\r\n"), NPH_FILE_LES);
    ck_assert_int_eq(KIND("# numbers\n64 64 16 8\n"), NPH_FILE_UNKNOWN);
    ck_assert_int_eq(KIND("# numbers\n6.4 64 16\n"), NPH_FILE_UNKNOWN);
    ck_assert_int_eq(KIND("2  parameter LWC file\n 64 64 16\n"), NPH_FILE_UNKNOWN);
}
END_TEST

START_TEST(phase_tables_begin_with_two_numbers) {
    ck_assert_int_eq(KIND("# angle value\n    0.0   0.1712880E+04\n    0.1   0.17E+04\n"), NPH_FILE_PHASE);
    ck_assert_int_eq(KIND("0,1\r\n180,1\r\n"), NPH_FILE_PHASE);
    ck_assert_int_eq(KIND("\n0 , 1 # straight on"), NPH_FILE_PHASE);
    ck_assert_int_eq(KIND("0\n180\n"), NPH_FILE_UNKNOWN);
    ck_assert_int_eq(KIND("0 1 2.5\n"), NPH_FILE_UNKNOWN);
    ck_assert_int_eq(KIND("0,,1\n"), NPH_FILE_UNKNOWN);
    ck_assert_int_eq(KIND("0 x\n"), NPH_FILE_UNKNOWN);
}
END_TEST

START_TEST(pbrt_files_begin_with_a_directive) {
    ck_assert_int_eq(KIND("# a cloud\nMakeNamedMedium \"cloud\"\n"), NPH_FILE_PBRT);
    ck_assert_int_eq(KIND("LookAt 1 2 3  0 0 0  0 0 1"), NPH_FILE_PBRT);
    ck_assert_int_eq(KIND("Film\"rgb\""), NPH_FILE_PBRT);
    ck_assert_int_eq(KIND("WorldBegin"), NPH_FILE_PBRT);
    ck_assert_int_eq(KIND("Camera: {}\n"), NPH_FILE_SCENE);
    ck_assert_int_eq(KIND("Filming \"x\"\n"), NPH_FILE_UNKNOWN);
}
END_TEST

START_TEST(scenes_begin_with_a_mapping) {
    ck_assert_int_eq(KIND("# a scene\ncamera:\n  fov: 30\n"), NPH_FILE_SCENE);
    ck_assert_int_eq(KIND("%YAML 1.1\n---\n# hello\nmedia: [a]\n"), NPH_FILE_SCENE);
    ck_assert_int_eq(KIND("\xef\xbb\xbfnephos: 1\n"), NPH_FILE_SCENE);
    ck_assert_int_eq(KIND("\n  {\"camera\": {}}\n"), NPH_FILE_SCENE);
    ck_assert_int_eq(KIND("\"camera\": {}\n"), NPH_FILE_SCENE);
    ck_assert_int_eq(KIND("camera:"), NPH_FILE_SCENE);
    ck_assert_int_eq(KIND("Dear reader, this: no\n"), NPH_FILE_UNKNOWN);
    ck_assert_int_eq(KIND("http://x\n"), NPH_FILE_UNKNOWN);
    ck_assert_int_eq(KIND("- a\n- b\n"), NPH_FILE_UNKNOWN);
    ck_assert_int_eq(KIND("camera: \0\n"), NPH_FILE_UNKNOWN);
    ck_assert_int_eq(KIND("# only a comment\n"), NPH_FILE_UNKNOWN);
    ck_assert_int_eq(KIND("\x7f"
                          "ELF: x\n"),
                     NPH_FILE_UNKNOWN);
}
END_TEST

START_TEST(a_cut_that_falls_anywhere_is_no_trouble) {
    static const char *const texts[] = {"\x93NUMPY\1\0", "# a\n1,2,3\n", "%YAML 1.1\n---\n\"key\": 1\n", "NanoVDB0"};
    for (int i = 0; i < 4; i++)
        for (size_t size = 0; size <= strlen(texts[i]); size++) {
            char exact[64]; /* so that the sanitizers see a byte too many */
            memcpy(exact + sizeof exact - size, texts[i], size);
            NphFileKind kind = nph_file_kind_of_bytes(exact + sizeof exact - size, size);
            ck_assert_int_lt(kind, NPH_FILE_KINDS);
            ck_assert_ptr_nonnull(nph_file_kind_name(kind));
        }
}
END_TEST

START_TEST(files_are_opened_and_what_cannot_be_is_refused) {
    NphContext *context = nph_test_context(1);
    NphFileKind kind = NPH_FILE_KINDS;
    const char *folder = nph_test_path("reference/data/env/exr_variants");
    ck_assert_int_eq(nph_file_kind(context, folder, &kind), NPH_BAD_INPUT);
    ck_assert_int_eq(nph_file_kind(context, nph_test_temporary("none"), &kind), NPH_BAD_INPUT);
    ck_assert_int_eq(kind, NPH_FILE_KINDS);
    static const struct {
        const char *name;
        NphFileKind kind;
    } files[] = {{"sunset256_half_piz.exr", NPH_FILE_EXR},
                 {"sunset256_half_dwaa.exr", NPH_FILE_EXR},
                 {"sunset256.hdr", NPH_FILE_HDR},
                 {"sunset256_float.pfm", NPH_FILE_PFM},
                 {"GROUND_TRUTH.txt", NPH_FILE_UNKNOWN}};
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        char path[1200];
        snprintf(path, sizeof path, "%s/%s", folder, files[i].name);
        ck_assert_int_eq(nph_file_kind(context, path, &kind), NPH_OK);
        ck_assert_int_eq(kind, files[i].kind);
    }
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, signatures_name_the_binary_formats);
    tcase_add_test(cases, les_text_begins_with_three_sizes);
    tcase_add_test(cases, phase_tables_begin_with_two_numbers);
    tcase_add_test(cases, pbrt_files_begin_with_a_directive);
    tcase_add_test(cases, scenes_begin_with_a_mapping);
    tcase_add_test(cases, a_cut_that_falls_anywhere_is_no_trouble);
    tcase_add_test(cases, files_are_opened_and_what_cannot_be_is_refused);
}

int main(void) { return nph_test_main("describe", fill); }
