/* SPDX-License-Identifier: Apache-2.0
 *
 * The files a scene names: whether they are there is checked while reading, their contents are loaded once the scene
 * itself has no mistakes. A damaged file is named by its reader with its own message, then with its place in the
 * scene. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/memory.h"
#include "core/text.h"
#include "field/cloud.h"
#include "field/grid.h"
#include "io/phase_rows.h"
#include "scene/scene_read.h"

static const double MOST_PER_M = 1e9;

/* Copies a name, each run of # replaced by at least as many digits of number; to NULL: only counts. Returns the length. */
static size_t number_file(const char *name, uint32_t number, char *to) {
    size_t used = 0;
    while (*name) {
        size_t run = strspn(name, "#"), plain = strcspn(name, "#");
        char digits[16];
        if (to) memcpy(to + used, name, plain);
        used += plain;
        if (run > 0) {
            size_t length = (size_t)snprintf(digits, sizeof digits, "%u", (unsigned)number);
            size_t zeros = run > length ? run - length : 0;
            if (to) memset(to + used, '0', zeros);
            if (to) memcpy(to + used + zeros, digits, length);
            used += zeros + length;
        }
        name += run + plain;
    }
    return used;
}

NphStatus nph_scene_file_path(NphSceneReader *reader, const NphSceneValue *value, const char *what, uint32_t number, char **path) {
    char *full = NULL, quote[NPH_QUOTE_BYTES], reason[96] = "it is not a regular file";
    const char *folder = value->text[0] == '/' ? "" : reader->folder, *slash = folder[0] ? "/" : "";
    size_t begin = strlen(folder) + strlen(slash);
    NPH_TRY(NPH_NEW(reader->context, begin + number_file(value->text, number, NULL) + 1, "path", &full));
    snprintf(full, begin + 1, "%s%s", folder, slash);
    full[begin + number_file(value->text, number, full + begin)] = 0;
    struct stat facts;
    errno = 0;
    int regular = stat(full, &facts) == 0 && S_ISREG(facts.st_mode) && access(full, R_OK) == 0;
    if (!regular) {
        if (errno) strerror_r(errno, reason, sizeof reason);
        nph_scene_bad_input(reader, value->place, "%s %s cannot be read: %s (looked up as %s)", what,
                            nph_node_quote(value->node, quote), reason, full);
    }
    *path = full;
    return NPH_OK;
}

/* Each point is the middle of a voxel: half a spacing around the outermost points. */
static NphStatus widen_to_cells(NphContext *context, const NphLes *les, const char *path, double lo[3], double hi[3]) {
    int64_t levels = les->lwc_g_per_m3.shape[0];
    if (levels < 2)
        return nph_error(context, NPH_BAD_INPUT, "%s: has one level only, so the height of its cells is unknown", path);
    double half[3] = {les->spacing_m[0] / 2, les->spacing_m[1] / 2, (hi[2] - lo[2]) / (double)(levels - 1) / 2};
    for (int axis = 0; axis < 3; axis++) {
        lo[axis] -= half[axis];
        hi[axis] += half[axis];
    }
    return NPH_OK;
}

static NphStatus load_les(NphContext *context, const NphSceneFile *file, NphGrid *grid) {
    NphLes les = {0};
    NphArray density = {0};
    double lo[3], hi[3];
    NPH_TRY(nph_les_read(context, file->path, &les));
    NphStatus status = nph_cloud_extinction(context, &les, file->path, &density, lo, hi);
    if (status == NPH_OK && file->centring == NPH_CENTRING_CELL)
        status = widen_to_cells(context, &les, file->path, lo, hi);
    if (status == NPH_OK)
        status = nph_grid_from_array(context, &density, lo, hi, file->centring, file->outside, file->lookup, file->path,
                                     grid);
    nph_array_free(context, &density);
    nph_les_free(context, &les);
    return status;
}

