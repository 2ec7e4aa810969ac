/* SPDX-License-Identifier: Apache-2.0
 *
 * The program: finds the command and runs it. Its exit status is an NphStatus. */
#include <stdlib.h>
#include <string.h>

#include "cli/command.h"
#include "core/cpu.h"
#include "nephos/context.h"

static const Command *const commands[] = {&command_render,  &command_plan,  &command_info,
                                          &command_compare, &command_merge, &command_bench,
                                          &command_verify,  &command_stage, &command_batch,
                                          &command_phase,
#ifdef NPH_HAVE_ALTERED
                                          &command_diagnose, &command_tolerance
#endif
};
enum { COMMANDS = sizeof commands / sizeof *commands };

static void print_help(void) {
    puts("nephos: a reference renderer for clouds, smoke and atmosphere on the CPU\n"
         "\n"
         "usage: nephos COMMAND [arguments]     nephos COMMAND --help tells more\n");
    for (int i = 0; i < COMMANDS; i++) printf("  %-9s  %s\n", commands[i]->name, commands[i]->summary);
    puts("\n"
         "A first picture, and what is in it:\n"
         "  nephos render reference/scenes/cumulus.yaml -o cumulus.exr --png\n"
         "  nephos info cumulus.exr\n"
         "\n"
         "Until the noise is half a percent of the mean, then compare with a second run of another seed:\n"
         "  nephos render cumulus.yaml -o a.exr --target-error 0.005\n"
         "  nephos render cumulus.yaml -o b.exr --target-error 0.005 --seed 2\n"
         "  nephos compare a.exr b.exr\n"
         "\n"
         "On two machines, byte for byte the picture of one:\n"
         "  nephos render cumulus.yaml -o 1.part --part --samples 0:512\n"
         "  nephos render cumulus.yaml -o 2.part --part --samples 512:1024\n"
         "  nephos merge 1.part 2.part -o cumulus.exr\n"
         "\n"
         "Exit status: 0 done, 1 comparison failed, 2 usage, 3 scene, 4 input data, 5 output, 6 memory refused,\n"
         "7 numerical (NaN, density above its majorant), 75 interrupted: what was done is written.\n"
         "NEPHOS_ISA=base, avx2 or avx512 bounds the vector level; the bytes stay the same.");
}

static NphStatus print_version(void) {
    NphIsa machine = nph_cpu_isa(), used = machine, limit;
    const char *word = getenv("NEPHOS_ISA");
    if (word) {
        if (!nph_isa_parse(word, &limit)) {
            fprintf(stderr, "nephos: environment variable NEPHOS_ISA=%s: expected base, avx2 or avx512\n", word);
            return NPH_BAD_USAGE;
        }
        if (limit < used) used = limit;
    }
    printf("nephos %s\nvector level: %s", nph_version(), nph_isa_name(used));
    if (used != machine) printf(" (the machine has %s)", nph_isa_name(machine));
    printf("\nbuilt with: %s\nlibraries: %s\n", NPH_BUILD_COMPILER, NPH_BUILD_LIBRARIES);
    return NPH_OK;
}

static NphStatus unknown_command(const char *word) {
    const char *names[COMMANDS];
    for (int i = 0; i < COMMANDS; i++) names[i] = commands[i]->name;
    const char *near = closest_word(word, names, COMMANDS);
    fprintf(stderr, "nephos: unknown command %s", word);
    if (near) fprintf(stderr, "; did you mean %s?", near);
    fprintf(stderr, "\nTry: nephos --help\n");
    return NPH_BAD_USAGE;
}

static NphStatus dispatch(int argc, char **argv) {
    const char *word = argc > 1 ? argv[1] : "--help";
    if (argc < 2) {
        fprintf(stderr, "nephos: no command given\nTry: nephos --help\n");
        return NPH_BAD_USAGE;
    }
    if (strcmp(word, "--version") == 0) return print_version();
    int help = strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0 || strcmp(word, "help") == 0;
    if (help && argc == 2) {
        print_help();
        return NPH_OK;
    }
    for (int i = 0; i < COMMANDS; i++) {
        if (strcmp(commands[i]->name, help ? argv[2] : word) != 0) continue;
        char *asked[] = {argv[2], "--help", NULL};
        return help ? commands[i]->run(commands[i], 2, asked) : commands[i]->run(commands[i], argc - 1, argv + 1);
    }
    return unknown_command(help ? argv[2] : word);
}

int main(int argc, char **argv) {
    NphStatus status = dispatch(argc, argv);
    if (fflush(stdout) != 0 || ferror(stdout)) {
        if (status == NPH_OK) status = NPH_BAD_OUTPUT;
        fprintf(stderr, "nephos: error: standard output cannot be written\n");
    }
    return (int)status;
}
