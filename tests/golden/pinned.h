/* SPDX-License-Identifier: Apache-2.0
 *
 * Pinned digests: reference/golden/digests/SCENE.csv has a row for every buffer that a stage writes and every channel of the picture,
 * of every method that takes the scene; SCENE.npy some cells of each, in the order of the rows, as pairs of u64: batch << 48 |
 * number << 32 | index, and the value's bits. docs/determinism.md. */
#ifndef NPH_TESTS_PINNED_H
#define NPH_TESTS_PINNED_H

#include "../bytes/stage_digests.h"

enum { PINNED_SCENES = 64 };

typedef struct PinnedRow {
    char method[DIGEST_NAME];
    DigestRow row;
    char since[16];  /* the release that first has this digest */
    char before[16]; /* the last one that had another; "" where none had one */
} PinnedRow;

typedef struct Pinned {
    int count;
    PinnedRow *rows; /* nph_free */
} Pinned;

/* Names of all scenes of reference/scenes, sorted. root: of the source tree. */
int pinned_scenes(const char *root, char names[PINNED_SCENES][DIGEST_NAME]);

/* A scene at 64 x 48 pixels, and what a method is run with on it. */
NphStatus pinned_scene(NphContext *context, const char *root, const char *name, NphScene **scene);
NphRenderOptions pinned_options(const char *method);

/* Renders a scene at 64 x 48 pixels by every method that takes it. */
NphStatus pinned_take(NphContext *context, const char *root, const char *scene, Pinned *pinned);

/* NPH_BAD_INPUT, with a message, where there are none. */
NphStatus pinned_read(NphContext *context, const char *root, const char *scene, Pinned *pinned);
NphStatus pinned_write(NphContext *context, const char *root, const char *scene, const Pinned *pinned);

/* The row of the same method, stage and buffer, or NULL. */
const PinnedRow *pinned_find(const Pinned *pinned, const PinnedRow *like);

/* How two rows differ, in words. */
void pinned_difference(const PinnedRow *before, const PinnedRow *now, char *text, size_t size);

/* The section of a release in CHANGELOG.md: 0 where there is none. *released: its heading does not say "not released". */
int changelog_section(const char *changelog, const char *release, int *released);
/* The newest release; "" before the first. */
void changelog_newest(const char *changelog, char release[16]);
/* Whether the section of row->since has a line that speaks of digests, names the stage (of a picture: the method too) and
 * row->before. 1 where nothing was released before. */
int changelog_tells(const char *changelog, const PinnedRow *row);

#endif
