/* SPDX-License-Identifier: Apache-2.0
 *
 * nephos diagnose: which known bug explains a picture. The scene is rendered without a bug and with each, with few samples
 * first; what A excludes is dropped, the samples of the rest are doubled. docs/diagnose.md. */
#ifndef NPH_ALTERED_DIAGNOSIS_H
#define NPH_ALTERED_DIAGNOSIS_H

#include "cli/session.h"
#include "nephos/render.h"
#include "oracle/diagnose.h"

typedef struct KnownBug {
    int number;
    const char *name, *what;
} KnownBug;

enum { KNOWN_BUGS = 31, CANDIDATES = KNOWN_BUGS + 1 };
/* By number; 0 is the right picture. */
extern const KnownBug known_bugs[CANDIDATES];

/* The bug of that number or name; NULL: there is none. */
const KnownBug *known_bug_find(const char *word);

typedef enum CandidateState {
    CANDIDATE_OPEN,
    CANDIDATE_EXCLUDED,
    CANDIDATE_HIDDEN, /* the bytes of the right picture: cannot show in this scene */
    CANDIDATE_TWIN    /* the bytes of another candidate's picture */
} CandidateState;

typedef struct Candidate {
    const KnownBug *bug;
    CandidateState state;
    int twin;             /* whose */
    int failed;           /* the numeric checks of the run failed, as they should with some bugs */
    int64_t samples;
    NphFilm *film;
    NphImage image;
    NphFit fit;
    NphLead behind;              /* of the best candidate against this one */
    double reach;                /* of the right picture against this one, where that is the verdict */
    double factor[4], factor_error[4]; /* mean over the right picture's mean: R, G, B, luminance */
    int moved;
    NphShift shift;       /* of grids that lie elsewhere: by how many pixels */
} Candidate;

typedef enum Diagnosed { DIAGNOSED_RIGHT, DIAGNOSED_KNOWN, DIAGNOSED_UNKNOWN } Diagnosed;

typedef struct Diagnosis {
    Session *session;
    const char *scene_path;
    NphScene *scene;
    NphImage a;
    NphRenderOptions render;     /* seed, crop, knobs */
    NphFitOptions fit;
    double a_samples;            /* of A per pixel; 0: unknown */
    int64_t samples, samples_least, samples_most; /* of each picture: reached; for a verdict; at most */
    double time_budget_s;
    Candidate candidates[CANDIDATES];
    int transform_count;
    NphTransform transforms[NPH_MAX_TRANSFORMS];
    Diagnosed verdict;
    int clear;                   /* nothing that is left comes near the best */
    int ranking[CANDIDATES], ranked; /* open candidates, the likeliest first */
} Diagnosis;

/* diagnose_render.c. Renders a scene with a bug, whatever the numeric checks say: *failed. */
NphStatus diagnose_render(Session *session, const char *scene_path, const NphScene *scene, int bug, const NphRenderOptions *options,
                          NphFilm **film, int *failed);
/* Brings a candidate up to that many samples. */
NphStatus diagnose_extend(Diagnosis *diagnosis, Candidate *candidate, int64_t samples);
void diagnose_drop(Diagnosis *diagnosis, Candidate *candidate); /* film and image */

/* diagnose_search.c. From a, scene and options to a verdict. */
NphStatus diagnose_search(Diagnosis *diagnosis);
/* Is a lead in score more than chance and noise give? */
int diagnose_leads(double lead, double noise);
/* How many times its samples an A of the right picture must have for a lead over that candidate; 0: unknown. */
double diagnose_samples_needed(const Candidate *candidate);

/* diagnose_report.c */
void diagnose_text(const Diagnosis *diagnosis, const char *picture);
void diagnose_json(const Diagnosis *diagnosis, const char *picture);

#endif
