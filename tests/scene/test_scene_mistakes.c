/* SPDX-License-Identifier: Apache-2.0
 *
 * Wrong scenes: each mistake is reported at its line and column with what is wrong and what is allowed. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "harness.h"
#include "nephos/scene.h"
#include "scene/scene_read.h"

#define CAMERA "camera: {resolution: [4, 3], position: [0, -4, 0], look_at: [0, 0, 0], fov: 35}\n"
#define HEAD "nephos: 1\n" CAMERA /* lines 1 and 2 */
#define MEDIUM HEAD "media:\n  - box: [[0, 0, 0], [1, 1, 1]]\n    extinction: 1\n" /* lines 3 to 5 */
#define LIGHTS HEAD "lights:\n  - " /* line 4, column 5 */
#define ANIMATED MEDIUM "    albedo: " /* line 6, column 13 */
#define SEQUENCE HEAD "media:\n  - {density: {box: [[0, 0, 0], [1, 1, 1]], file: "

typedef struct Wrong {
    const char *text;
    int line, column;
    const char *fragment; /* of the message at that place */
    int messages;         /* in all */
} Wrong;

static const Wrong wrong[] = {
    /* the file as a whole */
    {"", 1, 1, "empty", 1},
    {"# only a comment\n", 1, 1, "empty", 1},
    {"---\n...\n", 2, 1, "the scene: nothing where a mapping (key: value) is expected", 1},
    {"just text\n", 1, 1, "the scene: 'just text' where a mapping", 1},
    {"- nephos: 1\n", 1, 1, "a list where a mapping", 1},
    {"nephos: 1\n", 1, 1, "the scene lacks camera", 1},
    {CAMERA, 1, 1, "the scene lacks nephos", 1},
    {"nephos: 2\n" CAMERA, 1, 9, "nephos is '2'; allowed: 1", 1},
    {"nephos: '1'\n" CAMERA, 1, 9, "quoted", 1},
    {"nephos: one\n" CAMERA, 1, 9, "not a number", 1},
    {"nephos:\n" CAMERA, 1, 8, "nephos has no value; expected a whole number", 1},
    {HEAD "---\nnephos: 1\n", 3, 1, "second document", 1},
    {HEAD "lihgts: []\n", 3, 1, "unknown key 'lihgts' in the scene; did you mean 'lights'?", 1},
    {HEAD "albedo: 1\n", 3, 1, "it belongs to a medium", 1},
    {HEAD "materials: []\n", 3, 1, "allowed: nephos, camera, wavelengths, media, lights, air, surfaces, periodic, render", 1},
    {HEAD "render: {}\nrender: {}\n", 4, 1, "render is given twice; first in line 3", 1},
    {HEAD "<<: {a: 1}\n", 3, 1, "merge keys", 1},
    {HEAD "[1, 2]: 3\n", 3, 1, "a key of the scene is a list", 1},
    {HEAD "media: {}\n", 3, 8, "media is a mapping; expected a list", 1},
    {HEAD "media:\n", 3, 7, "media has no value", 1},
    {HEAD "media: 3\n", 3, 8, "media is '3'; expected a list of mappings", 1},
    {HEAD "media:\n  - 3\n", 4, 5, "a medium: '3' where a mapping", 1},
    {HEAD "lights: [[]]\n", 3, 10, "a light: a list where a mapping", 1},
    {HEAD "render: [64]\n", 3, 9, "render is a list; expected a mapping", 1},

    /* YAML and bytes */
    {HEAD "media: [1, 2\n", 4, 1, "not YAML: did not find expected ',' or ']'", 1},
    {HEAD "media:\n\t- a\n", 4, 1, "blanks, not tabs", 1},
    {HEAD "render: a: b\n", 3, 10, "not YAML: mapping values are not allowed", 1},
    {HEAD "render: {samples: *none}\n", 3, 19, "undefined alias", 1},
    {HEAD "render: {samples: \"64}\n", 4, 1, "not YAML: found unexpected end of stream", 1},
    {HEAD "render: {samples: !!int 64}\n", 3, 19, "tag 'tag:yaml.org,2002:int'", 1},
    {HEAD "render: {samples: !!str 64}\n", 3, 19, "tags are not used", 1},
    {HEAD "render: !mine {samples: 64}\n", 3, 9, "tag '!mine'", 1},
    {HEAD "# caf\xe9\n", 3, 6, "byte 0xE9 at offset 95 is not UTF-8", 1},
    {HEAD "# \xc0\x80\n", 3, 3, "not UTF-8", 1},
    {HEAD "# \xed\xa0\x80\n", 3, 3, "not UTF-8", 1},
    {HEAD "# \xc3\xa9 \x01\n", 3, 5, "control characters are not allowed", 1},
    {"\xff\xfen\0e\0", 1, 1, "UTF-8", 1},
    {HEAD "render: {samples: \"6\\04\"}\n", 3, 19, "quoted", 1},
    {HEAD "a: [[[[[[[[[[[[[[[[[[[[1]]]]]]]]]]]]]]]]]]]]\n", 3, 19, "nested more than 16 deep", 1},
    {HEAD "\"medi\\0a\": 1\n", 3, 1, "keys are words", 1},
    {HEAD "render: {\"a\\eb\": 1}\n", 3, 10, "unknown key 'a?b'", 1},

    /* numbers */
    {HEAD "render: {samples: 0x40}\n", 3, 19, "no hex", 1},
    {HEAD "render: {samples: 6_4}\n", 3, 19, "no '_'", 1},
    {HEAD "render: {samples: 1:30}\n", 3, 19, "no ':'", 1},
    {HEAD "render: {samples: 064}\n", 3, 19, "octal", 1},
    {HEAD "render: {samples: 6.5}\n", 3, 19, "not a whole number", 1},
    {HEAD "render: {samples: 1e3}\n", 3, 19, "not a whole number", 1},
    {HEAD "render: {samples: true}\n", 3, 19, "'true' is not a number", 1},
    {HEAD "render: {samples: 0}\n", 3, 19, "samples is '0'; allowed: 1 to 2147483647 per pixel", 1},
    {HEAD "render: {samples: -64}\n", 3, 19, "allowed: 1 to", 1},
    {HEAD "render: {samples: 99999999999999999999}\n", 3, 19, "allowed: 1 to", 1},
    {HEAD "render: {samples: [64]}\n", 3, 19, "samples is a list; expected a whole number", 1},
    {HEAD "render: {seed: 4294967296}\n", 3, 16, "seed is '4294967296'; allowed: 0 to 4294967295", 1},
    {HEAD "render: {seed: ~}\n", 3, 16, "seed has no value", 1},
    {HEAD "render: {spp: 64}\n", 3, 10, "unknown key 'spp' in render; allowed: samples, seed", 1},

    /* camera */
    {"nephos: 1\ncamera: {}\n", 2, 9, "the camera lacks resolution", 4},
    {"nephos: 1\ncamera: none\n", 2, 9, "camera is 'none'; expected a mapping", 1},
    {"nephos: 1\ncamera: {type: ortographic, resolution: [4, 3], position: [0, 0, 9], look_at: [1, 0, 0]}\n", 2, 16,
     "type: 'ortographic' is not known; allowed: perspective, orthographic, flux, fisheye, fluence, radiance; did you mean 'orthographic'?", 1},
    {"nephos: 1\ncamera: {type: orthographic, resolution: [4, 3], position: [0, 0, 9], look_at: [1, 0, 0], fov: 3, "
     "extent: 1}\n", 2, 91, "fov does not go with type orthographic, only with perspective", 1},
    {"nephos: 1\ncamera: {type: flux, resolution: [4, 3], position: [0, 0, 9], look_at: [1, 0, 0]}\n", 2, 9,
     "the camera lacks extent", 1},
    {"nephos: 1\ncamera: {resolution: [4], position: [0, 0, 9], look_at: [1, 0, 0], fov: 3}\n", 2, 22,
     "resolution has 1 entries; expected two whole numbers, [width, height]", 1},
    {"nephos: 1\ncamera: {resolution: [0, 3], position: [0, 0, 9], look_at: [1, 0, 0], fov: 3}\n", 2, 23,
     "resolution is '0'; allowed: 1 to 65536 pixels", 1},
    {"nephos: 1\ncamera: {resolution: [4, 65537], position: [0, 0, 9], look_at: [1, 0, 0], fov: 3}\n", 2, 26,
     "allowed: 1 to 65536", 1},
    {"nephos: 1\ncamera: {resolution: 4, position: [0, 0, 9], look_at: [1, 0, 0], fov: 3}\n", 2, 22,
     "resolution is '4'; expected two", 1},
    {"nephos: 1\ncamera: {resolution: [4, 3], position: [0, nan, 9], look_at: [1, 0, 0], fov: 3}\n", 2, 44,
     "position: 'nan' is not a finite number", 1},
    {"nephos: 1\ncamera: {resolution: [4, 3], position: [0, -.inf, 9], look_at: [1, 0, 0], fov: 3}\n", 2, 44,
     "not a finite number", 1},
    {"nephos: 1\ncamera: {resolution: [4, 3], position: [0, 1e13, 9], look_at: [1, 0, 0], fov: 3}\n", 2, 44,
     "position is '1e13'; allowed: -1e12 to 1e12 m", 1},
    {"nephos: 1\ncamera: {resolution: [4, 3], position: [0, 1e999, 9], look_at: [1, 0, 0], fov: 3}\n", 2, 44,
     "too large a number", 1},
    {"nephos: 1\ncamera: {resolution: [4, 3], position: [1, 2, 3], look_at: [1, 2, 3], fov: 3}\n", 2, 60,
     "look_at is the camera's own position", 1},
    {"nephos: 1\ncamera: {resolution: [4, 3], position: [1, 2, 3], look_at: [1, 2, 4], fov: 3}\n", 2, 9,
     "up (default [0, 0, 1]) is parallel to the viewing direction", 1},
    {"nephos: 1\ncamera: {resolution: [4, 3], position: [1, 2, 3], direction: [1, 2, 4], up: [2, 4, 8], fov: 3}\n", 2, 77,
     "up is parallel", 1},
    {"nephos: 1\ncamera: {resolution: [4, 3], position: [1, 2, 3], direction: [1, 2, 4], up: [0, 0, 0], fov: 3}\n", 2, 77,
     "up has length 0", 1},
    {"nephos: 1\ncamera: {resolution: [4, 3], position: [1, 2, 3], direction: [0, 0, 0], fov: 3}\n", 2, 62,
     "direction has length 0", 1},
    {"nephos: 1\ncamera: {resolution: [4, 3], position: [1, 2, 3], direction: [1, 0, 0], look_at: [0, 0, 0], fov: 3}\n", 2,
     62, "look_at and direction exclude each other", 1},
    {"nephos: 1\ncamera: {resolution: [4, 3], position: [1, 2, 3], fov: 3}\n", 2, 9, "the camera lacks look_at, or direction", 1},
    {"nephos: 1\ncamera: {resolution: [4, 3], position: [1, 2, 3], direction: [1, 0, 0], fov: 180}\n", 2, 78,
     "fov is '180'; allowed: 0.001 to 179 degrees", 1},
    {"nephos: 1\ncamera: {resolution: [4, 3], position: [1, 2, 3], direction: [1, 0, 0], fov: 0}\n", 2, 78, "fov is '0'", 1},
    {"nephos: 1\ncamera: {type: flux, resolution: [4, 3], position: [1, 2, 3], direction: [1, 0, 0], extent: 0}\n", 2, 93,
     "extent is '0'; allowed: 1e-9 to 1e12 m", 1},
    {"nephos: 1\ncamera: {resolution: [4, 3], position: [1, 2, 3], direction: [1, 0, 0], fov: 3, crop: [0, 0, 5, 3]}\n", 2,
     87, "crop [0, 0, 5, 3] is not within the picture; allowed: 0 <= x0 < x1 <= 4", 1},
    {"nephos: 1\ncamera: {resolution: [4, 3], position: [1, 2, 3], direction: [1, 0, 0], fov: 3, crop: [2, 0, 2, 3]}\n", 2,
     87, "not within the picture", 1},
    {"nephos: 1\ncamera: {resolution: [4, 3], position: [1, 2, 3], direction: [1, 0, 0], fov: 3, crop: [-1, 0, 2, 3]}\n", 2,
     88, "crop is '-1'; allowed: 0 to 65536", 1},

    /* surfaces */
    {HEAD "surfaces: [3]\n", 3, 12, "a surface: '3' where a mapping", 1},
    {HEAD "surfaces:\n  - {albedo: 1}\n", 4, 5, "a surface lacks mesh with transform, or plane", 1},
    {HEAD "surfaces:\n  - {plane: 0, mesh: a.obj}\n", 4, 13, "mesh and plane exclude each other", 1},
    {HEAD "surfaces:\n  - {plane: 0, transform: []}\n", 4, 13, "transform and plane exclude each other", 1},
    {HEAD "surfaces:\n  - {transform: []}\n", 4, 5, "transform is given without mesh", 1},
    {HEAD "surfaces:\n  - {plane: 2e12}\n", 4, 13, "plane is '2e12'; allowed: -1e12 to 1e12 m", 1},
    {HEAD "surfaces:\n  - {plane: [0, 0, 1]}\n", 4, 13, "plane is a list; expected a number", 1},
    {HEAD "surfaces:\n  - {plane: 0, albedo: 1.5}\n", 4, 24, "albedo is '1.5'; allowed: 0 to 1", 1},
    {HEAD "surfaces:\n  - {plane: 0, albedo: [1, 0]}\n", 4, 24, "albedo has 2 entries", 1},
    {HEAD "surfaces:\n  - {plane: 0, color: 1}\n", 4, 16, "unknown key 'color' in a surface; allowed: name, mesh, transform, plane, albedo", 1},
    {HEAD "surfaces:\n  - {name: a, plane: 0}\n  - {name: a, plane: 1}\n", 5, 12, "the name 'a' is taken by surface number 0", 1},
    {HEAD "surfaces:\n  - {mesh: a.stl}\n", 4, 12, "mesh: 'a.stl' ends in none of .obj, .ply", 2},
    {HEAD "surfaces:\n  - {mesh: a.stl, transform: [{scale: 0}]}\n", 4, 39, "scale has a factor 0", 3},

    /* more sensors */
    {"nephos: 1\ncamera: {type: fisheye, resolution: [4, 3], position: [1, 2, 3], direction: [1, 0, 0], fov: 361}\n", 2, 93,
     "fov is '361'; allowed: 0.001 to 360 degrees", 1},
    {"nephos: 1\ncamera: {type: fisheye, resolution: [4, 3], position: [1, 2, 3], direction: [1, 0, 0], extent: 1}\n", 2, 88,
     "extent does not go with type fisheye, only with orthographic or flux or fluence or radiance", 2},
    {"nephos: 1\ncamera: {type: fluence, resolution: [4, 3], position: [1, 2, 3], direction: [1, 0, 0]}\n", 2, 9,
     "the camera lacks extent", 1},
    {"nephos: 1\ncamera: {type: fluence, resolution: [4, 3], position: [1, 2, 3], direction: [1, 0, 0], extent: 1, seen: [1, 0, 0]}\n",
     2, 99, "seen does not go with type fluence, only with radiance", 1},
    {"nephos: 1\ncamera: {type: radiance, resolution: [4, 3], position: [1, 2, 3], direction: [1, 0, 0], extent: 1}\n", 2, 9,
     "the camera lacks seen", 1},
    {"nephos: 1\ncamera: {type: radiance, resolution: [4, 3], position: [1, 2, 3], direction: [1, 0, 0], extent: 1, seen: [0, 0, 0]}\n",
     2, 106, "seen has length 0", 1},

    /* periodic sides */
    {HEAD "periodic: {}\n", 3, 11, "periodic lacks x, y, or both", 1},
    {HEAD "periodic: [0, 1]\n", 3, 11, "periodic is a list; expected a mapping", 1},
    {HEAD "periodic: {z: [0, 1]}\n", 3, 12, "unknown key 'z' in periodic; allowed: x, y", 2},
    {HEAD "periodic: {x: [1, 1]}\n", 3, 15, "x is flat: from 1 to 1", 1},
    {HEAD "periodic: {x: [1, 0]}\n", 3, 15, "x is inverted: from 1 to 0", 1},
    {HEAD "periodic: {y: 3}\n", 3, 15, "y is '3'; expected two numbers, [low, high]", 1},
    {MEDIUM "periodic: {x: [1, 2]}\n", 6, 11, "medium medium0 lies outside of periodic x: it reaches from 0 to 1 m", 1},
    {MEDIUM "periodic: {x: [0, 2], y: [-3, 0]}\n", 6, 11, "lies outside of periodic y", 1},
    {HEAD "periodic: {x: [0, 1]}\nlights: [{type: point, position: [0, 0, 0], intensity: 1}]\n", 3, 11,
     "periodic does not go with a point light", 1},

    /* media: shape and coefficients */
    {HEAD "media:\n  - extinction: 1\n", 4, 5, "a medium lacks density, or box, or layer", 1},
    {HEAD "media:\n  - box: [[0, 0, 0], [1, 1, 1]]\n", 4, 5,
     "a medium lacks extinction with albedo, or scattering with absorption", 1},
    {HEAD "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], albedo: 1}\n", 4, 5, "albedo is given without extinction", 1},
    {MEDIUM "    layer: [0, 1]\n", 6, 12, "box and layer exclude each other", 1},
    {MEDIUM "    absorption: 1\n", 6, 17, "extinction and absorption exclude each other", 1},
    {MEDIUM "    albdo: 1\n", 6, 5, "unknown key 'albdo' in a medium; did you mean 'albedo'?", 1},
    {MEDIUM "    albedo: 1.5\n", 6, 13, "albedo is '1.5'; allowed: 0 to 1", 1},
    {MEDIUM "    albedo: [1, 1, -0.1]\n", 6, 20, "albedo is '-0.1'", 1},
    {MEDIUM "    albedo: [1, 1]\n", 6, 13, "albedo has 2 entries; expected a number or three, [r, g, b]", 1},
    {MEDIUM "    albedo: {r: 1}\n", 6, 13, "albedo is a mapping; expected a number or three", 1},
    {MEDIUM "    g: 0.5\n", 6, 5, "it belongs to a phase function", 1},
    {MEDIUM "    name: \"\"\n", 6, 11, "name has 0 bytes; allowed: 1 to 63", 1},
    {MEDIUM "    name: \"a\\nb\"\n", 6, 11, "control character", 1},
    {MEDIUM "    name: medium1\n  - {layer: [0, 1], extinction: 1}\n", 7, 5, "the name 'medium1' is taken by medium number 0", 1},
    {HEAD "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: -1}\n", 4, 47,
     "extinction is '-1'; allowed: 0 to 1e9 1/m", 1},
    {HEAD "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 1.1e9}\n", 4, 47, "allowed: 0 to 1e9 1/m", 1},
    {HEAD "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], scattering: 6e8, absorption: 6e8}\n", 4, 47, "exceed 1e9", 1},
    {HEAD "media:\n  - {box: [[0, 0, 0], [1, 0, 1]], extinction: 1}\n", 4, 11, "box is flat along y: from 0 to 0", 1},
    {HEAD "media:\n  - {box: [[0, 0, 2], [1, 1, 1]], extinction: 1}\n", 4, 11, "box is inverted along z: from 2 to 1", 1},
    {HEAD "media:\n  - {box: [[0, 0, 0], [1, 1, 1e13]], extinction: 1}\n", 4, 30, "allowed: -1e12 to 1e12 m", 1},
    {HEAD "media:\n  - {box: [0, 0, 0, 1, 1, 1], extinction: 1}\n", 4, 11, "box has 6 entries; expected two corners", 1},
    {HEAD "media:\n  - {box: [[0, 0, 0], 3], extinction: 1}\n", 4, 23, "box is '3'; expected two corners", 1},
    {HEAD "media:\n  - {layer: [1, 1], extinction: 1}\n", 4, 13, "layer is flat: from 1 to 1", 1},
    {HEAD "media:\n  - {layer: [2, 1], extinction: 1}\n", 4, 13, "layer is inverted: from 2 to 1", 1},

    /* emission */
    {MEDIUM "    emission: 3\n", 6, 15, "emission is '3'; expected a mapping", 1},
    {MEDIUM "    emission: {radiance: 1}\n", 6, 15, "an emission lacks type (one of volume, blackbody)", 1},
    {MEDIUM "    emission: {type: flame, radiance: 1}\n", 6, 22, "type: 'flame' is not known; allowed: volume, blackbody", 1},
    {MEDIUM "    emission: {type: volume}\n", 6, 15, "an emission lacks radiance", 1},
    {MEDIUM "    emission: {type: volume, radiance: -1}\n", 6, 40, "radiance is '-1'; allowed: 0 to 1e35 W/m3/sr", 1},
    {MEDIUM "    emission: {type: volume, radiance: 1, temperature: 300}\n", 6, 43,
     "temperature does not go with type volume, only with blackbody", 1},
    {MEDIUM "    emission: {type: blackbody}\n", 6, 15, "an emission lacks temperature, or volume", 1},
    {MEDIUM "    emission: {type: blackbody, temperature: 1e6}\n", 6, 46, "temperature is '1e6'; allowed: 0 to 100000 K", 1},
    {MEDIUM "    emission: {type: blackbody, temperature: -4}\n", 6, 46, "temperature is '-4'", 1},
    {MEDIUM "    emission: {type: blackbody, temperature: nan}\n", 6, 46, "not a finite number", 1},
    {MEDIUM "    emission: {type: blackbody, temperature: 300, scale: 2}\n", 6, 58, "scale and offset are for a grid", 1},
    {MEDIUM "    emission: {type: blackbody, temperature: 300, grid: heat}\n", 6, 57, "temperature and grid exclude each other", 2},
    {MEDIUM "    emission: {type: volume, radiance: 1, grid: flame}\n", 6, 49, "this medium has none; give volume", 1},
    {MEDIUM "    emission: {type: blackbody, volume: {file: none.npy, box: [[0, 0, 0], [1, 1, 1]]}}\n", 6, 41,
     "a grid of temperatures goes with a medium that has a density", 1},
    {MEDIUM "    emission: {type: volume, radiance: 1, volume: {file: none.xyz}}\n", 6, 58, "ends in none of", 1},
    {MEDIUM "    emission: {type: volume, radiance: 1, volume: {file: none.npy}}\n", 6, 51, "a density lacks box", 2},

    /* wavelengths */
    {HEAD "wavelengths: 550\n", 3, 14, "wavelengths is '550'; expected a list of 1 to 60 numbers", 1},
    {HEAD "wavelengths: []\n", 3, 14, "wavelengths has 0 entries", 1},
    {HEAD "wavelengths: [359, 400]\n", 3, 15, "wavelengths is '359'; allowed: 360 to 830 nm", 1},
    {HEAD "wavelengths: [400, 500, 500]\n", 3, 25, "wavelengths: '500' does not lie above the one before", 1},
    {HEAD "wavelengths: [400, 500]\nmedia: [{layer: [0, 1], extinction: [1, 2, 3]}]\n", 4, 37,
     "extinction has 3 entries; expected a number, or one for each of the 2 wavelengths", 1},
    {HEAD "wavelengths: [400, x]\nmedia: [{layer: [0, 1], extinction: [1, 2]}]\n", 3, 20, "'x' is not a number", 1},
    {HEAD "wavelengths: [400, 500]\nlights: [{type: sun, elevation: 1, azimuth: 0, irradiance: [1, -1]}]\n", 4, 64,
     "irradiance is '-1'", 1},
    {HEAD "wavelengths: [400]\nmedia: [{layer: [0, 1], extinction: 1, emission: {type: volume, radiance: 1}}]\n", 4, 50,
     "emission does not go with wavelengths yet", 1},

    /* phase functions */
    {MEDIUM "    phase: hg\n", 6, 12, "phase is 'hg'; expected a mapping", 1},
    {MEDIUM "    phase: {g: 0.5}\n", 6, 12, "a phase function lacks type (one of isotropic, hg, two_lobe, rayleigh, draine, tabulated, mie)", 1},
    {MEDIUM "    phase: {type: hgg, g: 0.5}\n", 6, 19, "type: 'hgg' is not known; allowed: isotropic, hg, two_lobe, rayleigh, draine, tabulated, mie; "
     "did you mean 'hg'?", 1},
    {MEDIUM "    phase: {type: hg}\n", 6, 12, "a phase function lacks g", 1},
    {MEDIUM "    phase: {type: hg, g: 2}\n", 6, 26, "g is '2'; allowed: -0.99999 to 0.99999", 1},
    {MEDIUM "    phase: {type: hg, g: -1}\n", 6, 26, "g is '-1'", 1},
    {MEDIUM "    phase: {type: isotropic, g: 0}\n", 6, 30, "g does not go with type isotropic, only with hg or two_lobe or draine", 1},
    {MEDIUM "    phase: {type: two_lobe, g: 0.8}\n", 6, 12, "lacks g2", 2},
    {MEDIUM "    phase: {type: two_lobe, g: 0.8, g2: 0, weight: 1.5}\n", 6, 52, "weight is '1.5'; allowed: 0 to 1", 1},
    {MEDIUM "    phase: {type: draine, g: 0.8}\n", 6, 12, "lacks alpha", 1},
    {MEDIUM "    phase: {type: draine, g: 0.8, alpha: -1}\n", 6, 42, "alpha is '-1'; allowed: 0 to 1000", 1},
    {MEDIUM "    phase: {type: hg, g: 0.8, alpha: 1}\n", 6, 31, "alpha does not go with type hg, only with draine", 1},
    {MEDIUM "    phase: {type: tabulated}\n", 6, 12, "a phase function lacks file", 1},
    {MEDIUM "    phase: {type: tabulated, file: 3, g: 0.5}\n", 6, 39, "g does not go with type tabulated", 2},
    {MEDIUM "    phase: {type: draine, g: 0.8, alpha: 1, file: x}\n", 6, 45, "file does not go with type draine, only with tabulated", 1},
    {MEDIUM "    phase: {type: mie, particle: water, sizes: single, radius: 1}\n", 6, 12, "lacks wavelengths, and so does the scene", 1},
    {MEDIUM "    phase: {type: mie, particle: wine, sizes: single, radius: 1, wavelengths: [550]}\n", 6, 34, "allowed: water, ice, soot, other", 1},
    {MEDIUM "    phase: {type: mie, particle: other, n: 1.5, sizes: single, radius: 1, wavelengths: [550]}\n", 6, 12, "a phase function of particle other lacks k", 1},
    {MEDIUM "    phase: {type: mie, particle: ice, k: 1, sizes: single, radius: 1, wavelengths: [550]}\n", 6, 42, "k goes with particle other only", 1},
    {MEDIUM "    phase: {type: mie, particle: ice, sizes: gamma, radius: 1, wavelengths: [550]}\n", 6, 12, "lacks spread", 1},
    {MEDIUM "    phase: {type: mie, particle: ice, sizes: single, spread: 2, radius: 1, wavelengths: [550]}\n", 6, 62, "spread goes with sizes lognormal and gamma only", 1},
    {MEDIUM "    phase: {type: mie, particle: ice, sizes: gamma, spread: 1.5, radius: 1, wavelengths: [550]}\n", 6, 74, "its effective variance, is 1e-4 to 0.49", 1},
    {MEDIUM "    phase: {type: mie, particle: ice, sizes: modified_gamma, alpha: 2, radius: 1, wavelengths: [550]}\n", 6, 12, "a phase function of sizes modified_gamma lacks gamma", 1},
    {MEDIUM "    phase: {type: mie, particle: ice, sizes: single, radius: 0, wavelengths: [550]}\n", 6, 62, "radius is '0'", 1},

    /* transforms */
    {MEDIUM "    transform: {scale: 2}\n", 6, 16, "transform is a mapping; expected a list", 1},
    {MEDIUM "    transform: [scale]\n", 6, 17, "a transform step: 'scale' where a mapping", 1},
    {MEDIUM "    transform: [{}]\n", 6, 17, "a transform step lacks scale, or rotate, or translate, or matrix", 1},
    {MEDIUM "    transform: [{scale: 2, translate: [1, 0, 0]}]\n", 6, 39, "scale and translate exclude each other", 1},
    {MEDIUM "    transform: [{scale: 0}]\n", 6, 25, "factor 0", 1},
    {MEDIUM "    transform: [{scale: [1, 1, 0]}]\n", 6, 25, "flattens", 1},
    {MEDIUM "    transform: [{rotate: 30}]\n", 6, 26, "rotate is '30'; expected a mapping", 1},
    {MEDIUM "    transform: [{rotate: {axis: [0, 0, 1]}}]\n", 6, 26, "a rotation lacks angle", 1},
    {MEDIUM "    transform: [{rotate: {axis: [0, 0, 0], angle: 1}}]\n", 6, 33, "axis has length 0", 1},
    {MEDIUM "    transform: [{rotat: {}}]\n", 6, 18, "did you mean 'rotate'?", 2},
    {MEDIUM "    transform: [{matrix: [1, 0, 0, 0, 0, 1, 0, 0]}]\n", 6, 26, "matrix has 8 entries; expected 12", 1},
    {MEDIUM "    transform: [{matrix: [1, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0]}]\n", 6, 17, "singular", 1},
    {MEDIUM "    transform: [{translate: [9e11, 0, 0]}, {translate: [9e11, 0, 0]}]\n", 6, 16, "beyond 1e12 m along x", 1},
    {MEDIUM "    transform: [{scale: 1e-9}, {translate: [1e12, 0, 0]}]\n", 6, 16, "flat", 1},
    {HEAD "media:\n  - layer: [0, 1]\n    extinction: 1\n    transform: [{scale: [1, 1, 2]}]\n", 6, 25, "tilt or stretch", 1},
    {HEAD "media:\n  - layer: [0, 1]\n    extinction: 1\n    transform: [{scale: -1}]\n", 6, 25, "tilt or stretch", 1},
    {HEAD "media:\n  - layer: [0, 1]\n    extinction: 1\n    transform: [{rotate: {axis: [1, 0, 1], angle: 1}}]\n", 6, 33,
     "rotate about z", 1},
    {HEAD "media:\n  - layer: [0, 1]\n    extinction: 1\n    transform: [{matrix: [1,0,0,0, 0,1,0,0, 0,0,1,0]}]\n", 6, 26,
     "a matrix would tilt", 1},

    /* density files */
    {HEAD "media:\n  - {density: cloud.nvdb, extinction: 1}\n", 4, 15, "density is 'cloud.nvdb'; expected a mapping", 1},
    {HEAD "media:\n  - {density: {}, extinction: 1}\n", 4, 15, "a density lacks file", 1},
    {HEAD "media:\n  - {density: {file: a.vtk}, extinction: 1}\n", 4, 22, "file: 'a.vtk' ends in none of .nvdb, .npy, .txt", 1},
    {HEAD "media:\n  - {density: {file: a}, extinction: 1}\n", 4, 22, "ends in none of", 1},
    {HEAD "media:\n  - {density: {file: [a.npy]}, extinction: 1}\n", 4, 22, "file is a list; expected the path of a file", 1},
    {HEAD "media:\n  - {density: {file: \"a\\0.nvdb\"}, extinction: 1}\n", 4, 22, "control character", 1},
    {HEAD "media:\n  - {density: {file: /dev/null/a.nvdb, box: [[0, 0, 0], [1, 1, 1]]}, extinction: 1}\n", 4, 40,
     "box does not go with .nvdb files, only with npy", 2},
    {HEAD "media:\n  - {density: {file: /dev/null/a.nvdb, outside: clamp}, extinction: 1}\n", 4, 40,
     "outside does not go with .nvdb files, only with npy or txt", 2},
    {HEAD "media:\n  - {density: {file: /dev/null/a.npy}, extinction: 1}\n", 4, 15, "a density lacks box", 2},
    {HEAD "media:\n  - {density: {file: /dev/null/a.npy, grid: x, box: [[0, 0, 0], [1, 1, 1]]}, extinction: 1}\n", 4, 39,
     "grid does not go with .npy files", 2},
    {HEAD "media:\n  - {density: {file: /dev/null/a.txt}, extinction: 1}\n", 4, 15,
     "a density lacks centring (one of cell, point)", 2},
    {HEAD "media:\n  - {density: {file: /dev/null/a.npy, box: [[0, 0, 0], [1, 1, 1]], centring: vdb}, extinction: 1}\n", 4,
     78, "centring: 'vdb' is not known; allowed: cell, point", 2},
    {HEAD "media:\n  - {density: {file: /dev/null/a.nvdb, lookup: linear}, extinction: 1}\n", 4, 48,
     "lookup: 'linear' is not known; allowed: trilinear, nearest; did you mean 'trilinear'?", 2},

    /* lights */
    {LIGHTS "{}\n", 4, 5, "a light lacks type (one of sun, constant, environment, point, sky)", 1},
    {LIGHTS "{type: moon}\n", 4, 12, "type: 'moon' is not known; allowed: sun, constant, environment, point", 1},
    {LIGHTS "{type: 3}\n", 4, 12, "type: '3' is not known", 1},
    {LIGHTS "{type: [sun]}\n", 4, 12, "type is a list; expected a word", 1},
    {LIGHTS "{type: sun, irradiance: 1}\n", 4, 5, "a light lacks direction, or elevation with azimuth", 1},
    {LIGHTS "{type: sun, irradiance: 1, elevation: 30}\n", 4, 5, "elevation is given without azimuth", 1},
    {LIGHTS "{type: sun, irradiance: 1, direction: [0, 0, 1], azimuth: 3}\n", 4, 63, "direction and azimuth exclude", 1},
    {LIGHTS "{type: sun, irradiance: 1, direction: [0, 0, 0]}\n", 4, 43, "direction has length 0", 1},
    {LIGHTS "{type: sun, irradiance: 1, elevation: 91, azimuth: 0}\n", 4, 43, "elevation is '91'; allowed: -90 to 90 degrees", 1},
    {LIGHTS "{type: sun, direction: [0, 0, 1]}\n", 4, 5, "a light lacks irradiance", 1},
    {LIGHTS "{type: sun, direction: [0, 0, 1], irradiance: -1}\n", 4, 51, "irradiance is '-1'; allowed: 0 to 1e35 W/m2", 1},
    {LIGHTS "{type: sun, direction: [0, 0, 1], irradiance: 1e36}\n", 4, 51, "irradiance is '1e36'", 1},
    {LIGHTS "{type: sun, direction: [0, 0, 1], irradiance: 1, angular_diameter: 1e-6}\n", 4, 72, "use 0 for parallel light", 1},
    {LIGHTS "{type: sun, direction: [0, 0, 1], irradiance: 1e35, angular_diameter: 1}\n", 4, 51, "beyond 1e35", 1},
    {LIGHTS "{type: sun, direction: [0, 0, 1], radiance: 1}\n", 4, 39,
     "radiance does not go with type sun, only with constant", 2},
    {LIGHTS "{type: constant}\n", 4, 5, "a light lacks radiance", 1},
    {LIGHTS "{type: constant, radiance: 1, hemisphere: top}\n", 4, 47, "hemisphere: 'top' is not known; allowed: all, upper, "
     "lower", 1},
    {LIGHTS "{type: point, intensity: 1}\n", 4, 5, "a light lacks position", 1},
    {LIGHTS "{type: point, intensity: 1, position: 3}\n", 4, 43, "position is '3'; expected three numbers, [x, y, z]", 1},
    {LIGHTS "{type: environment}\n", 4, 5, "a light lacks file", 1},
    {LIGHTS "{type: environment, file: /dev/null/a.exr, scale: -1}\n", 4, 55, "scale is '-1'", 2},

    /* values that change over frames: each is read, whatever the frame (here 0) */
    {ANIMATED "{frames: [0, 8], values: [0.5]}\n", 6, 38, "values has 1 entries, frames has 2; expected as many", 1},
    {ANIMATED "{frames: [0, 8, 8], values: [0, 0.5, 1]}\n", 6, 29, "frames: '8' does not lie above the one before", 1},
    {ANIMATED "{frames: [8, 0], values: [0, 1]}\n", 6, 26, "frames: '0' does not lie above the one before", 1},
    {ANIMATED "{frames: [0, 0.5], values: [0, 1]}\n", 6, 26, "frames: '0.5' is not a whole number", 1},
    {ANIMATED "{frames: [-1, 0], values: [0, 1]}\n", 6, 23, "frames is '-1'; allowed: 0 to 16777215", 1},
    {ANIMATED "{frames: [0, 16777216], values: [0, 1]}\n", 6, 26, "frames is '16777216'; allowed: 0 to 16777215", 1},
    {ANIMATED "{frames: [], values: []}\n", 6, 22, "frames has 0 entries; expected a list of 1 to 4096 whole numbers", 2},
    {ANIMATED "{frames: 0, values: [1]}\n", 6, 22, "frames is '0'; expected a list of 1 to 4096 whole numbers", 1},
    {ANIMATED "{frames: [0], values: 1}\n", 6, 35, "values is '1'; expected a list of values, one for each frame", 1},
    {ANIMATED "{frames: [0]}\n", 6, 13, "an animated value lacks values", 1},
    {ANIMATED "{values: [0]}\n", 6, 13, "an animated value lacks frames", 1},
    {ANIMATED "{frame: [0], values: [0]}\n", 6, 14, "unknown key 'frame' in an animated value; did you mean 'frames'?", 2},
    {ANIMATED "{frames: [0], values: [0], step: 2}\n", 6, 40, "unknown key 'step' in an animated value; it belongs to", 1},
    {ANIMATED "{frames: [0], frames: [0], values: [0]}\n", 6, 27, "frames is given twice", 1},
    {ANIMATED "{frames: [0, 5, 9], values: [1, 0, 1.5]}\n", 6, 48, "albedo is '1.5'; allowed: 0 to 1", 1},
    {ANIMATED "{frames: [0, 5, 9], values: [1, [0, 1], half]}\n", 6, 45, "albedo has 2 entries; expected a number or three", 2},
    {ANIMATED "{frames: [0, 5, 9], values: [1, [0, 1], half]}\n", 6, 53, "albedo: 'half' is not a number", 2},
    {ANIMATED "{frames: [0, 5], values: [1, '1']}\n", 6, 42, "albedo: '1' is quoted text", 1},
    {ANIMATED "{frames: [0, 5], values: [1, ~]}\n", 6, 42, "albedo has no value", 1},
    {ANIMATED "{frames: [0, 5], values: [1, {frames: [0], values: [1]}]}\n", 6, 42, "albedo cannot be animated here; expected a number", 1},
    {ANIMATED "&a {frames: [0, 5], values: [1, *a]}\n", 6, 13, "albedo cannot be animated here; expected a number", 1},
    {ANIMATED "{frames: &a [*a, 5], values: [1, 1]}\n", 6, 22, "frames is a list; expected a list of 1 to 4096", 1},
    {HEAD "media: [{layer: {frames: [0, 9], values: [[0, 1], [3, 2]]}, extinction: 1}]\n", 3, 51, "layer is inverted: from 3 to 2", 1},
    {HEAD "media: [{box: {frames: [0], values: [[[0, 0, 0], [1, 0, 1]]]}, extinction: 1}]\n", 3, 38, "box is flat along y", 1},
    {MEDIUM "    transform: [{rotate: {axis: [0, 0, 1], angle: {frames: [0, 4], values: [0, 3601]}}}]\n", 6, 80,
     "angle is '3601'; allowed: -3600 to 3600 degrees", 1},
    {"nephos: {frames: [0], values: [1]}\n" CAMERA, 1, 9, "nephos cannot be animated here; expected a whole number", 1},
    {HEAD "render: {samples: {frames: [0], values: [1]}}\n", 3, 19, "samples cannot be animated here", 1},
    {HEAD "wavelengths: {frames: [0], values: [[500]]}\n", 3, 14, "wavelengths cannot be animated here", 1},
    {HEAD "media: {frames: [0], values: [[]]}\n", 3, 8, "media cannot be animated here; expected a list of mappings", 1},
    {"nephos: 1\ncamera: {resolution: {frames: [0], values: [[4, 3]]}, position: [0, 0, 0], direction: [0, 1, 0], fov: 9}\n", 2, 22,
     "resolution cannot be animated here; expected two whole numbers", 1},
    {LIGHTS "{type: {frames: [0], values: [sun]}}\n", 4, 12, "type cannot be animated here; expected a word", 1},
    {HEAD "media:\n  - {density: {file: {frames: [0], values: [a.npy]}}, extinction: 1}\n", 4, 22, "file cannot be animated here", 1},
    {SEQUENCE "a.npy, numbers: {first: 0, last: 4}}, extinction: 1}\n", 4, 67, "numbers is given, but no # in the name", 1},
    {SEQUENCE "a.#.npy, numbers: {first: 4, last: 3}}, extinction: 1}\n", 4, 86, "last is 3; expected first, 4, plus a whole number of steps of 1", 1},
    {SEQUENCE "a.#.npy, numbers: {first: 4, last: 9, step: 2}}, extinction: 1}\n", 4, 86, "plus a whole number of steps of 2", 1},
    {SEQUENCE "a.#.npy, numbers: {first: 4, last: 8, step: 0}}, extinction: 1}\n", 4, 95, "step is '0'; allowed: 1 to 16777215", 1},
    {SEQUENCE "a.#.npy, numbers: {first: 4}}, extinction: 1}\n", 4, 69, "a sequence of files lacks last", 1},
};

