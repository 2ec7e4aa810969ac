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
    uint32_t sample, generation;
    int64_t blocks[NPH_TPM_KINDS];
    int64_t *added;             /* [worker][values]: what its blocks of this generation added */
    int64_t *sums;              /* I */
    void *coarse, *fine;
    void **scratch;             /* per worker */
    NphTpmLedger *ledgers;      /* per worker */
    NphTally *tallies;          /* per worker */
    NphStageCounts *stages;     /* per worker */
} NphTpmCache;

NphStatus nph_tpm_cache_open(const NphJob *job, const NphTpmChoice *choice, const void *scene, NphTpmCache *cache);
void nph_tpm_cache_close(NphTpmCache *cache);
/* I and J of the frame, from photons of one sample's own. */
NphStatus nph_tpm_cache_make(NphTpmCache *cache, uint32_t sample);
void nph_tpm_cache_ledger(const NphTpmCache *cache, NphTpmLedger *sum);

#endif
