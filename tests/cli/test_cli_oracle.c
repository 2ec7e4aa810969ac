/* SPDX-License-Identifier: Apache-2.0
 *
 * render --dump, stage, verify, and the client examples/numpy: the commands of docs/oracle.md, in its order, from the source's root. */
#include <sys/stat.h>

#include "cli/program.h"
#include "oracle/manifest.h"

static char reference[600], mine[600], tracked[600], tolerances[700];

/* Where the commands of the page would be typed. */
static void enter_root(void) {
    const char *root = getenv("NEPHOS_SOURCE_ROOT");
    ck_assert_int_eq(chdir(root ? root : "."), 0);
    snprintf(reference, sizeof reference, "%s", file_of("reference"));
    snprintf(mine, sizeof mine, "%s", file_of("mine"));
    snprintf(tracked, sizeof tracked, "%s", file_of("tracked"));
}

static void remove_folders(void) {
    char command[2000];
    snprintf(command, sizeof command, "rm -rf '%s' '%s' '%s'", reference, mine, tracked);
    ck_assert_int_eq(system(command), 0);
}

#define DUMP "render", "reference/scenes/cube_g070.yaml", "-q", "-o", file_of("cube.exr"), "--spp", "16", "--crop", "96,96,160,144"

/* A Python with NumPy, or NULL. */
static const char *python(void) {
    static const char *const names[] = {"python3", "/usr/bin/python3"};
    for (int i = 0; i < 2; i++) {
        char command[128];
        snprintf(command, sizeof command, "%s -c 'import numpy' 2>/dev/null", names[i]);
        if (system(command) == 0) return names[i];
    }
    return NULL;
}

static int run_numpy(const char *mistake) {
    char command[2000];
    snprintf(command, sizeof command, "%s examples/numpy/track.py '%s' '%s' %s", python(), reference, mine, mistake);
    return system(command);
}

/* What stands in `tracked` against a launch of the dump. */
static void check_that_stage_wrote_the_dumps(const char *buffer, int64_t batch, int64_t number, const char *where) {
    char path[700];
    NphContext *context = nph_test_context(1);
    NphManifest manifest;
    NphArray ours, dumped;
    ck_assert_int_eq(nph_manifest_read(context, reference, &manifest), NPH_OK);
    const NphManifestLaunch *launch = nph_manifest_find(&manifest, batch, number);
    ck_assert_ptr_nonnull(launch);
    int o = 0;
    while (o < launch->output_count && strcmp(launch->outputs[o].buffer, buffer) != 0) o++;
    ck_assert_int_lt(o, launch->output_count);
    ck_assert_ptr_nonnull(strstr(launch->outputs[o].file, where));
    ck_assert_int_eq(nph_manifest_array(context, &manifest, launch->outputs[o].file, &dumped), NPH_OK);
    snprintf(path, sizeof path, "%s/%s.npy", tracked, buffer);
    ck_assert_int_eq(nph_array_read_npy(context, path, &ours), NPH_OK);
    ck_assert(nph_array_count(&ours) > 0 && nph_array_count(&ours) == nph_array_count(&dumped));
    ck_assert_mem_eq(ours.data, dumped.data, (size_t)nph_array_count(&ours) * nph_type_size(ours.type));
    nph_array_free(context, &ours);
    nph_array_free(context, &dumped);
    nph_manifest_free(context, &manifest);
    nph_test_context_close(context);
}

