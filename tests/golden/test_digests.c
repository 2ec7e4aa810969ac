/* SPDX-License-Identifier: Apache-2.0
 *
 * The pinned digests hold, and where one has moved since a release, CHANGELOG.md says so. */
#define _POSIX_C_SOURCE 200809L
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "harness.h"
#include "io/file.h"
#include "oracle/manifest.h"
#include "pinned.h"

static char scenes[PINNED_SCENES][DIGEST_NAME];
static int scene_count;

enum { SHOWN = 12 };

/* The first rows that differ, in the order in which stages run; count: of all that do. */
static int compare(const Pinned *pinned, const Pinned *now, char *text, size_t size) {
    int count = 0;
    size_t used = 0;
    for (int r = 0; r < now->count; r++) {
        const PinnedRow *row = &now->rows[r], *old = pinned_find(pinned, row);
        char line[1024];
        if (old && strcmp(old->row.digest, row->row.digest) == 0) continue;
        if (old) pinned_difference(old, row, line, sizeof line);
        else snprintf(line, sizeof line, "%s %s %s is not pinned", row->method, row->row.stage, row->row.buffer);
        if (count++ < SHOWN && used < size) used += (size_t)snprintf(text + used, size - used, "%s\n", line);
    }
    for (int r = 0; r < pinned->count; r++) {
        const PinnedRow *row = &pinned->rows[r];
        if (pinned_find(now, row)) continue;
        if (count++ < SHOWN && used < size)
            used += (size_t)snprintf(text + used, size - used, "%s %s %s is pinned, but nothing writes it\n", row->method,
                                     row->row.stage, row->row.buffer);
    }
    return count;
}

static void check_scene(const char *name, int threads) {
    static char text[SHOWN * 1024];
    NphContext *context = nph_test_context(threads);
    Pinned pinned, now;
    ck_assert_msg(pinned_read(context, nph_test_path("."), name, &pinned) == NPH_OK, "%s; write it with scripts/golden_digests",
                  nph_test_messages());
    ck_assert_msg(pinned_take(context, nph_test_path("."), name, &now) == NPH_OK, "%s", nph_test_messages());
    int count = compare(&pinned, &now, text, sizeof text);
    ck_assert_msg(count == 0, "%s: %d digests are not the pinned ones (docs/determinism.md, Pinned digests); the first:\n%s", name,
                  count, text);
    nph_free(context, pinned.rows);
    nph_free(context, now.rows);
    nph_test_context_close(context);
}

START_TEST(every_stage_of_every_scene_writes_what_is_pinned) {
    if (_i > 0 && !nph_test_long("the pinned digests of a scene")) return;
    check_scene(scenes[_i], 0);
}
END_TEST

START_TEST(neither_threads_nor_vectors_move_a_digest) {
    static const char *const levels[] = {"base", "avx2", "avx512"};
    for (int k = 0; k < 3; k++) {
        setenv("NEPHOS_ISA", levels[k], 1);
        check_scene("cube_g070", 2 * k + 1);
    }
}
END_TEST

/* The digest of a row is that of the launches' digests: what a manifest holds is enough to make it. */
static void digest_of_dump(NphContext *context, const NphManifest *manifest, const char *stage, const char *buffer, char text[]) {
    XXH128_canonical_t digests[4096];
    size_t count = 0;
    for (int l = 0; l < manifest->launch_count; l++) {
        const NphManifestLaunch *launch = &manifest->launches[l];
        NphArray array;
        for (int o = 0; o < launch->output_count; o++) {
            if (strcmp(launch->stage, stage) != 0 || strcmp(launch->outputs[o].buffer, buffer) != 0) continue;
            ck_assert_uint_lt(count, 4096);
            ck_assert_int_eq(nph_manifest_array(context, manifest, launch->outputs[o].file, &array), NPH_OK);
            size_t bytes = (size_t)nph_array_count(&array) * nph_type_size(array.type);
            XXH128_canonicalFromHash(&digests[count++], XXH3_128bits(array.data, bytes));
            nph_array_free(context, &array);
        }
    }
    nph_digest_text(digests, count * sizeof *digests, text);
}

START_TEST(a_dump_has_the_pinned_digests) {
    static const char *const name = "cube_g070";
    NphContext *context = nph_test_context(0);
    NphScene *scene = NULL;
    NphFilm *film = NULL;
    NphRenderOptions options = pinned_options("path");
    NphDumpOptions dump;
    NphManifest manifest;
    Pinned pinned;
    char digest[NPH_DIGEST_TEXT], command[700];
    int rows = 0;
    nph_dump_options_default(&dump);
    dump.folder = nph_test_temporary("dump");
    dump.stage = "path.track";
    ck_assert_int_eq(pinned_scene(context, nph_test_path("."), name, &scene), NPH_OK);
    ck_assert_msg(nph_dump(context, scene, name, &options, &dump, &film, NULL) == NPH_OK, "%s", nph_test_messages());
    ck_assert_int_eq(nph_manifest_read(context, dump.folder, &manifest), NPH_OK);
    ck_assert_int_eq(pinned_read(context, nph_test_path("."), name, &pinned), NPH_OK);
    for (int r = 0; r < pinned.count; r++) {
        const DigestRow *row = &pinned.rows[r].row;
        if (strcmp(row->stage, dump.stage) != 0) continue;
        digest_of_dump(context, &manifest, row->stage, row->buffer, digest);
        ck_assert_str_eq(digest, row->digest);
        rows++;
    }
    ck_assert_int_ge(rows, 5);
    nph_free(context, pinned.rows);
    nph_manifest_free(context, &manifest);
    nph_film_free(context, film);
    nph_scene_free(context, scene);
    snprintf(command, sizeof command, "rm -rf '%s'", dump.folder);
    ck_assert_int_eq(system(command), 0);
    nph_test_context_close(context);
}
END_TEST