static int count_lines(const char *text) {
    int lines = 0;
    for (; *text; text++) lines += *text == '\n';
    return lines;
}

/* 1 when one of the lines that begin with place holds the fragment. */
static int says(const char *messages, const char *place, const char *fragment) {
    for (const char *at = messages; (at = strstr(at, place)); at++) {
        const char *found = strstr(at, fragment), *end = strchr(at, '\n');
        if (found && found < end) return 1;
    }
    return 0;
}

START_TEST(every_mistake_is_reported_at_its_line_and_column_with_what_is_allowed) {
    NphContext *context = nph_test_context(1);
    int unlike = 0;
    ck_assert_uint_ge(sizeof wrong / sizeof wrong[0], 80);
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        const Wrong *w = &wrong[i];
        NphScene *scene = NULL;
        NphStatus status = nph_scene_parse(context, w->text, strlen(w->text), "dir/a.yaml", NULL, &scene);
        const char *messages = nph_test_messages();
        char place[64];
        snprintf(place, sizeof place, "dir/a.yaml:%d:%d: ", w->line, w->column);
        int right = status == NPH_BAD_SCENE && !scene && says(messages, place, w->fragment);
        if (right && count_lines(messages) == w->messages) continue;
        unlike++;
        printf("--- %s--- expected %d: %s%s\n--- given %s:\n%s", w->text, w->messages, place, w->fragment,
               nph_status_name(status), messages);
        nph_scene_free(context, scene);
    }
    fflush(stdout);
    ck_assert_msg(unlike == 0, "%d scenes are not judged as expected", unlike);
    nph_test_context_close(context);
}
END_TEST

