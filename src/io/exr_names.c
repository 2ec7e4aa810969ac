/* SPDX-License-Identifier: Apache-2.0
 *
 * Attribute names that OpenEXR keeps for itself. */
#include "io/exr.h"

#include <stddef.h>
#include <string.h>

static const char *const reserved[] = {
    "channels",           "compression",       "dataWindow", "displayWindow", "lineOrder", "pixelAspectRatio",
    "screenWindowCenter", "screenWindowWidth", "name",       "type",          "tiles",     "version",
    "chunkCount"};

int nph_exr_reserved_name(const char *name) {
    for (size_t i = 0; i < sizeof reserved / sizeof *reserved; i++)
        if (strcmp(name, reserved[i]) == 0) return 1;
    return 0;
}
