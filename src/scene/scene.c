/* SPDX-License-Identifier: Apache-2.0
 *
 * Scenes from files and from memory: bytes, document, sections, files, digest, in this order; each step only when the
 * one before left no mistake. */
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "core/float_state.h"
#include "core/memory.h"
#include "io/file.h"
#include "scene/scene_read.h"

static void read_render(NphSceneReader *reader, const NphSceneValue *value) {
    NphSceneSection render;
    const NphSceneValue *samples, *seed;
    reader->scene->default_spp = 64;
    reader->scene->default_seed = 1;
    if (!value || !nph_section_read(reader, value->node, "render", &render)) return;
    if ((samples = nph_section_value(&render, "samples"))) reader->scene->default_spp = (int64_t)samples->number[0];
    if ((seed = nph_section_value(&render, "seed"))) reader->scene->default_seed = (uint32_t)seed->number[0];
}

static NphStatus read_sections(NphSceneReader *reader) {
    NphSceneSection scene;
    const NphSceneValue *value;
    if (!nph_section_read(reader, yaml_document_get_root_node(&reader->document), "scene", &scene)) return NPH_OK;
    nph_scene_read_wavelengths(reader, &scene);
    if ((value = nph_section_value(&scene, "camera"))) nph_scene_read_camera(reader, value->node);
    if ((value = nph_section_value(&scene, "media"))) NPH_TRY(nph_scene_read_media(reader, value->node));
    if ((value = nph_section_value(&scene, "lights"))) NPH_TRY(nph_scene_read_lights(reader, value->node));
    if ((value = nph_section_value(&scene, "air"))) NPH_TRY(nph_scene_read_air(reader, value->node));
    if ((value = nph_section_value(&scene, "surfaces"))) NPH_TRY(nph_scene_read_surfaces(reader, value->node));
    if ((value = nph_section_value(&scene, "periodic"))) nph_scene_read_period(reader, value->node);
    read_render(reader, nph_section_value(&scene, "render"));
    return NPH_OK;
}

static NphStatus read_scene(NphSceneReader *reader, const char *text, size_t size) {
    NPH_TRY(nph_scene_document(reader, text, size));
    if (reader->has_document) NPH_TRY(read_sections(reader));
    if (reader->mistakes == 0 && reader->bad_inputs == 0) NPH_TRY(nph_scene_load_files(reader));
    if (reader->mistakes == 0 && reader->bad_inputs == 0) nph_scene_check_period(reader);
    if (reader->mistakes == 0 && reader->bad_inputs == 0) NPH_TRY(nph_scene_attenuate_lights(reader));
    if (reader->mistakes) return NPH_BAD_SCENE;
    if (reader->bad_inputs) return NPH_BAD_INPUT;
    NPH_TRY(nph_scene_build_surfaces(reader->context, reader->scene));
    return nph_scene_digest(reader->context, reader->scene);
}

static const char *base_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static void close_reader(NphSceneReader *reader) {
    if (reader->has_document) yaml_document_delete(&reader->document);
    for (int i = 0; i < NPH_MAX_MEDIA; i++) {
        nph_free(reader->context, reader->volumes[i].path);
        nph_free(reader->context, reader->phases[i].path);
        nph_free(reader->context, reader->emissions[i].file.path);
    }
    for (int i = 0; i < NPH_MAX_LIGHTS; i++) nph_free(reader->context, reader->maps[i].path);
    for (int i = 0; i < NPH_MAX_SURFACES; i++) nph_free(reader->context, reader->meshes[i].path);
    nph_free(reader->context, reader->air_profile.path);
    nph_free(reader->context, reader->aerosol_phase.path);
    nph_free(reader->context, reader);
}

static NphStatus read_again(NphContext *context, const NphSceneSource *source, uint32_t frame, NphScene **scene);

static NphStatus keep_source(NphContext *context, const char *text, size_t size, const char *name, const char *folder,
                             NphSceneSource *source) {
    NPH_TRY(nph_strdup(context, name, &source->name));
    NPH_TRY(nph_strdup(context, folder, &source->folder));
    NPH_TRY(NPH_NEW(context, size, "text of a scene", &source->text));
    memcpy(source->text, text, size);
    source->size = size;
    source->read = read_again;
    return NPH_OK;
}

static NphStatus parse(NphContext *context, const char *text, size_t size, const char *name, const char *folder, uint32_t frame,
                       NphScene **scene) {
    NphSceneReader *reader = NULL;
    NphScene *made = NULL;
    NphFloatState state;
    if (frame > NPH_MAX_FRAME) return nph_error(context, NPH_BAD_USAGE, "frame: %u is above %d", (unsigned)frame, (int)NPH_MAX_FRAME);
    NPH_TRY(NPH_NEW(context, 1, "scene reader", &reader));
    reader->context = context;
    reader->name = name;
    reader->folder = folder && folder[0] ? folder : ".";
    reader->frame = frame;
    NphStatus status = NPH_NEW(context, 1, "scene", &made);
    if (status == NPH_OK) {
        reader->scene = made;
        made->frame = frame;
        status = nph_strdup(context, base_name(name), &made->name);
    }
    nph_float_state_enter(&state);
    if (status == NPH_OK) status = read_scene(reader, text, size);
    nph_float_state_leave(&state);
    if (status == NPH_OK) status = keep_source(context, text, size, name, reader->folder, &made->source);
    close_reader(reader);
    if (status != NPH_OK) {
        nph_scene_free(context, made);
        return status;
    }
    *scene = made;
    return NPH_OK;
}

static NphStatus read_again(NphContext *context, const NphSceneSource *source, uint32_t frame, NphScene **scene) {
    return parse(context, source->text, source->size, source->name, source->folder, frame, scene);
}

NphStatus nph_scene_parse(NphContext *context, const char *text, size_t size, const char *name, const char *folder,
                          NphScene **scene) {
    return parse(context, text, size, name, folder, 0, scene);
}

NphStatus nph_scene_load_frame(NphContext *context, const char *path, uint32_t frame, NphScene **scene) {
    char *bytes = NULL, *folder = NULL;
    size_t size = 0, length = (size_t)(base_name(path) - path);
    struct stat facts;
    if (stat(path, &facts) == 0 && facts.st_size > NPH_SCENE_BYTES)
        return nph_error(context, NPH_BAD_SCENE, "%s:1:1: " NPH_SCENE_TOO_LARGE, path, (int)NPH_SCENE_BYTES,
                         (unsigned long long)facts.st_size);
    NphStatus status = nph_file_read(context, path, &bytes, &size);
    if (status != NPH_OK) return status == NPH_BAD_INPUT ? NPH_BAD_SCENE : status; /* the scene is what is missing */
    status = nph_strdup(context, path, &folder);
    if (status == NPH_OK) {
        folder[length > 1 ? length - 1 : length] = 0; /* "a/b.yaml" -> "a", "/b.yaml" -> "/", "b.yaml" -> "" */
        status = parse(context, bytes, size, path, folder, frame, scene);
    }
    nph_free(context, folder);
    nph_free(context, bytes);
    return status;
}

NphStatus nph_scene_load(NphContext *context, const char *path, NphScene **scene) {
    return nph_scene_load_frame(context, path, 0, scene);
}
