/* SPDX-License-Identifier: Apache-2.0
 *
 * What every command does first. */
#include "cli/command.h"

#include <string.h>

static void print_help(const Command *command, const OptionTable *table) {
    printf("nephos %s: %s\n\nusage: nephos %s %s\n\n%s\noptions:\n", command->name, command->summary, command->name,
           command->arguments, command->before);
    options_print(table, stdout);
    printf("  -h, --help                     this text\n\nexamples:\n%s", command->examples);
}

int command_begin(const Command *command, const OptionTable *table, int argc, char **argv, TextList *files,
                  NphStatus *status) {
    for (int i = 1; i < argc && strcmp(argv[i], "--") != 0; i++)
        if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0) {
            print_help(command, table);
            *status = NPH_OK;
            return 0;
        }
    *status = options_parse(table, command->name, argc, argv, files);
    if (*status == NPH_OK && files->count < command->files_min)
        *status = usage_error(command->name, "too few files; usage: nephos %s %s", command->name, command->arguments);
    if (*status == NPH_OK && files->count > command->files_max)
        *status = usage_error(command->name, "what is '%s'? usage: nephos %s %s", files->items[command->files_max],
                              command->name, command->arguments);
    return *status == NPH_OK;
}
