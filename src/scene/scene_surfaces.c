/* SPDX-License-Identifier: Apache-2.0
 *
 * The surfaces section to NphSurface. Meshes are read once the whole file has been checked, moved into world space in
 * double precision, and put into one hierarchy about the origin of scene-local space. */
#include <stdio.h>
#include <string.h>

#include "core/memory.h"
#include "io/triangles.h"
#include "scene/scene_read.h"

static const double FARTHEST_M = 1e12;

static NphStatus read_name(NphSceneReader *reader, const NphSceneSection *section, int index) {
    const NphSceneValue *name = nph_section_value(section, "name");
    char own[24], quote[NPH_QUOTE_BYTES];
    NphSurface *surfaces = reader->scene->surfaces;
    snprintf(own, sizeof own, "surface%d", index);
    const char *text = name ? name->text : own;
    for (int i = 0; i < index; i++) {
        if (strcmp(surfaces[i].name, text) != 0) continue;
        nph_scene_mistake(reader, name ? name->place : section->place,
                          "the name %s is taken by surface number %d; names differ",
                          nph_text_quote(text, strlen(text), quote), i);
        break;
    }
    return nph_strdup(reader->context, text, &surfaces[index].name);
}

static NphStatus read_mesh(NphSceneReader *reader, const NphSceneSection *section, int index) {
    const NphSceneValue *mesh = nph_section_value(section, "mesh");
    const NphSceneValue *transform = nph_section_value(section, "transform");
    NphSceneFile *file = &reader->meshes[index];
    char quote[NPH_QUOTE_BYTES];
    if (transform) nph_scene_read_transform(reader, transform->node, 0, reader->world_from_mesh[index]);
    if (!mesh) return NPH_OK;
    const char *ending = strrchr(mesh->text, '.');
    file->place = mesh->place;
    file->kind = ending && strcmp(ending, ".ply") == 0;
    if (!ending || (!file->kind && strcmp(ending, ".obj") != 0))
        nph_scene_mistake(reader, mesh->place, "mesh: %s ends in none of .obj, .ply", nph_node_quote(mesh->node, quote));
    return nph_scene_file_path(reader, mesh, "mesh", reader->frame, &file->path);
}

static NphStatus read_surface(NphSceneReader *reader, const yaml_node_t *node, int index) {
    NphSceneSection section;
    NphSurface *surface = &reader->scene->surfaces[index];
    nph_affine_identity(reader->world_from_mesh[index]);
    int whole = nph_section_read(reader, node, "surface", &section);
    NPH_TRY(read_name(reader, &section, index));
    if (!whole) return NPH_OK;
    const NphSceneValue *albedo = nph_section_value(&section, "albedo"), *plane = nph_section_value(&section, "plane");
    if (albedo) nph_scene_take_rgb(reader, albedo, surface->albedo, surface->albedo_spectrum);
    if (section.chosen[0] == 0) return read_mesh(reader, &section, index);
    surface->is_plane = 1;
    if (section.chosen[0] == 1 && plane) surface->height_m = plane->number[0];
    return NPH_OK;
}

NphStatus nph_scene_read_surfaces(NphSceneReader *reader, const yaml_node_t *list) {
    yaml_node_item_t *items = list->data.sequence.items.start;
    int count = (int)(list->data.sequence.items.top - items);
    for (int i = 0; i < count && i < NPH_MAX_SURFACES; i++) {
        reader->scene->surface_count = i + 1;
        NPH_TRY(read_surface(reader, yaml_document_get_node(&reader->document, items[i]), i));
    }
    return NPH_OK;
}

static NphStatus load_mesh(NphContext *context, const NphSceneFile *file, const double map[12], NphMesh *mesh) {
    NphTriangles triangles = {0};
    NPH_TRY(file->kind ? nph_ply_read(context, file->path, &triangles) : nph_obj_read(context, file->path, &triangles));
    double *vertices = triangles.vertices.data;
    for (int64_t i = 0; i < triangles.vertices.shape[0]; i++) {
        double p[3] = {vertices[3 * i], vertices[3 * i + 1], vertices[3 * i + 2]};
        for (int a = 0; a < 3; a++)
            vertices[3 * i + a] = map[4 * a] * p[0] + map[4 * a + 1] * p[1] + map[4 * a + 2] * p[2] + map[4 * a + 3];
    }
    NphStatus status = nph_mesh_make(context, file->path, &triangles.vertices, &triangles.triangles, mesh);
    nph_triangles_free(context, &triangles);
    return status;
}

/* What only the loaded mesh tells. */
static void check_mesh(NphSceneReader *reader, const NphSceneFile *file, const NphMesh *mesh) {
    if (mesh->triangle_count == 0) {
        nph_scene_bad_input(reader, file->place, "this mesh has no triangles: %s", file->path);
        return;
    }
    for (int64_t i = 0; i < 3 * (int64_t)mesh->vertex_count; i++) {
        if (mesh->vertices_m[i] >= -FARTHEST_M && mesh->vertices_m[i] <= FARTHEST_M) continue;
        nph_scene_mistake(reader, file->place, "after its transform this mesh reaches beyond 1e12 m along %c",
                          "xyz"[i % 3]);
        return;
    }
}

NphStatus nph_scene_load_meshes(NphSceneReader *reader) {
    for (int i = 0; i < reader->scene->surface_count; i++) {
        const NphSceneFile *file = &reader->meshes[i];
        NphMesh *mesh = &reader->scene->surfaces[i].mesh;
        int bad = reader->bad_inputs;
        if (!file->path) continue;
        NphStatus status = load_mesh(reader->context, file, reader->world_from_mesh[i], mesh);
        NPH_TRY(nph_scene_note(reader, file, "mesh", status));
        if (reader->bad_inputs == bad) check_mesh(reader, file, mesh);
    }
    return NPH_OK;
}

NphStatus nph_scene_build_surfaces(NphContext *context, NphScene *scene) {
    NphMesh meshes[NPH_MAX_SURFACES];
    double origin[3];
    int count = 0;
    for (int i = 0; i < scene->surface_count; i++)
        if (!scene->surfaces[i].is_plane) meshes[count++] = scene->surfaces[i].mesh;
    if (count == 0) return NPH_OK;
    nph_scene_origin(scene, origin);
    return nph_bvh_build(context, meshes, count, origin, &scene->bvh);
}
