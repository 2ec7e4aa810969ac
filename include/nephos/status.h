/* SPDX-License-Identifier: Apache-2.0
 *
 * Status codes. Every call that can fail returns one; the words (what, where, what would be right) go to the
 * message callback of the context. The values are the exit statuses of the nephos program. */
#ifndef NEPHOS_STATUS_H
#define NEPHOS_STATUS_H

#ifdef __cplusplus
extern "C" {
#endif

typedef enum NphStatus {
    NPH_OK = 0,
    NPH_DIFFERENT = 1,    /* a comparison ran and did not say "same" */
    NPH_BAD_USAGE = 2,    /* arguments of a call or of the command line */
    NPH_BAD_SCENE = 3,    /* scene file or scene settings */
    NPH_BAD_INPUT = 4,    /* volume, image, table: damaged, unsupported, or not a valid value */
    NPH_BAD_OUTPUT = 5,   /* cannot write: full disk, no permission */
    NPH_NO_MEMORY = 6,    /* over the memory limit, or the system has no more */
    NPH_BAD_NUMBER = 7,   /* NaN, infinity, or a density above its majorant during a run */
    NPH_INTERRUPTED = 75  /* stopped on request between blocks; what was done is kept */
} NphStatus;

/* Short English name of a status; never NULL. */
const char *nph_status_name(NphStatus status);

#ifdef __cplusplus
}
#endif
#endif
