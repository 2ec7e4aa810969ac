/* SPDX-License-Identifier: Apache-2.0
 *
 * Reading a scene file section by section after the table of keys. Mistakes are reported where they are found and
 * counted; reading goes on, so that one run shows them all. Only running out of memory ends it at once. */
#ifndef NPH_SCENE_READ_H
#define NPH_SCENE_READ_H

#include <yaml.h>

#include "core/message.h"
#include "field/kelvin.h"
#include "optics/mie_cloud.h"
#include "scene/model.h"
#include "scene/scene_keys.h"

enum { NPH_SECTION_KEYS = 20, NPH_SHOWN_MISTAKES = 50, NPH_QUOTE_BYTES = 64, NPH_SCENE_BYTES = 1 << 20 };
#define NPH_SCENE_TOO_LARGE \
    "a scene file has at most %d bytes, this one has %llu; volumes and images stand in files of their own"

typedef struct NphScenePlace {
    int line, column; /* from 1 */
    int animated;     /* what stands there depends on the frame */
} NphScenePlace;

/* What a medium, light or surface names and is loaded once the whole file has been checked. Texts belong to the document. */
typedef struct NphSceneFile {
    char *path; /* NULL: none */
    const char *grid;
    NphScenePlace place, extinction_place;
    int kind; /* of a volume: NphVolumeKind */
    NphCentring centring;
    NphOutside outside;
    NphLookup lookup;
    double lo[3], hi[3];
    double scale[3]; /* of an environment */
    int hot;          /* its values are temperatures, in these units */
    NphKelvin kelvin;
} NphSceneFile;

/* What a medium emits; with a path: from a grid. */
typedef struct NphSceneEmission {
    NphSceneFile file;
    NphScenePlace place;
    int blackbody;
    double kelvin; /* of one temperature everywhere */
} NphSceneEmission;

/* Spheres whose phase function is computed. */
typedef struct NphSceneMie {
    int given;
    NphScenePlace place;
    NphMieRequest request;
} NphSceneMie;

typedef enum NphVolumeKind { NPH_VOLUME_NVDB, NPH_VOLUME_NPY, NPH_VOLUME_LES, NPH_VOLUME_VOL, NPH_VOLUME_PBRT, NPH_VOLUME_VDB } NphVolumeKind;

typedef struct NphSceneReader {
    NphContext *context;
    NphScene *scene;
    const char *name;   /* of the file, in messages */
    const char *folder; /* where the files it names are looked up */
    const char *text;   /* the bytes, without a byte order mark */
    size_t size;
    yaml_document_t document;
    int has_document;
    int mistakes;   /* in the scene */
    int bad_inputs; /* in files it names */
    uint32_t frame;
    int unsure;     /* the wavelengths are wrong: lists of any length go for RGB */
    NphSceneFile volumes[NPH_MAX_MEDIA], phases[NPH_MAX_MEDIA], maps[NPH_MAX_LIGHTS], meshes[NPH_MAX_SURFACES];
    double world_from_mesh[NPH_MAX_SURFACES][12];
    NphSceneEmission emissions[NPH_MAX_MEDIA];
    NphSceneMie mies[NPH_MAX_MEDIA], aerosol_mie;
    NphScenePlace period_place;
    NphScenePlace air_place, height_place;   /* of the air; line 0: no height is written */
    NphSceneFile air_profile, aerosol_phase;
    NphScenePlace light_places[NPH_MAX_LIGHTS];
    int bare[NPH_MAX_LIGHTS]; /* lights that the air does not attenuate */
    int sky_rows[NPH_MAX_LIGHTS]; /* of lights that are a sky: of its map; else 0 */
} NphSceneReader;

typedef struct NphSceneValue {
    int given; /* written in the file */
    int valid; /* usable: written and right, or the default */
    NphScenePlace place;
    double number[NPH_MAX_WAVELENGTHS]; /* factors are always three; rgb too, or as many as there are wavelengths */
    int count;          /* of a list of wavelengths */
    int word;           /* index into the key's words */
    const char *text;
    const yaml_node_t *node;
} NphSceneValue;

typedef struct NphSceneSection {
    const NphSceneSectionInfo *info;
    const yaml_node_t *node;
    NphScenePlace place;
    char variant[16]; /* "" where there is none or it is unknown */
    int variant_unknown;
    const NphSceneKey *keys;
    int count;
    int chosen[4]; /* alternative taken of each rule of the section, in the table's order; -1: none or several */
    NphSceneValue values[NPH_SECTION_KEYS];
} NphSceneSection;

/* scene_yaml.c: checks the bytes and loads reader->document. NPH_NO_MEMORY, else NPH_OK: see has_document, mistakes. */
NphStatus nph_scene_document(NphSceneReader *reader, const char *text, size_t size);

/* scene_report.c */
NphScenePlace nph_node_place(const yaml_node_t *node);
void nph_scene_mistake(NphSceneReader *reader, NphScenePlace place, const char *format, ...) NPH_PRINTF(3, 4);
/* Also counts in bad_inputs instead of mistakes. */
void nph_scene_bad_input(NphSceneReader *reader, NphScenePlace place, const char *format, ...) NPH_PRINTF(3, 4);
/* What a node says, cut and made printable, or what it is ("a list"). buffer: NPH_QUOTE_BYTES. Returns buffer. */
const char *nph_node_quote(const yaml_node_t *node, char *buffer);
const char *nph_text_quote(const char *text, size_t length, char *buffer);

