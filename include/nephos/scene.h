/* SPDX-License-Identifier: Apache-2.0
 *
 * Scenes: read from a YAML (or JSON) file, validated, immutable afterwards. Keys: docs/scene.md. */
#ifndef NEPHOS_SCENE_H
#define NEPHOS_SCENE_H

#include <stddef.h>

#include "nephos/context.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct NphScene NphScene;

/* Reads and checks a scene and every file it names (relative to the scene's folder). Each mistake found is reported as
 * FILE:LINE:COLUMN: message; then NPH_BAD_SCENE, or NPH_BAD_INPUT when a file it names is damaged. */
NphStatus nph_scene_load(NphContext *context, const char *path, NphScene **scene);

/* The same from memory; name stands for the file in messages, folder (NULL: ".") is where files are looked up. */
NphStatus nph_scene_parse(NphContext *context, const char *text, size_t size, const char *name, const char *folder,
                          NphScene **scene);

/* The scene as of a frame. */
NphStatus nph_scene_load_frame(NphContext *context, const char *path, uint32_t frame, NphScene **scene);
NphStatus nph_scene_at_frame(NphContext *context, const NphScene *scene, uint32_t frame, NphScene **other);
int nph_scene_is_animated(const NphScene *scene);

void nph_scene_free(NphContext *context, NphScene *scene);

#ifdef __cplusplus
}
#endif
#endif
