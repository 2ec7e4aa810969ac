/* SPDX-License-Identifier: Apache-2.0
 *
 * shdom.properties: the mean density of every cell, from points spread evenly in it, two at least a voxel (of at most eight along each
 * axis); cells that the medium fills are 1. What is lost of a density finer than its cells is lost here and in the sweep alone: beams
 * and cameras walk the density itself. */
#include "core/fmath.h"
#include "truth/shdom/shdom.h"

/* At a place of the grid, 0 outside of the medium. */
static double density_at(const NphShdomGrid *grid, const RMedium *medium, const double u[3]) {
    double p[3], v[3];
    for (int a = 0; a < 3; a++) {
        const double *row = grid->to_local + 4 * a;
        p[a] = row[0] * u[0] + row[1] * u[1] + row[2] * u[2] + row[3];
    }
    for (int a = 0; a < 3; a++) {
        const double *row = medium->from_local + 4 * a;
        v[a] = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3];
        double margin = 1e-9 * (medium->hi[a] - medium->lo[a]);
        if (v[a] < medium->lo[a] - margin || v[a] > medium->hi[a] + margin) return 0.0;
        v[a] = r_clamp(v[a], medium->lo[a], medium->hi[a]);
    }
    return medium->shape == NPH_SHAPE_GRID ? r_grid_value(&medium->grid, v[0], v[1], v[2]) : 1.0;
}

/* How many points along an axis: by how many voxels, or parts of the medium's box, a cell may hold. */
static int parts_of(const NphShdomGrid *grid, const RMedium *medium, int axis) {
    double most = 1.0;
    for (int b = 0; b < 3 && medium->shape == NPH_SHAPE_GRID; b++) {
        const double *row = medium->from_local + 4 * b;
        double voxels = 0.0;
        for (int k = 0; k < 3; k++) voxels += row[k] * grid->to_local[4 * k + axis];
        most = nph_abs(voxels) > most ? nph_abs(voxels) : most;
    }
    int parts = most < 4.0 ? (int)nph_floor(2.0 * most + 0.999) : 8;
    return medium->shape == NPH_SHAPE_LAYER ? 1 : parts < 2 ? 2 : parts;
}

void nph_shdom_properties(NphShdomSolver *solver, int64_t block, int worker) {
    const NphShdomGrid *grid = &solver->choice->grid;
    const RMedium *medium = &solver->scene->local.media[0];
    int64_t first = block * NPH_SHDOM_BLOCK, end = first + NPH_SHDOM_BLOCK < grid->cell_count ? first + NPH_SHDOM_BLOCK : grid->cell_count;
    int parts[3], all = 1;
    double *row = solver->rows[worker];
    for (int a = 0; a < 3; a++) {
        parts[a] = parts_of(grid, medium, a);
        all *= parts[a];
    }
    for (int64_t cell = first; cell < end; cell++) {
        int64_t at[3] = {cell % grid->cells[0], cell / grid->cells[0] % grid->cells[1], cell / grid->cells[0] / grid->cells[1]};
        double sum = 0.0;
        for (int i = 0; i < all; i++) {
            int part[3] = {i % parts[0], i / parts[0] % parts[1], i / parts[0] / parts[1]};
            double u[3];
            for (int a = 0; a < 3; a++) u[a] = (double)at[a] + (part[a] + 0.5) / (double)parts[a];
            sum += density_at(grid, medium, u);
        }
        row[cell - first] = sum / (double)all;
    }
    size_t real = (size_t)solver->precision / 8;
    solver->kernels.store(row, end - first, (char *)solver->density + real * (size_t)first);
}
