/* SPDX-License-Identifier: Apache-2.0 */
#include "method/temporal_photons/tpm_carry.h"

#include <string.h>

#include "core/memory.h"
#include "core/message.h"

/* Generation n lies at n modulo m. */
struct NphTpmCarry {
    double knobs[NPH_MAX_KNOBS];
    uint32_t seed;
    int precision;
    int64_t begin, samples, ring, values;
    int64_t frame;      /* whose generations are there, of every sample, and the picture that it showed; below 0: none */
    int first;          /* generation that the frame under way is short of */
    int64_t at;         /* sample under way */
    size_t picture_bytes;
    char *pictures;     /* [sample], where impostors are shown */
    int64_t *partial;   /* [sample][slot][values] */
    int64_t *sums;      /* [sample][values] */
    double (*shares)[NPH_TPM_KINDS]; /* [slot] */
};

static int64_t ring_of(const NphJob *job) { return (int64_t)job->knobs[NPH_TPM_KNOB_GENERATIONS]; }

uint64_t nph_tpm_carry_bytes(const NphJob *job, const NphTpmChoice *choice) {
    uint64_t values = (uint64_t)(NPH_TPM_KINDS * nph_tpm_cells(choice->cells) * NPH_TPM_VALUES), picture = 0;
    int origin[2], size[2];
    nph_tpm_small(job, origin, size);
    if (job->knobs[NPH_TPM_KNOB_IMPOSTORS] > 0.5) picture = (uint64_t)size[0] * (uint64_t)size[1] * NPH_SAMPLE_FIELDS * (uint64_t)(job->precision / 8);
    return (uint64_t)(job->sample_end - job->sample_begin) * (values * ((uint64_t)ring_of(job) + 1) * 8 + picture);
}

static int is_of(const NphTpmCarry *carry, const NphJob *job, int64_t values, size_t picture_bytes) {
    return nph_tpm_same(carry->knobs, job->knobs, NPH_MAX_KNOBS) && carry->seed == job->seed && carry->precision == job->precision &&
           carry->begin == job->sample_begin && carry->samples == job->sample_end - job->sample_begin && carry->values == values &&
           carry->picture_bytes == picture_bytes;
}

static NphStatus allocate(NphContext *context, NphTpmCarry *carry) {
    NPH_TRY(nph_alloc(context, (size_t)(carry->samples * carry->ring), (size_t)carry->values * 8, "partial caches of a sequence", (void **)&carry->partial));
    NPH_TRY(nph_alloc(context, (size_t)carry->samples, (size_t)carry->values * 8, "caches of a sequence", (void **)&carry->sums));
    if (carry->picture_bytes)
        NPH_TRY(nph_alloc(context, (size_t)carry->samples, carry->picture_bytes, "pictures of a sequence", (void **)&carry->pictures));
    return NPH_NEW(context, carry->ring, "generations of a sequence", &carry->shares);
}

NphStatus nph_tpm_carry_open(const NphJob *job, const NphTpmCache *cache, size_t picture_bytes, void **carry) {
    NphTpmCarry *made = NULL;
    picture_bytes = job->knobs[NPH_TPM_KNOB_IMPOSTORS] > 0.5 ? picture_bytes : 0;
    if (*carry && is_of(*carry, job, cache->values, picture_bytes)) return NPH_OK;
    if (*carry) nph_tpm_carry_drop(job->context, *carry);
    *carry = NULL;
    NPH_TRY(NPH_NEW(job->context, 1, "sequence", &made));
    *made = (NphTpmCarry){.seed = job->seed, .precision = job->precision, .begin = job->sample_begin, .samples = job->sample_end - job->sample_begin,
                          .ring = ring_of(job), .values = cache->values, .frame = -1, .picture_bytes = picture_bytes};
    memcpy(made->knobs, job->knobs, sizeof made->knobs);
    NphStatus status = allocate(job->context, made);
    if (status != NPH_OK) nph_tpm_carry_drop(job->context, made);
    else *carry = made;
    return status;
}

void nph_tpm_carry_drop(NphContext *context, void *opaque) {
    NphTpmCarry *carry = opaque;
    if (!carry) return;
    nph_free(context, carry->shares);
    nph_free(context, carry->pictures);
    nph_free(context, carry->sums);
    nph_free(context, carry->partial);
    nph_free(context, carry);
}

static int64_t slot_of(const NphTpmCarry *carry, int64_t number) {
    int64_t slot = number % carry->ring;
    return slot < 0 ? slot + carry->ring : slot;
}

static int64_t *place_of(NphTpmCarry *carry, const NphTpmCache *cache) {
    return carry->partial + (carry->at * carry->ring + slot_of(carry, nph_tpm_cache_number(cache, cache->generation))) * carry->values;
}

static int64_t frame_of(const NphTpmCache *cache) { return nph_tpm_cache_number(cache, cache->choice.generations - 1); }

void nph_tpm_carry_begin(NphTpmCarry *carry, const NphTpmCache *cache, int age) {
    int64_t shown = frame_of(cache), first = cache->choice.generations + carry->frame - shown;
    /* from the frame that is shown to this one all show it, so that what an earlier one of them left is its picture */
    int kept = carry->frame >= 0 && carry->frame < shown + age && first > 0;
    carry->first = kept ? (int)first : 0;
    if (!kept) memset(carry->shares, 0, sizeof *carry->shares * (size_t)carry->ring);
    carry->frame = -1;
}

int nph_tpm_carry_take(NphTpmCarry *carry, int64_t sample, NphTpmCache *cache) {
    carry->at = sample - carry->begin;
    int64_t *partial = carry->partial + carry->at * carry->ring * carry->values;
    if (carry->first == 0) memset(partial, 0, (size_t)(carry->ring * carry->values) * sizeof *partial);
    else memcpy(cache->sums, carry->sums + carry->at * carry->values, (size_t)carry->values * sizeof *cache->sums);
    for (int g = 0; g < carry->first; g++)
        memcpy(cache->shares[g], carry->shares[slot_of(carry, nph_tpm_cache_number(cache, g))], sizeof *cache->shares);
    return carry->first;
}

void *nph_tpm_carry_picture(NphTpmCarry *carry) { return carry->pictures ? carry->pictures + (size_t)carry->at * carry->picture_bytes : NULL; }

int64_t *nph_tpm_carry_old(NphTpmCarry *carry, const NphTpmCache *cache) { return place_of(carry, cache); }

void nph_tpm_carry_keep(NphTpmCarry *carry, const NphTpmCache *cache) {
    memcpy(place_of(carry, cache), cache->partial, (size_t)carry->values * sizeof *cache->partial);
}

void nph_tpm_carry_give(NphTpmCarry *carry, const NphTpmCache *cache) {
    memcpy(carry->sums + carry->at * carry->values, cache->sums, (size_t)carry->values * sizeof *cache->sums);
}

void nph_tpm_carry_end(NphTpmCarry *carry, const NphTpmCache *cache, int age) {
    for (int g = 0; g < cache->choice.generations + age; g++)
        memcpy(carry->shares[slot_of(carry, nph_tpm_cache_number(cache, g))], cache->shares[g], sizeof *cache->shares);
    carry->frame = frame_of(cache) + age;
}
