/* SPDX-License-Identifier: Apache-2.0
 *
 * Names of statuses. */
#include "nephos/status.h"

const char *nph_status_name(NphStatus status) {
    switch (status) {
    case NPH_OK: return "done";
    case NPH_DIFFERENT: return "comparison failed";
    case NPH_BAD_USAGE: return "bad usage";
    case NPH_BAD_SCENE: return "bad scene";
    case NPH_BAD_INPUT: return "bad input";
    case NPH_BAD_OUTPUT: return "cannot write";
    case NPH_NO_MEMORY: return "out of memory";
    case NPH_BAD_NUMBER: return "numerical failure";
    case NPH_INTERRUPTED: return "interrupted";
    }
    return "unknown status";
}