START_TEST(all_mistakes_of_a_file_are_reported_in_one_run) {
    static const char text[] =
        "nephos: 1\n"
        "camera: {resolution: [400, 0], position: [0, 0], look_at: [0, 0, 0], fov: 500}\n"
        "media:\n"
        "  - box: [[0, 0, 0], [1, 1, 0]]\n"
        "    extinktion: 40\n"
        "    phase: {type: hg, g: 3}\n"
        "lights:\n"
        "  - {type: sun, irradiance: -1, azimuth: 3}\n"
        "rendr: {}\n";
    static const char *const places[] = {":2:28: resolution", ":2:42: position", ":2:75: fov", ":4:10: box", ":5:5: unknown",
                                         ":4:5: a medium lacks", ":6:26: g is", ":8:29: irradiance", ":8:5: azimuth is given",
                                         ":9:1: unknown"};
    NphContext *context = nph_test_context(1);
    NphScene *scene = NULL;
    ck_assert_int_eq(nph_scene_parse(context, text, strlen(text), "s", NULL, &scene), NPH_BAD_SCENE);
    const char *messages = nph_test_messages();
    for (size_t i = 0; i < sizeof places / sizeof places[0]; i++)
        ck_assert_msg(strstr(messages, places[i]) != NULL, "%s not in\n%s", places[i], messages);
    ck_assert_msg(count_lines(messages) == 10, "%s", messages);
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_flood_of_mistakes_is_cut_off) {
    NphContext *context = nph_test_context(1);
    NphScene *scene = NULL;
    static char text[70000];
    size_t used = (size_t)snprintf(text, sizeof text, HEAD);
    for (int i = 0; i < 5000; i++) used += (size_t)snprintf(text + used, sizeof text - used, "k%d: 1\n", i);
    ck_assert_int_eq(nph_scene_parse(context, text, used, "s", NULL, &scene), NPH_BAD_SCENE);
    const char *messages = nph_test_messages();
    ck_assert_int_eq(count_lines(messages), NPH_SHOWN_MISTAKES + 1);
    ck_assert_ptr_nonnull(strstr(messages, "more than 50 mistakes"));
    nph_test_context_close(context);
}
END_TEST

