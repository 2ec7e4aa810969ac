/* SPDX-License-Identifier: Apache-2.0
 *
 * Scenes made without files: what a cross-built program without libraries can render. */
#ifndef NPH_TESTS_MADE_SCENES_H
#define NPH_TESTS_MADE_SCENES_H

#include "scene/model.h"

typedef struct MadeScene {
    const char *name;
    NphStatus (*fill)(NphContext *context, NphScene *scene);
    const char *methods; /* that render it, blank separated */
} MadeScene;

extern const MadeScene made_scenes[];
extern const int made_scene_count;

/* A scene of width x height pixels; nph_scene_free frees it. */
NphStatus made_scene(NphContext *context, const MadeScene *what, int width, int height, NphScene **scene);

#endif
