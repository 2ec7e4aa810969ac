/* SPDX-License-Identifier: Apache-2.0
 *
 * Known bugs: mistakes that renderers make, one at a time, to see that the tests find them. NPH_BUG(n) is 0 here, and
 * the object code is as if it were not there (scripts/check_bugs). src/altered compiles the kernels once more with
 * NPH_ALTERED defined, where it asks whether bug n is the one to be made: `nephos diagnose` renders with each, and tests/bugs
 * runs the tests of the suite against them, each of which must make one fail. */
#ifndef NPH_CORE_BUG_H
#define NPH_CORE_BUG_H

#ifdef NPH_ALTERED
extern int nph_bug_number;
#define NPH_BUG(n) (nph_bug_number == (n))
#else
#define NPH_BUG(n) 0
#endif

/* Number, name, what is done wrong. Those marked "scene" are made by handing the kernels a wrong scene. */
#define NPH_KNOWN_BUGS(X)                                                                                            \
    X(1, "virtual_weight", "a virtual collision leaves the transmittance as it was")                                 \
    X(2, "mis_of_light_samples", "light samples count fully, though directions find the light too")                  \
    X(3, "cosine_sign", "the phase function's value is that of the opposite angle")                                  \
    X(4, "one_over_4_pi", "the isotropic phase function is 1")                                                       \
    X(5, "albedo_twice", "a scattering takes the albedo twice")                                                      \
    X(6, "albedo_never", "nothing takes the albedo")                                                                 \
    X(7, "environment_twice", "an environment found by chance counts fully, though light samples find it too")       \
    X(8, "half_voxel", "scene: grids lie half a voxel beside their place")                                           \
    X(9, "axes_swapped", "scene: x and z of grids are exchanged")                                                    \
    X(10, "sigma_s_for_sigma_t", "the extinction is the scattering coefficient")                                     \
    X(11, "voxel_size", "scene: voxels are as large as they would be with half as many")                             \
    X(12, "clamped", "no sample adds more than 1")                                                                   \
    X(13, "low_majorant", "majorants are four fifths of what they must be")                                          \
    X(14, "one_pdf_for_all", "every channel's weight is as if the hero's density were its own")                      \
    X(15, "reused_word", "a collision is decided by the word that gave its distance")                                \
    X(16, "roulette_weight", "survivors of the roulette weigh what they did")                                        \
    X(17, "sun_radiance", "the irradiance of a sun with a disc is taken as its radiance")                            \
    X(18, "inverse_square", "a point light does not grow dim with distance")                                         \
    X(19, "flux_pi", "a flux sensor's paths weigh 1 instead of pi")                                                  \
    X(20, "behind_the_light", "shadow rays go on behind a point light")                                              \
    X(21, "reused_azimuth", "the azimuth is turned by the word that gave the cosine")                                \
    X(22, "not_the_nearest", "of overlapping media the last one collides, wherever")                                 \
    X(23, "shadow_roulette_weight", "shadow rays that survive their roulette weigh what they did")                   \
    X(24, "weighed_virtual", "weighed flights forget their virtual collisions")                                      \
    X(25, "one_transmittance", "every channel's shadow rays see the extinction of the first")                        \
    X(26, "hemispheres", "light from above comes from below")                                                        \
    X(27, "upside_down", "row 0 is the bottom")                                                                      \
    X(28, "forgotten_cosine", "light samples at surfaces and flux sensors forget the cosine")                        \
    X(29, "mixed_fractions", "trilinear fractions of x and y are exchanged")                                         \
    X(30, "unweighted_guiding", "directions drawn towards the sun weigh as if drawn from the phase function")          \
    X(31, "forced_collision", "a first collision that was forced weighs as if every path had it")

#endif