/* Temperatures in place of the file's values. */
static NphStatus heat_array(NphContext *context, const NphSceneFile *file, NphArray *values) {
    NphArray hot = {0};
    if (!file->hot) return NPH_OK;
    NPH_TRY(nph_kelvin_array(context, &file->kelvin, values, file->path, &hot));
    nph_array_free(context, values);
    *values = hot;
    return NPH_OK;
}

static NphStatus load_npy(NphContext *context, const NphSceneFile *file, NphGrid *grid) {
    NphArray density = {0};
    NPH_TRY(nph_npy_read(context, file->path, &density));
    NphStatus status = heat_array(context, file, &density);
    if (status == NPH_OK)
        status = nph_grid_from_array(context, &density, file->lo, file->hi, file->centring, file->outside, file->lookup,
                                     file->path, grid);
    nph_array_free(context, &density);
    return status;
}

/* Cells of a box that the file itself states; pbrt's medium is chosen by name. */
static NphStatus load_box_grid(NphContext *context, const NphSceneFile *file, NphGrid *grid) {
    NphBoxGrid box = {0};
    int vol = file->kind == NPH_VOLUME_VOL;
    NphStatus status = vol ? nph_vol_read(context, file->path, &box) : nph_pbrt_read(context, file->path, file->grid, &box);
    NPH_TRY(status);
    if (box.values.rank == 4)
        status = nph_error(context, NPH_BAD_INPUT, "%s: has %lld channels; a density has one", file->path,
                           (long long)box.values.shape[3]);
    if (status == NPH_OK) status = heat_array(context, file, &box.values);
    if (status == NPH_OK)
        status = nph_grid_from_array(context, &box.values, box.lo, box.hi, file->centring, file->outside, file->lookup,
                                     file->path, grid);
    nph_box_grid_free(context, &box);
    return status;
}

static NphStatus load_vdb(NphContext *context, const NphSceneFile *file, NphGrid *grid) {
    NphVolume volume = {0};
    int nano = file->kind == NPH_VOLUME_NVDB;
    NphStatus status = (nano ? nph_nvdb_read : nph_vdb_read)(context, file->path, file->grid, &volume);
    NPH_TRY(status);
    if (file->hot) status = nph_kelvin_volume(context, &file->kelvin, file->path, &volume);
    if (status == NPH_OK)
        status = nph_grid_from_volume(context, &volume, file->centring, file->lookup, file->path, grid);
    nph_volume_free(context, &volume);
    return status;
}

static NphStatus load_volume(NphContext *context, const NphSceneFile *file, NphGrid *grid) {
    switch ((NphVolumeKind)file->kind) {
    case NPH_VOLUME_NVDB:
    case NPH_VOLUME_VDB: return load_vdb(context, file, grid);
    case NPH_VOLUME_NPY: return load_npy(context, file, grid);
    case NPH_VOLUME_LES: return load_les(context, file, grid);
    case NPH_VOLUME_VOL:
    case NPH_VOLUME_PBRT: return load_box_grid(context, file, grid);
    }
    return NPH_BAD_INPUT;
}

static NphStatus load_phase(NphContext *context, const NphSceneFile *file, NphPhase *phase) {
    NphArray rows = {0};
    NPH_TRY(nph_phase_rows_read(context, file->path, &rows));
    NphStatus status = nph_phase_tabulate(context, &rows, file->path, phase);
    nph_array_free(context, &rows);
    return status;
}

static NphStatus load_map(NphContext *context, const NphSceneFile *file, NphEnvironment *map) {
    NphImage image = {0};
    NPH_TRY(nph_exr_read(context, file->path, &image));
    NphStatus status = nph_environment_build(context, &image, file->scale, file->path, map);
    nph_image_free(context, &image);
    return status;
}

