/* SPDX-License-Identifier: Apache-2.0
 *
 * The periodic section to NphPeriod. Media that reach beyond the interval are cut there, which needs no check; one that
 * lies outside of it altogether would never be met, and a point light would stand there an infinite number of times.
 * Meshes are refused: flights repeat media, nothing else. */
#include "core/text.h"
#include "scene/scene_read.h"

void nph_scene_read_period(NphSceneReader *reader, const yaml_node_t *node) {
    static const char *const names[] = {"x", "y"};
    NphSceneSection section;
    NphPeriod *period = &reader->scene->period;
    if (!nph_section_read(reader, node, "periodic", &section)) return;
    reader->period_place = section.place;
    int written = 0;
    for (int a = 0; a < 2; a++) {
        const NphSceneValue *interval = nph_section_value(&section, names[a]);
        for (int i = 0; i < section.count; i++) written |= section.values[i].given;
        if (!interval || !interval->given) continue;
        period->on[a] = 1;
        period->lo[a] = interval->number[0];
        period->hi[a] = interval->number[1];
    }
    if (!written) nph_scene_mistake(reader, section.place, "periodic lacks x, y, or both");
}

void nph_scene_check_period(NphSceneReader *reader) {
    const NphScene *scene = reader->scene;
    const NphPeriod *period = &scene->period;
    if (!period->on[0] && !period->on[1]) return;
    for (int l = 0; l < scene->light_count; l++)
        if (scene->lights[l].kind == NPH_LIGHT_POINT)
            nph_scene_mistake(reader, reader->period_place,
                              "periodic does not go with a point light (light number %d): its images without end would add "
                              "up to infinite light; take a sun, an environment or a constant light",
                              l);
    for (int s = 0; s < scene->surface_count; s++)
        if (!scene->surfaces[s].is_plane)
            nph_scene_mistake(reader, reader->period_place,
                              "periodic does not go with a mesh (surface %s), which would have to repeat as well; only with planes",
                              scene->surfaces[s].name);
    for (int m = 0; m < scene->medium_count; m++) {
        double lo[3], hi[3];
        nph_medium_bounds(&scene->media[m], lo, hi);
        for (int a = 0; a < 2; a++) {
            char low[NPH_DOUBLE_TEXT], high[NPH_DOUBLE_TEXT];
            if (!period->on[a] || (lo[a] < period->hi[a] && hi[a] > period->lo[a])) continue;
            nph_scene_mistake(reader, reader->period_place,
                              "medium %s lies outside of periodic %c: it reaches from %s to %s m, and everything beyond the "
                              "interval is cut off",
                              scene->media[m].name, "xy"[a], nph_format_double(lo[a], low), nph_format_double(hi[a], high));
            break;
        }
    }
}
