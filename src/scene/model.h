/* SPDX-License-Identifier: Apache-2.0
 *
 * What a scene is once it is read and checked. World space: metres, f64, right-handed, z up by default. Immutable. */
#ifndef NPH_SCENE_MODEL_H
#define NPH_SCENE_MODEL_H

#include "field/emission.h"
#include "geometry/bvh.h"
#include "light/light.h"
#include "nephos/scene.h"
#include "optics/phase.h"

enum { NPH_MAX_MEDIA = 64, NPH_MAX_LIGHTS = 32, NPH_MAX_SURFACES = 64 };

typedef enum NphSensorKind {
    NPH_SENSOR_PERSPECTIVE,
    NPH_SENSOR_ORTHOGRAPHIC,
    NPH_SENSOR_FLUX,
    NPH_SENSOR_FISHEYE,
    NPH_SENSOR_FLUENCE,
    NPH_SENSOR_RADIANCE
} NphSensorKind;

/* Pixel (x, y) covers s in [2x/W - 1, 2(x+1)/W - 1], t in [1 - 2(y+1)/H, 1 - 2y/H]: t rises upwards.
 * perspective: from position along forward + s half_size[0] right + t half_size[1] up (half_size: tangents).
 * orthographic: from position + s half_size[0] right + t half_size[1] up along forward (half_size: metres).
 * flux: the same points of a rectangle; the pixel is the irradiance [W/m2] that arrives there from the hemisphere
 * around forward, the delta sun's direct beam included.
 * fluence: the same points; the pixel is the integral of the radiance over all directions [W/m2], the delta sun included.
 * radiance: the same points, along `seen`; orthographic is that with `seen` = forward.
 * fisheye, equidistant: with a = s half_size[0], b = t half_size[1], r = sqrt(a^2 + b^2) [rad] along
 * cos r forward + sin r (a right + b up) / r; nothing is seen beyond r = the smaller half_size. */
typedef struct NphSensor {
    NphSensorKind kind;
    int width, height;
    int crop[4];                                     /* x0, y0, x1, y1; whole image unless cropped */
    double position[3], right[3], up[3], forward[3]; /* right, up, forward: orthonormal */
    double half_size[2];
    double seen[3];                                  /* unit; of radiance as the scene says, of others forward */
} NphSensor;

/* Sensors whose pixels gather light from many directions; they take light samples as vertices do. */
static inline int nph_sensor_gathers(NphSensorKind kind) { return kind == NPH_SENSOR_FLUX || kind == NPH_SENSOR_FLUENCE; }

typedef enum NphShape {
    NPH_SHAPE_GRID,  /* density from a file: the grid's box in lattice space */
    NPH_SHAPE_BOX,   /* constant density 1 in the box [lo, hi] of the medium's space */
    NPH_SHAPE_LAYER, /* constant density 1 for z in [lo[2], hi[2]], without end in x and y */
    NPH_SHAPE_AIR    /* density exp(-h / scale_height_m) at heights h in [0, hi[2]], without end; unlike a layer it has no part
                        in the scene's bounds. h = z, or above the sphere of radius_m that touches z = 0 from below at the
                        origin of its space, which lies upright in the world */
} NphShape;

typedef struct NphMedium {
    char *name;
    NphShape shape;
    NphGrid grid;
    double lo[3], hi[3];          /* of box, layer and air; +-HUGE_VAL where there is no end */
    double scale_height_m, radius_m; /* of air; radius 0: flat */
    double world_from_medium[12]; /* row-major 3x4; medium space is lattice space for a grid */
    double extinction_per_m[3];   /* per unit of density */
    double albedo[3];             /* in [0, 1] */
    double extinction_spectrum[NPH_MAX_WAVELENGTHS], albedo_spectrum[NPH_MAX_WAVELENGTHS]; /* see wavelength_count */
    NphPhase phase;
    NphEmission emission;
    char *unmodelled;             /* a grid of flames or temperatures in its file that no medium emits from; or NULL */
} NphMedium;

/* Opaque, Lambertian on both sides. */
typedef struct NphSurface {
    char *name;
    int is_plane;     /* z = height_m, without end, or the globe; else a mesh */
    double height_m;
    double radius_m;  /* > 0: the globe under air, a sphere whose highest point is (0, 0, height_m); seen from outside. One at most */
    NphMesh mesh;     /* world space */
    double albedo[3]; /* in [0, 1] */
    double albedo_spectrum[NPH_MAX_WAVELENGTHS];
} NphSurface;

/* Sides that repeat: everything is cut to [lo, hi] along the axes that are on (x, y) and stands there once a period. */
typedef struct NphPeriod {
    int on[2];
    double lo[2], hi[2];
} NphPeriod;

