/* SPDX-License-Identifier: Apache-2.0
 *
 * The sky (optics/sky.h) as an environment map: means over texels, by ABOVE x BESIDE directions of each, evenly in solid angle.
 * Without phase functions a flat sky depends on the elevation alone; one around a sphere also on the azimuth from the sun, and
 * smoothly: it is computed at NODES of them in half a turn and a cubic goes through four. Phase functions are taken
 * direction by direction. */
#include "core/fmath.h"
#include "core/memory.h"
#include "core/message.h"
#include "light/light.h"

enum { ABOVE = 4, BESIDE = 2, NODES = 17 };

typedef struct Drawing {
    const NphSky *sky;
    double height_m;
    double azimuth_turns;                 /* of the sun */
    int nodes;                            /* 1: flat */
    double source[NODES][NPH_SKY_MOST][3]; /* of one elevation */
} Drawing;

static void fill_sources(Drawing *drawing, double rise) {
    double flat = nph_sqrt((1.0 - rise) * (1.0 + rise)), across, along;
    for (int n = 0; n < drawing->nodes; n++) {
        nph_sincos2pi(drawing->azimuth_turns + 0.5 * n / (NODES - 1), &across, &along);
        NphSkyLine line = {drawing->height_m, {flat * along, flat * across, rise}, nph_infinity()};
        nph_sky_sources(drawing->sky, &line, drawing->source[n]);
    }
}

/* A node beyond the ends of the half turn is its mirror image. */
static int mirrored(int n) { return n < 0 ? -n : n > NODES - 1 ? 2 * (NODES - 1) - n : n; }

static void source_at(const Drawing *drawing, double turns, double source[NPH_SKY_MOST][3]) {
    double off = turns - drawing->azimuth_turns, weight[4] = {0.0, 1.0, 0.0, 0.0};
    off -= nph_floor(off);
    double place = (off > 0.5 ? 1.0 - off : off) * 2.0 * (NODES - 1), t = place - nph_floor(place);
    int first = drawing->nodes > 1 ? (int)nph_floor(place) - 1 : -1;
    if (drawing->nodes > 1) {
        weight[0] = t * (t - 1.0) * (t - 2.0) / -6.0;
        weight[1] = (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0;
        weight[2] = (t + 1.0) * t * (t - 2.0) / -2.0;
        weight[3] = (t + 1.0) * t * (t - 1.0) / 6.0;
    }
    for (int i = 0; i < drawing->sky->count; i++)
        for (int c = 0; c < 3; c++) {
            double sum = 0.0;
            for (int k = 0; k < 4; k++)
                if (drawing->nodes > 1 || k == 1) sum += weight[k] * drawing->source[mirrored(first + k)][i][c];
            source[i][c] = sum > 0.0 ? sum : 0.0;
        }
}

/* Adds the directions of one elevation to the texels of its row. */
static void add_elevation(Drawing *drawing, double rise, int width, double *row) {
    double flat = nph_sqrt((1.0 - rise) * (1.0 + rise)), across, along, source[NPH_SKY_MOST][3], radiance[3];
    fill_sources(drawing, rise);
    for (int i = 0; i < BESIDE * width; i++) {
        double turns = 0.5 - (i + 0.5) / (BESIDE * width); /* light.h: u = 1/2 - phi / 2 pi */
        nph_sincos2pi(turns, &across, &along);
        double direction[3] = {flat * along, flat * across, rise};
        source_at(drawing, turns, source);
        nph_sky_combine(drawing->sky, direction, source, radiance);
        for (int c = 0; c < 3; c++) row[3 * (i / BESIDE) + c] += radiance[c] / (ABOVE * BESIDE);
    }
}

NphStatus nph_environment_sky(NphContext *context, const NphSky *sky, double height_m, int height, NphEnvironment *map) {
    const double *sun = sky->sun;
    int width = 2 * height, curved = sky->radius_m > 0.0;
    Drawing drawing = {.sky = sky, .height_m = height_m, .nodes = curved ? NODES : 1};
    double *texels = NULL;
    drawing.azimuth_turns = nph_atan2(sun[1], sun[0]) * 0.15915494309189535;
    NPH_TRY(NPH_NEW(context, 3 * (int64_t)width * height, "sky", &texels));
    for (int row = 0; row < height; row++) {
        double top, bottom, unused;
        nph_sincos2pi(0.5 * row / height, &unused, &top);
        nph_sincos2pi(0.5 * (row + 1.0) / height, &unused, &bottom);
        for (int k = 0; k < ABOVE; k++)
            add_elevation(&drawing, top + (bottom - top) * (k + 0.5) / ABOVE, width, texels + 3 * (int64_t)row * width);
    }
    NphStatus status = nph_environment_of_texels(context, width, height, texels, map);
    nph_free(context, texels);
    return status;
}
