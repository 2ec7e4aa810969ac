/* SPDX-License-Identifier: Apache-2.0
 *
 * What a medium emits: its section, then, once the medium's own density is loaded, the grids. Of a black body the
 * emission  j = absorption * B(T)  is computed at the samples of the temperature's grid, where the density is looked up. */
#include <string.h>

#include "core/memory.h"
#include "field/sample.h"
#include "optics/blackbody.h"
#include "scene/scene_read.h"

static const char *const flame = "flame", *const temperature_name = "temperature";

static int has_names(const NphSceneFile *file) {
    return file->path && (file->kind == NPH_VOLUME_NVDB || file->kind == NPH_VOLUME_VDB);
}

/* ---- the section ---- */

static const NphSceneValue *written(const NphSceneSection *section, const char *key) {
    const NphSceneValue *value = nph_section_value(section, key);
    return value && value->given ? value : NULL;
}

/* At most one of temperature, volume and grid; scale and offset belong to a grid. 0 after mistakes. */
static int check_section(NphSceneReader *reader, const NphSceneSection *section, const NphSceneFile *own, int has_density) {
    const NphSceneValue *kelvin = written(section, "temperature"), *volume = written(section, "volume");
    const NphSceneValue *grid = written(section, "grid"), *scale = written(section, "scale");
    const NphSceneValue *offset = written(section, "offset"), *second = kelvin ? volume : grid;
    int before = reader->mistakes;
    if (kelvin && !second) second = grid;
    if ((kelvin || volume) && second)
        nph_scene_mistake(reader, second->place, "%s and %s exclude each other", kelvin ? temperature_name : "volume",
                          kelvin && volume ? "volume" : "grid");
    if (kelvin && (scale || offset))
        nph_scene_mistake(reader, (scale ? scale : offset)->place, "scale and offset are for a grid of temperatures, "
                          "not for temperature");
    if (grid && !has_names(own))
        nph_scene_mistake(reader, grid->place, "grid names one in the medium's own .nvdb or .vdb file, and this medium has "
                          "none; give volume: {file: ...}");
    if (strcmp(section->variant, "blackbody") != 0) return reader->mistakes == before;
    if (!kelvin && !volume && !grid && !has_names(own))
        nph_scene_mistake(reader, section->place, "an emission lacks temperature, or volume: this medium has no .nvdb or "
                          ".vdb file of its own with a grid of temperatures");
    if (!kelvin && !has_density && (volume || grid))
        nph_scene_mistake(reader, (volume ? volume : grid)->place, "a grid of temperatures goes with a medium that has a "
                          "density; give temperature to a box or layer");
    return reader->mistakes == before;
}

/* The named grid of the medium's own file, looked up as the density is. */
static NphStatus take_own_grid(NphSceneReader *reader, const NphSceneFile *own, const NphSceneValue *grid, int blackbody,
                               NphScenePlace place, NphSceneFile *file) {
    *file = *own;
    file->path = NULL;
    file->place = grid ? grid->place : place;
    file->grid = grid ? grid->text : blackbody ? temperature_name : flame;
    return nph_strdup(reader->context, own->path, &file->path);
}

static NphStatus choose_source(NphSceneReader *reader, const NphSceneSection *section, int index, NphSceneEmission *out) {
    NphMedium *medium = &reader->scene->media[index];
    NphEmission *emission = &medium->emission;
    const NphSceneFile *own = &reader->volumes[index];
    const NphSceneValue *kelvin = written(section, "temperature"), *volume = written(section, "volume");
    const NphSceneValue *grid = written(section, "grid");
    int uniform = kelvin || (!volume && !has_names(own));
    if (uniform) {
        emission->kind = medium->shape == NPH_SHAPE_GRID ? NPH_EMISSION_DENSITY : NPH_EMISSION_CONSTANT;
        if (kelvin) out->kelvin = kelvin->number[0];
        return NPH_OK;
    }
    emission->kind = NPH_EMISSION_GRID;
    NPH_TRY(volume ? nph_scene_read_density(reader, volume, &out->file)
                   : take_own_grid(reader, own, grid, out->blackbody, section->place, &out->file));
    if (volume && out->blackbody && out->file.path && out->file.kind == NPH_VOLUME_LES)
        nph_scene_mistake(reader, out->file.place, "a cloud field holds no temperatures");
    const NphSceneValue *scale = nph_section_value(section, "scale"), *offset = nph_section_value(section, "offset");
    out->file.hot = out->blackbody;
    if (scale && offset) out->file.kelvin = (NphKelvin){scale->number[0], offset->number[0], NPH_KELVIN_MOST};
    return NPH_OK;
}

