/* SPDX-License-Identifier: Apache-2.0
 *
 * nephos verify: a port's dump against the reference's, stage by stage. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "cli/command.h"
#include "cli/session.h"
#include "core/json.h"
#include "core/message.h"
#include "core/xml.h"
#include "io/file.h"
#include "nephos/verify.h"

typedef struct VerifyCommand {
    Session session;
    NphVerifyOptions options;
    NphTolerances measured;
    TextList allow;
    const char *scene, *junit, *tolerances;
    int json, ulp_given, flips_given;
} VerifyCommand;

static const char *const bins[NPH_VERIFY_BINS] = {"0", "1", "4", "16", "64", "1024", "2^20", "more"};

static void cell_text(const NphVerifyCell *cell, char text[256]) {
    size_t used = (size_t)snprintf(text, 256, "batch %lld launch %lld [", (long long)cell->batch, (long long)cell->number);
    for (int a = 0; a < cell->rank; a++)
        used += (size_t)snprintf(text + used, 256 - used, "%s%lld", a ? ", " : "", (long long)cell->index[a]);
    snprintf(text + used, 256 - used, "]: %.9g, reference %.9g, %.3g ulp, off by %.3g (%.3g%%)", cell->candidate, cell->reference,
             cell->ulp, cell->absolute, 100 * cell->relative);
}

static void print_row(const NphVerifyRow *row) {
    char text[256];
    printf("%-4s  %-16s %-16s %8lld %12lld %10lld", row->failed ? "FAIL" : "ok", row->stage, row->buffer, (long long)row->launches,
           (long long)row->cells, (long long)row->beyond);
    if (row->worst.ulp > 0) printf(" %10.3g", row->worst.ulp);
    else printf(" %10s", "");
    if (row->tolerance.ulp > 0) printf(" %10.3g", row->tolerance.ulp);
    else printf(" %8.2g %%", 100 * row->tolerance.flips);
    printf("  %s\n", row->tolerance.cause[0] ? row->tolerance.cause : "given");
    if (row->problem[0]) printf("        %s\n", row->problem);
    if (row->failed && row->items > 0)
        printf("        of %lld items %lld are turned over, at most %.3g may be; %lld are off by more than %.3g ulp, at most %.3g may be\n",
               (long long)row->items, (long long)row->turned, row->tolerance.flips * (double)row->items, (long long)row->untypical,
               row->tolerance.typical, row->tolerance.tail * (double)row->items + 1);
    if (row->cells == 0 || (row->beyond == 0 && !row->failed)) return;
    cell_text(&row->worst, text);
    printf("        worst: %s\n        ulp up to:", text);
    for (int b = 0; b < NPH_VERIFY_BINS; b++) printf("  %s: %lld", bins[b], (long long)row->histogram[b]);
    putchar('\n');
}

static void print_text(const NphVerification *result) {
    if (result->first >= 0)
        printf("first beyond tolerance: %s, %s, batch %lld launch %lld\n\n", result->rows[result->first].stage,
               result->rows[result->first].buffer, (long long)result->first_batch, (long long)result->first_number);
    printf("      stage            buffer           launches        cells     beyond    largest  tolerance  from\n");
    for (int r = 0; r < result->row_count; r++) print_row(&result->rows[r]);
    printf("\n%s: %lld launches compared, %lld of them on the candidate's own inputs; %lld of the reference's are not in the candidate\n",
           result->failed ? "FAILED" : "passed", (long long)result->launches, (long long)result->run_again, (long long)result->left_out);
}

static void json_row(NphJson *json, const NphVerifyRow *row) {
    double index[NPH_MAX_RANK], histogram[NPH_VERIFY_BINS];
    const NphVerifyCell *worst = &row->worst;
    for (int a = 0; a < worst->rank; a++) index[a] = (double)worst->index[a];
    for (int b = 0; b < NPH_VERIFY_BINS; b++) histogram[b] = (double)row->histogram[b];
    nph_json_object(json, NULL);
    nph_json_text(json, "stage", row->stage);
    nph_json_text(json, "buffer", row->buffer);
    nph_json_boolean(json, "failed", row->failed);
    nph_json_text(json, "problem", row->problem[0] ? row->problem : NULL);
    nph_json_integer(json, "launches", row->launches);
    nph_json_integer(json, "cells", row->cells);
    nph_json_integer(json, "beyond", row->beyond);
    nph_json_integer(json, "items", row->items);
    nph_json_integer(json, "turned", row->turned);
    nph_json_integer(json, "untypical", row->untypical);
    nph_json_object(json, "tolerance");
    nph_json_text(json, "cause", row->tolerance.cause[0] ? row->tolerance.cause : NULL);
    nph_json_number(json, "ulp", row->tolerance.ulp);
    nph_json_number(json, "flips", row->tolerance.flips);
    nph_json_number(json, "typical_ulp", row->tolerance.typical);
    nph_json_number(json, "tail", row->tolerance.tail);
    nph_json_close(json);
    nph_json_numbers(json, "ulp_histogram", NPH_VERIFY_BINS, histogram);
    nph_json_object(json, "worst");
    nph_json_integer(json, "batch", worst->batch);
    nph_json_integer(json, "number", worst->number);
    nph_json_numbers(json, "index", worst->rank, index);
    nph_json_number(json, "reference", worst->reference);
    nph_json_number(json, "candidate", worst->candidate);
    nph_json_number(json, "ulp", worst->ulp);
    nph_json_number(json, "absolute", worst->absolute);
    nph_json_number(json, "relative", worst->relative);
    nph_json_close(json);
    nph_json_close(json);
}

static void print_json(const NphVerification *result) {
    NphJson json;
    nph_json_begin(&json, nph_json_to_file, stdout);
    nph_json_object(&json, NULL);
    nph_json_boolean(&json, "failed", result->failed);
    nph_json_integer(&json, "launches", result->launches);
    nph_json_integer(&json, "on_the_candidates_inputs", result->run_again);
    nph_json_integer(&json, "left_out", result->left_out);
    nph_json_text(&json, "first_stage", result->first >= 0 ? result->rows[result->first].stage : NULL);
    nph_json_text(&json, "first_buffer", result->first >= 0 ? result->rows[result->first].buffer : NULL);
    if (result->first >= 0) {
        nph_json_integer(&json, "first_batch", result->first_batch);
        nph_json_integer(&json, "first_number", result->first_number);
    }
    nph_json_array(&json, "buffers");
    for (int r = 0; r < result->row_count; r++) json_row(&json, &result->rows[r]);
    nph_json_close(&json);
    nph_json_close(&json);
}

static void xml_text(FILE *out, const char *text) { nph_xml_text(nph_json_to_file, out, text); }

/* A test case for each buffer of each stage. */
static void write_junit(FILE *out, const NphVerification *result) {
    int failures = 0;
    for (int r = 0; r < result->row_count; r++) failures += result->rows[r].failed;
    fprintf(out, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"nephos verify\" tests=\"%d\" failures=\"%d\">\n",
            result->row_count, failures);
    for (int r = 0; r < result->row_count; r++) {
        const NphVerifyRow *row = &result->rows[r];
        char text[256];
        fputs("  <testcase classname=\"", out);
        xml_text(out, row->stage);
        fputs("\" name=\"", out);
        xml_text(out, row->buffer[0] ? row->buffer : "launch");
        fputs(row->failed ? "\"><failure message=\"" : "\"/>\n", out);
        if (!row->failed) continue;
        cell_text(&row->worst, text);
        xml_text(out, row->problem[0] ? row->problem : text);
        fprintf(out, "\">%lld of %lld cells are beyond the tolerance</failure></testcase>\n", (long long)row->beyond, (long long)row->cells);
    }
    fputs("</testsuite>\n", out);
}

