/* SPDX-License-Identifier: Apache-2.0
 *
 * Dumps that end early: a full disk (a limit on the size of files fails in the same calls), the limit of the dump, an interruption;
 * and digests, the same from every vector level. */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include "harness.h"
#include "io/volume.h"
#include "nephos/scene.h"
#include "nephos/verify.h"
#include "oracle/digest.h"
#include "oracle/manifest.h"

#define BOX "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 6, albedo: 0.95, phase: {type: hg, g: 0.8}}\n" \
            "lights:\n  - {type: sun, direction: [-1, 0.2, 0.3], irradiance: 3}\n"
static const char two_tiles[] =
    "nephos: 1\ncamera: {type: perspective, resolution: [18, 9], position: [-2, -1.5, 1.2], look_at: [0.5, 0.5, 0.5], fov: 40}\n" BOX;
/* The box in the first of nine tiles; nothing in those around the middle. */
static const char box_at_the_edge[] =
    "nephos: 1\ncamera: {type: orthographic, resolution: [144, 16], position: [4.5, -3, 0.5], look_at: [4.5, 0.5, 0.5], extent: 1}\n" BOX;

static NphScene *parse(NphContext *context, const char *text) {
    NphScene *scene = NULL;
    NphStatus status = nph_scene_parse(context, text, strlen(text), "test.yaml", ".", &scene);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    return scene;
}

static NphStatus dump(NphContext *context, const NphScene *scene, const char *folder, uint64_t limit_bytes, NphFilm **film) {
    NphRenderOptions options;
    NphDumpOptions what;
    nph_render_options_default(&options);
    options.samples = 16;
    nph_dump_options_default(&what);
    what.folder = folder;
    if (limit_bytes) what.limit_bytes = limit_bytes;
    return nph_dump(context, scene, "test.yaml", &options, &what, film, NULL);
}

static int has(const char *folder, const char *name) {
    char path[4200];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return access(path, F_OK) == 0;
}

static void remove_folder(const char *folder) {
    char command[4200];
    snprintf(command, sizeof command, "rm -r '%s'", folder);
    ck_assert_int_eq(system(command), 0);
}

static void limit_file_size(rlim_t bytes) {
    struct rlimit limit;
    signal(SIGXFSZ, SIG_IGN);
    ck_assert_int_eq(getrlimit(RLIMIT_FSIZE, &limit), 0);
    limit.rlim_cur = bytes < limit.rlim_max ? bytes : limit.rlim_max;
    ck_assert_int_eq(setrlimit(RLIMIT_FSIZE, &limit), 0);
}

static long bytes_of(const char *folder, const char *name) {
    char path[4200];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "rb");
    ck_assert_ptr_nonnull(file);
    fseek(file, 0, SEEK_END);
    long bytes = ftell(file);
    fclose(file);
    return bytes;
}

/* In the middle of a batch's file, and in its last bytes. */
START_TEST(a_full_disk_ends_the_run_and_leaves_no_manifest) {
    for (int threads = 1; threads <= 2; threads++) {
        NphContext *context = nph_test_context(threads);
        NphScene *scene = parse(context, two_tiles);
        NphFilm *film = NULL;
        const char *folder = nph_test_temporary("full");
        ck_assert_int_eq(dump(context, scene, folder, 0, &film), NPH_OK);
        const long sizes[] = {bytes_of(folder, "000000.npys"), bytes_of(folder, "000001.npys")};
        const long limits[] = {sizes[0] / 2, (sizes[0] > sizes[1] ? sizes[0] : sizes[1]) - 1};
        nph_film_free(context, film);
        remove_folder(folder);
        for (int l = 0; l < 2; l++) {
            film = NULL;
            nph_test_messages();
            limit_file_size((rlim_t)limits[l]);
            NphStatus status = dump(context, scene, folder, 0, &film);
            limit_file_size(RLIM_INFINITY);
            const char *said = nph_test_messages();
            ck_assert_msg(status == NPH_BAD_OUTPUT, "status %d: %s", (int)status, said);
            ck_assert_msg(strstr(said, ".npys: cannot be written: ") && strstr(said, folder), "%s", said);
            ck_assert(!has(folder, "manifest.json"));
            nph_film_free(context, film);
            remove_folder(folder);
        }
        nph_scene_free(context, scene);
        nph_test_context_close(context);
    }
}
END_TEST