static const char *const story = "# Changes\n\n## 0.3.0, not released yet\n\n- Other digests: path.track, path.scatter of path (the\n"
                                 "  last release with the old ones is 0.2.0).\n- Other things of path.escape, 0.2.0.\n\n"
                                 "## 0.2.0, 1 May\n\n- digest: path.generate 0.1.0 path\n\n## 0.1.0, 1 April\n";

static int tells(const char *stage, const char *since, const char *before) {
    PinnedRow row = {.method = "path"};
    snprintf(row.row.stage, sizeof row.row.stage, "%s", stage);
    snprintf(row.since, sizeof row.since, "%s", since);
    snprintf(row.before, sizeof row.before, "%s", before);
    return changelog_tells(story, &row);
}

START_TEST(a_line_of_the_changelog_must_name_stage_and_last_release) {
    char release[16];
    int released = -1;
    changelog_newest(story, release);
    ck_assert_str_eq(release, "0.2.0");
    ck_assert(changelog_section(story, "0.3.0", &released) && released == 0);
    ck_assert(changelog_section(story, "0.1.0", &released) && released == 1);
    ck_assert(!changelog_section(story, "0.1", &released));
    ck_assert(tells("path.track", "0.3.0", "0.2.0") && tells("path.scatter", "0.3.0", "0.2.0"));
    ck_assert(tells("path.generate", "0.2.0", "0.1.0"));
    ck_assert(tells("path.escape", "0.3.0", "")); /* nothing was released with another */
    ck_assert(!tells("path.escape", "0.3.0", "0.2.0"));  /* the line does not speak of digests */
    ck_assert(!tells("path.generate", "0.3.0", "0.2.0")); /* another release's section */
    ck_assert(!tells("path.track", "0.3.0", "0.1.0"));
}
END_TEST

START_TEST(the_changelog_tells_of_every_digest_that_has_moved) {
    NphContext *context = nph_test_context(1);
    char *changelog = NULL;
    size_t size;
    ck_assert_int_eq(nph_file_read(context, nph_test_path("CHANGELOG.md"), &changelog, &size), NPH_OK);
    for (int s = 0; s < scene_count; s++) {
        Pinned pinned;
        int released;
        ck_assert_msg(pinned_read(context, nph_test_path("."), scenes[s], &pinned) == NPH_OK, "%s", nph_test_messages());
        for (int r = 0; r < pinned.count; r++) {
            const PinnedRow *row = &pinned.rows[r];
            ck_assert_msg(changelog_section(changelog, row->since, &released), "CHANGELOG.md has no section of %s", row->since);
            ck_assert_msg(changelog_tells(changelog, row), "CHANGELOG.md, %s, must say: Other digests: %s of %s; the last release "
                          "with the old ones is %s", row->since, row->row.stage, row->method, row->before);
        }
        nph_free(context, pinned.rows);
    }
    nph_free(context, changelog);
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_digest_that_moves_tells_cells_and_ulp) {
    PinnedRow a = {.method = "path", .since = "0.1.0"}, b;
    char text[1024];
    float values[3] = {1.0f, -0.0f, 2.0f};
    a.row.type = NPH_F32;
    a.row.cell_count = 3;
    for (int i = 0; i < 3; i++) {
        a.row.cells[i] = (DigestCell){1, 2, (uint32_t)(10 * i), 0};
        memcpy(&a.row.cells[i].bits, &values[i], sizeof values[i]);
    }
    b = a;
    b.row.cells[1].bits = 5;            /* from -0 to the fifth number above 0 */
    b.row.cells[2].index = 21;          /* kept by one of them alone */
    pinned_difference(&a, &b, text, sizeof text);
    ck_assert_msg(strstr(text, "of 2 cells kept 1 moved, the most by 5 ulp: batch 1 launch 2 element 10") != NULL, "%s", text);
    b.row.cells[0].bits -= 7;
    pinned_difference(&a, &b, text, sizeof text);
    ck_assert_msg(strstr(text, "2 moved, the most by 7 ulp: batch 1 launch 2 element 0 from 1 to 0.99999958") != NULL, "%s", text);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_loop_test(cases, every_stage_of_every_scene_writes_what_is_pinned, 0, scene_count);
    tcase_add_test(cases, neither_threads_nor_vectors_move_a_digest);
    tcase_add_test(cases, a_dump_has_the_pinned_digests);
    tcase_add_test(cases, a_line_of_the_changelog_must_name_stage_and_last_release);
    tcase_add_test(cases, the_changelog_tells_of_every_digest_that_has_moved);
    tcase_add_test(cases, a_digest_that_moves_tells_cells_and_ulp);
}

int main(void) {
    scene_count = pinned_scenes(nph_test_path("."), scenes);
    return nph_test_main("digests", fill);
}
