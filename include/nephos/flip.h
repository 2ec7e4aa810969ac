/* SPDX-License-Identifier: Apache-2.0
 *
 * FLIP [Andersson20; Andersson21]: how different two pictures look when one alternates with the other, from 0 (equal) to
 * 1. docs/compare.md tells the stages. */
#ifndef NEPHOS_FLIP_H
#define NEPHOS_FLIP_H

#include "nephos/image.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum NphFlipKind {
    NPH_FLIP_HDR, /* radiance: the largest of LDR-FLIP over exposures, tone-mapped */
    NPH_FLIP_LDR  /* linear R, G, B in [0, 1], as a display shows them */
} NphFlipKind;

typedef struct NphFlipOptions {
    NphFlipKind kind;
    double pixels_per_degree; /* of visual angle, 1 to 1000; 67.02: 0.7 m from a display 0.7 m and 3840 pixels wide */
    int exposures;            /* HDR: how many, 0: as many as B's luminances ask for; LDR: 1 applies start_stops, 0 does not */
    double start_stops, stop_stops; /* first and last exposure, at most 100 either way; unused when exposures is 0 */
} NphFlipOptions;

enum { NPH_FLIP_EXPOSURES = 512 }; /* most that may be asked for */

void nph_flip_options_default(NphFlipOptions *options);

typedef struct NphFlip {
    NphFlipKind kind;
    double pixels_per_degree, start_stops, stop_stops;
    int exposures;             /* what was used; of LDR: 0 or 1 */
    double mean, largest;      /* over the pixels */
    int largest_x, largest_y;  /* the first pixel that has it */
    double noise_mean;         /* mean that noise of the stated standard errors alone would give; 0 when unknown */
    const char *noise_unknown; /* why it is; NULL when it is not */
} NphFlip;

/* A against B, the reference. Refuses what nph_compare refuses, and for LDR without an exposure values outside [0, 1]
 * (NPH_BAD_INPUT); options out of range are NPH_BAD_USAGE. map (may be NULL): becomes an image with channel FLIP, to be
 * freed by the caller. The same bits for any number of threads. */
NphStatus nph_flip(NphContext *context, const NphImage *a, const NphImage *b, const NphFlipOptions *options,
                   NphFlip *flip, NphImage *map);

#ifdef __cplusplus
}
#endif
#endif