START_TEST(a_manifest_that_cannot_be_written_is_told) {
    NphContext *context = nph_test_context(1);
    NphScene *scene = parse(context, box_at_the_edge);
    NphRenderOptions options;
    NphDumpOptions what;
    NphFilm *film = NULL;
    nph_render_options_default(&options);
    options.samples = 16;
    nph_dump_options_default(&what);
    what.folder = nph_test_temporary("manifest");
    what.batch = 99; /* none of nine: no arrays */
    limit_file_size(2000);
    NphStatus status = nph_dump(context, scene, "test.yaml", &options, &what, &film, NULL);
    limit_file_size(RLIM_INFINITY);
    const char *said = nph_test_messages();
    ck_assert_msg(status == NPH_BAD_OUTPUT, "status %d: %s", (int)status, said);
    ck_assert_msg(strstr(said, "manifest.json: cannot be written: File too large"), "%s", said);
    ck_assert(!has(what.folder, "manifest.json"));
    nph_film_free(context, film);
    remove_folder(what.folder);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

/* The forecast, from the middle, lets it pass. */
START_TEST(a_dump_stops_where_it_grows_beyond_its_limit) {
    NphContext *context = nph_test_context(2);
    NphScene *scene = parse(context, box_at_the_edge);
    NphFilm *film = NULL;
    const char *folder = nph_test_temporary("grows");
    ck_assert_int_eq(dump(context, scene, folder, 0, &film), NPH_OK);
    long edge = bytes_of(folder, "000000.npys"), middle = bytes_of(folder, "000004.npys");
    ck_assert_int_gt(edge, 2 * middle);
    nph_film_free(context, film);
    remove_folder(folder);
    film = NULL;
    NphStatus status = dump(context, scene, folder, (uint64_t)(9 * middle + (edge - middle) / 2), &film);
    const char *said = nph_test_messages();
    ck_assert_msg(status == NPH_NO_MEMORY && strstr(said, "the dump grows beyond its limit of"), "status %d: %s", (int)status, said);
    ck_assert_ptr_null(film);
    ck_assert(has(folder, "000000.npys") && !has(folder, "manifest.json"));
    remove_folder(folder);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

static struct {
    NphContext *context;
    int calls, last; /* interrupted at the last one */
} stopped;

static void interrupt(void *user, const char *task, double done, double total, double seconds_left) {
    const struct timespec wait = {0, 120000000}; /* longer than progress is held back */
    (void)user, (void)task, (void)seconds_left;
    ck_assert(++stopped.calls > 1 || done >= total);
    nanosleep(&wait, NULL);
    if (stopped.calls == stopped.last) nph_interrupt(stopped.context);
}

/* The launches in the manifest, all of batch 0; their arrays are whole. */
static int whole_launches(NphContext *context, const char *folder) {
    NphManifest manifest;
    ck_assert_int_eq(nph_manifest_read(context, folder, &manifest), NPH_OK);
    int count = manifest.launch_count;
    for (int l = 0; l < count; l++) {
        const NphManifestLaunch *launch = &manifest.launches[l];
        ck_assert_int_eq(launch->batch, 0);
        for (int o = 0; o < launch->output_count; o++) {
            NphArray array;
            ck_assert_int_eq(nph_manifest_array(context, &manifest, launch->outputs[o].file, &array), NPH_OK);
            nph_array_free(context, &array);
        }
    }
    nph_manifest_free(context, &manifest);
    return count;
}

START_TEST(an_interrupted_dump_names_what_there_is) {
    static const struct { int at; uint64_t limit_bytes; int is_begun, most, least; } cases[] = {
        {1, 0, 1, 0, 0},           /* after the forecast from one tile */
        {2, 0, 1, 100000, 10},     /* after the first tile of the run */
        {2, 32 << 20, 0, 0, 0}};   /* in the middle of the forecast from several */
    NphSettings settings;
    nph_settings_default(&settings);
    settings.threads = 1;
    settings.progress = interrupt;
    stopped.calls = 0;
    stopped.last = cases[_i].at;
    ck_assert_int_eq(nph_context_open(&stopped.context, &settings), NPH_OK);
    NphContext *context = stopped.context;
    NphScene *scene = parse(context, two_tiles);
    NphFilm *film = NULL;
    const char *folder = nph_test_temporary("stopped");
    ck_assert_int_eq(dump(context, scene, folder, cases[_i].limit_bytes, &film), NPH_INTERRUPTED);
    nph_resume(context);
    ck_assert_int_eq(access(folder, F_OK) == 0, cases[_i].is_begun);
    ck_assert_int_eq(film != NULL, cases[_i].is_begun);
    if (cases[_i].is_begun) {
        int count = whole_launches(context, folder);
        ck_assert_msg(count >= cases[_i].least && count <= cases[_i].most, "%d launches", count);
        remove_folder(folder);
    }
    nph_film_free(context, film);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

/* Rows with gaps, of every length around the blocks and the lanes of XXH3, against the bytes without gaps. */
START_TEST(every_vector_level_digests_the_same) {
    enum { MOST = 2100, ROWS = 3, STRIDE = 2200 };
    static unsigned char data[ROWS * STRIDE], dense[ROWS * MOST];
    NphContext *context = nph_test_context(1);
    for (int i = 0; i < ROWS * STRIDE; i++) data[i] = (unsigned char)((unsigned)i * 2654435761u >> 13);
    for (int isa = NPH_ISA_BASE; isa <= (int)nph_context_isa(context); isa++)
        for (size_t row = 0; row <= MOST; row += row < 300 ? 1 : 37) {
            char expected[NPH_DIGEST_TEXT], text[NPH_DIGEST_TEXT];
            for (size_t r = 0; r < ROWS; r++) memcpy(dense + r * row, data + r * STRIDE, row);
            nph_digest_text(dense, ROWS * row, expected);
            nph_digest_pick((NphIsa)isa)(data, ROWS, row, STRIDE, text);
            ck_assert_msg(strcmp(text, expected) == 0, "%s, %zu bytes: %s, not %s", nph_isa_name((NphIsa)isa), row, text, expected);
        }
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, a_full_disk_ends_the_run_and_leaves_no_manifest);
    tcase_add_test(cases, a_manifest_that_cannot_be_written_is_told);
    tcase_add_test(cases, a_dump_stops_where_it_grows_beyond_its_limit);
    tcase_add_loop_test(cases, an_interrupted_dump_names_what_there_is, 0, 3);
    tcase_add_test(cases, every_vector_level_digests_the_same);
}

int main(void) { return nph_test_main("dump", fill); }
