/* SPDX-License-Identifier: Apache-2.0
 *
 * The search: samples double until what is left is told apart, or the limit is reached. */
#include <math.h>
#include <string.h>

#include "altered/diagnosis.h"
#include "core/message.h"
#include "core/pool.h"
#include "scene/model.h"

enum { FIRST = 16, AGAIN = 4 };
/* A lead that counts: e^13 to 1, so that one of 31 bugs takes it over the right picture by chance once in 14000 times, and four
 * standard deviations of what the noise of our own pictures makes. */
static const double least_lead = 13.0, least_deviations = 4.0;

int diagnose_leads(double lead, double noise) { return lead > least_lead + least_deviations * noise; }

static const float *plane(const NphImage *image, const char *name) { return nph_image_channel(image, name)->pixels; }

static int same_bytes(const NphImage *a, const NphImage *b) {
    static const char *const names[] = {"R", "G", "B"};
    size_t bytes = (size_t)a->width * (size_t)a->height * sizeof(float);
    for (int c = 0; c < 3; c++)
        if (memcmp(plane(a, names[c]), plane(b, names[c]), bytes) != 0) return 0;
    return 1;
}

/* A picture of the first samples that is another one's: never rendered again. */
static void find_twin(Diagnosis *diagnosis, int index) {
    Candidate *candidate = &diagnosis->candidates[index];
    for (int i = 0; i < index && candidate->state == CANDIDATE_OPEN; i++) {
        const Candidate *other = &diagnosis->candidates[i];
        if ((i > 0 && other->state != CANDIDATE_OPEN) || other->samples != candidate->samples) continue;
        if (!same_bytes(&candidate->image, &other->image)) continue;
        candidate->state = i == 0 ? CANDIDATE_HIDDEN : CANDIDATE_TWIN;
        candidate->twin = i;
    }
}

/* Its means over the right picture's, which has as many samples; the random numbers are the same, so that the error bar is an
 * upper bound. */
static NphStatus measure_factor(const Diagnosis *diagnosis, Candidate *candidate) {
    NphFit fit;
    NPH_TRY(nph_fit(diagnosis->session->context, &candidate->image, &diagnosis->candidates[0].image, &diagnosis->fit, &fit));
    memcpy(candidate->factor, fit.ratio, sizeof candidate->factor);
    memcpy(candidate->factor_error, fit.ratio_error, sizeof candidate->factor_error);
    return NPH_OK;
}

static NphStatus try_candidate(Diagnosis *diagnosis, int index, int64_t samples) {
    Candidate *candidate = &diagnosis->candidates[index];
    int first = candidate->samples == 0;
    NPH_TRY(diagnose_extend(diagnosis, candidate, samples));
    candidate->state = CANDIDATE_OPEN;
    if (!nph_fit_clean(&candidate->image)) {
        candidate->state = CANDIDATE_EXCLUDED;
        candidate->fit.score = -HUGE_VAL;
        return NPH_OK;
    }
    if (first) find_twin(diagnosis, index);
    if (candidate->state != CANDIDATE_OPEN) return NPH_OK;
    NPH_TRY(nph_fit(diagnosis->session->context, &diagnosis->a, &candidate->image, &diagnosis->fit, &candidate->fit));
    if (candidate->fit.excluded) candidate->state = CANDIDATE_EXCLUDED;
    return index && !candidate->fit.excluded ? measure_factor(diagnosis, candidate) : NPH_OK;
}

static void sort_open(Diagnosis *diagnosis) {
    diagnosis->ranked = 0;
    for (int i = 0; i < CANDIDATES; i++) {
        int at = diagnosis->ranked;
        if (diagnosis->candidates[i].state != CANDIDATE_OPEN) continue;
        for (; at > 0; at--) {
            int above = diagnosis->ranking[at - 1];
            if (diagnosis->candidates[above].fit.score >= diagnosis->candidates[i].fit.score) break;
            diagnosis->ranking[at] = above;
        }
        diagnosis->ranking[at] = i;
        diagnosis->ranked++;
    }
}

static NphStatus rank(Diagnosis *diagnosis) {
    sort_open(diagnosis);
    const Candidate *best = &diagnosis->candidates[diagnosis->ranking[0]];
    for (int k = 1; k < diagnosis->ranked; k++) {
        Candidate *other = &diagnosis->candidates[diagnosis->ranking[k]];
        const NphImage *pictures[2] = {&best->image, &other->image};
        NPH_TRY(nph_fit_lead(diagnosis->session->context, &diagnosis->a, pictures, &diagnosis->fit, &other->behind));
    }
    return NPH_OK;
}

static int is_clear(const Diagnosis *diagnosis) {
    for (int k = 1; k < diagnosis->ranked; k++) {
        const Candidate *other = &diagnosis->candidates[diagnosis->ranking[k]];
        if (!diagnose_leads(other->behind.score, other->behind.noise)) return 0;
    }
    return 1;
}

double diagnose_samples_needed(const Candidate *candidate) { return candidate->reach > 0.0 ? least_lead / candidate->reach : 0.0; }

/* More samples would not help: A's own noise would hide it from pictures without any, or what is left shares its noise, and
 * A's own is no smaller. */
static int is_settled(const Diagnosis *diagnosis) {
    int as_many = diagnosis->a_samples > 0.0 && (double)diagnosis->samples >= diagnosis->a_samples;
    for (int k = 1; k < diagnosis->ranked; k++) {
        const NphLead *behind = &diagnosis->candidates[diagnosis->ranking[k]].behind;
        if (behind->reach >= least_lead && !(as_many && behind->noise <= 1.0)) return 0;
    }
    return 1;
}