NphStatus nph_scene_read_emission(NphSceneReader *reader, const NphSceneValue *value, int index) {
    NphSceneSection section;
    NphMedium *medium = &reader->scene->media[index];
    NphSceneEmission *out = &reader->emissions[index];
    int before = reader->mistakes;
    if (!nph_section_read(reader, value->node, "emission", &section) || reader->mistakes > before) return NPH_OK;
    if (reader->scene->wavelength_count > 0)
        nph_scene_mistake(reader, section.place, "emission does not go with wavelengths yet; give R, G, B");
    if (reader->scene->wavelength_count > 0) return NPH_OK;
    if (!check_section(reader, &section, &reader->volumes[index], medium->shape == NPH_SHAPE_GRID)) return NPH_OK;
    const NphSceneValue *radiance = nph_section_value(&section, "radiance");
    out->place = section.place;
    out->blackbody = strcmp(section.variant, "blackbody") == 0;
    if (radiance) memcpy(medium->emission.value, radiance->number, sizeof medium->emission.value);
    return choose_source(reader, &section, index, out);
}

/* ---- the grids ---- */

static void absorption_of(const NphMedium *medium, double absorption[3]) {
    for (int c = 0; c < 3; c++) absorption[c] = medium->extinction_per_m[c] * (1.0 - medium->albedo[c]);
}

/* One channel of a black body at a sample of the temperature's grid. */
typedef struct Glow {
    const NphPlanckTable *planck;
    RGrid density;
    double density_from_grid[12]; /* lattice to lattice */
    double absorption;
    int channel;
} Glow;

/* The density at a place of its lattice, 0 beyond it. Places within 1e-6 of a sample are the sample's. */
static double density_at(const Glow *glow, const double at[3]) {
    double place[3];
    for (int a = 0; a < 3; a++) {
        const double *row = glow->density_from_grid + 4 * a;
        double u = row[0] * at[0] + row[1] * at[1] + row[2] * at[2] + row[3], whole = nph_floor(u + 0.5);
        place[a] = nph_abs(u - whole) < 1e-6 ? whole : u;
        if (!(place[a] >= 0.0 && place[a] <= (double)(glow->density.n[a] - 1))) return 0.0;
    }
    return (double)r_grid_value(&glow->density, place[0], place[1], place[2]);
}

static double glow_at(const void *user, const double at[3], double kelvin) {
    const Glow *glow = user;
    double rgb[3];
    if (!(kelvin > 0.0)) return 0.0;
    nph_planck_rgb(glow->planck, kelvin, rgb);
    return rgb[glow->channel] > 0.0 ? rgb[glow->channel] * glow->absorption * density_at(glow, at) : 0.0;
}

static NphStatus derive_glow(NphSceneReader *reader, const NphMedium *medium, const NphGrid *kelvin, Glow *glow,
                             NphEmission *emission, const char *what) {
    double inverse[12], absorption[3];
    nph_affine_invert(medium->world_from_medium, inverse);
    nph_affine_multiply(inverse, emission->world_from_grid, glow->density_from_grid);
    nph_grid_view(&medium->grid, &glow->density);
    absorption_of(medium, absorption);
    NPH_TRY(NPH_NEW(reader->context, 3, what, &emission->grids));
    emission->grid_count = 3;
    for (int c = 0; c < 3; c++) {
        emission->value[c] = 1.0;
        glow->channel = c;
        glow->absorption = absorption[c];
        NPH_TRY(nph_grid_derive(reader->context, kelvin, glow_at, glow, what, &emission->grids[c]));
    }
    return NPH_OK;
}

/* Temperatures have been loaded as a grid of kelvin; three grids of emission take its place. */
static NphStatus make_glow(NphSceneReader *reader, NphMedium *medium, const char *what) {
    NphContext *context = reader->context;
    NphEmission *emission = &medium->emission;
    NphGrid kelvin = emission->grids[0];
    NphPlanckTable *planck = NULL;
    nph_free(context, emission->grids);
    emission->grids = NULL;
    emission->grid_count = 0;
    NphStatus status = NPH_NEW(context, 1, "table of black bodies", &planck);
    if (status == NPH_OK) {
        Glow glow = {.planck = planck};
        nph_planck_table(planck);
        status = derive_glow(reader, medium, &kelvin, &glow, emission, what);
    }
    nph_free(context, planck);
    nph_grid_free(context, &kelvin);
    return status;
}

