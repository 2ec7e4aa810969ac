/* SPDX-License-Identifier: Apache-2.0
 *
 * Directions of truth/shdom: ordinates with their weights, real spherical harmonics, the cut of their peak
 * (delta-M) and windows against ringing. All of it in double. */
#ifndef NPH_TRUTH_SHDOM_ANGLES_H
#define NPH_TRUTH_SHDOM_ANGLES_H

#include "optics/phase.h"

enum { NPH_SHDOM_BANDS_MAX = 32, NPH_SHDOM_TERMS_MAX = NPH_SHDOM_BANDS_MAX * NPH_SHDOM_BANDS_MAX };
enum { NPH_SHDOM_POLAR_MAX = 128, NPH_SHDOM_AZIMUTHS_MAX = 256 };
enum { NPH_SHDOM_NO_WINDOW, NPH_SHDOM_HANNING, NPH_SHDOM_LANCZOS, NPH_SHDOM_GAUSSIAN }; /* shdom.prefilter */

typedef struct NphShdomAngles {
    int bands;             /* harmonics of degree 0 to bands - 1 */
    int terms;             /* coefficients that scatter: those up to the last degree that does, squared */
    int polar, azimuths;   /* ordinates: as many polar angles, half of them upwards, and azimuths of each */
    double cosine[NPH_SHDOM_POLAR_MAX], weight[NPH_SHDOM_POLAR_MAX]; /* of polar angles; the weights add to 2 */
    double cut;            /* f: what delta-M takes for not scattered */
    double kept[NPH_SHDOM_BANDS_MAX]; /* (chi_l - f) / (1 - f) w_l: what the source function keeps of degree l */
    double plain[NPH_SHDOM_BANDS_MAX]; /* without the window */
} NphShdomAngles;

/* Of one ordinate: unit vector along which its light travels; returns its weight [sr]. */
double nph_shdom_ordinate(const NphShdomAngles *angles, int ordinate, double d[3]);
static inline int nph_shdom_ordinates(const NphShdomAngles *angles) { return angles->polar * angles->azimuths; }
/* The ordinate in whose part of the sphere a direction lies. */
int nph_shdom_ordinate_of(const NphShdomAngles *angles, const double d[3]);

/* Real orthonormal harmonics of degree < bands at a unit vector: y[l (l + 1) + m]. */
void nph_shdom_harmonics(int bands, const double d[3], double *y);

/* The phase function times 4 pi as solved, at a cosine: sum of (2 l + 1) plain_l P_l; windowed: of kept_l. */
double nph_shdom_cut_phase(const NphShdomAngles *angles, double cosine, int windowed);

/* Gauss and Legendre's points in rising order and weights on [0, 1] [Golub69]; count at most 64. */
void nph_shdom_gauss(int count, double *point, double *weight);

typedef struct NphShdomCut {
    int bands, polar, azimuths; /* polar, azimuths 0: twice the bands */
    int delta_m, window;
    double width;               /* of the window, in bands; 0: the bands */
} NphShdomCut;
void nph_shdom_angles(const NphPhase *phase, const NphShdomCut *cut, NphShdomAngles *angles);

/* A place in the grid to look up the source function at: eight points with weights, one direction. */
typedef struct NphShdomLook {
    int64_t points[8];
    double weights[8];
    int rows, terms;     /* of every point: rows of terms */
    const double *basis; /* [terms] */
    double *room;        /* [rows][terms] */
} NphShdomLook;

#endif
