/* SPDX-License-Identifier: Apache-2.0
 *
 * Places where light of the media begins, for methods that follow it from there: one is drawn with a density that is the
 * emission's bound over its integral, constant within a cell of 4^3 samples (a box is one cell). What a place is worth is
 * j / density, the mean of which is the integral of j over all media: times 4 pi their power [W]. */
#ifndef NPH_TRANSPORT_EMISSION_SOURCE_H
#define NPH_TRANSPORT_EMISSION_SOURCE_H

#include "transport/choice.h"

typedef struct NphEmissionCell {
    int32_t emitter;     /* place among the emitters of RScene: media that choice->emits, in order */
    double lo[3], hi[3]; /* in its space */
    double density;      /* 1/m3 */
} NphEmissionCell;

typedef struct NphEmissionSources {
    int64_t count;            /* 0: nothing shines */
    NphEmissionCell *cells;
    double *cdf;              /* count + 1 values from 0 to 1 */
    double total;             /* integral of the bound, W/sr */
    double world_from_space[NPH_MAX_MEDIA][12]; /* by emitter */
} NphEmissionSources;

/* A layer that emits is refused (NPH_BAD_INPUT), its power has no end; so are media that emit between sides that repeat. */
NphStatus nph_emission_sources(NphContext *context, const NphScene *scene, const NphTransportChoice *choice,
                               NphEmissionSources *sources);
void nph_emission_sources_free(NphContext *context, NphEmissionSources *sources);

#endif
