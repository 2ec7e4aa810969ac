/* SPDX-License-Identifier: Apache-2.0
 *
 * See emission_source.h. Cells are listed in the order of media and of the lattice, so that a random number finds the same
 * place everywhere. */
#include "transport/emission_source.h"

#include <string.h>

#include "core/memory.h"
#include "core/message.h"

static double volume_of(const double m[12]) {
    double v = m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
               m[2] * (m[4] * m[9] - m[5] * m[8]);
    return v < 0.0 ? -v : v;
}

static double largest(const double v[3]) {
    double most = v[0] > v[1] ? v[0] : v[1];
    return v[2] > most ? v[2] : most;
}

static int64_t cell_count(const NphMedium *medium) {
    if (medium->emission.kind == NPH_EMISSION_CONSTANT) return 1;
    const NphMajorant *bound = &medium->emission.bound;
    int64_t cells = (int64_t)bound->n[0] * bound->n[1] * bound->n[2], lit = 0;
    for (int64_t i = 0; i < cells; i++) lit += bound->cells[i] > 0.0f;
    return lit;
}

/* Appends a cell with its bound as the density, to be divided by the total later; nothing where it has no volume. */
static void append(NphEmissionSources *out, int emitter, const double lo[3], const double hi[3], double bound) {
    NphEmissionCell *cell = &out->cells[out->count];
    double volume = volume_of(out->world_from_space[emitter]);
    for (int a = 0; a < 3; a++) {
        if (!(lo[a] < hi[a])) return;
        cell->lo[a] = lo[a];
        cell->hi[a] = hi[a];
        volume *= hi[a] - lo[a];
    }
    cell->emitter = emitter;
    cell->density = bound;
    out->total += bound * volume;
    out->cdf[++out->count] = out->total;
}

static void append_grid(NphEmissionSources *out, int emitter, const NphMedium *medium) {
    const NphMajorant *bound = &medium->emission.bound;
    const NphGrid *grid = nph_emission_grid(&medium->emission, &medium->grid, 0);
    for (int32_t z = 0; z < bound->n[2]; z++)
        for (int32_t y = 0; y < bound->n[1]; y++)
            for (int32_t x = 0; x < bound->n[0]; x++) {
                float most = bound->cells[((int64_t)z * bound->n[1] + y) * bound->n[0] + x];
                if (!(most > 0.0f)) continue;
                double at[3] = {(double)x, (double)y, (double)z}, lo[3], hi[3];
                for (int a = 0; a < 3; a++) {
                    lo[a] = at[a] * NPH_MAJORANT_CELL > grid->lo[a] ? at[a] * NPH_MAJORANT_CELL : grid->lo[a];
                    hi[a] = (at[a] + 1.0) * NPH_MAJORANT_CELL < grid->hi[a] ? (at[a] + 1.0) * NPH_MAJORANT_CELL : grid->hi[a];
                }
                append(out, emitter, lo, hi, (double)most);
            }
}

static NphStatus check_ends(NphContext *context, const NphScene *scene, const NphTransportChoice *choice, int64_t *cells) {
    *cells = 0;
    if (choice->emission && (scene->period.on[0] || scene->period.on[1]))
        return nph_error(context, NPH_BAD_INPUT, "light of media cannot be followed where sides repeat");
    for (int m = 0; m < scene->medium_count; m++) {
        const NphMedium *medium = &scene->media[m];
        if (!choice->emits[m]) continue;
        if (medium->shape == NPH_SHAPE_LAYER && medium->emission.kind == NPH_EMISSION_CONSTANT)
            return nph_error(context, NPH_BAD_INPUT, "medium %s: light cannot be followed from a layer without end that "
                             "emits; give a box", medium->name);
        *cells += cell_count(medium);
    }
    return NPH_OK;
}

static void fill(const NphScene *scene, const NphTransportChoice *choice, NphEmissionSources *out) {
    int emitter = 0;
    for (int m = 0; m < scene->medium_count; m++) {
        const NphMedium *medium = &scene->media[m];
        int constant = medium->emission.kind == NPH_EMISSION_CONSTANT;
        if (!choice->emits[m]) continue;
        memcpy(out->world_from_space[emitter], constant ? medium->world_from_medium : medium->emission.world_from_grid,
               sizeof out->world_from_space[emitter]);
        double most = largest(medium->emission.value);
        if (!constant) append_grid(out, emitter, medium);
        else if (most > 0.0) append(out, emitter, medium->lo, medium->hi, most);
        emitter++;
    }
    for (int64_t i = 0; i < out->count; i++) out->cells[i].density /= out->total;
    for (int64_t i = 1; i <= out->count; i++) out->cdf[i] /= out->total;
}

NphStatus nph_emission_sources(NphContext *context, const NphScene *scene, const NphTransportChoice *choice,
                               NphEmissionSources *sources) {
    NphEmissionSources made;
    int64_t cells;
    memset(&made, 0, sizeof made);
    NPH_TRY(check_ends(context, scene, choice, &cells));
    NPH_TRY(NPH_NEW(context, cells, "cells that emit", &made.cells));
    NphStatus status = NPH_NEW(context, cells + 1, "cells that emit", &made.cdf);
    if (status != NPH_OK) {
        nph_free(context, made.cells);
        return status;
    }
    fill(scene, choice, &made);
    *sources = made;
    return NPH_OK;
}

void nph_emission_sources_free(NphContext *context, NphEmissionSources *sources) {
    nph_free(context, sources->cells);
    nph_free(context, sources->cdf);
    memset(sources, 0, sizeof *sources);
}
