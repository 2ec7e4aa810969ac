/* SPDX-License-Identifier: Apache-2.0
 *
 * From spectra to the film's linear Rec. 709: the CIE 1931 standard observer, normalised so that a spectrum of value 1
 * at every wavelength has Y = 1:
 *     XYZ = sum L(lambda) (x, y, z)(lambda) / sum y(lambda)         over whole nanometres, 360 to 830
 * A spectral radiance in W/m2/sr/nm therefore gives R, G, B in W/m2/sr/nm: weighted means of it. */
#ifndef NPH_OPTICS_CIE_H
#define NPH_OPTICS_CIE_H

enum { NPH_CIE_FIRST_NM = 360, NPH_CIE_COUNT = 471 };

extern const double nph_cie1931[NPH_CIE_COUNT][3]; /* x, y, z; one row a nanometre */
extern const double nph_rec709_from_xyz[9];        /* row-major; XYZ of white D65 with Y = 1 gives 1, 1, 1 */

static inline void nph_rgb_from_xyz(const double xyz[3], double rgb[3]) {
    const double *m = nph_rec709_from_xyz;
    for (int c = 0; c < 3; c++) rgb[c] = m[3 * c] * xyz[0] + m[3 * c + 1] * xyz[1] + m[3 * c + 2] * xyz[2];
}

#endif