static NphStatus report(VerifyCommand *verify, const NphVerification *result) {
    if (verify->json) print_json(result);
    else if (!verify->session.quiet) print_text(result);
    if (verify->junit) {
        NphWriter writer;
        NPH_TRY(nph_writer_open(verify->session.context, verify->junit, &writer));
        write_junit(writer.stream, result);
        NPH_TRY(nph_writer_commit(verify->session.context, &writer));
    }
    return result->failed ? NPH_DIFFERENT : NPH_OK;
}

/* nephos tolerance DUMP -o FILE, as a program of its own. */
static NphStatus measure(VerifyCommand *verify, const char *reference, const char *scene, const char *path) {
    char *line[] = {NULL, "tolerance", (char *)reference, "-o", (char *)path, "--scene", (char *)scene, "-q", NULL};
    int status = 0;
    fflush(NULL);
    pid_t child = fork();
    if (child == 0) {
        altered_replace(line);
        _exit(NPH_BAD_INPUT);
    }
    if (child < 0) return nph_error(verify->session.context, NPH_NO_MEMORY, "tolerances cannot be measured: %s", strerror(errno));
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {}
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return NPH_OK;
    return nph_error(verify->session.context, WIFEXITED(status) ? (NphStatus)WEXITSTATUS(status) : NPH_INTERRUPTED,
                     "tolerances of %s were not measured; --ulp N and --flips PART do without", reference);
}