START_TEST(a_dump_is_verified_and_its_stages_run_alone) {
    if (!has_altered()) return;
    char path[700];
    enter_root();
    RUN_EXPECT(0, DUMP);
    RUN_EXPECT(0, "render", "reference/scenes/cube_g070.yaml", "-q", "-o", file_of("plain.exr"), "--spp", "16", "--crop", "96,96,160,144");
    RUN_EXPECT(0, DUMP, "--dump", reference);
    ck_assert_msg(same_files(file_of("plain.exr"), file_of("cube.exr")), "the picture of a run that is dumped is another one");
    RUN_EXPECT(5, DUMP, "--dump", reference);
    const Ran *run = program_run((const char *const[]){"verify", reference, reference, NULL});
    ck_assert_int_eq(run->status, 0);
    ck_assert_ptr_nonnull(strstr(run->out, "passed: "));
    run = program_run((const char *const[]){"info", reference, NULL});
    ck_assert_int_eq(run->status, 0);
    ck_assert_ptr_nonnull(strstr(run->out, "path.track"));
    RUN_EXPECT(0, "stage", "path.track", "--from", reference, "--launch", "5:1", "-o", tracked);
    check_that_stage_wrote_the_dumps("path.distance", 5, 1, "000005.npys@");
    snprintf(path, sizeof path, "path.ray=%s/path.distance.npy", tracked);
    run = program_run((const char *const[]){"stage", "path.track", "--from", reference, "--launch", "5:1", "--in", path, "-o", tracked, NULL});
    ck_assert_int_eq(run->status, 4);
    ck_assert_ptr_nonnull(strstr(run->err, "input path.ray: 1 axes, expected [6][path]"));
    RUN_EXPECT(4, "stage", "path.scatter", "--from", reference, "--launch", "5:1", "-o", tracked);
    RUN_EXPECT(2, "stage", "path.track", "--from", reference, "-o", tracked);
    RUN_EXPECT(2, "stage", "path.trak", "--scene", "reference/scenes/cube_g070.yaml", "-o", tracked);
    RUN_EXPECT(2, "stage", "path.generate", "--scene", "reference/scenes/cube_g070.yaml", "--set", "tiel=3", "-o", tracked);
    RUN_EXPECT(0, "stage", "path.generate", "--scene", "reference/scenes/cube_g070.yaml", "--spp", "16", "--set", "tile=136", "-q", "-o", tracked);
    remove_folders();
}
END_TEST

START_TEST(majorants_run_alone_on_the_density_of_a_dump) {
    enter_root();
    RUN_EXPECT(0, "render", "reference/scenes/smoke.yaml", "-q", "-o", file_of("smoke.exr"), "--spp", "16", "--crop", "192,144,200,152", "--dump",
               reference, "--dump-select", "stage=path.generate");
    RUN_EXPECT(0, "stage", "path.majorant", "--from", reference, "--launch", "-1:0", "-q", "-o", tracked);
    check_that_stage_wrote_the_dumps("path.bound", -1, 0, "scene.npys@");
    RUN_EXPECT(4, "stage", "path.majorant", "--from", reference, "--launch", "-1:0", "--set", "medium=1", "-o", tracked);
    remove_folders();
}
END_TEST

START_TEST(a_photon_map_is_dumped_and_its_stages_run_alone) {
    static const char *const stages[][3] = {{"photonmap.pilot", "photonmap.count", "-1:0"}, {"photonmap.trace", "photonmap.power", "3:2"},
                                            {"photonmap.tree", "photonmap.node_photon", "3:3"}, {"photonmap.march", "photonmap.image", "3:4"}};
    enter_root();
    RUN_EXPECT(0, DUMP, "--dump", reference, "--method", "photonmap", "-D", "photonmap.photons=2000");
    RUN_EXPECT(0, "render", "reference/scenes/cube_g070.yaml", "-q", "-o", file_of("plain.exr"), "--spp", "16", "--crop", "96,96,160,144",
               "--method", "photonmap", "-D", "photonmap.photons=2000");
    ck_assert_msg(same_files(file_of("plain.exr"), file_of("cube.exr")), "the picture of a run that is dumped is another one");
    for (int s = 0; s < 4; s++) {
        RUN_EXPECT(0, "stage", stages[s][0], "--from", reference, "--launch", stages[s][2], "-q", "-o", tracked);
        check_that_stage_wrote_the_dumps(stages[s][1], atoi(stages[s][2]), atoi(strchr(stages[s][2], ':') + 1),
                                         s == 0 ? "scene.npys@" : "000003.npys@");
    }
    RUN_EXPECT(0, "verify", reference, reference, "--ulp", "0");
    RUN_EXPECT(4, "stage", "photonmap.march", "--from", reference, "--launch", "3:3", "-q", "-o", tracked);
    remove_folders();
    RUN_EXPECT(0, DUMP, "--dump", reference, "--method", "photonmap", "-D", "photonmap.photons=2000", "-D", "photonmap.emitted=500",
               "--dump-select", "stage=photonmap.march");
    const Ran *run = program_run((const char *const[]){"stage", "photonmap.pilot", "--scene", "reference/scenes/cube_g070.yaml", "--method",
                                                       "photonmap", "-D", "photonmap.emitted=500", "-q", "-o", tracked, NULL});
    ck_assert_int_eq(run->status, 4);
    ck_assert_ptr_nonnull(strstr(run->err, "photonmap.emitted says how many"));
    remove_folders();
}
END_TEST

