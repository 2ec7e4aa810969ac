/* SPDX-License-Identifier: Apache-2.0
 *
 * The program behind those commands of nephos that need altered kernels; nephos runs it and hands over its line. */
#include <stdlib.h>
#include <string.h>

#include "cli/command.h"

static const Command *const commands[] = {&command_diagnose, &command_tolerance};
enum { COMMANDS = sizeof commands / sizeof *commands };

static NphStatus dispatch(int argc, char **argv) {
    for (int i = 0; i < COMMANDS && argc > 1; i++)
        if (strcmp(commands[i]->name, argv[1]) == 0) return commands[i]->run(commands[i], argc - 1, argv + 1);
    fprintf(stderr, "nephos-altered: part of nephos, which runs it; try: nephos --help\n");
    return NPH_BAD_USAGE;
}

int main(int argc, char **argv) {
    setenv("NEPHOS_ISA", "base", 1); /* the level that is altered */
    NphStatus status = dispatch(argc, argv);
    if (fflush(stdout) != 0 || ferror(stdout)) {
        if (status == NPH_OK) status = NPH_BAD_OUTPUT;
        fprintf(stderr, "nephos: error: standard output cannot be written\n");
    }
    return (int)status;
}
