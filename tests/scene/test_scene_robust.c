/* SPDX-License-Identifier: Apache-2.0
 *
 * Damaged scenes and failing memory: a status and a message, never a crash, a leak or a half-made scene. The sanitizers'
 * run of this program is where overruns would show. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "harness.h"
#include "nephos/scene.h"

static const char whole[] =
    "%YAML 1.1\n"
    "---\n"
    "nephos: 1 # v\xC3\xA9rsion\n"
    "camera:\n"
    "  type: perspective\n"
    "  resolution: [400, 300]\n"
    "  position: &p [0, -4, 1]\n"
    "  look_at: [0, 0, 0.5]\n"
    "  up: [0, 0, 1]\n"
    "  fov: 35\n"
    "  crop: [0, 0, 100, 100]\n"
    "media:\n"
    "  - name: \"cl\\u00F6ud\"\n"
    "    box: [[0, 0, 0], [1, 1, 1]]\n"
    "    transform: [{scale: 2}, {rotate: {axis: [0, 0, 1], angle: 30}}, {translate: *p},\n"
    "      {matrix: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]}]\n"
    "    extinction: 40\n"
    "    albedo: [1, 0.99, 0.98]\n"
    "    phase: {type: two_lobe, g: {frames: &f [0, 9], values: [.1, 0.85]}, g2: -0.3, weight: {frames: *f, values: [0.9, 0]}}\n"
    "  - layer: [0, 1e3]\n"
    "    scattering: 1\n"
    "    absorption: [1, 2, 3]\n"
    "lights:\n"
    "  - {type: sun, elevation: 30, azimuth: 120, irradiance: [9, 8, 7], angular_diameter: 0.53}\n"
    "  - type: constant\n"
    "    radiance: 0.5\n"
    "    hemisphere: upper\n"
    "  - {\"type\": \"point\", 'position': [1, 2, 3], intensity: 4}\n"
    "render: {samples: 64, seed: 1}\n"
    "...\n";

/* Runs on an exact copy on the heap, so that a byte read beyond the end is seen. Returns the status. */
static NphStatus try_bytes(NphContext *context, const char *bytes, size_t size) {
    char *copy = malloc(size ? size : 1);
    ck_assert_ptr_nonnull(copy);
    memcpy(copy, bytes, size);
    NphScene *scene = NULL;
    uint64_t before = nph_context_bytes(context);
    NphStatus status = nph_scene_parse(context, copy, size, "s", NULL, &scene);
    free(copy);
    const char *messages = nph_test_messages();
    ck_assert_msg((status == NPH_OK) == (scene != NULL), "%s", messages);
    ck_assert_msg(status == NPH_OK || status == NPH_BAD_SCENE, "%d", status);
    if (status == NPH_BAD_SCENE) ck_assert_msg(strncmp(messages, "s:", 2) == 0, "%s", messages);
    nph_scene_free(context, scene);
    ck_assert_uint_eq(nph_context_bytes(context), before);
    return status;
}

START_TEST(a_scene_cut_at_any_byte_is_read_or_refused) {
    NphContext *context = nph_test_context(1);
    size_t size = strlen(whole);
    int read = 0;
    for (size_t i = 0; i <= size; i++) read += try_bytes(context, whole, i) == NPH_OK;
    ck_assert_int_eq(try_bytes(context, whole, size), NPH_OK);
    ck_assert_int_lt(read, 250); /* most cuts lose something required or close nothing */
    nph_test_context_close(context);
}
END_TEST

static uint32_t next_random(uint64_t *state) {
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(*state >> 33);
}