/* tolerances.json beside the reference's manifest; measured now where it is not there, and kept where it can be. */
static NphStatus find_tolerances(VerifyCommand *verify, const char *reference, const char *scene) {
    NphContext *context = verify->session.context;
    char path[4096], passing[4096];
    const char *last = strrchr(reference, '/');
    struct stat found;
    int manifest = strcmp(last ? last + 1 : reference, "manifest.json") == 0;
    int length = !manifest ? (int)strlen(reference) : last ? (int)(last - reference) : 0;
    snprintf(path, sizeof path, "%.*s%stolerances.json", length, reference, length > 0 ? "/" : "");
    if (stat(path, &found) == 0) return nph_tolerances_read(context, path, &verify->measured);
    snprintf(path, sizeof path, "%.*s", length > 0 ? length : 1, length > 0 ? reference : ".");
    const char *temporary = getenv("TMPDIR");
    snprintf(passing, sizeof passing, "%s/nephos-tolerances.XXXXXX", temporary && *temporary ? temporary : "/tmp");
    int kept = access(path, W_OK) == 0, file = kept ? -1 : mkstemp(passing);
    if (!kept && file < 0) return nph_error(context, NPH_BAD_OUTPUT, "%s: no file for tolerances: %s", passing, strerror(errno));
    if (kept) snprintf(path, sizeof path, "%.*s%stolerances.json", length, reference, length > 0 ? "/" : "");
    else {
        close(file);
        snprintf(path, sizeof path, "%s", passing);
    }
    fprintf(stderr, "nephos: measuring tolerances of %s%s%s\n", reference, kept ? ", kept in " : "", kept ? path : "");
    NphStatus status = measure(verify, reference, scene, path);
    if (status == NPH_OK) status = nph_tolerances_read(context, path, &verify->measured);
    if (!kept) unlink(path);
    return status;
}

static NphStatus choose_tolerances(VerifyCommand *verify, const char *reference, const char *scene) {
    if (verify->ulp_given || verify->flips_given) return NPH_OK;
    if (verify->tolerances) NPH_TRY(nph_tolerances_read(verify->session.context, verify->tolerances, &verify->measured));
    else NPH_TRY(find_tolerances(verify, reference, scene));
    verify->options.tolerances = &verify->measured;
    return NPH_OK;
}

static NphStatus verify_dumps(VerifyCommand *verify, const char *reference, const char *candidate) {
    NphContext *context = verify->session.context;
    NphScene *scene = NULL;
    NphVerification result;
    char name[4096];
    uint32_t frame = 0;
    const char *path = verify->scene;
    if ((verify->ulp_given || verify->flips_given) && (verify->tolerances || verify->options.interface))
        return usage_error("verify", "--ulp and --flips are in place of measured tolerances: they exclude --tolerances and --interface");
    if (verify->junit) NPH_TRY(check_writable(&verify->session, verify->junit));
    int given = verify->ulp_given || verify->flips_given || verify->tolerances;
    if (!path && !(verify->options.whole_run && given)) {
        NPH_TRY(nph_dump_scene(context, reference, name, sizeof name, &frame));
        path = name;
    } else if (!verify->options.whole_run) {
        NPH_TRY(nph_dump_scene(context, reference, NULL, 0, &frame));
    }
    if (!verify->options.whole_run) NPH_TRY(nph_scene_load_frame(context, path, frame, &scene));
    verify->options.scene = scene;
    verify->options.allow_count = verify->allow.count;
    verify->options.allow = verify->allow.items;
    NphStatus status = choose_tolerances(verify, reference, path);
    if (status == NPH_OK) status = nph_verify(context, reference, candidate, &verify->options, &result);
    nph_scene_free(context, scene);
    nph_tolerances_free(context, &verify->measured);
    if (status != NPH_OK) return status;
    status = report(verify, &result);
    nph_verification_free(context, &result);
    return status;
}