NphStatus nph_scene_note(NphSceneReader *reader, const NphSceneFile *file, const char *what, NphStatus status) {
    if (status == NPH_OK || status == NPH_NO_MEMORY || status == NPH_INTERRUPTED) return status;
    nph_scene_bad_input(reader, file->place, "this %s cannot be used: %s", what, file->path);
    return NPH_OK;
}

/* What only the loaded grid tells: where it lies, and how dense it is. */
static void check_grid(NphSceneReader *reader, const NphSceneFile *file, NphMedium *medium) {
    char most[NPH_DOUBLE_TEXT], product[NPH_DOUBLE_TEXT];
    double inverse[12];
    nph_affine_multiply(medium->world_from_medium, medium->grid.world_from_lattice, medium->world_from_medium);
    if (!nph_affine_invert(medium->world_from_medium, inverse)) {
        nph_scene_mistake(reader, file->place, "the volume's own transform and the scene's flatten space together");
        return;
    }
    nph_scene_check_reach(reader, file->place, medium);
    int count = reader->scene->wavelength_count;
    for (int i = 0; i < (count > 0 ? count : 3); i++) {
        double value = count > 0 ? medium->extinction_spectrum[i] : medium->extinction_per_m[i];
        double extinction = value * (double)medium->grid.max;
        if (extinction <= MOST_PER_M) continue;
        nph_scene_mistake(reader, file->extinction_place,
                          "extinction times the volume's largest density, %s, is %s 1/m; "
                          "at most 1e9 1/m is allowed",
                          nph_format_double((double)medium->grid.max, most), nph_format_double(extinction, product));
        return;
    }
}

NphStatus nph_scene_load_volume(NphSceneReader *reader, const NphSceneFile *file, const char *what, NphGrid *grid) {
    return nph_scene_note(reader, file, what, load_volume(reader->context, file, grid));
}

NphStatus nph_scene_load_files(NphSceneReader *reader) {
    NphScene *scene = reader->scene;
    for (int i = 0; i < scene->medium_count; i++) {
        const NphSceneFile *file = &reader->volumes[i];
        NphMedium *medium = &scene->media[i];
        int bad = reader->bad_inputs;
        memcpy(medium->emission.world_from_grid, medium->world_from_medium, sizeof medium->world_from_medium);
        if (file->path) {
            NPH_TRY(nph_scene_load_volume(reader, file, "volume", &medium->grid));
            if (reader->bad_inputs == bad) check_grid(reader, file, medium);
        }
        if (reader->bad_inputs == bad && reader->mistakes == 0) NPH_TRY(nph_scene_load_emission(reader, i));
    }
    NPH_TRY(nph_scene_find_unmodelled(reader));
    for (int i = 0; i < scene->medium_count; i++) {
        const NphSceneFile *file = &reader->phases[i];
        NPH_TRY(nph_scene_load_mie(reader, &reader->mies[i], scene->media[i].name, &scene->media[i].phase));
        if (!file->path) continue;
        NphStatus status = load_phase(reader->context, file, &scene->media[i].phase);
        NPH_TRY(nph_scene_note(reader, file, "table of a phase function", status));
    }
    NPH_TRY(nph_scene_load_mie(reader, &reader->aerosol_mie, "the aerosol", &scene->air.aerosol.phase));
    if (reader->aerosol_phase.path)
        NPH_TRY(nph_scene_note(reader, &reader->aerosol_phase, "table of a phase function",
                               load_phase(reader->context, &reader->aerosol_phase, &scene->air.aerosol.phase)));
    for (int i = 0; i < scene->light_count; i++) {
        const NphSceneFile *file = &reader->maps[i];
        if (!file->path) continue;
        int bad = reader->bad_inputs;
        NPH_TRY(nph_scene_note(reader, file, "environment map", load_map(reader->context, file, &scene->lights[i].map)));
        if (reader->bad_inputs == bad) nph_scene_check_map(reader, file, &scene->lights[i].map);
    }
    return nph_scene_load_meshes(reader);
}