START_TEST(what_cannot_be_dumped_is_refused) {
    enter_root();
    RUN_EXPECT(6, DUMP, "--dump", reference, "--dump-limit", "1M");
    RUN_EXPECT(2, DUMP, "--dump", reference, "--dump-select", "stage=path.trak");
    RUN_EXPECT(2, DUMP, "--dump", reference, "--dump-select", "pixel=3");
    RUN_EXPECT(2, DUMP, "--dump", reference, "--dump-select", "pixel=3,4");
    RUN_EXPECT(2, DUMP, "--dump-select", "stage=path.track");
    RUN_EXPECT(2, DUMP, "--dump", reference, "--method", "photonmap", "--dump-select", "pixel=120,100");
    RUN_EXPECT(2, DUMP, "--dump", reference, "--method", "light", "--dump-select", "pixel=120,100");
    RUN_EXPECT(6, DUMP, "--dump", reference, "--method", "light", "--dump-limit", "1M");
    ck_assert(!exists(reference));
    write_text(reference, "a file");
    RUN_EXPECT(5, DUMP, "--dump", reference);
    RUN_EXPECT(4, "verify", reference, reference);
    write_text(reference, "");
    ck_assert_int_eq(unlink(reference), 0);
    RUN_EXPECT(4, "verify", reference, reference);
}
END_TEST

/* The reference's path.track as a candidate, of which one output has another name or another array: the reference's of another
 * buffer, one that is cut short, or none. */
static const struct {
    const char *title;
    int format, status, is_torn;
    const char *stage, *output, *name, *array, *words;
} candidates[] = {
    {"good", 1, 0, 0, "path.track", "path.distance", "path.distance", "path.distance", "passed: 1 launches compared"},
    {"another format", 2, 4, 0, "path.track", "path.distance", "path.distance", "path.distance",
     "mine/manifest.json:1: is no manifest of a dump: expected \"nephos_dump\": 1"},
    {"unknown stage", 1, 4, 0, "path.trak", "path.distance", "path.distance", "path.distance",
     "mine/manifest.json: batch 5 launch 1: method path has no stage path.trak"},
    {"unknown buffer", 1, 1, 0, "path.track", "path.distance", "path.distanse", "path.distance", "batch 5 launch 1: missing, expected f32 [4096]"},
    {"wrong type", 1, 1, 0, "path.track", "path.distance", "path.distance", "path.medium", "batch 5 launch 1: i32 [4096], expected f32 [4096]"},
    {"wrong shape", 1, 1, 0, "path.track", "path.medium", "path.medium", "path.colliding", "batch 5 launch 1: i32 [4075], expected i32 [4096]"},
    {"torn array", 1, 4, 1, "path.track", "path.distance", "path.distance", "path.distance", "mine/torn.npy: byte 128: 72 bytes follow the header"},
    {"missing array", 1, 4, 0, "path.track", "path.distance", "path.distance", NULL, "mine/nowhere.npy: cannot read: No such file or directory"},
};

static const char *file_of_output(const NphManifestLaunch *launch, const char *buffer) {
    static char file[1400];
    for (int o = 0; o < launch->output_count; o++)
        if (strcmp(launch->outputs[o].buffer, buffer) == 0) snprintf(file, sizeof file, "%s/%s", reference, launch->outputs[o].file);
    return file;
}

static void write_torn(NphContext *context, const char *from, const char *to) {
    NphArray array;
    ck_assert_int_eq(nph_array_read_npy(context, from, &array), NPH_OK);
    ck_assert_int_eq(nph_array_write_npy(context, to, &array), NPH_OK);
    ck_assert_int_eq(truncate(to, 200), 0);
    nph_array_free(context, &array);
}

/* As a double append leaves it. */
static void write_doubled(NphContext *context, const char *from, const char *to) {
    NphArray array, twice;
    ck_assert_int_eq(nph_array_read_npy(context, from, &array), NPH_OK);
    size_t bytes = (size_t)array.shape[0] * sizeof(int32_t);
    ck_assert_int_gt(array.shape[0], 0);
    ck_assert_int_eq(nph_array_new(context, NPH_I32, 1, (const int64_t[]){2 * array.shape[0]}, "twice", &twice), NPH_OK);
    for (int i = 0; i < 2; i++) memcpy((char *)twice.data + (size_t)i * bytes, array.data, bytes);
    ck_assert_int_eq(nph_array_write_npy(context, to, &twice), NPH_OK);
    nph_array_free(context, &twice);
    nph_array_free(context, &array);
}

