/* SPDX-License-Identifier: Apache-2.0
 *
 * The cache of one frame: its memory, and the generations that make it. */
#ifndef NPH_METHOD_TPM_CACHE_H
#define NPH_METHOD_TPM_CACHE_H

#include "method/temporal_photons/tpm.h"

typedef struct NphTpmCache {
    NphContext *context;
    NphTpmKernels kernels;
    NphTpmChoice choice;
    const void *scene;
    int64_t frame, values;      /* values: of a partial cache, both kinds */
    uint32_t sample;
    int generation;             /* of the frame's, from 0 on */
    int64_t blocks[NPH_TPM_KINDS];
    int64_t *added;             /* [worker][values]: what its blocks of this generation added */
    int64_t *partial;           /* H */
    int64_t *sums;              /* I */
    void *coarse, *fine;
    void **scratch;             /* per worker */
    NphTpmLedger *ledgers;      /* per worker */
    NphTally *tallies;          /* per worker */
    NphStageCounts *stages;     /* per worker */
} NphTpmCache;

NphStatus nph_tpm_cache_open(const NphJob *job, const NphTpmChoice *choice, const void *scene, NphTpmCache *cache);
void nph_tpm_cache_close(NphTpmCache *cache);
/* One stage, from clear to upsample, of what `sample` and `generation` say. */
NphStatus nph_tpm_cache_step(NphTpmCache *cache, NphTpmStage stage);
/* All of them: I and J of the frame, from photons of one sample's own. */
NphStatus nph_tpm_cache_make(NphTpmCache *cache, uint32_t sample);
void nph_tpm_cache_ledger(const NphTpmCache *cache, NphTpmLedger *sum);

/* A run. */
typedef struct NphTpmState {
    NphJob job;
    NphTpmChoice choice;
    NphTpmCache cache;
    int made;                   /* the cache is open */
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
