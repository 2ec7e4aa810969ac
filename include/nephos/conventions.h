/* SPDX-License-Identifier: Apache-2.0
 *
 * The conventions of this library, its scenes, its files and its pictures, stated once. Everything else refers here.
 *
 * SPACE. World space is right-handed, in metres, z up unless a camera says otherwise. Angles are degrees in files and
 * radians in C. Positions and transforms at the edge are double.
 *
 * TRANSFORMS are named target_from_source and read from right to left: world_from_grid takes a position of the grid to
 * the world. They are affine maps of 12 numbers, three rows of four, row-major, for column vectors:
 *     world[r] = m[4 r] x + m[4 r + 1] y + m[4 r + 2] z + m[4 r + 3]
 *
 * DIRECTIONS are unit vectors that point away from the vertex they belong to: from the scene towards the light, from a
 * collision to where the path goes on. Azimuth counts from +x towards +y, elevation from the horizon towards +z.
 *
 * SCATTERING ANGLE. cos_theta is the cosine between the directions of travel before and after: +1 goes on forward, -1
 * comes back. For two directions a, b that both point away from the vertex, cos_theta = -dot(a, b). A phase function is
 * a density over the sphere, 1/sr: its integral is 1, isotropic is 1/(4 pi), and positive g scatters forward.
 *
 * MEDIA. extinction(x) = density(x) * extinction_per_m, along metres of the WORLD: scaling a volume changes its size and
 * with it its optical depth, not its extinction. scattering = albedo * extinction. Where media overlap, coefficients add.
 *
 * SURFACES are opaque and reflect diffusely (Lambert) on both sides: albedo is the reflected part of the light, and the order
 * of a triangle's corners makes no difference.
 *
 * VOLUMES. Arrays are in C order with the axes z, y, x: a[k][j][i], x fastest; tuples are written x, y, z and indices
 * i, j, k. Sample (i, j, k) stands at the lattice point (i, j, k) of its grid; a voxel is the cube of edge 1 around it, so
 * its lower corner is i - 1/2. docs/volumes.md has the drawing and says what lies between and beyond the samples.
 *
 * PICTURES. Row 0 is the top row, x runs to the right, y downwards. Pixel (x, y) is the square [x, x + 1) x [y, y + 1);
 * its value is the mean over it. Crops are x0, y0, x1, y1 with x1 and y1 outside. R, G, B are all the light that arrives,
 * that of a sky seen through the media included; A = 1 - mean transmittance of the media, 1 behind a
 * surface.
 *
 * UNITS. extinction 1/m; radiance W/m2/sr; irradiance W/m2, on a plane that faces the sun; intensity of a point W/sr; all
 * per channel. The three channels are R, G, B, carried one by one; the library knows no colour space but luminance.
 *
 * ENVIRONMENT MAPS are latitude-longitude: the top row is +z, the middle of an unrotated map lies along +x, its right half
 * towards -y; a texel has one radiance all over.
 *
 * RANDOM NUMBERS are functions of (seed, frame, pixel, sample, vertex, draw): samples have numbers, from 0, and sample 7
 * of a pixel is the same whatever was rendered before (docs/path.md). Ranges of samples begin and end at multiples of
 * NPH_SAMPLE_STEP.
 *
 * FILES hold no time, host, path or user; numbers in binary files are little-endian; decimals are read and written
 * without the locale. */
#ifndef NEPHOS_CONVENTIONS_H
#define NEPHOS_CONVENTIONS_H

/* Axes of tuples, planes of colour. */
enum { NPH_X = 0, NPH_Y = 1, NPH_Z = 2 };
enum { NPH_RED = 0, NPH_GREEN = 1, NPH_BLUE = 2 };

/* Ranges of samples begin and end at multiples of this. */
enum { NPH_SAMPLE_STEP = 16 };

/* Luminance of linear R, G, B (Rec. 709). */
#define NPH_LUMINANCE_RED   0.2126
#define NPH_LUMINANCE_GREEN 0.7152
#define NPH_LUMINANCE_BLUE  0.0722

#endif