START_TEST(too_many_entries_and_too_many_anchors_are_refused_where_they_begin) {
    NphContext *context = nph_test_context(1);
    NphScene *scene = NULL;
    static char text[20000];
    size_t used = (size_t)snprintf(text, sizeof text, HEAD "lights:\n");
    for (int i = 0; i < 33; i++) used += (size_t)snprintf(text + used, sizeof text - used, "- {type: constant, radiance: 1}\n");
    ck_assert_int_eq(nph_scene_parse(context, text, used, "s", NULL, &scene), NPH_BAD_SCENE);
    ck_assert_str_eq(nph_test_messages(), "s:36:3: lights has 33 entries; allowed: at most 32\n");
    used = (size_t)snprintf(text, sizeof text, HEAD "media:\n");
    for (int i = 0; i < 65; i++) used += (size_t)snprintf(text + used, sizeof text - used, "- {layer: [0, 1], extinction: 0}\n");
    ck_assert_int_eq(nph_scene_parse(context, text, used, "s", NULL, &scene), NPH_BAD_SCENE);
    ck_assert_str_eq(nph_test_messages(), "s:68:3: media has 65 entries; allowed: at most 64\n");
    used = (size_t)snprintf(text, sizeof text, HEAD "lights: [\n");
    for (int i = 0; i < 300; i++) used += (size_t)snprintf(text + used, sizeof text - used, "&a%d 1,\n", i);
    used += (size_t)snprintf(text + used, sizeof text - used, "]\n");
    ck_assert_int_eq(nph_scene_parse(context, text, used, "s", NULL, &scene), NPH_BAD_SCENE);
    ck_assert_str_eq(nph_test_messages(), "s:260:1: more than 256 anchors\n");
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_file_that_is_no_scene_at_all_is_refused_without_reading_it_whole) {
    NphContext *context = nph_test_context(1);
    NphScene *scene = NULL;
    const char *path = nph_test_temporary("large.yaml");
    FILE *file = fopen(path, "wb");
    ck_assert_ptr_nonnull(file);
    ck_assert_int_eq(fseek(file, 1L << 31, SEEK_SET), 0);
    fputc('x', file);
    fclose(file);
    ck_assert_int_eq(nph_scene_load(context, path, &scene), NPH_BAD_SCENE);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "at most 1048576 bytes, this one has 2147483649"));
    ck_assert_uint_lt(nph_context_peak_bytes(context), 1 << 21);
    ck_assert_int_eq(remove(path), 0);
    ck_assert_int_eq(nph_scene_load(context, path, &scene), NPH_BAD_SCENE);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "large.yaml: cannot read"));
    ck_assert_ptr_null(scene);
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, every_mistake_is_reported_at_its_line_and_column_with_what_is_allowed);
    tcase_add_test(cases, all_mistakes_of_a_file_are_reported_in_one_run);
    tcase_add_test(cases, a_flood_of_mistakes_is_cut_off);
    tcase_add_test(cases, too_many_entries_and_too_many_anchors_are_refused_where_they_begin);
    tcase_add_test(cases, a_file_that_is_no_scene_at_all_is_refused_without_reading_it_whole);
}

int main(void) { return nph_test_main("scene_mistakes", fill); }