static void write_candidate(NphContext *context, const NphManifest *manifest, int c) {
    char text[8000], path[700];
    const NphManifestLaunch *launch = nph_manifest_find(manifest, 5, 1);
    ck_assert(launch && strcmp(launch->stage, "path.track") == 0);
    int used = snprintf(text, sizeof text, "{\"nephos_dump\": %d, \"method\": \"path\", \"launches\": [{\"batch\": 5, \"number\": 1, "
                                           "\"stage\": \"%s\", \"outputs\": {", candidates[c].format, candidates[c].stage);
    for (int o = 0; o < launch->output_count; o++) {
        const char *buffer = launch->outputs[o].buffer;
        int changed = strcmp(buffer, candidates[c].output) == 0;
        const char *array = changed ? candidates[c].array : buffer, *file = array ? file_of_output(launch, array) : "nowhere.npy";
        if (changed && candidates[c].is_torn) {
            snprintf(path, sizeof path, "%s/torn.npy", mine);
            write_torn(context, file, path);
            file = "torn.npy";
        }
        used += snprintf(text + used, sizeof text - (size_t)used, "%s\"%s\": \"%s\"", o ? ", " : "", changed ? candidates[c].name : buffer, file);
    }
    snprintf(text + used, sizeof text - (size_t)used, "}}]}\n");
    snprintf(path, sizeof path, "%s/manifest.json", mine);
    write_text(path, text);
}

static void expect_verdict(int status, const char *words, const char *title) {
    const Ran *run = program_run((const char *const[]){"verify", reference, mine, "--ulp", "0", NULL});
    ck_assert_msg(run->status == status && (strstr(run->out, words) || strstr(run->err, words)), "%s: %d\n%s%s", title, run->status, run->out,
                  run->err);
}

START_TEST(bad_candidates_are_told_what_and_where) {
    NphContext *context = nph_test_context(1);
    NphManifest manifest;
    char path[700];
    enter_root();
    RUN_EXPECT(0, DUMP, "--dump", reference, "--dump-select", "pixel=120,120", "--dump-select", "launch=1");
    ck_assert_int_eq(nph_manifest_read(context, reference, &manifest), NPH_OK);
    ck_assert_int_eq(mkdir(mine, 0777), 0);
    expect_verdict(4, "mine/manifest.json: cannot read: No such file or directory", "no manifest");
    for (int c = 0; c < (int)(sizeof candidates / sizeof *candidates); c++) {
        write_candidate(context, &manifest, c);
        expect_verdict(candidates[c].status, candidates[c].words, candidates[c].title);
    }
    snprintf(path, sizeof path, "%s/manifest.json", mine);
    write_text(path, "{\"nephos_dump\": 1, \"method\": \"path\", \"launches\": []}\n");
    expect_verdict(4, "mine/manifest.json: has no launches: there is nothing to compare", "no launches");
    write_text(path, "{\"nephos_dump\": 1, \"method\": \"light\", \"launches\": []}\n");
    expect_verdict(4, "mine of light", "another method");
    write_text(path, "{\"nephos_dump\": 1,\n");
    expect_verdict(4, "mine/manifest.json:2: did not find expected node content", "torn manifest");
    nph_manifest_free(context, &manifest);
    nph_test_context_close(context);
    remove_folders();
}
END_TEST

static void shell(const char *format, const char *a, const char *b) {
    char command[4000];
    snprintf(command, sizeof command, format, a, b);
    ck_assert_int_eq(system(command), 0);
}

static void expect(int status, const char *words, const char *const *arguments) {
    const Ran *run = program_run(arguments);
    ck_assert_msg(run->status == status && (strstr(run->out, words) || strstr(run->err, words)), "%s: %d\n%s%s", arguments[0], run->status, run->out, run->err);
}
#define EXPECT(status, words, ...) expect(status, words, (const char *const[]){__VA_ARGS__, NULL})

