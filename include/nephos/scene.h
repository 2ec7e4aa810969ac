/* SPDX-License-Identifier: Apache-2.0
 *
 * Scenes: read from a YAML (or JSON) file, validated, immutable afterwards. Keys: docs/scene.md. */
#ifndef NEPHOS_SCENE_H
#define NEPHOS_SCENE_H

#include <stddef.h>
#include <stdint.h>

#include "nephos/context.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct NphScene NphScene;

/* Reads and checks a scene and every file it names (relative to the scene's folder). Each mistake found is reported as
 * FILE:LINE:COLUMN: message; then NPH_BAD_SCENE, or NPH_BAD_INPUT when a file it names is damaged. */
NphStatus nph_scene_load(NphContext *context, const char *path, NphScene **scene);

/* As of a frame, 0 to 16777215: animated values, files numbered with #. The other functions that read scenes take frame 0. A frame
 * beyond is NPH_BAD_USAGE. Noise has a frame of its own, NphRenderOptions.frame. */
NphStatus nph_scene_load_frame(NphContext *context, const char *path, uint32_t frame, NphScene **scene);

/* The same from memory; name stands for the file in messages, folder (NULL: ".") is where files are looked up. */
NphStatus nph_scene_parse(NphContext *context, const char *text, size_t size, const char *name, const char *folder,
                          NphScene **scene);

/* Another frame of a scene: its text is read again, as it was when the scene was, and so are the files it names. `scene` stays as it
 * is; both are freed by nph_scene_free. NPH_BAD_USAGE where the scene was made without a text. */
NphStatus nph_scene_at_frame(NphContext *context, const NphScene *scene, uint32_t frame, NphScene **other);

/* 1 where another frame may differ: it has animated values or numbered files. */
int nph_scene_is_animated(const NphScene *scene);

void nph_scene_free(NphContext *context, NphScene *scene);

#ifdef __cplusplus
}
#endif
#endif
