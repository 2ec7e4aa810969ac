/* SPDX-License-Identifier: Apache-2.0
 *
 * A command of the program: command_NAME.c defines one of these, main.c lists them. */
#ifndef NPH_CLI_COMMAND_H
#define NPH_CLI_COMMAND_H

#include "cli/options.h"

typedef struct Command {
    const char *name;
    const char *arguments;   /* "SCENE -o OUT.exr [options]" */
    const char *summary;     /* one line */
    const char *before;      /* help above the options */
    const char *examples;    /* help below them */
    int files_min, files_max; /* arguments that are no options */
    NphStatus (*run)(const struct Command *command, int argc, char **argv);
} Command;

/* Parses the command's line. Returns 1 to go on; 0 when the command is done with *status: help was asked for, or the
 * line was wrong and the mistake has been told. */
int command_begin(const Command *command, const OptionTable *table, int argc, char **argv, TextList *files,
                  NphStatus *status);

/* Runs nephos-altered with line[1 ...] in place of this program, NULL at the end; line[0] is set. Returns only where it cannot be
 * run, which has been told. */
void altered_replace(char **line);

extern const Command command_render, command_plan, command_info, command_compare, command_merge, command_bench, command_verify,
    command_stage, command_batch, command_phase, command_diagnose, command_tolerance;

#endif