/* A reference whose paths of one batch end one launch earlier, a reference that was changed after it was written, and one of another scene. */
START_TEST(a_longer_run_is_judged_and_a_reference_that_is_not_what_it_was_is_refused) {
    enter_root();
    RUN_EXPECT(0, DUMP, "--dump", reference, "--dump-select", "pixel=120,120");
    shell("cp -r '%s' '%s'", reference, mine);
    EXPECT(0, "passed: ", "verify", reference, mine, "--ulp", "0", "--complete");
    shell("sed -i '/\"batch\": 5, \"number\": 9,/d' '%s/manifest.json'%s", reference, "");
    EXPECT(0, "passed: ", "verify", reference, mine, "--ulp", "0");
    EXPECT(1, "the reference has no launch there", "verify", reference, mine, "--ulp", "0", "--whole-run");
    EXPECT(0, "passed: ", "verify", mine, reference, "--ulp", "0");
    EXPECT(1, "FAILED", "verify", mine, reference, "--ulp", "0", "--complete");
    EXPECT(2, "the dump says what its run was", "stage", "path.track", "--from", mine, "--launch", "5:1", "-o", tracked, "-D", "path.roulette=0.9");
    EXPECT(2, "the dump says what its run was", "stage", "path.track", "--from", mine, "--launch", "5:1", "-o", tracked, "--seed", "9");
    EXPECT(2, "--launch: of which dump?", "stage", "path.track", "--scene", "reference/scenes/slab.yaml", "--launch", "5:1", "-o", tracked);
    EXPECT(4, "the scene is not the one of the dump", "stage", "path.track", "--from", mine, "--launch", "5:1", "-o", tracked, "--scene", "reference/scenes/cube_g000.yaml");
    if (has_altered() && !getenv("NEPHOS_TEST_QUICK")) {
        EXPECT(4, "the scene is not the one of the dump", "tolerance", mine, "--scene", "reference/scenes/cube_g000.yaml", "-o", file_of("t.json"));
        RUN_EXPECT(0, "tolerance", mine, "-q", "-o", file_of("mine/tolerances.json"));
        EXPECT(0, "passed: ", "verify", mine, mine, "--whole-run");
        EXPECT(0, "passed: ", "verify", mine, mine, "--allow", "f16:path.weight");
        EXPECT(2, "is a dump, which says what its run was", "tolerance", mine, "--method", "light", "-o", file_of("t.json"));
    }
    shell("printf '\\377' | dd of=%s/000005.npys bs=1 seek=5000 conv=notrunc 2>/dev/null%s", mine, "");
    EXPECT(4, "it has been changed or torn", "verify", mine, reference, "--ulp", "0", "--whole-run");
    EXPECT(2, "one of a kind", DUMP, "--dump", tracked, "--dump-select", "batch=1", "--dump-select", "batch=2");
    EXPECT(2, "--dump and --only exclude each other", DUMP, "--dump", tracked, "--only", "0,100,100,3");
    EXPECT(2, "no launch of this run is among those to be written", DUMP, "--dump", tracked, "--dump-select", "batch=999");
    remove_folders();
}
END_TEST

/* A double append: the stage that made it is named, and that no stage can go on from it does not end the verification. */
START_TEST(a_queue_whose_entries_stand_twice_is_located) {
    NphContext *context = nph_test_context(1);
    NphManifest manifest;
    char twice[700], command[1600];
    enter_root();
    RUN_EXPECT(0, DUMP, "--dump", reference, "--dump-select", "pixel=120,120");
    ck_assert_int_eq(nph_manifest_read(context, reference, &manifest), NPH_OK);
    shell("cp -r '%s' '%s'", reference, mine);
    const char *file = file_of_output(nph_manifest_find(&manifest, 5, 1), "path.colliding");
    snprintf(twice, sizeof twice, "%s/twice.npy", mine);
    write_doubled(context, file, twice);
    snprintf(command, sizeof command, "sed -i 's/\"%s\"/\"twice.npy\"/g' '%s/manifest.json'", strrchr(file, '/') + 1, mine);
    ck_assert_int_eq(system(command), 0);
    EXPECT(1, "first beyond tolerance: path.track, path.colliding, batch 5 launch 1", "verify", reference, mine, "--ulp", "0");
    EXPECT(1, "its inputs are none that a run could have", "verify", reference, mine, "--ulp", "0");
    nph_manifest_free(context, &manifest);
    nph_test_context_close(context);
    remove_folders();
}
END_TEST

