/* SPDX-License-Identifier: Apache-2.0
 *
 * Every key of a scene file. After a change run the test scene_docs with NEPHOS_UPDATE_DOCS=1 to renew docs/scene.md
 * and docs/scene.schema.json. */
#include "optics/index.h"
#include "optics/phase.h"
#include "optics/sizes.h"
#include "scene/scene_keys.h"

#define FAR_M 1e12       /* coordinates: beyond, an f64 cannot tell a tenth of a millimetre */
#define MOST_PER_M 1e9   /* extinction times the largest density */
#define MOST_LIGHT 1e35  /* below f32's end with room for a sum of lights */
#define MOST_G 0.99999

#define EMISSIONS "volume|blackbody"
#define CAMERAS "perspective|orthographic|flux|fisheye|fluence|radiance"
#define PHASES "isotropic|hg|two_lobe|rayleigh|draine|tabulated|mie" /* in the order of NphPhaseKind; mie becomes a table */
#define LIGHTS "sun|constant|environment|point|sky"
#define AIRS "exponential|table"

const char nph_key_required[] = "required";

const NphSceneSectionInfo nph_scene_sections[] = {
    {"scene", "the scene", NULL, NULL, "The file is one mapping."},
    {"camera", "the camera", "type", CAMERAS,
     "Where the picture is seen from. Pixels are square; x runs to the right, y downwards, row 0 is the top. "
     "A `flux` camera is a rectangle whose pixels measure the irradiance [W/m2] that arrives from the hemisphere around "
     "its direction, the direct beam of a sun included. Pixels of `fluence` measure the radiance from all directions "
     "together [W/m2], a sun included; those of `radiance` the radiance [W/m2/sr] seen along one direction, whatever way "
     "the rectangle faces. The three may stand inside media. `fisheye` is equidistant: the angle from the viewing "
     "direction grows evenly from the middle to the rim of a circle, outside of which the picture is black and opaque."},
    {"medium", "a medium", NULL, NULL,
     "What scatters and absorbs. Media may overlap: their coefficients add. Exactly one of `density`, `box` and `layer` "
     "gives the shape; box and layer have density 1. Extinction is per metre of the world: a `scale` changes a medium's "
     "size, not its extinction."},
    {"density", "a density", "file", "nvdb|npy|txt|vol|pbrt|vdb",
     "A density volume from a file, by its ending: `.nvdb`, `.vdb`, `.npy`, `.txt`, `.vol` or `.pbrt`."},
    {"numbers", "a sequence of files", NULL, NULL,
     "For files that do not exist for every frame: # in the name of the file stands for the last of the numbers `first`, `first` + `step`, "
     "... `last` that is not above the frame, or for `first`. Without it # stands for the frame itself."},
    {"emission", "an emission", "type", EMISSIONS,
     "Light that a medium gives off, alike in all directions. `volume`: radiance per metre, times the value of a grid. "
     "`blackbody`: absorption times Planck's radiance of a temperature, in W/m2/sr/nm: R, G, B are the means over the "
     "spectrum that the CIE 1931 observer takes, so that a flat spectrum of 1 gives 1 (colours redder than Rec. 709 "
     "have no blue; below 100 K there is no light). Without `temperature`, `grid` and `volume`: the grid `flame` or "
     "`temperature` of the medium's own .nvdb or .vdb file; of other files the density itself (volume); in a box or layer "
     "constant. What is interpolated between samples is the emission, computed at each of them; where a grid has no "
     "active voxels there is none."},
    {"transform", "a transform step", NULL, NULL,
     "Steps applied in the order they are written, each a mapping of exactly one key. A medium with `layer` takes only "
     "`translate`, a positive uniform `scale`, and `rotate` about z. A transform that flattens space is refused."},
    {"rotate", "a rotation", NULL, NULL,
     "Rotation about an axis through the origin, by the right-hand rule: about z, from +x towards +y."},
    {"phase", "a phase function", "type", PHASES,
     "How light is scattered. Left out: isotropic. Positive g is forward. hg is Henyey and Greenstein's function; "
     "two_lobe is weight * hg(g) + (1 - weight) * hg(g2); draine is hg(g) * (1 + alpha cos^2), normalised. mie is that of "
     "spheres, computed when the scene is loaded: see optics.md; extinction and albedo stay what the medium says. All channels "
     "share one phase function; of several wavelengths it is the mean, weighted by scattering."},
    {"light", "a light", "type", LIGHTS,
     "Directions point from the scene towards the light; azimuth counts from +x towards +y. In the middle of an "
     "unrotated environment map one looks along +x, its top row is +z, and its right half lies towards -y. A `sky` is what the air "
     "scatters once of the sun that it names, as a map; the sun itself is a light of its own. It needs `air`: see sky.md."},
    {"air", "the air", "type", AIRS,
     "What attenuates suns, constant lights and environments before their light reaches the scene; within it there is no air. "
     "It changes each by direction alone, as at one `height`, before anything is rendered: see air.md. exponential: a flat "
     "atmosphere, which lets nothing through at the horizon. table: a spherical one, exponential or from a profile. With "
     "`where: within` the air is among the media instead, and scatters there: see sky.md."},
    {"aerosol", "an aerosol", NULL, NULL,
     "What else is in the air: haze, whose density falls exponentially with height. Its extinction at sea level is given, or by "
     "`turbidity`, the vertical optical depth of air and haze over that of the air alone at 550 nm."},
    {"surface", "a surface", NULL, NULL,
     "What light does not pass: opaque, diffusely reflecting (Lambert) on both sides. A triangle mesh, or a level plane "
     "without end. Media on both sides of a surface do not see each other through it."},
    {"periodic", "periodic", NULL, NULL,
     "Sides that repeat. Along each axis given here all media are cut to the interval, and what is left stands in the world "
     "once a period, without end: light that leaves through one side comes in through the other. A medium that reaches "
     "nowhere into the interval is refused, and so are point lights and meshes (level planes may be there)."},
    {"render", "render", NULL, NULL, "Defaults of a run; the command line has the last word."},
    {"animated", "an animated value", NULL, NULL,
     "In place of a value that consists of numbers: keys, of which each is a frame and the value that it has there, written as it would "
     "be alone. Between two keys every number goes in a straight line; before the first and after the last it stays. Directions and axes "
     "are normalised afterwards: halfway between two they point halfway, but do not turn at an even speed. A matrix goes entry by entry, "
     "which is no rotation; animate `angle`. A number for all channels may be followed by one for each. What a value must fulfil "
     "together with others (a direction of length 0, a scale of 0 on the way from 1 to -1) is checked at the frame that is read."},
};
const int nph_scene_section_count = (int)(sizeof nph_scene_sections / sizeof nph_scene_sections[0]);

