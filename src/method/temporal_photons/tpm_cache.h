/* SPDX-License-Identifier: Apache-2.0
 *
 * The cache of one frame: its memory, and the generations that make it, each from the scene as it was at its time. Before frame 0
 * the scene stood still. */
#ifndef NPH_METHOD_TPM_CACHE_H
#define NPH_METHOD_TPM_CACHE_H

#include "method/temporal_photons/tpm.h"

typedef struct NphTpmCache {
    NphContext *context;
    NphTpmKernels kernels;
    NphJob job;
    NphTpmChoice choice, reference;
    const void *scene;          /* of the frame */
    int64_t values;             /* of a partial cache, both kinds */
    uint32_t sample;
    int generation;             /* of the frame's, from 0 on: set by enter */
    NphTpmGeneration now;       /* its photons, and their scene: the frame's, or `other` */
    const void *traced;
    void *units, *other;        /* scenes of the reference frame and of a generation, where the scene is animated */
    int64_t other_frame;
    NphTpmChoice other_choice;
    NphScene *other_scene;
    double (*shares)[NPH_TPM_KINDS]; /* of each generation that was entered */
    int64_t *old;               /* H that `update` takes out; NULL: none */
    int64_t *old_room;          /* where a stage by itself finds it, once it has been given */
    int64_t *added;             /* [worker][values]: what its blocks of this generation added */
    int64_t *partial;           /* H */
    int64_t *sums;              /* I */
    void *coarse, *fine, *guide; /* guide, seen: of fine cells, of the frame's scene */
    uint8_t *seen;
    void **scratch;             /* per worker */
    NphTpmLedger *ledgers;      /* per worker */
    NphTally *tallies;          /* per worker */
    NphStageCounts *stages;     /* per worker */
} NphTpmCache;

/* scene: prepared by the kernels for the job; it takes the units of the reference frame. later: generations of frames after it that may
 * be entered too. */
NphStatus nph_tpm_cache_open(const NphJob *job, void *scene, int later, NphTpmCache *cache);
void nph_tpm_cache_close(NphTpmCache *cache);
/* Generation k of the frame's, from 0 on, or of later frames': its photons, and its scene. */
NphStatus nph_tpm_cache_enter(NphTpmCache *cache, int generation);
/* Its number: that of the frame whose new one it was; negative ones lie before frame 0. */
int64_t nph_tpm_cache_number(const NphTpmCache *cache, int generation);
/* One stage, from clear to upsample, of what `sample` and `generation` say. */
NphStatus nph_tpm_cache_step(NphTpmCache *cache, NphTpmStage stage);
/* All of them: I and J of the frame, from photons of one sample's own. */
NphStatus nph_tpm_cache_make(NphTpmCache *cache, uint32_t sample);
void nph_tpm_cache_ledger(const NphTpmCache *cache, NphTpmLedger *sum);

/* A run. What is traced and marched is that of the frame whose picture is shown: `age` frames ago. */
typedef struct NphTpmState {
    NphJob job;
    NphTpmChoice choice;        /* of that frame */
    NphTpmCache cache;
    int made;                   /* the cache is open */
    int age, film_channels;
    NphScene *shown_scene;      /* where it is not the job's */
    void *shown;                /* for the kernels; `scene` where age is 0 */
    struct NphTpmCarry *carry;  /* NULL: the frame stands for itself */
    void *scene, *picture;
    void *images;               /* [16][field][pixel] */
    void *samples;              /* of a tile */
    double *film_scratch;
    size_t image_bytes;
    int origin[2], small[2];
    NphFilm *film;
    int64_t chunk;
    int slot;
    double started;
} NphTpmState;

/* What launch->stage does with the buffers as they stand. */
NphStatus nph_tpm_launch(NphTpmState *state, const NphLaunch *launch);

/* tpm_alone.c: of NphMethod. */
NphStatus nph_tpm_begin_launch(void *state, int worker, NphFilm *film, const NphLaunch *launch);
NphStatus nph_tpm_extend(void *state, int worker, int buffer, const int64_t *shape);
int nph_tpm_view(void *state, int worker, int buffer, NphView *view);
NphStatus nph_tpm_check(void *state, int worker, const NphLaunch *launch);
NphStatus nph_tpm_launch_alone(void *state, int worker, const NphLaunch *launch);

#endif