/* What a stage made of inputs of one's own, and with another argument. */
START_TEST(inputs_and_arguments_of_ones_own_take_the_place_of_the_dumps) {
    enter_root();
    RUN_EXPECT(0, DUMP, "--dump", reference, "--dump-select", "pixel=120,120");
    RUN_EXPECT(0, "stage", "path.generate", "--from", reference, "--launch", "5:0", "-q", "-o", mine);
    shell("grep -q '\"number\": 0, \"stage\": \"path.generate\".*\"items\": 4096, \"grid\": \\[1, 1, 1\\]' '%s/manifest.json'%s", reference, "");
    char word[800];
    snprintf(word, sizeof word, "path.ray=%s/path.ray.npy", mine);
    RUN_EXPECT(0, "stage", "path.track", "--from", reference, "--launch", "5:1", "--in", word, "-q", "-o", tracked);
    check_that_stage_wrote_the_dumps("path.distance", 5, 1, "000005.npys@");
    NphContext *context = nph_test_context(1);
    snprintf(word, sizeof word, "%s/path.colliding.npy", tracked);
    write_doubled(context, word, file_of("twice.npy"));
    nph_test_context_close(context);
    snprintf(word, sizeof word, "path.colliding=%s", file_of("twice.npy"));
    EXPECT(4, "input path.colliding: position ", "stage", "path.scatter", "--from", reference, "--launch", "5:4", "--in", word, "-q", "-o", mine);
    RUN_EXPECT(0, "stage", "path.track", "--from", reference, "--launch", "5:1", "--set", "vertex=3", "-q", "-o", mine);
    ck_assert_msg(!same_files(file_of("mine/path.distance.npy"), file_of("tracked/path.distance.npy")), "other random numbers give the same flights");
    remove_folders();
}
END_TEST

/* Where the dump's folder takes no file: where temporary files go, which here is nowhere. */
START_TEST(measured_tolerances_go_where_temporary_files_go) {
    if (geteuid() == 0) {
        nph_test_skip("root may write everywhere");
        return;
    }
    enter_root();
    RUN_EXPECT(0, DUMP, "--dump", reference, "--dump-select", "pixel=120,120", "--dump-select", "launch=1");
    ck_assert_int_eq(chmod(reference, 0555), 0);
    ck_assert_int_eq(setenv("TMPDIR", "/no/such/folder", 1), 0);
    const Ran *run = program_run((const char *const[]){"verify", reference, reference, NULL});
    ck_assert_int_eq(chmod(reference, 0755), 0);
    ck_assert_msg(run->status == 5 && strstr(run->err, "/no/such/folder/nephos-tolerances."), "%d\n%s%s", run->status, run->out, run->err);
    remove_folders();
}
END_TEST

/* The page's own commands that take a while. */
START_TEST(the_pages_long_commands_say_what_the_page_says) {
    enter_root();
    if (getenv("NEPHOS_TEST_QUICK")) {
        nph_test_skip("long commands of docs/oracle.md");
        return;
    }
    EXPECT(6, "1160.8 MiB", "render", "reference/scenes/cube_g070.yaml", "-o", file_of("cube.exr"), "--spp", "16", "--crop", "120,120,136,136", "--method", "photonmap",
           "--dump", reference, "--dump-limit", "1M");
    if (has_altered()) {
        RUN_EXPECT(0, "tolerance", "reference/scenes/cube_g070.yaml", "-q", "-o", file_of("cube.json"));
        ck_assert(exists(file_of("cube.json")));
    }
}
END_TEST

START_TEST(tolerances_are_of_one_scene) {
    if (!has_altered() || !nph_test_long("tolerances of another scene")) return;
    char text[400];
    enter_root();
    snprintf(tolerances, sizeof tolerances, "%s", file_of("tolerances.json"));
    RUN_EXPECT(0, "tolerance", "reference/scenes/slab.yaml", "-q", "-o", tolerances);
    RUN_EXPECT(0, DUMP, "--dump", reference);
    const Ran *run = program_run((const char *const[]){"verify", reference, reference, "--tolerances", tolerances, NULL});
    ck_assert_int_eq(run->status, 4);
    ck_assert_ptr_nonnull(strstr(run->err, "the tolerances were measured on another scene"));
    snprintf(text, sizeof text, "{\"nephos_tolerances\": 1, \"method\": \"path\", \"scene_digest\": \"0\", \"precision\": \"f32\",\n \"tolerances\": [{}]}\n");
    write_text(tolerances, text);
    run = program_run((const char *const[]){"verify", reference, reference, "--tolerances", tolerances, NULL});
    ck_assert_int_eq(run->status, 4);
    ck_assert_ptr_nonnull(strstr(run->err, "tolerances.json:2: expected a text: stage"));
    RUN_EXPECT(2, "tolerance", "reference/scenes/slab.yaml", "--scene", "reference/scenes/slab.yaml");
    RUN_EXPECT(2, "tolerance", "reference/scenes/slab.yaml", "--method", "nosuch");
    RUN_EXPECT(5, "tolerance", "reference/scenes/slab.yaml", "-o", "/no/such/folder/t.json");
    remove_folders();
}
END_TEST

