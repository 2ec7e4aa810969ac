/* SPDX-License-Identifier: Apache-2.0
 *
 * What a sequence keeps from one frame to the next: of every sample the partial caches of its last m generations and their sum, and
 * with impostors the picture that was marched. */
#ifndef NPH_METHOD_TPM_CARRY_H
#define NPH_METHOD_TPM_CARRY_H

#include "method/temporal_photons/tpm_cache.h"

typedef struct NphTpmCarry NphTpmCarry;

/* What it takes. */
uint64_t nph_tpm_carry_bytes(const NphJob *job, const NphTpmChoice *choice);
/* Made where `*carry` is NULL or of other settings. */
NphStatus nph_tpm_carry_open(const NphJob *job, const NphTpmCache *cache, size_t picture_bytes, void **carry);
void nph_tpm_carry_drop(NphContext *context, void *carry);

/* A frame begins, which shows the picture of the cache's, `age` frames earlier: from then until end what is kept is no frame's. */
void nph_tpm_carry_begin(NphTpmCarry *carry, const NphTpmCache *cache, int age);
/* A sample of it: I as the last frame left it, and the first generation of the cache's frame, or of later ones, that is missing; 0: all are,
 * and I is to be cleared; not below their number: the picture is there. */
int nph_tpm_carry_take(NphTpmCarry *carry, int64_t sample, NphTpmCache *cache);
/* Memory of the sample's picture; NULL where none is kept. */
void *nph_tpm_carry_picture(NphTpmCarry *carry);
/* The H that gives way to the cache's generation; then that one in its place. */
int64_t *nph_tpm_carry_old(NphTpmCarry *carry, const NphTpmCache *cache);
void nph_tpm_carry_keep(NphTpmCarry *carry, const NphTpmCache *cache);
/* The sample is done. */
void nph_tpm_carry_give(NphTpmCarry *carry, const NphTpmCache *cache);
void nph_tpm_carry_end(NphTpmCarry *carry, const NphTpmCache *cache, int age);

#endif
