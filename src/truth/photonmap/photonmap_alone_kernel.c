/* SPDX-License-Identifier: Apache-2.0
 *
 * What others see of a photon map: fields of its photons and nodes as rows, and numbers of its scene. */
#include <string.h>

#include "transport/facts_lookup.h"
#include "truth/photonmap/photonmap_state.h"

void NPH_KERNEL(nph_photonmap_clear)(NphPhotonMap *map);
void NPH_KERNEL(nph_photonmap_show)(const NphPhotonMap *map, int buffer, void *column);
void NPH_KERNEL(nph_photonmap_take)(NphPhotonMap *map, int buffer, const void *column);
void NPH_KERNEL(nph_photonmap_facts)(const void *scene, int64_t room, NphFactFn fact, void *user);

void NPH_KERNEL(nph_photonmap_clear)(NphPhotonMap *map) {
    RPhoton *photons = map->photons;
    RKdNode *items = map->tree.items;
    for (int32_t i = 0; i < map->tree.count; i++) {
        photons[i] = (RPhoton){.medium = 0};
        items[i] = (RKdNode){{R(0.0), R(0.0), R(0.0)}, (uint32_t)i << 2};
        map->names[i] = -1;
    }
}

/* Of photon or node i; its rows. */
static Real *reals_of(const NphPhotonMap *map, int buffer, int32_t i, int *rows) {
    RPhoton *photon = (RPhoton *)map->photons + i;
    *rows = buffer == NPH_PHOTONMAP_EXTINCTION ? 1 : 3;
    switch (buffer) {
    case NPH_PHOTONMAP_PLACE: return ((RKdNode *)map->tree.items + i)->p;
    case NPH_PHOTONMAP_DIRECTION: return photon->d;
    case NPH_PHOTONMAP_POWER: return photon->power;
    case NPH_PHOTONMAP_EXTINCTION: return &photon->extinction;
    default: return ((RKdNode *)map->tree.nodes + i)->p;
    }
}

static int is_integer(int buffer) {
    return buffer == NPH_PHOTONMAP_MEDIUM || buffer == NPH_PHOTONMAP_ORDER || buffer == NPH_PHOTONMAP_NODE_PHOTON ||
           buffer == NPH_PHOTONMAP_NODE_AXIS;
}

static void show_integers(const NphPhotonMap *map, int buffer, int32_t *column) {
    const RPhoton *photons = map->photons;
    const RKdNode *nodes = map->tree.nodes;
    for (int32_t i = 0; i < map->tree.count; i++)
        column[i] = buffer == NPH_PHOTONMAP_MEDIUM        ? photons[i].medium
                    : buffer == NPH_PHOTONMAP_ORDER       ? photons[i].order
                    : buffer == NPH_PHOTONMAP_NODE_PHOTON ? (int32_t)r_kd_number(&nodes[i])
                                                          : (int32_t)(nodes[i].tag & 3u);
}

/* The tree's items are in any order once it has been built; each knows its photon. */
void NPH_KERNEL(nph_photonmap_show)(const NphPhotonMap *map, int buffer, void *column) {
    const RKdNode *items = map->tree.items;
    Real *reals = column;
    int rows;
    if (is_integer(buffer)) {
        show_integers(map, buffer, column);
        return;
    }
    for (int32_t i = 0; i < map->tree.count; i++) {
        const Real *from = reals_of(map, buffer, i, &rows);
        int64_t at = buffer == NPH_PHOTONMAP_PLACE ? (int64_t)r_kd_number(&items[i]) : i;
        for (int r = 0; r < rows; r++) reals[r * map->room + at] = from[r];
    }
}

static void take_integers(NphPhotonMap *map, int buffer, const int32_t *column) {
    RPhoton *photons = map->photons;
    RKdNode *nodes = map->tree.nodes;
    for (int32_t i = 0; i < map->tree.count; i++) {
        if (buffer == NPH_PHOTONMAP_MEDIUM) photons[i].medium = column[i];
        if (buffer == NPH_PHOTONMAP_ORDER) photons[i].order = column[i];
        if (buffer == NPH_PHOTONMAP_NODE_PHOTON) nodes[i].tag = (uint32_t)column[i] << 2 | (nodes[i].tag & 3u);
        if (buffer == NPH_PHOTONMAP_NODE_AXIS) nodes[i].tag = (nodes[i].tag & ~3u) | (uint32_t)column[i];
    }
}

void NPH_KERNEL(nph_photonmap_take)(NphPhotonMap *map, int buffer, const void *column) {
    RKdNode *items = map->tree.items;
    const Real *reals = column;
    int rows;
    if (is_integer(buffer)) {
        take_integers(map, buffer, column);
        return;
    }
    for (int32_t i = 0; i < map->tree.count; i++) {
        Real *to = reals_of(map, buffer, i, &rows);
        for (int r = 0; r < rows; r++) to[r] = reals[r * map->room + i];
        if (buffer == NPH_PHOTONMAP_PLACE) items[i].tag = (uint32_t)i << 2;
    }
}

void NPH_KERNEL(nph_photonmap_facts)(const void *memory, int64_t room, NphFactFn fact, void *user) {
    const RPhotonScene *scene = memory;
    const RScene *local = &scene->local;
    double cones[4 * NPH_MAX_LIGHTS];
    for (int l = 0; l < local->light_count; l++) {
        for (int a = 0; a < 3; a++) cones[4 * l + a] = (double)scene->from[l].axis[a];
        cones[4 * l + 3] = (double)scene->from[l].width;
    }
    fact(user, -1, "room", 1, (double[]){(double)room});
    r_fact(fact, user, "nearest", (Real)scene->nearest);
    r_fact(fact, user, "reach", scene->reach);
    r_fact(fact, user, "step", scene->step);
    r_fact(fact, user, "direct", (Real)scene->direct);
    r_fact(fact, user, "printed", (Real)scene->printed);
    if (scene->choose[local->light_count] > 0.0) { /* else nothing is emitted */
        fact(user, -1, "bounds_lo", 3, local->bounds_lo);
        fact(user, -1, "bounds_hi", 3, local->bounds_hi);
        fact(user, -1, "choose", local->light_count + 1, scene->choose);
        fact(user, -1, "cones", 4 * local->light_count, cones);
    }
    r_scene_facts(local, 1, fact, user);
}