START_TEST(the_numpy_client_is_right_and_its_mistake_is_located) {
    if (!has_altered() || !nph_test_long("the client in NumPy")) return;
    enter_root();
    if (!python()) {
        nph_test_skip("no Python with NumPy");
        return;
    }
    RUN_EXPECT(0, DUMP, "--dump", reference);
    ck_assert_int_eq(run_numpy(""), 0);
    RUN_EXPECT(0, "verify", reference, mine, "--ulp", "8");
    snprintf(tolerances, sizeof tolerances, "%s/tolerances.json", reference);
    ck_assert(!exists(tolerances));
    const Ran *run = program_run((const char *const[]){"verify", reference, mine, NULL});
    ck_assert_msg(run->status == 0, "%s%s", run->out, run->err);
    ck_assert(exists(tolerances));
    ck_assert_ptr_nonnull(strstr(run->err, "nephos: measuring tolerances of "));
    ck_assert_ptr_nonnull(strstr(run->out, "passed: 288 launches compared, 288 of them on the candidate's own inputs; 888 of"));
    run = program_run((const char *const[]){"verify", reference, mine, "--interface", "cuda", NULL});
    ck_assert_msg(run->status == 0, "%s%s", run->out, run->err);
    ck_assert_ptr_null(strstr(run->err, "measuring"));
    RUN_EXPECT(2, "verify", reference, mine, "--interface", "cud");
    RUN_EXPECT(2, "verify", reference, mine, "--interface", "cuda", "--ulp", "8");
    char command[700];
    snprintf(command, sizeof command, "rm -r '%s'", mine);
    ck_assert_int_eq(system(command), 0);
    ck_assert_int_eq(run_numpy("--mistake"), 0);
    run = program_run((const char *const[]){"verify", reference, mine, "--junit", file_of("verify.xml"), NULL});
    ck_assert_int_eq(run->status, 1);
    ck_assert_ptr_nonnull(strstr(run->out, "first beyond tolerance: path.track, path.distance, batch 0 launch 5"));
    snprintf(command, sizeof command, "grep -q '<testsuite name=\"nephos verify\" tests=\"5\" failures=\"4\">' '%s'", file_of("verify.xml"));
    ck_assert_int_eq(system(command), 0);
    run = program_run((const char *const[]){"verify", reference, mine, "--json", NULL});
    ck_assert_int_eq(run->status, 1);
    ck_assert_ptr_nonnull(strstr(run->out, "\"first_stage\": \"path.track\""));
    remove_folders();
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, a_dump_is_verified_and_its_stages_run_alone);
    tcase_add_test(cases, majorants_run_alone_on_the_density_of_a_dump);
    tcase_add_test(cases, a_photon_map_is_dumped_and_its_stages_run_alone);
    tcase_add_test(cases, what_cannot_be_dumped_is_refused);
    tcase_add_test(cases, bad_candidates_are_told_what_and_where);
    tcase_add_test(cases, a_longer_run_is_judged_and_a_reference_that_is_not_what_it_was_is_refused);
    tcase_add_test(cases, a_queue_whose_entries_stand_twice_is_located);
    tcase_add_test(cases, inputs_and_arguments_of_ones_own_take_the_place_of_the_dumps);
    tcase_add_test(cases, the_pages_long_commands_say_what_the_page_says);
    tcase_add_test(cases, tolerances_are_of_one_scene);
    tcase_add_test(cases, the_numpy_client_is_right_and_its_mistake_is_located);
    tcase_add_test(cases, measured_tolerances_go_where_temporary_files_go); /* changes the environment */
}

int main(void) { return nph_test_main("cli_oracle", fill); }
