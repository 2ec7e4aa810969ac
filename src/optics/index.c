/* SPDX-License-Identifier: Apache-2.0
 *
 * Refractive indices between the rows of their tables. */
#include "optics/index.h"

#include "core/fmath.h"

int nph_index_at(NphMaterial material, double wavelength_um, double index[2]) {
    const NphIndexTable *table = &nph_index_tables[material];
    int low = 0, high = table->count - 1;
    if (!(wavelength_um >= table->rows[low].wavelength_um && wavelength_um <= table->rows[high].wavelength_um)) return 0;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        *(table->rows[middle].wavelength_um <= wavelength_um ? &low : &high) = middle;
    }
    const NphIndexRow *a = &table->rows[low], *b = &table->rows[high];
    double along = nph_log(wavelength_um / a->wavelength_um) / nph_log(b->wavelength_um / a->wavelength_um);
    index[0] = a->n + along * (b->n - a->n);
    index[1] = a->k * nph_exp(along * nph_log(b->k / a->k));
    return 1;
}
