/* SPDX-License-Identifier: Apache-2.0
 *
 * Phase functions of type mie: what the scene says of the spheres, then, with all other files there, their table. */
#include <string.h>

#include "optics/index.h"
#include "optics/mie_table.h"
#include "scene/scene_read.h"

enum { OTHER = NPH_INDEX_MATERIALS }; /* particle: other */

static double number_of(const NphSceneSection *section, const char *key, double otherwise) {
    const NphSceneValue *value = nph_section_value(section, key);
    return value ? value->number[0] : otherwise;
}

/* A key that goes with one choice alone: 0 after a mistake. */
static int check_goes(NphSceneReader *reader, const NphSceneSection *section, const char *key, int wanted, const char *with) {
    const NphSceneValue *value = nph_section_value(section, key);
    int given = value && value->given;
    if (given == wanted) return 1;
    if (given) nph_scene_mistake(reader, value->place, "%s goes with %s only", key, with);
    else nph_scene_mistake(reader, section->place, "a phase function of %s lacks %s", with, key);
    return 0;
}

static void read_index(NphSceneReader *reader, const NphSceneSection *section, int particle, NphMieRequest *request) {
    int other = particle == OTHER, right = check_goes(reader, section, "n", other, "particle other");
    right &= check_goes(reader, section, "k", other, "particle other");
    for (int i = 0; i < request->wavelength_count && right; i++) {
        request->index[i][0] = number_of(section, "n", 1.0);
        request->index[i][1] = number_of(section, "k", 0.0);
        if (!other && !nph_index_at((NphMaterial)particle, request->wavelength_um[i], request->index[i])) return; /* 360 to 830 nm are there */
    }
}

/* Its own wavelengths, or those of the scene. */
static int read_wavelengths(NphSceneReader *reader, const NphSceneSection *section, NphMieRequest *request) {
    const NphSceneValue *own = nph_section_value(section, "wavelengths");
    const double *nm = own && own->given ? own->number : reader->scene->wavelengths_nm;
    request->wavelength_count = own && own->given ? own->count : reader->scene->wavelength_count;
    for (int i = 0; i < request->wavelength_count; i++) request->wavelength_um[i] = 1e-3 * nm[i];
    if (request->wavelength_count > 0) return 1;
    nph_scene_mistake(reader, section->place, "a phase function of type mie lacks wavelengths, and so does the scene");
    return 0;
}

void nph_scene_read_mie(NphSceneReader *reader, const NphSceneSection *section, NphSceneMie *mie) {
    const NphSceneValue *particle = nph_section_value(section, "particle"), *sizes = nph_section_value(section, "sizes");
    const NphSceneValue *radius = nph_section_value(section, "radius");
    NphMieRequest *request = &mie->request;
    int before = reader->mistakes;
    if (!particle || !sizes || !radius || !read_wavelengths(reader, section, request)) return;
    read_index(reader, section, particle->word, request);
    request->tolerance = number_of(section, "tolerance", 0.01);
    request->sizes = (NphSizes){(NphSizesKind)sizes->word, radius->number[0], number_of(section, "spread", 0.0),
                                number_of(section, "alpha", 0.0), number_of(section, "gamma", 0.0)};
    int spread = sizes->word == NPH_SIZES_LOGNORMAL || sizes->word == NPH_SIZES_GAMMA, modified = sizes->word == NPH_SIZES_MODIFIED_GAMMA;
    check_goes(reader, section, "spread", spread, "sizes lognormal and gamma");
    check_goes(reader, section, "alpha", modified, "sizes modified_gamma");
    check_goes(reader, section, "gamma", modified, "sizes modified_gamma");
    const char *mistake = reader->mistakes == before ? nph_sizes_mistake(&request->sizes) : NULL;
    if (mistake) nph_scene_mistake(reader, radius->place, "%s", mistake);
    mie->place = section->place;
    mie->given = reader->mistakes == before;
}

NphStatus nph_scene_load_mie(NphSceneReader *reader, const NphSceneMie *mie, const char *name, NphPhase *phase) {
    NphMieTable table = {0};
    if (!mie->given) return NPH_OK;
    NphStatus status = nph_mie_table(reader->context, &mie->request, name, &table);
    if (status == NPH_OK) status = nph_phase_tabulate(reader->context, &table.rows, name, phase);
    nph_mie_table_free(reader->context, &table);
    if (status == NPH_OK || status == NPH_NO_MEMORY || status == NPH_INTERRUPTED) return status;
    nph_scene_bad_input(reader, mie->place, "the phase function of %s cannot be computed", name);
    return NPH_OK;
}
