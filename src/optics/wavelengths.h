/* SPDX-License-Identifier: Apache-2.0
 *
 * A list of wavelengths as samples of a spectrum: what each is worth in X, Y, Z, and which are transported together.
 *
 * Each stands for the interval between the midpoints to its neighbours, the outermost for an interval that reaches
 * as far outwards as inwards. The observer (cie.h, linear between whole nanometres) is taken at the wavelength, and
 * the weights are scaled so that a spectrum of value 1 at every wavelength has Y = 1. Spectral radiances in
 * W/m2/sr/nm so give R, G, B in W/m2/sr/nm. A spectrum of one value is the equal-energy white E, which in Rec. 709,
 * whose white is D65, is not R = G = B but about (1.205, 0.948, 0.909).
 *
 * Groups of three are transported at once. Those of group g are g, g + G, g + 2 G of G groups, so that every group
 * spans the list; where that runs beyond its end a wavelength is repeated and weighs nothing. */
#ifndef NPH_OPTICS_WAVELENGTHS_H
#define NPH_OPTICS_WAVELENGTHS_H

enum { NPH_MAX_WAVELENGTHS = 60 };

/* Out: weight[i][k], X, Y and Z of a spectrum that is 1 at wavelength i and 0 at the others. One wavelength alone
 * has the chromaticity of its colour. 1 <= count <= NPH_MAX_WAVELENGTHS, rising, 360 to 830 nm. */
void nph_wavelength_weights(const double *wavelengths_nm, int count, double (*weight)[3]);

static inline int nph_wavelength_groups(int count) { return (count + 2) / 3; }

/* The wavelength of channel c of a group; *repeated: it stands there for nothing. */
static inline int nph_wavelength_of(int count, int group, int c, int *repeated) {
    int groups = nph_wavelength_groups(count), index = group + c * groups;
    *repeated = index >= count;
    while (index >= count) index -= groups;
    return index;
}

/* Row-major: what channel c of a group adds to R, G, B (columns are channels). Summed over the groups it is the whole
 * conversion. */
void nph_wavelength_matrix(const double *wavelengths_nm, int count, int group, double rgb_from_channels[9]);

/* Means over the upper, middle and lower third of the list, at least one value each: a spectrum as R, G, B for where
 * a rough colour is enough. 0 only where all of its values are 0. */
void nph_spectrum_thirds(const double *values, int count, double rgb[3]);

#endif