static NphStatus run(const Command *command, int argc, char **argv) {
    VerifyCommand verify;
    OptionTable table = {0};
    TextList files = {0};
    NphStatus status = NPH_OK;
    memset(&verify, 0, sizeof verify);
    nph_verify_options_default(&verify.options);
    option_add(&table, (Option){.name = "whole-run", .kind = OPTION_FLAG, .target = &verify.options.whole_run,
                                .meaning = "compare with the reference's own run, whatever inputs the candidate had"});
    option_add(&table, (Option){.name = "complete", .kind = OPTION_FLAG, .target = &verify.options.complete,
                                .meaning = "launches that the reference has and the candidate has not are a failure"});
    option_add(&table, (Option){.name = "scene", .kind = OPTION_TEXT, .target = &verify.scene, .value_name = "SCENE",
                                .meaning = "of the reference, where its manifest's name for it leads nowhere"});
    option_add(&table, (Option){.name = "tolerances", .kind = OPTION_TEXT, .target = &verify.tolerances, .value_name = "FILE.json",
                                .meaning = "what nephos tolerance wrote; default: REFERENCE/tolerances.json, measured now if it is not there"});
    option_add(&table, (Option){.name = "interface", .kind = OPTION_TEXT, .target = &verify.options.interface, .value_name = "NAME",
                                .meaning = "the candidate's: opencl, cuda, cuda_fast, vulkan or webgpu; default: the least accurate"});
    option_add(&table, (Option){.name = "allow", .kind = OPTION_LIST, .target = &verify.allow, .value_name = "f16:BUFFER",
                                .meaning = "the candidate keeps that buffer in halves; may be given several times"});
    option_add(&table, (Option){.name = "ulp", .kind = OPTION_NUMBER, .target = &verify.options.ulp, .value_name = "N", .min = 0, .max = 1e18,
                                .given = &verify.ulp_given, .meaning = "in place of what was measured: units in the last place, of a "
                                "value or of its row's largest one; 64 with --flips alone"});
    option_add(&table, (Option){.name = "flips", .kind = OPTION_NUMBER, .target = &verify.options.flips, .value_name = "PART", .min = 0,
                                .max = 1, .given = &verify.flips_given, .meaning = "in place of what was measured: part of the items that "
                                "rounding may turn over; 0 with --ulp alone"});
    option_add(&table, (Option){.name = "junit", .kind = OPTION_TEXT, .target = &verify.junit, .value_name = "FILE.xml",
                                .meaning = "the outcome as JUnit's XML too"});
    option_add(&table, (Option){.name = "json", .kind = OPTION_FLAG, .target = &verify.json, .meaning = "as JSON on standard output"});
    session_add_options(&table, &verify.session);
    if (!command_begin(command, &table, argc, argv, &files, &status)) return status;
    NPH_TRY(session_open(&verify.session, command->name));
    return session_close(&verify.session, verify_dumps(&verify, files.items[0], files.items[1]));
}

const Command command_verify = {
    .name = "verify",
    .arguments = "REFERENCE CANDIDATE [options]",
    .summary = "two dumps: the first stage and cell that differ",
    .before = "Holds the dump CANDIDATE of a port against the dump REFERENCE (nephos render --dump). Each launch whose\n"
              "manifest lists inputs is judged on those: the reference's stage is run again on them, so that one flipped\n"
              "decision does not damn what follows. Items with an identity are matched by it. How far it may be off has been\n"
              "measured (nephos tolerance). Exit status 0 means within the tolerance, 1 anything else.\n",
    .examples = "  nephos render cloud.yaml -o cloud.exr --spp 16 --crop 0,0,64,48 --dump reference\n"
                "  nephos verify reference mine\n"
                "  nephos verify reference mine --whole-run --junit verify.xml\n",
    .files_min = 2,
    .files_max = 2,
    .run = run,
};
