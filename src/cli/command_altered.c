/* SPDX-License-Identifier: Apache-2.0
 *
 * Commands that need altered kernels (src/altered): nephos-altered is run in place of this program. It lies beside it in a build
 * folder, else where it was installed to, as seen from here or as configured. */
#include <errno.h>
#include <string.h>
#include <unistd.h>

#include "cli/command.h"

/* The folder of this program's file, with a slash at the end; "" where the system does not say. */
static void own_folder(char *folder, size_t bytes) {
    ssize_t length = readlink("/proc/self/exe", folder, bytes - 1);
    folder[length > 0 ? length : 0] = 0;
    char *slash = strrchr(folder, '/');
    if (slash) slash[1] = 0;
}

void altered_replace(char **line) {
    static const char *const places[] = {"../altered/nephos-altered", "../libexec/nephos/nephos-altered"};
    char folder[3072], path[4096];
    line[0] = path;
    own_folder(folder, sizeof folder);
    for (int i = 0; i < 3; i++) {
        if (i < 2) snprintf(path, sizeof path, "%s%s", folder, places[i]);
        else snprintf(path, sizeof path, "%s", NPH_LIBEXEC "/nephos-altered");
        if (i == 2 || folder[0]) execv(path, line);
        if (errno != ENOENT && errno != ENOTDIR) break;
    }
    fprintf(stderr, "nephos: error: %s, a part of nephos, cannot be run: %s\n", path, strerror(errno));
    line[0] = NULL;
}

static NphStatus run(const Command *command, int argc, char **argv) {
    char *line[256] = {NULL, (char *)command->name};
    if (argc + 1 >= (int)(sizeof line / sizeof line[0])) return usage_error(command->name, "%d arguments are too many", argc - 1);
    for (int i = 1; i < argc; i++) line[i + 1] = argv[i];
    altered_replace(line);
    return NPH_BAD_INPUT;
}

#define ALTERED(word, text) {.name = (word), .summary = (text), .run = run}
const Command command_diagnose = ALTERED("diagnose", "which known mistake explains a picture"),
              command_tolerance = ALTERED("tolerance", "how far an honest port may be off, measured");
