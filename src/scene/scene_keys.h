/* SPDX-License-Identifier: Apache-2.0
 *
 * The language of scene files as data: sections, their keys (type, unit, range, default, when they apply, meaning) and
 * which keys exclude each other. Reading, checking, docs/scene.md, the JSON Schema and "did you mean" all follow it.
 *
 * A section may have variants: values of its `type` key, or endings of its `file`. A row whose `applies` is set counts
 * for those variants only; one key may have several rows with different defaults. */
#ifndef NPH_SCENE_KEYS_H
#define NPH_SCENE_KEYS_H

#include <stddef.h>

#include "core/json.h"

enum { NPH_MAX_FRAME = 16777215, NPH_MAX_KEY_FRAMES = 4096 };

typedef enum NphKeyType {
    NPH_KEY_NUMBER,     /* one number */
    NPH_KEY_WHOLE,      /* one whole number */
    NPH_KEY_RGB,        /* one number or three, one a channel; where there are wavelengths one number or one for each */
    NPH_KEY_SPECTRUM,   /* wavelengths: 1 to 60 rising numbers */
    NPH_KEY_FACTORS,    /* one number or three, one an axis */
    NPH_KEY_VECTOR,     /* [x, y, z] */
    NPH_KEY_RESOLUTION, /* [width, height] */
    NPH_KEY_CROP,       /* [x0, y0, x1, y1] */
    NPH_KEY_INTERVAL,   /* [low, high], low < high */
    NPH_KEY_BOX,        /* [[x0, y0, z0], [x1, y1, z1]], low < high */
    NPH_KEY_MATRIX,     /* 12 numbers, row-major 3x4 */
    NPH_KEY_WORD,       /* one of `words` */
    NPH_KEY_TEXT,
    NPH_KEY_FILE,       /* a path, relative to the scene file; # stands for digits of the frame */
    NPH_KEY_FRAMES,     /* 1 to NPH_MAX_KEY_FRAMES rising whole numbers */
    NPH_KEY_VALUES,     /* as many values of an animated key */
    NPH_KEY_SECTION,    /* a mapping; `words` names the section */
    NPH_KEY_LIST        /* a list of mappings; `words` names the section */
} NphKeyType;

typedef struct NphSceneKey {
    const char *section, *key;
    NphKeyType type;
    double min, max;      /* of every number, both allowed */
    const char *unit;     /* "" where there is none */
    const char *words;    /* "a|b|c", or the section's name */
    const char *fallback; /* as it would be written; nph_key_required; NULL: may be left out, meaning tells what then */
    const char *applies;  /* variants "a|b"; NULL: all */
    const char *meaning;
} NphSceneKey;

typedef struct NphSceneSectionInfo {
    const char *name, *place; /* place: "a medium", as messages name it */
    const char *variant_key;  /* "type", "file" or NULL */
    const char *variants;     /* "a|b": the types, or the endings of files */
    const char *meaning;
} NphSceneSectionInfo;

/* Exactly one of the alternatives separated by '|' is given. An alternative is keys separated by blanks; those with '?'
 * may be left out, but not all keys of the chosen one. */
typedef struct NphSceneRule {
    const char *section, *applies, *alternatives;
} NphSceneRule;

extern const char nph_key_required[];
extern const NphSceneKey nph_scene_keys[]; /* sections are contiguous */
extern const int nph_scene_key_count;
extern const NphSceneSectionInfo nph_scene_sections[];
extern const int nph_scene_section_count;
extern const NphSceneRule nph_scene_rules[];
extern const int nph_scene_rule_count;

const NphSceneSectionInfo *nph_scene_section_info(const char *name);
/* First row of a section; *count rows follow. */
const NphSceneKey *nph_scene_section_keys(const char *section, int *count);

/* 1 where {frames, values} may stand in place of a value. */
int nph_key_animates(NphKeyType type);

/* Position of a word in "a|b|c", or -1. */
int nph_words_index(const char *words, const char *word);
/* The n-th word, copied (cut to fit); 0 when there are not that many. */
int nph_words_get(const char *words, int n, char *word, size_t size);
/* 1 when words is NULL, variant is NULL, or variant is one of words. */
int nph_words_apply(const char *words, const char *variant);

/* Damerau's distance (optimal string alignment); words of 64 and more characters count as far apart. */
int nph_edit_distance(const char *a, const char *b);
/* 1 when b is close enough to a to be what was meant. */
int nph_edit_close(const char *a, const char *b);

/* A limit as people write it: 1e9, 0.001. size >= NPH_DOUBLE_TEXT. Returns text. */
const char *nph_limit_text(double value, char *text);

/* docs/scene.md and docs/scene.schema.json, piece by piece. */
void nph_scene_keys_markdown(NphTextFn write, void *user);
void nph_scene_keys_json(NphTextFn write, void *user);

#endif