/* What a scene was read from, to read it again at another frame. */
typedef struct NphSceneSource {
    char *text, *name, *folder; /* name: in messages; folder: where files are looked up */
    size_t size;
    NphStatus (*read)(NphContext *context, const struct NphSceneSource *source, uint32_t frame, NphScene **scene);
} NphSceneSource;

typedef enum NphAirKind { NPH_AIR_NONE, NPH_AIR_EXPONENTIAL, NPH_AIR_TABLE } NphAirKind;

/* Haze in the air: density exp(-h / scale_height_m). */
typedef struct NphSceneAerosol {
    int given;
    double extinction_per_m[3], albedo[3]; /* at sea level */
    double extinction_spectrum[NPH_MAX_WAVELENGTHS], albedo_spectrum[NPH_MAX_WAVELENGTHS];
    double scale_height_m;
    NphPhase phase;
} NphSceneAerosol;

/* What the lights have been attenuated with: their values are those behind it. */
typedef struct NphSceneAir {
    NphAirKind kind;
    int within;                 /* media of the scene instead */
    int skies;                  /* lights that are what it scatters */
    NphSceneAerosol aerosol;
    double extinction_per_m[3]; /* at sea level */
    double extinction_spectrum[NPH_MAX_WAVELENGTHS];
    double scale_height_m, ground_m, radius_m;
    double ground_albedo[3], ground_albedo_spectrum[NPH_MAX_WAVELENGTHS]; /* of the globe, where the air is within */
    double height_m; /* z at which the lights are attenuated */
} NphSceneAir;

struct NphScene {
    char *name;                         /* file name without folder */
    NphSceneSource source;              /* all 0: the scene was made without a text */
    uint32_t frame;                     /* that it stands at */
    int animated;                       /* another frame may differ */
    NphSensor sensor;
    NphPeriod period;
    NphSceneAir air;
    int medium_count, light_count, surface_count;
    NphMedium media[NPH_MAX_MEDIA];
    NphLight lights[NPH_MAX_LIGHTS];
    NphSurface surfaces[NPH_MAX_SURFACES];
    int wavelength_count;               /* 0: channels are R, G, B. Else values of media, lights and surfaces are spectra,
                                           an entry a wavelength, and their RGB is the spectra's thirds */
    double wavelengths_nm[NPH_MAX_WAVELENGTHS]; /* rising */
    NphBvh bvh;                         /* of all meshes, in the order of surfaces, about nph_scene_origin; no nodes: none */
    int64_t default_spp;                /* render: section; overridden by the command line */
    uint32_t default_seed;
    uint8_t digest[16];                 /* XXH128 (canonical) of sensor, period, media, lights, surfaces with the contents of their
                                           files; names, paths, comments, order of keys, defaults written out or not,
                                           and the render: section (part of a run, not of the scene) do not enter */
};

/* 1 where channels are wavelengths that become a colour: two at least. One alone makes a grey picture of its radiance. */
static inline int nph_scene_is_spectral(const NphScene *scene) { return scene->wavelength_count > 1; }

/* Out: three channels of a group of wavelengths (optics/wavelengths.h) from a spectrum; without wavelengths rgb itself. */
void nph_scene_channels(const NphScene *scene, int group, const double rgb[3], const double *spectrum, double out[3]);

/* Bounding box in world space of all media, what they emit, and surfaces, that have one (layers and planes count in z
 * only); lo > hi when there is none. */
void nph_scene_bounds(const NphScene *scene, double lo[3], double hi[3]);

/* The origin of scene-local space, in which kernels work: the middle of that box, or of the period where sides repeat; along
 * an axis without bounds the sensor's position. */
void nph_scene_origin(const NphScene *scene, double origin[3]);

/* The same of one medium; a layer's x and y are -+HUGE_VAL. */
void nph_medium_bounds(const NphMedium *medium, double lo[3], double hi[3]);

/* Of the grids that a medium emits from; 0, lo and hi untouched, when it has none of its own. */
int nph_emission_bounds(const NphMedium *medium, double lo[3], double hi[3]);

/* A 3x4 row-major affine map: out = a after b (out may be a or b). inverse: 0, out untouched, when it is singular: its
 * columns span less than 1e-12 of a box with edges of their lengths. */
void nph_affine_identity(double out[12]);
void nph_affine_multiply(const double a[12], const double b[12], double out[12]);
int nph_affine_invert(const double a[12], double out[12]);

int nph_vector_normalise(const double vector[3], double unit[3]); /* 0 for length 0 */
void nph_vector_cross(const double a[3], const double b[3], double out[3]);

#endif
