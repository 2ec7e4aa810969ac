/* SPDX-License-Identifier: Apache-2.0
 *
 * Scattering by hexagonal prisms in random orientation, by geometric optics: rays with their electric field are reflected, refracted
 * and split at facets by Fresnel's formulas [Macke96; Takano89], and what falls on a crystal is diffracted once more as by a disc
 * of the projected area. Right where crystals are much larger than the wavelength; beams do not interfere.
 *
 * tilt > 0 makes facets rough: each time a ray meets one, its normal is turned by a random angle, evenly spread up to tilt times 90
 * degrees, about a random axis [Macke96]. That is what stands for irregular crystals and for snow. */
#ifndef NPH_OPTICS_CRYSTAL_H
#define NPH_OPTICS_CRYSTAL_H

#include "nephos/array.h"

typedef struct NphCrystal {
    double length_um; /* along the axis: columns are longer than wide, plates shorter */
    double edge_um;   /* of the hexagon, half its width */
    double tilt;      /* 0: smooth, below 1 */
    double wavelength_um, index[2];
    int64_t rays;     /* that fall on the sphere around the crystal; rounded up to blocks of NPH_CRYSTAL_BLOCK */
    uint32_t seed;
} NphCrystal;

enum { NPH_CRYSTAL_BLOCK = 4096, NPH_CRYSTAL_BINS = 720 /* of a quarter of a degree */ };
#define NPH_CRYSTAL_MOST_RAYS (1LL << 36)

/* Of the light that falls on the crystal; all but `lost` is accounted for. Errors are standard errors of blocks. */
typedef struct NphCrystalRays {
    int64_t rays, hits;
    double bin[NPH_CRYSTAL_BINS]; /* part that leaves within quarters of a degree from the old direction, without `straight` */
    double straight;              /* part that leaves in the old direction, through parallel facets */
    double absorbed, lost;        /* lost: what still ran in the crystal after 300 facets, or left through an edge */
    double mean_cosine, mean_cosine_error; /* of what leaves */
    double projected_um2, projected_error_um2; /* mean projected area; a quarter of the surface */
} NphCrystalRays;

typedef struct NphCrystalTable {
    NphArray rows; /* f64 [n][2]: degrees, 1/sr; owned */
    NphCrystalRays rays;
    double extinction_um2, albedo, asymmetry, asymmetry_error;
} NphCrystalTable;

double nph_crystal_surface_um2(const NphCrystal *crystal);

/* NPH_BAD_INPUT names what is out of range. Interruptible; the same numbers for any number of threads. */
NphStatus nph_crystal_trace(NphContext *context, const NphCrystal *crystal, const char *what, NphCrystalRays *rays);
NphStatus nph_crystal_table(NphContext *context, const NphCrystal *crystal, const char *what, NphCrystalTable *table);
void nph_crystal_table_free(NphContext *context, NphCrystalTable *table);

#endif