START_TEST(flipped_bits_and_bytes_never_crash_or_leak) {
    NphContext *context = nph_test_context(1);
    static const char odd[] = "[]{}:,-&*!|>'\"%@`#\n\t\0\xFF\xC3 09e.~?";
    char bytes[sizeof whole];
    uint64_t state = 7;
    for (int round = 0; round < 4000; round++) {
        memcpy(bytes, whole, sizeof whole);
        int edits = 1 + (int)(next_random(&state) % 4);
        for (int i = 0; i < edits; i++) {
            size_t at = next_random(&state) % strlen(whole);
            if (round & 1) bytes[at] ^= (char)(1u << (next_random(&state) & 7));
            else bytes[at] = odd[next_random(&state) % (sizeof odd - 1)];
        }
        try_bytes(context, bytes, strlen(whole));
    }
    nph_test_context_close(context);
}
END_TEST

START_TEST(moved_and_repeated_lines_never_crash_or_leak) {
    NphContext *context = nph_test_context(1);
    const char *lines[64];
    size_t lengths[64];
    int count = 0;
    uint64_t state = 11;
    for (const char *at = whole; *at; at = strchr(at, '\n') + 1) {
        lines[count] = at;
        lengths[count++] = (size_t)(strchr(at, '\n') + 1 - at);
    }
    for (int round = 0; round < 1500; round++) {
        char text[8192];
        size_t used = 0;
        for (int i = 0; i < count; i++) {
            int line = next_random(&state) % 8 ? i : (int)(next_random(&state) % (uint32_t)count);
            if (next_random(&state) % 12 == 0) continue;
            if (used + lengths[line] > sizeof text) break;
            memcpy(text + used, lines[line], lengths[line]);
            used += lengths[line];
        }
        try_bytes(context, text, used);
    }
    nph_test_context_close(context);
}
END_TEST

START_TEST(nested_brackets_by_the_hundred_thousand_are_refused_at_once) {
    NphContext *context = nph_test_context(1);
    static const char *const units[] = {"[", "{a: ", "- ", "? ", "[ a ,", "&a [", "!a [", "{a: &b "};
    static char bytes[1 << 20];
    for (size_t u = 0; u < sizeof units / sizeof units[0]; u++) {
        size_t length = strlen(units[u]), used = 0;
        for (; used + length < 400000; used += length) memcpy(bytes + used, units[u], length);
        ck_assert_int_eq(try_bytes(context, bytes, used), NPH_BAD_SCENE);
    }
    nph_test_context_close(context);
}
END_TEST

/* Every allocation of a parse in turn fails; the last round, where none does, succeeds. */
static void fail_every_allocation(const char *text, const char *folder, NphStatus at_last) {
    for (uint64_t n = 1;; n++) {
        NphSettings settings;
        nph_settings_default(&settings);
        settings.threads = 1;
        settings.fail_allocation = n;
        NphContext *context = NULL;
        ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
        NphScene *scene = NULL;
        NphStatus status = nph_scene_parse(context, text, strlen(text), "s", folder, &scene);
        int reached = nph_context_allocations(context) >= n;
        ck_assert_int_eq(status, reached ? NPH_NO_MEMORY : at_last);
        ck_assert((status == NPH_OK) == (scene != NULL));
        nph_scene_free(context, scene);
        ck_assert_uint_eq(nph_context_bytes(context), 0);
        nph_context_close(context);
        if (!reached) break;
        ck_assert_uint_lt(n, 10000);
    }
}

START_TEST(any_allocation_that_fails_is_reported_and_nothing_leaks) {
    fail_every_allocation(whole, NULL, NPH_OK);
    fail_every_allocation("nephos: 1\nmedia:\n- {density: {file: no.npy, box: [[0,0,0],[1,1,1]]}}\n- 3\n", NULL, NPH_BAD_SCENE);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, a_scene_cut_at_any_byte_is_read_or_refused);
    tcase_add_test(cases, flipped_bits_and_bytes_never_crash_or_leak);
    tcase_add_test(cases, moved_and_repeated_lines_never_crash_or_leak);
    tcase_add_test(cases, nested_brackets_by_the_hundred_thousand_are_refused_at_once);
    tcase_add_test(cases, any_allocation_that_fails_is_reported_and_nothing_leaks);
}

int main(void) { return nph_test_main("scene_robust", fill); }