const NphSceneRule nph_scene_rules[] = {
    {"camera", NULL, "look_at|direction"},
    {"medium", NULL, "density|box|layer"},
    {"medium", NULL, "extinction albedo?|scattering? absorption?"},
    {"transform", NULL, "scale|rotate|translate|matrix"},
    {"light", "sun|sky", "direction|elevation azimuth"},
    {"aerosol", NULL, "extinction|turbidity angstrom?"},
    {"surface", NULL, "mesh transform?|plane"},
};
const int nph_scene_rule_count = (int)(sizeof nph_scene_rules / sizeof nph_scene_rules[0]);

#define REQUIRED nph_key_required

const NphSceneKey nph_scene_keys[] = {
    {"scene", "nephos", NPH_KEY_WHOLE, 1, 1, "", NULL, REQUIRED, NULL, "Version of this format."},
    {"scene", "camera", NPH_KEY_SECTION, 0, 0, "", "camera", REQUIRED, NULL, "The camera or flux sensor."},
    {"scene", "wavelengths", NPH_KEY_SPECTRUM, 360, 830, "nm", NULL, NULL, NULL,
     "Instead of R, G, B: 1 to 60, rising. Values with channels take one number or one for each of them; lights are per "
     "nanometre. The picture is linear R, G, B (Rec. 709) by the CIE 1931 observer, negative where Rec. 709 lacks a colour; "
     "a spectrum of value 1 has luminance 1. One alone: its radiance in grey. Environment maps must be grey; emission is "
     "refused. See path.md."},
    {"scene", "media", NPH_KEY_LIST, 0, 64, "", "medium", NULL, NULL, "The media; none: empty space."},
    {"scene", "lights", NPH_KEY_LIST, 0, 32, "", "light", NULL, NULL, "The lights; none: darkness."},
    {"scene", "air", NPH_KEY_SECTION, 0, 0, "", "air", NULL, NULL, "Air between the lights and the scene; left out: none."},
    {"scene", "surfaces", NPH_KEY_LIST, 0, 64, "", "surface", NULL, NULL, "The surfaces; none: nothing but media."},
    {"scene", "periodic", NPH_KEY_SECTION, 0, 0, "", "periodic", NULL, NULL, "Sides that repeat; left out: none."},
    {"scene", "render", NPH_KEY_SECTION, 0, 0, "", "render", NULL, NULL, "Defaults of a run."},

    {"camera", "type", NPH_KEY_WORD, 0, 0, "", CAMERAS, "perspective", NULL, "Kind of camera."},
    {"camera", "resolution", NPH_KEY_RESOLUTION, 1, 65536, "pixels", NULL, REQUIRED, NULL, "Width and height."},
    {"camera", "position", NPH_KEY_VECTOR, -FAR_M, FAR_M, "m", NULL, REQUIRED, NULL,
     "The eye; of orthographic, flux, fluence and radiance the middle of the rectangle."},
    {"camera", "look_at", NPH_KEY_VECTOR, -FAR_M, FAR_M, "m", NULL, NULL, NULL,
     "The point in the middle of the picture."},
    {"camera", "direction", NPH_KEY_VECTOR, -FAR_M, FAR_M, "", NULL, NULL, NULL,
     "The viewing direction, of any length but 0; of flux, fluence and radiance the one the rectangle faces."},
    {"camera", "up", NPH_KEY_VECTOR, -FAR_M, FAR_M, "", NULL, "[0, 0, 1]", NULL,
     "What is up in the picture; must not be parallel to the viewing direction."},
    {"camera", "fov", NPH_KEY_NUMBER, 0.001, 179, "degrees", NULL, REQUIRED, "perspective",
     "Field of view across the shorter side of the picture."},
    {"camera", "fov", NPH_KEY_NUMBER, 0.001, 360, "degrees", NULL, REQUIRED, "fisheye", "Field of view across the circle."},
    {"camera", "extent", NPH_KEY_NUMBER, 1e-9, FAR_M, "m", NULL, REQUIRED, "orthographic|flux|fluence|radiance",
     "Length of the shorter side of the rectangle."},
    {"camera", "seen", NPH_KEY_VECTOR, -FAR_M, FAR_M, "", NULL, REQUIRED, "radiance",
     "The direction that one looks along, of any length but 0; the light comes from there."},
    {"camera", "crop", NPH_KEY_CROP, 0, 65536, "pixels", NULL, NULL, NULL,
     "The part that is rendered: x0 <= x < x1, y0 <= y < y1; left out: the whole picture."},

    {"medium", "name", NPH_KEY_TEXT, 1, 63, "", NULL, NULL, NULL,
     "For messages and plans; left out: medium0, medium1, ..."},
    {"medium", "density", NPH_KEY_SECTION, 0, 0, "", "density", NULL, NULL, "Density from a file."},
    {"medium", "box", NPH_KEY_BOX, -FAR_M, FAR_M, "m", NULL, NULL, NULL, "Density 1 within this box."},
    {"medium", "layer", NPH_KEY_INTERVAL, -FAR_M, FAR_M, "m", NULL, NULL, NULL,
     "Density 1 between these two heights, without end in x and y."},
    {"medium", "transform", NPH_KEY_LIST, 0, 64, "", "transform", NULL, NULL,
     "Steps from the medium's own space into the world; left out: none."},
    {"medium", "extinction", NPH_KEY_RGB, 0, MOST_PER_M, "1/m", NULL, NULL, NULL,
     "Extinction at density 1. Times the largest density it must not exceed 1e9 1/m."},
    {"medium", "albedo", NPH_KEY_RGB, 0, 1, "", NULL, "1", NULL, "Scattered share of the extinction."},
    {"medium", "scattering", NPH_KEY_RGB, 0, MOST_PER_M, "1/m", NULL, "0", NULL, "Scattering at density 1."},
    {"medium", "absorption", NPH_KEY_RGB, 0, MOST_PER_M, "1/m", NULL, "0", NULL, "Absorption at density 1."},
    {"medium", "phase", NPH_KEY_SECTION, 0, 0, "", "phase", NULL, NULL, "Phase function; left out: isotropic."},
    {"medium", "emission", NPH_KEY_SECTION, 0, 0, "", "emission", NULL, NULL, "What the medium emits; left out: nothing."},

    {"density", "file", NPH_KEY_FILE, 1, 4095, "", NULL, REQUIRED, NULL,
     "`.nvdb`, `.vdb`: NanoVDB or OpenVDB grid, its own transform gives metres. `.npy`: array with axes z, y, x. `.txt`: cloud field of "
     "water content and effective radius, whose density is then its extinction in 1/m (use `extinction: 1`). `.vol`: Mitsuba's grid volume with one channel. "
     "`.pbrt`: the density of a named medium (`uniformgrid`, or pbrt-v3's `heterogeneous`). Both lie in the box that the "
     "file states; what else the file says, coefficients and transforms, is not taken over."},
    {"density", "numbers", NPH_KEY_SECTION, 0, 0, "", "numbers", NULL, NULL,
     "Which files of a sequence there are (`file` with #); left out: one for every frame."},
    {"density", "grid", NPH_KEY_TEXT, 1, 63, "", NULL, NULL, "nvdb|vdb|pbrt",
     "Name of the grid (of the medium); left out: the only one, else `density`."},
    {"density", "lookup", NPH_KEY_WORD, 0, 0, "", "trilinear|nearest", "trilinear", NULL, "Between the samples."},
    {"density", "centring", NPH_KEY_WORD, 0, 0, "", "cell|point|vdb", "vdb", "nvdb|vdb",
     "cell: values fill voxels; point: values stand on points, the field ends at the outermost ones; vdb: values stand on "
     "points, the field falls to zero within one voxel outside."},
    {"density", "centring", NPH_KEY_WORD, 0, 0, "", "cell|point", "cell", "npy|vol|pbrt",
     "cell: the box is filled by the cells; point: the box is spanned by the outermost points."},
    {"density", "centring", NPH_KEY_WORD, 0, 0, "", "cell|point", REQUIRED, "txt",
     "Such files do not say: point, the field ends at the outermost points; cell, each point is the middle of a voxel."},
    {"density", "outside", NPH_KEY_WORD, 0, 0, "", "zero|clamp", "zero", "npy|txt|pbrt",
     "What a trilinear lookup near the border of the box finds beyond it: zero, or the border's value."},
    {"density", "outside", NPH_KEY_WORD, 0, 0, "", "zero|clamp", "clamp", "vol", "The same; as Mitsuba does it."},
    {"density", "box", NPH_KEY_BOX, -FAR_M, FAR_M, "m", NULL, REQUIRED, "npy", "Where the array lies."},

    {"numbers", "first", NPH_KEY_WHOLE, 0, NPH_MAX_FRAME, "", NULL, REQUIRED, NULL, "Number of the first file."},
    {"numbers", "last", NPH_KEY_WHOLE, 0, NPH_MAX_FRAME, "", NULL, REQUIRED, NULL, "Of the last one: a whole number of steps further."},
    {"numbers", "step", NPH_KEY_WHOLE, 1, NPH_MAX_FRAME, "", NULL, "1", NULL, "From one file to the next."},

    {"emission", "type", NPH_KEY_WORD, 0, 0, "", EMISSIONS, REQUIRED, NULL, "Kind of emission."},
    {"emission", "radiance", NPH_KEY_RGB, 0, MOST_LIGHT, "W/m3/sr", NULL, REQUIRED, "volume",
     "Radiance that a metre adds, at the grid's value 1."},
    {"emission", "temperature", NPH_KEY_NUMBER, 0, 1e5, "K", NULL, NULL, "blackbody", "The same everywhere."},
    {"emission", "grid", NPH_KEY_TEXT, 1, 63, "", NULL, NULL, NULL,
     "Name of a grid in the medium's own .nvdb or .vdb file."},
    {"emission", "volume", NPH_KEY_SECTION, 0, 0, "", "density", NULL, NULL,
     "A grid from a file of its own, which lies in the medium's space (before its transform)."},
    {"emission", "scale", NPH_KEY_NUMBER, -1e9, 1e9, "K", NULL, "1", "blackbody",
     "kelvin = scale * value + offset; 0 to 1e5 K are allowed."},
    {"emission", "offset", NPH_KEY_NUMBER, -1e9, 1e9, "K", NULL, "0", "blackbody", "See scale."},

    {"transform", "scale", NPH_KEY_FACTORS, -1e9, 1e9, "", NULL, NULL, NULL,
     "Factor, or one for each axis; negative mirrors, 0 is refused."},
    {"transform", "rotate", NPH_KEY_SECTION, 0, 0, "", "rotate", NULL, NULL, "Rotation."},
    {"transform", "translate", NPH_KEY_VECTOR, -FAR_M, FAR_M, "m", NULL, NULL, NULL, "Shift."},
    {"transform", "matrix", NPH_KEY_MATRIX, -FAR_M, FAR_M, "", NULL, NULL, NULL,
     "Affine map: three rows of four, the fourth column is the shift."},

    {"rotate", "axis", NPH_KEY_VECTOR, -FAR_M, FAR_M, "", NULL, REQUIRED, NULL, "Axis, of any length but 0."},
    {"rotate", "angle", NPH_KEY_NUMBER, -3600, 3600, "degrees", NULL, REQUIRED, NULL, "Angle."},

    {"phase", "type", NPH_KEY_WORD, 0, 0, "", PHASES, REQUIRED, NULL, "Kind of phase function."},
    {"phase", "g", NPH_KEY_NUMBER, -MOST_G, MOST_G, "", NULL, REQUIRED, "hg|two_lobe|draine",
     "Mean cosine (of the first lobe; of draine's first factor)."},
    {"phase", "g2", NPH_KEY_NUMBER, -MOST_G, MOST_G, "", NULL, REQUIRED, "two_lobe", "Mean cosine of the second lobe."},
    {"phase", "weight", NPH_KEY_NUMBER, 0, 1, "", NULL, REQUIRED, "two_lobe", "Share of the first lobe."},
    {"phase", "alpha", NPH_KEY_NUMBER, 0, NPH_PHASE_MOST_ALPHA, "", NULL, REQUIRED, "draine",
     "0: hg; 1 with g = 0: rayleigh."},
    {"phase", "file", NPH_KEY_FILE, 1, 4095, "", NULL, REQUIRED, "tabulated",
     "Text with a row per angle: degrees, rising from 0 to 180, and a value of at least 0 at any scale; `#` starts a "
     "comment. Linear in the cosine between rows, normalised."},
    {"phase", "particle", NPH_KEY_WORD, 0, 0, "", NPH_MATERIAL_WORDS "|other", REQUIRED, "mie", "What the spheres are made of; other: of n and k."},
    {"phase", "n", NPH_KEY_NUMBER, 0.01, 100, "", NULL, NULL, "mie", "Real part of the refractive index of particle other."},
    {"phase", "k", NPH_KEY_NUMBER, 0, 100, "", NULL, NULL, "mie", "Its imaginary part, which absorbs."},
    {"phase", "wavelengths", NPH_KEY_SPECTRUM, 360, 830, "nm", NULL, NULL, "mie", "One, or several for their mean; left out: the scene's."},
    {"phase", "sizes", NPH_KEY_WORD, 0, 0, "", NPH_SIZES_WORDS, REQUIRED, "mie",
     "Number of particles by radius r: lognormal exp(-ln^2(r / radius) / (2 ln^2 spread)) / r; gamma r^(1/spread - 3) exp(-r / (spread radius)); "
     "modified_gamma r^alpha exp(-alpha / gamma (r / radius)^gamma)."},
    {"phase", "radius", NPH_KEY_NUMBER, NPH_SIZES_LEAST_UM, NPH_SIZES_MOST_UM, "um", NULL, REQUIRED, "mie",
     "Of single the radius, of lognormal the median, of gamma the effective radius, of modified_gamma the most frequent one."},
    {"phase", "spread", NPH_KEY_NUMBER, NPH_SIZES_LEAST_GAMMA, NPH_SIZES_MOST_LOGNORMAL, "", NULL, NULL, "mie",
     "Of lognormal the geometric standard deviation, above 1; of gamma the effective variance, at most 0.49."},
    {"phase", "alpha", NPH_KEY_NUMBER, 1e-6, 100, "", NULL, NULL, "mie", "Of modified_gamma."},
    {"phase", "gamma", NPH_KEY_NUMBER, 0.1, 10, "", NULL, NULL, "mie", "Of modified_gamma."},
    {"phase", "tolerance", NPH_KEY_NUMBER, 1e-4, 0.5, "", NULL, "0.01", "mie",
     "Relative error of the table: root mean square over angles of the sum over sizes, and the most between its rows."},

    {"light", "type", NPH_KEY_WORD, 0, 0, "", LIGHTS, REQUIRED, NULL, "Kind of light."},
    {"light", "direction", NPH_KEY_VECTOR, -FAR_M, FAR_M, "", NULL, NULL, "sun|sky", "Towards the sun, of any length but 0."},
    {"light", "elevation", NPH_KEY_NUMBER, -90, 90, "degrees", NULL, NULL, "sun|sky", "Height above the horizon."},
    {"light", "azimuth", NPH_KEY_NUMBER, -3600, 3600, "degrees", NULL, NULL, "sun|sky", "From +x towards +y."},
    {"light", "irradiance", NPH_KEY_RGB, 0, MOST_LIGHT, "W/m2", NULL, REQUIRED, "sun|sky",
     "On a plane that faces the sun; of a sun behind air, and of a sky, outside it."},
    {"light", "angular_diameter", NPH_KEY_NUMBER, 0, 180, "degrees", NULL, "0", "sun",
     "0: parallel light; else at least 0.001: a disc of uniform radiance that gives the same irradiance."},
    {"light", "radiance", NPH_KEY_RGB, 0, MOST_LIGHT, "W/m2/sr", NULL, REQUIRED, "constant", "From every direction."},
    {"light", "hemisphere", NPH_KEY_WORD, 0, 0, "", "all|upper|lower", "all", "constant",
     "Light from all directions, from above (z > 0) or from below (z < 0) only."},
    {"light", "file", NPH_KEY_FILE, 1, 4095, "", NULL, REQUIRED, "environment",
     "OpenEXR image: latitude-longitude map of radiance."},
    {"light", "rotation", NPH_KEY_NUMBER, -3600, 3600, "degrees", NULL, "0", "environment",
     "Turns the map about z, counterclockwise as seen from above."},
    {"light", "scale", NPH_KEY_RGB, 0, MOST_LIGHT, "", NULL, "1", "environment", "Factor of the map's radiance."},
    {"light", "rows", NPH_KEY_WHOLE, 2, 4096, "", NULL, "256", "sky", "Of the map; it has twice as many columns."},
    {"light", "air", NPH_KEY_WORD, 0, 0, "", "attenuates|ignored", "attenuates", "sun|constant|environment",
     "ignored: the light is as it arrives, such as a sky photographed from the ground."},
    {"light", "position", NPH_KEY_VECTOR, -FAR_M, FAR_M, "m", NULL, REQUIRED, "point", "Where it stands."},
    {"light", "intensity", NPH_KEY_RGB, 0, MOST_LIGHT, "W/sr", NULL, REQUIRED, "point", "The same in every direction."},

    {"air", "type", NPH_KEY_WORD, 0, 0, "", AIRS, REQUIRED, NULL, "Form of the atmosphere."},
    {"air", "extinction", NPH_KEY_RGB, 0, 1, "1/m", NULL, NULL, NULL,
     "At sea level. Left out: Rayleigh scattering at 680, 550 and 440 nm, or at the scene's wavelengths."},
    {"air", "ground", NPH_KEY_NUMBER, -FAR_M, FAR_M, "m", NULL, "0", NULL, "The height z of sea level."},
    {"air", "height", NPH_KEY_NUMBER, -FAR_M, FAR_M, "m", NULL, NULL, NULL,
     "The height z, not below the ground, at which lights are attenuated. Left out: the middle of the media and surfaces."},
    {"air", "scale_height", NPH_KEY_NUMBER, 1, 1e5, "m", NULL, "8000", NULL,
     "Over which the air becomes thinner by a factor e. Not together with `file`."},
    {"air", "radius", NPH_KEY_NUMBER, 1e6, FAR_M, "m", NULL, "6371000", "table", "Of the planet."},
    {"air", "file", NPH_KEY_FILE, 1, 4095, "", NULL, NULL, "table",
     "Profile of the atmosphere: text with a row per level, from the top down to height 0, of height in km, pressure, "
     "temperature and number of molecules; further columns are skipped, `#` starts a comment."},

    {"air", "where", NPH_KEY_WORD, 0, 0, "", "before|within", "before", NULL,
     "before: between the lights and the scene. within: as media of the scene, without end, which `path` and `single` know; lights "
     "are as they are outside."},
    {"air", "ground_albedo", NPH_KEY_RGB, 0, 1, "", NULL, "0", "table",
     "With `where: within`: of the globe, the surface under the air, whose highest point is (0, 0, `ground`)."},
    {"air", "aerosol", NPH_KEY_SECTION, 0, 0, "", "aerosol", NULL, NULL, "Haze; left out: none."},

    {"aerosol", "extinction", NPH_KEY_RGB, 0, 1, "1/m", NULL, NULL, NULL, "At sea level."},
    {"aerosol", "turbidity", NPH_KEY_NUMBER, 1, 100, "", NULL, NULL, NULL, "1: none; 2 to 3 a clear day; 10 haze."},
    {"aerosol", "angstrom", NPH_KEY_NUMBER, 0, 4, "", NULL, "1.3", NULL,
     "With turbidity: extinction falls with this power of the wavelength."},
    {"aerosol", "albedo", NPH_KEY_RGB, 0, 1, "", NULL, "0.9", NULL, "Scattered share of the extinction."},
    {"aerosol", "scale_height", NPH_KEY_NUMBER, 1, 1e5, "m", NULL, "1200", NULL, "Over which it becomes thinner by a factor e."},
    {"aerosol", "phase", NPH_KEY_SECTION, 0, 0, "", "phase", NULL, NULL,
     "How it scatters. Left out: hg with g = 0.76."},

    {"surface", "name", NPH_KEY_TEXT, 1, 63, "", NULL, NULL, NULL,
     "For messages and plans; left out: surface0, surface1, ..."},
    {"surface", "mesh", NPH_KEY_FILE, 1, 4095, "", NULL, NULL, NULL,
     "Triangles from a file, by its ending: `.obj` or `.ply`; metres, as they stand there."},
    {"surface", "transform", NPH_KEY_LIST, 0, 64, "", "transform", NULL, NULL,
     "Steps from the mesh's own space into the world; left out: none."},
    {"surface", "plane", NPH_KEY_NUMBER, -FAR_M, FAR_M, "m", NULL, NULL, NULL, "The height z of a level plane."},
    {"surface", "albedo", NPH_KEY_RGB, 0, 1, "", NULL, "0.5", NULL, "Reflected share of the light."},

    {"periodic", "x", NPH_KEY_INTERVAL, -FAR_M, FAR_M, "m", NULL, NULL, NULL, "One period along x; left out: no repetition."},
    {"periodic", "y", NPH_KEY_INTERVAL, -FAR_M, FAR_M, "m", NULL, NULL, NULL, "The same along y. One of them at least is given."},

    {"render", "samples", NPH_KEY_WHOLE, 1, 2147483647, "per pixel", NULL, "64", NULL, "Rounded up to a multiple of 16."},
    {"render", "seed", NPH_KEY_WHOLE, 0, 4294967295.0, "", NULL, "1", NULL, "Of the random numbers."},

    {"animated", "frames", NPH_KEY_FRAMES, 0, NPH_MAX_FRAME, "", NULL, REQUIRED, NULL, "At most 4096, rising."},
    {"animated", "values", NPH_KEY_VALUES, 0, 0, "", NULL, REQUIRED, NULL, "One for each of the frames."},
};
const int nph_scene_key_count = (int)(sizeof nph_scene_keys / sizeof nph_scene_keys[0]);
