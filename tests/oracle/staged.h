/* SPDX-License-Identifier: Apache-2.0
 *
 * Scenes in which every method has every one of its stages. */
#ifndef NPH_TESTS_STAGED_H
#define NPH_TESTS_STAGED_H

#define CAMERA "nephos: 1\ncamera: {type: perspective, resolution: [18, 9], position: [-2, -1.5, 1.2], look_at: [0.5, 0.5, 0.5], fov: 40}\n"
#define CLOUD "density: {file: ../data/cumulus/cumulus_300.zip.nvdb}"

static const char *const scenes[] = {
    CAMERA "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 6, albedo: 0.95, phase: {type: hg, g: 0.8}}\n"
           "lights:\n  - {type: sun, direction: [-1, 0.2, 0.3], irradiance: 3}\n  - {type: constant, radiance: 0.2}\n",
    /* weighed flights through a grid, that end at surfaces */
    CAMERA "media:\n  - {" CLOUD ", extinction: 20, albedo: 0.6}\nsurfaces:\n  - {plane: 0.1, albedo: 0.7}\n"
           "lights:\n  - {type: constant, radiance: [0.1, 0.2, 0.3]}\n",
    /* split camera rays of a flux sensor */
    "nephos: 1\ncamera: {type: flux, position: [0, 0, 1.1], direction: [0, 0, -1], extent: 1, resolution: [18, 9], up: [0, 1, 0]}\n"
    "media:\n  - {layer: [0, 1], extinction: 0.02, albedo: 0.9, phase: {type: rayleigh}}\n"
    "lights:\n  - {type: sun, direction: [1, 0.2, 1], irradiance: 3}\n  - {type: constant, radiance: 0.5, hemisphere: upper}\n",
    /* channels, a grid over a box, emission, a point light in a medium, a sun with a disc, a mesh */
    CAMERA "media:\n"
           "  - {box: [[0, 0, 0], [1, 1, 1]], extinction: [2, 5, 0], albedo: [0.9, 1, 0.5], phase: {type: two_lobe, g: 0.8, g2: -0.3, weight: 0.7},\n"
           "     emission: {type: volume, radiance: 0.1}}\n"
           "  - {" CLOUD ", extinction: [20, 30, 9], albedo: 0.9}\n"
           "surfaces:\n  - {plane: -0.3}\n  - {mesh: ../data/mesh/teapot.obj, albedo: [0.2, 0.5, 0.9], transform: [{scale: 0.2}, {translate: [0.3, 0, -0.3]}]}\n"
           "lights:\n  - {type: sun, direction: [1, 0.2, 1], irradiance: [3, 2, 1], angular_diameter: 5}\n"
           "  - {type: point, position: [0.5, 0.5, 0.5], intensity: [1, 2, 3]}\n",
    /* a grid and a sun, repeated */
    CAMERA "periodic: {x: [0.1, 0.8], y: [0, 1]}\nmedia:\n  - {" CLOUD ", extinction: 40, albedo: 1, phase: {type: hg, g: 0.85}}\n"
           "lights:\n  - {type: sun, direction: [1, -1, 1], irradiance: 3}\n",
    CAMERA "wavelengths: [420, 480, 550, 600, 690]\n"
           "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: [8, 6, 4, 3, 2], albedo: [1, 0.9, 0.8, 0.9, 1], phase: {type: hg, g: 0.8}}\n"
           "lights:\n  - {type: sun, direction: [1, 0.2, 1], irradiance: [3, 2, 1, 2, 3]}\n",
    /* channels, a grid over a box */
    CAMERA "media:\n"
           "  - {box: [[0, 0, 0], [1, 1, 1]], extinction: [2, 5, 0], albedo: [0.9, 1, 0.5], phase: {type: two_lobe, g: 0.8, g2: -0.3, weight: 0.7}}\n"
           "  - {" CLOUD ", extinction: [20, 30, 9], albedo: 0.9}\n"
           "lights:\n  - {type: sun, direction: [1, 0.2, 1], irradiance: [3, 2, 1], angular_diameter: 5}\n"
           "  - {type: constant, radiance: 0.1}\n  - {type: point, position: [0.5, 0.5, 0.5], intensity: [1, 2, 3]}\n",
    /* one grid, a sun, a sky and a point */
    CAMERA "media:\n  - {density: {file: ../data/sphere/sphere.npy, box: [[0, 0, 0], [1, 1, 1]]}, extinction: 0.05, albedo: 0.95, phase: {type: hg, g: 0.7}}\n"
           "lights:\n  - {type: sun, direction: [1, 0.2, 1], irradiance: [3, 2, 1]}\n  - {type: constant, radiance: 0.1}\n"
           "  - {type: point, position: [0.4, 0.6, 1.4], intensity: [0.1, 0.2, 0.3]}\n",
    /* the same between a plane and a mesh */
    CAMERA "media:\n  - {density: {file: ../data/sphere/sphere.npy, box: [[0, 0, 0], [1, 1, 1]]}, extinction: 0.05, albedo: 0.95, phase: {type: hg, g: 0.7}}\n"
           "surfaces:\n  - {plane: -0.3}\n  - {mesh: ../data/mesh/teapot.obj, albedo: [0.2, 0.5, 0.9], transform: [{scale: 0.2}, {translate: [0.3, 0, -0.3]}]}\n"
           "lights:\n  - {type: sun, direction: [1, 0.2, 1], irradiance: [3, 2, 1]}\n  - {type: constant, radiance: 0.1}\n"
           "  - {type: point, position: [0.4, 0.6, 1.4], intensity: [0.1, 0.2, 0.3]}\n",
};
enum { SCENES = sizeof scenes / sizeof *scenes, MAX_METHODS = 16 };

#endif
