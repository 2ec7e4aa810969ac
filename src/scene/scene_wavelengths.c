/* SPDX-License-Identifier: Apache-2.0
 *
 * Wavelengths in place of R, G, B: reading them, spreading RGB keys over them, and what does not go with them. */
#include <string.h>

#include "scene/scene_read.h"

void nph_scene_read_wavelengths(NphSceneReader *reader, const NphSceneSection *scene) {
    const NphSceneValue *value = nph_section_value(scene, "wavelengths");
    for (int i = 0; i < scene->count; i++)
        reader->unsure |= scene->values[i].given && !value && strcmp(scene->keys[i].key, "wavelengths") == 0;
    if (!value) return;
    reader->scene->wavelength_count = value->count;
    memcpy(reader->scene->wavelengths_nm, value->number, (size_t)value->count * sizeof value->number[0]);
}

void nph_scene_take_rgb(const NphSceneReader *reader, const NphSceneValue *value, double rgb[3], double *spectrum) {
    int count = reader->scene->wavelength_count;
    memcpy(rgb, value->number, 3 * sizeof rgb[0]);
    if (count == 0) return;
    memcpy(spectrum, value->number, (size_t)count * sizeof spectrum[0]);
    nph_spectrum_thirds(spectrum, count, rgb);
}

void nph_scene_check_map(NphSceneReader *reader, const NphSceneFile *file, const NphEnvironment *map) {
    int64_t texels = (int64_t)map->width * map->height;
    if (reader->scene->wavelength_count == 0) return;
    for (int64_t i = 0; i < texels; i++) {
        const float *t = map->radiance + 3 * i;
        if (t[0] == t[1] && t[0] == t[2]) continue;
        nph_scene_mistake(reader, file->place, "this environment map has colours, and R, G, B are no spectrum: with "
                          "wavelengths a map is grey (one channel Y)");
        return;
    }
}
