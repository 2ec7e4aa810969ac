/* SPDX-License-Identifier: Apache-2.0
 *
 * Complex refractive indices n + i k of what scatters in the atmosphere, relative to vacuum, from 0.2 to 20 um. Between rows n is
 * linear and ln k is linear in ln wavelength. That air's index is 1.0003 is left out: n is uncertain by more. */
#ifndef NPH_OPTICS_INDEX_H
#define NPH_OPTICS_INDEX_H

typedef struct NphIndexRow {
    double wavelength_um, n, k; /* k > 0 */
} NphIndexRow;

typedef struct NphIndexTable {
    const char *name;
    const NphIndexRow *rows; /* wavelengths rise */
    int count;
} NphIndexTable;

typedef enum NphMaterial { NPH_WATER, NPH_ICE, NPH_SOOT, NPH_INDEX_MATERIALS } NphMaterial;

#define NPH_MATERIAL_WORDS "water|ice|soot"

extern const NphIndexTable nph_index_tables[NPH_INDEX_MATERIALS];

/* 0, index untouched, where the table does not reach. */
int nph_index_at(NphMaterial material, double wavelength_um, double index[2]);

#endif
