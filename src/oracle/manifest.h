/* SPDX-License-Identifier: Apache-2.0
 *
 * manifest.json of a dump, read back. Whoever writes one by hand needs: method, buffers (name; comparison, identity and
 * queue where they are not the method's), launches (batch, number, stage, outputs: buffer and file). */
#ifndef NPH_ORACLE_MANIFEST_H
#define NPH_ORACLE_MANIFEST_H

#include "nephos/verify.h"

enum { NPH_MANIFEST_KNOBS = 64, NPH_MANIFEST_LIST = 64 /* numbers of a list that is kept */ };

typedef struct NphManifestFile {
    char *buffer, *file; /* file: below the folder */
    char *digest;        /* of an output's elements; NULL: not told */
} NphManifestFile;

typedef struct NphManifestLaunch {
    int64_t batch, number;
    char *stage;
    int argument_count, input_count, output_count;
    char *argument_names[8];
    int64_t arguments[8];
    NphManifestFile *inputs, *outputs;
} NphManifestLaunch;

/* Numbers that stand somewhere in the manifest: "media.0.sigma". */
typedef struct NphManifestNumbers {
    char *name;
    int count;
    double *values;
} NphManifestNumbers;

typedef struct NphManifest {
    char *folder, *scene, *scene_digest, *method;
    int precision, plan_full;
    uint32_t seed, frame, scene_frame; /* frame: of the random numbers */
    int64_t samples[2];
    int crop[4], crop_given;
    int knob_count, launch_count, number_count, half_count;
    char *knobs[NPH_MANIFEST_KNOBS]; /* "path.roulette=0.1" */
    char *halves[NPH_MAX_BUFFERS];   /* buffers whose type is said to be f16 */
    NphManifestLaunch *launches;     /* in the order of batch and number */
    NphManifestNumbers *numbers;     /* but those of stages, buffers and launches */
} NphManifest;

struct NphDumpRun {
    NphManifest manifest;
    NphRenderOptions options;
};

/* folder: of the dump, or its manifest.json. NPH_BAD_INPUT with file, line and what is wrong. */
NphStatus nph_manifest_read(NphContext *context, const char *folder, NphManifest *manifest);
void nph_manifest_free(NphContext *context, NphManifest *manifest);

const NphManifestLaunch *nph_manifest_find(const NphManifest *manifest, int64_t batch, int64_t number);

/* Reads a file of a launch as an array. */
NphStatus nph_manifest_array(NphContext *context, const NphManifest *manifest, const char *file, NphArray *array);

/* The run that made the dump, as options; they point into the manifest. */
void nph_manifest_options(const NphManifest *manifest, NphRenderOptions *options);

#endif