/* One round with so many samples. The right picture is always brought along: others are measured by it. */
static NphStatus try_all(Diagnosis *diagnosis, int64_t samples) {
    for (int i = 0; i < CANDIDATES; i++) {
        Candidate *candidate = &diagnosis->candidates[i];
        if (i && samples > FIRST && candidate->state != CANDIDATE_OPEN) continue;
        NPH_TRY(try_candidate(diagnosis, i, samples));
        if (i && candidate->state != CANDIDATE_OPEN) diagnose_drop(diagnosis, candidate);
    }
    diagnosis->samples = samples;
    NPH_TRY(rank(diagnosis));
    if (!diagnosis->session->quiet)
        nph_info(diagnosis->session->context, "%lld samples per pixel: %d of %d pictures within A's error bars", (long long)samples,
                 diagnosis->ranked, CANDIDATES);
    return NPH_OK;
}

/* Few samples of a heavy-tailed picture may lack its brightest light: the likeliest that were excluded get another chance. */
static NphStatus try_again(Diagnosis *diagnosis) {
    int tried[CANDIDATES] = {0};
    for (int k = 0; k < AGAIN; k++) {
        int best = 0;
        for (int i = 1; i < CANDIDATES; i++) {
            const Candidate *candidate = &diagnosis->candidates[i];
            if (candidate->state != CANDIDATE_EXCLUDED || tried[i] || !isfinite(candidate->fit.score)) continue;
            if (!best || candidate->fit.score > diagnosis->candidates[best].fit.score) best = i;
        }
        if (!best) break;
        tried[best] = 1;
        NPH_TRY(try_candidate(diagnosis, best, diagnosis->samples));
        if (diagnosis->candidates[best].state != CANDIDATE_OPEN) diagnose_drop(diagnosis, &diagnosis->candidates[best]);
    }
    return rank(diagnosis);
}

/* Right: the comparison finds nothing, and no bug is far likelier. */
static int is_right(const Diagnosis *diagnosis) {
    const Candidate *right = &diagnosis->candidates[0];
    if (right->state != CANDIDATE_OPEN) return 0;
    return diagnosis->ranking[0] == 0 || !diagnose_leads(right->behind.score, right->behind.noise);
}

static NphStatus measure_shifts(Diagnosis *diagnosis) {
    for (int k = 0; k < diagnosis->ranked; k++) {
        Candidate *candidate = &diagnosis->candidates[diagnosis->ranking[k]];
        if (candidate->bug->number != 8 || diagnosis->a.width < 8 || diagnosis->a.height < 8) continue;
        NPH_TRY(nph_fit_shift(diagnosis->session->context, &candidate->image, &diagnosis->candidates[0].image, &candidate->shift));
        candidate->moved = 1;
    }
    return NPH_OK;
}

/* What a right picture could tell of the bugs that its error bars hide. */
static NphStatus measure_reach(Diagnosis *diagnosis) {
    for (int k = 0; k < diagnosis->ranked; k++) {
        Candidate *candidate = &diagnosis->candidates[diagnosis->ranking[k]];
        const NphImage *pictures[2] = {&diagnosis->candidates[0].image, &candidate->image};
        NphLead lead;
        if (candidate->bug->number == 0) continue;
        NPH_TRY(nph_fit_lead(diagnosis->session->context, &diagnosis->a, pictures, &diagnosis->fit, &lead));
        candidate->reach = lead.reach;
    }
    return NPH_OK;
}

static NphStatus judge(Diagnosis *diagnosis) {
    diagnosis->clear = is_clear(diagnosis);
    if (is_right(diagnosis)) {
        diagnosis->verdict = DIAGNOSED_RIGHT;
        return measure_reach(diagnosis);
    }
    NPH_TRY(measure_shifts(diagnosis));
    NPH_TRY(nph_fit_transforms(diagnosis->session->context, &diagnosis->a, &diagnosis->candidates[0].image, &diagnosis->fit,
                               &diagnosis->transform_count, diagnosis->transforms));
    diagnosis->verdict = diagnosis->ranked + diagnosis->transform_count > 0 ? DIAGNOSED_KNOWN : DIAGNOSED_UNKNOWN;
    return NPH_OK;
}

NphStatus diagnose_search(Diagnosis *diagnosis) {
    double begin = nph_seconds();
    for (int i = 0; i < CANDIDATES; i++) diagnosis->candidates[i].bug = &known_bugs[i];
    NPH_TRY(try_all(diagnosis, FIRST));
    while (diagnosis->ranked > 0 && diagnosis->samples < diagnosis->samples_most) {
        if (diagnosis->samples >= diagnosis->samples_least && (is_clear(diagnosis) || is_settled(diagnosis))) break;
        if (diagnosis->time_budget_s > 0.0 && nph_seconds() - begin > diagnosis->time_budget_s) break;
        int64_t samples = 2 * diagnosis->samples;
        NPH_TRY(try_all(diagnosis, samples < diagnosis->samples_most ? samples : diagnosis->samples_most));
    }
    if (diagnosis->ranked == 0 && diagnosis->samples < diagnosis->samples_least) {
        diagnosis->samples = diagnosis->samples_least;
        NPH_TRY(try_candidate(diagnosis, 0, diagnosis->samples));
    }
    if (diagnosis->ranked == 0) NPH_TRY(try_again(diagnosis));
    return judge(diagnosis);
}
