/* SPDX-License-Identifier: Apache-2.0
 *
 * What transport through a scene needs, chosen once for plan, run and replay; and what it counts. */
#ifndef NPH_TRANSPORT_CHOICE_H
#define NPH_TRANSPORT_CHOICE_H

#include "pipeline/method.h"

/* Only what the scene requires; with plan_full everything. */
typedef struct NphTransportChoice {
    int channels;                 /* of transport: 1 when media and surfaces are grey, else 3 */
    int film_channels;            /* 1 when the lights are grey too */
    int groups;                   /* of three wavelengths; 1 without wavelengths */
    int sampled[NPH_MAX_LIGHTS];  /* lights with a light sample at every vertex: all that are not constant or black */
    int used[NPH_MAX_MEDIA];      /* media that can change the picture */
    int emits[NPH_MAX_MEDIA];     /* media with light of their own */
    int emission;                 /* any of them */
    int scatters;                 /* some medium has an albedo above 0 */
    int reflects;                 /* some surface has */
} NphTransportChoice;
void nph_transport_choose(const NphScene *scene, int plan_full, NphTransportChoice *choice);

/* NPH_BAD_SCENE where air is among the media. */
NphStatus nph_transport_refuse_air(NphContext *context, const NphScene *scene, const char *method);

/* Lines of a plan about what the choice leaves out, and about the memory of media and lights. */
NphStatus nph_transport_plan(NphContext *context, const NphScene *scene, const NphTransportChoice *choice, NphPlan *plan);

/* What must not pass silently, and what statistics show. */
typedef struct NphTally {
    int64_t collisions, tentative;
    int64_t violations;  /* density above its majorant */
    int64_t exhausted;   /* a flight used up its random numbers, or passed NPH_MAX_IMAGES periods */
} NphTally;
void nph_tally_add(const NphTally *tally, NphRenderStatistics *out);

#endif