static void uniform_glow(NphMedium *medium, double kelvin, NphPlanckTable *planck) {
    double absorption[3], rgb[3];
    absorption_of(medium, absorption);
    nph_planck_table(planck);
    nph_planck_rgb(planck, kelvin, rgb);
    for (int c = 0; c < 3; c++) medium->emission.value[c] = absorption[c] * rgb[c];
}

/* Where the grid lies, as a medium's is checked. */
static int check_place(NphSceneReader *reader, const NphSceneEmission *from, NphMedium *medium) {
    NphEmission *emission = &medium->emission;
    NphMedium place = {.shape = NPH_SHAPE_GRID, .grid = emission->grids[0]};
    double inverse[12];
    int before = reader->mistakes;
    nph_affine_multiply(emission->world_from_grid, emission->grids[0].world_from_lattice, emission->world_from_grid);
    memcpy(place.world_from_medium, emission->world_from_grid, sizeof place.world_from_medium);
    if (!nph_affine_invert(emission->world_from_grid, inverse))
        nph_scene_mistake(reader, from->file.place, "the volume's own transform and the scene's flatten space together");
    else
        nph_scene_check_reach(reader, from->file.place, &place);
    return reader->mistakes == before;
}

NphStatus nph_scene_load_emission(NphSceneReader *reader, int index) {
    NphContext *context = reader->context;
    NphMedium *medium = &reader->scene->media[index];
    NphEmission *emission = &medium->emission;
    const NphSceneEmission *from = &reader->emissions[index];
    int bad = reader->bad_inputs;
    if (emission->kind == NPH_EMISSION_NONE) return NPH_OK;
    if (emission->kind == NPH_EMISSION_GRID) {
        NPH_TRY(NPH_NEW(context, 1, from->file.path, &emission->grids));
        emission->grid_count = 1;
        NPH_TRY(nph_scene_load_volume(reader, &from->file, "volume", &emission->grids[0]));
        if (reader->bad_inputs != bad || !check_place(reader, from, medium)) return NPH_OK;
        if (from->blackbody) NPH_TRY(make_glow(reader, medium, from->file.path));
    } else if (from->blackbody) {
        NphPlanckTable *planck = NULL;
        NPH_TRY(NPH_NEW(context, 1, "table of black bodies", &planck));
        uniform_glow(medium, from->kelvin, planck);
        nph_free(context, planck);
    }
    if (emission->kind == NPH_EMISSION_DENSITY)
        memcpy(emission->world_from_grid, medium->world_from_medium, sizeof emission->world_from_grid);
    NphStatus status = nph_emission_finish(context, &medium->grid, medium->name, emission);
    if (status != NPH_BAD_INPUT) return status;
    nph_scene_bad_input(reader, from->place, "this emission cannot be used");
    return NPH_OK;
}

/* ---- what a file holds and nothing emits ---- */

static int is_emitted(const NphSceneReader *reader, const char *path, const char *grid) {
    for (int i = 0; i < reader->scene->medium_count; i++) {
        const NphSceneFile *file = &reader->emissions[i].file;
        if (file->path && file->grid && strcmp(file->path, path) == 0 && strcmp(file->grid, grid) == 0) return 1;
    }
    return 0;
}

static NphStatus find_unmodelled(NphSceneReader *reader, int index) {
    const NphSceneFile *file = &reader->volumes[index];
    NphGridInfo *grids = NULL;
    NphStatus status = NPH_OK;
    int count = 0;
    NPH_TRY((file->kind == NPH_VOLUME_NVDB ? nph_nvdb_list : nph_vdb_list)(reader->context, file->path, &grids, &count));
    for (int g = 0; g < count && status == NPH_OK && !reader->scene->media[index].unmodelled; g++) {
        const char *name = grids[g].name;
        int hot = strcmp(name, flame) == 0 || strcmp(name, temperature_name) == 0;
        int chosen = file->grid && strcmp(file->grid, name) == 0;
        if (!hot || chosen || !grids[g].readable || grids[g].active_voxels == 0 || is_emitted(reader, file->path, name))
            continue;
        status = nph_strdup(reader->context, name, &reader->scene->media[index].unmodelled);
    }
    nph_free(reader->context, grids);
    return status;
}

NphStatus nph_scene_find_unmodelled(NphSceneReader *reader) {
    for (int i = 0; i < reader->scene->medium_count && reader->bad_inputs == 0; i++)
        if (has_names(&reader->volumes[i])) NPH_TRY(find_unmodelled(reader, i));
    return NPH_OK;
}