/* scene_value.c: one value of a key; 0 when mistakes were reported. */
int nph_value_read(NphSceneReader *reader, const NphSceneKey *key, const yaml_node_t *node, NphSceneValue *value);
void nph_value_default(const NphSceneKey *key, NphSceneValue *value);
/* The same of one that may not be animated; then what holds between its numbers. */
int nph_value_read_still(NphSceneReader *reader, const NphSceneKey *key, const yaml_node_t *node, NphSceneValue *value);
int nph_value_check(NphSceneReader *reader, const NphSceneKey *key, const NphSceneValue *value);
/* 1 for an empty value or null. */
int nph_node_is_null(const yaml_node_t *node);

/* scene_animated.c: {frames, values} in place of a value, as of the reader's frame. */
int nph_animated_read(NphSceneReader *reader, const NphSceneKey *key, const yaml_node_t *node, NphSceneValue *value);
/* 1 for a mapping that is meant to be one: a key of it is frames or values, or nearly so. */
int nph_animated_meant(NphSceneReader *reader, const yaml_node_t *node);

/* scene_wavelengths.c: the wavelengths key, taken before all others; what an RGB key says, as three numbers and, where
 * there are wavelengths, as a spectrum; what does not go with them. */
void nph_scene_read_wavelengths(NphSceneReader *reader, const NphSceneSection *scene);
void nph_scene_take_rgb(const NphSceneReader *reader, const NphSceneValue *value, double rgb[3], double *spectrum);
void nph_scene_check_map(NphSceneReader *reader, const NphSceneFile *file, const NphEnvironment *map);

/* scene_section.c: all keys of a mapping; 0 when it is no mapping. Mistakes within leave values invalid. */
int nph_section_read(NphSceneReader *reader, const yaml_node_t *node, const char *name, NphSceneSection *section);
/* The value of a key when it is usable, else NULL. */
const NphSceneValue *nph_section_value(const NphSceneSection *section, const char *key);

/* scene_camera.c, scene_media.c, scene_transform.c, scene_lights.c, scene_surfaces.c: from sections to the model. */
void nph_scene_read_camera(NphSceneReader *reader, const yaml_node_t *node);
/* scene_period.c. check: once all media are loaded. */
void nph_scene_read_period(NphSceneReader *reader, const yaml_node_t *node);
void nph_scene_check_period(NphSceneReader *reader);
NphStatus nph_scene_read_media(NphSceneReader *reader, const yaml_node_t *list);
NphStatus nph_scene_read_lights(NphSceneReader *reader, const yaml_node_t *list);
NphStatus nph_scene_read_surfaces(NphSceneReader *reader, const yaml_node_t *list);
void nph_scene_check_reach(NphSceneReader *reader, NphScenePlace place, const NphMedium *medium);
/* 0 after mistakes. layer: only what keeps a layer level. */
int nph_scene_read_transform(NphSceneReader *reader, const yaml_node_t *list, int layer, double world_from_medium[12]);

/* scene_emission.c: the section; then, with the medium's own file loaded, what it names; then what is left unmodelled. */
NphStatus nph_scene_read_emission(NphSceneReader *reader, const NphSceneValue *value, int index);
NphStatus nph_scene_load_emission(NphSceneReader *reader, int index);
NphStatus nph_scene_find_unmodelled(NphSceneReader *reader);

/* scene_mie.c: a phase section of type mie; then, where it was given, its table. name: of what it belongs to. */
void nph_scene_read_mie(NphSceneReader *reader, const NphSceneSection *section, NphSceneMie *mie);
NphStatus nph_scene_load_mie(NphSceneReader *reader, const NphSceneMie *mie, const char *name, NphPhase *phase);

/* scene_air.c: the section. scene_air_lights.c: with everything else there, the lights as they arrive, and skies. */
NphStatus nph_scene_read_air(NphSceneReader *reader, const yaml_node_t *node);
NphStatus nph_scene_attenuate_lights(NphSceneReader *reader);
/* scene_air_within.c: the media that the air is, where it is within the scene. */
NphStatus nph_scene_air_within(NphSceneReader *reader);

/* scene_media.c: a section of a phase function, and one of a density file. */
NphStatus nph_scene_read_phase(NphSceneReader *reader, const NphSceneValue *value, NphPhase *phase, NphSceneFile *table, NphSceneMie *mie);
NphStatus nph_scene_read_density(NphSceneReader *reader, const NphSceneValue *value, NphSceneFile *volume);

/* scene_files.c: the path of a file named at a place, `number` in place of each run of #; a file that cannot be read is reported as
 * bad input. */
NphStatus nph_scene_file_path(NphSceneReader *reader, const NphSceneValue *value, const char *what, uint32_t number, char **path);
NphStatus nph_scene_load_files(NphSceneReader *reader);
/* A file's own failure is noted at its place, and the next one is tried; what concerns the run ends it. */
NphStatus nph_scene_note(NphSceneReader *reader, const NphSceneFile *file, const char *what, NphStatus status);

/* scene_surfaces.c: meshes, and when all are there the hierarchy over them. */
NphStatus nph_scene_load_meshes(NphSceneReader *reader);
NphStatus nph_scene_build_surfaces(NphContext *context, NphScene *scene);
NphStatus nph_scene_load_volume(NphSceneReader *reader, const NphSceneFile *file, const char *what, NphGrid *grid);

/* scene_digest.c */
NphStatus nph_scene_digest(NphContext *context, NphScene *scene);

#endif
