/* SPDX-License-Identifier: Apache-2.0
 *
 * How well a picture B, which some mistake would make, explains a picture A; and mistakes that need no rendering: a factor,
 * a mirrored, turned or shifted picture, exchanged channels, an encoding. docs/diagnose.md. */
#ifndef NPH_ORACLE_DIAGNOSE_H
#define NPH_ORACLE_DIAGNOSE_H

#include "nephos/compare.h"

/* A factor that a scene suggests. */
typedef struct NphConstant {
    char name[80];
    double value[3];      /* by channel */
} NphConstant;

typedef struct NphFitOptions {
    double alpha;         /* probability that the picture that A is of gets excluded */
    double a_samples;     /* A has no error bars: it has those of B at so many samples; 0: estimated, see nph_lend_noise */
    int constant_count;   /* beside the well-known ones: names of fitted factors */
    const NphConstant *constants;
} NphFitOptions;

/* What A says of B. */
typedef struct NphFit {
    int excluded;         /* A and B differ beyond error bars and margins: the verdict `different` of nph_compare */
    int lent;             /* A's error bars are not its own */
    double score;         /* ln of A's likelihood: Student's t with 8 degrees of freedom in each tile of 8 x 8 pixels */
    double score_noise;   /* standard deviation of the score by B's noise alone */
    double tiles;
    double ratio[4], ratio_error[4]; /* mean of A over mean of B: R, G, B, luminance; NAN where B is black */
    char reason[512];     /* the comparison's */
} NphFit;

NphStatus nph_fit(NphContext *context, const NphImage *a, const NphImage *b, const NphFitOptions *options, NphFit *fit);

/* How much likelier A is as one picture than as another of the same scene, samples and random numbers. */
typedef struct NphLead {
    double score; /* difference of the scores */
    double noise; /* what the noise of the pictures' difference, which they do not share, makes of it: a standard deviation */
    double reach; /* what it would be, in the mean, with an A of the first picture and pictures without noise: an estimate from
                     above, since noise adds to the pictures' difference. Proportional to A's samples while it is small */
} NphLead;
NphStatus nph_fit_lead(NphContext *context, const NphImage *a, const NphImage *const pictures[2], const NphFitOptions *options,
                       NphLead *lead);

/* A picture's sums as a comparison takes them: a variance too small for a float says nothing and becomes 0. Returns 0 where
 * values or variances are not finite, so that the picture cannot be compared. */
int nph_fit_clean(NphImage *image);

/* A's R, G, B with the variances that it does not have: B's pixel by pixel times k, as if one renderer had made both. k follows
 * from the number of samples; where that is 0, from A - B: half the sum over 2 x 2 pixels with alternating signs, whose
 * square is on average the noise alone where the expectations' difference is smooth. Tiles of 8 x 8, a tenth at either end left out. */
NphStatus nph_lend_noise(NphContext *context, const NphImage *a, const NphImage *b, double a_samples, NphImage *lent);

/* Least squares for A = f B moved by s pixels (right, down), for small s. */
typedef struct NphShift {
    double pixels[2], error[2];
} NphShift;
NphStatus nph_fit_shift(NphContext *context, const NphImage *a, const NphImage *b, NphShift *shift);

typedef struct NphTransform {
    char name[64];        /* "mirrored: left is right"; "a factor" */
    char known[80];       /* of the factor: "4 pi"; empty: none known */
    int factors;          /* fitted: 0, 1, or 3 (one a channel) */
    double factor[3], factor_error[3];
    int shifted;
    NphShift shift;
    NphFit fit;           /* score: less what choosing and fitting costs */
} NphTransform;

enum { NPH_MAX_TRANSFORMS = 64 };

/* All transforms of the right picture that A does not exclude, best first; room for NPH_MAX_TRANSFORMS. */
NphStatus nph_fit_transforms(NphContext *context, const NphImage *a, const NphImage *right, const NphFitOptions *options,
                             int *count, NphTransform *transforms);

#endif
