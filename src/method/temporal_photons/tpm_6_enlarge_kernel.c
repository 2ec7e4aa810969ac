/* SPDX-License-Identifier: Apache-2.0
 *
 * tpm.enlarge [Elek12 sec. 4.4]: from the small picture [pixel][field] to the sensor's pixels [field][pixel], linear between four.
 * With impostors a picture holds the cloud alone, and may serve later frames: it then stands on a plane through the cloud's middle. */
#include "method/temporal_photons/tpm_state.h"

void NPH_KERNEL(nph_tpm_enlarge)(const void *memory, const void *view, const void *picture, const int crop[4], int first, int end, void *image);

/* Between which two pixels of the small picture a place lies, along an axis; it is constant beyond its outermost. */
R_INLINE Real place_between(const RTpmScene *scene, int a, Real at, int32_t *low, int32_t *high) {
    Real u = r_clamp(at - (Real)scene->small_origin[a], R(0.0), (Real)(scene->small[a] - 1));
    *low = (int32_t)u;
    *high = *low + 1 < scene->small[a] ? *low + 1 : *low;
    return u - (Real)*low;
}

/* The place of a sensor's pixel in the small picture. */
R_INLINE Real place_of(const RTpmScene *scene, int pixel) {
    return scene->half ? R(0.5) * ((Real)pixel + R(0.5)) - R(0.5) : (Real)pixel;
}

/* Between four pixels. */
static void blend(const RTpmScene *scene, const Real *picture, const Real at[2], Real out[NPH_SAMPLE_FIELDS]) {
    int32_t low[2], high[2];
    int64_t corner[4];
    Real share[2];
    for (int a = 0; a < 2; a++) share[a] = place_between(scene, a, at[a], &low[a], &high[a]);
    for (int k = 0; k < 4; k++)
        corner[k] = ((int64_t)(k >> 1 ? high[1] : low[1]) * scene->small[0] + (k & 1 ? high[0] : low[0])) * NPH_SAMPLE_FIELDS;
    for (int f = 0; f < NPH_SAMPLE_FIELDS; f++) {
        const Real *from = picture + f;
        Real upper = r_grid_mix(from[corner[0]], from[corner[1]], share[0]);
        Real lower = r_grid_mix(from[corner[2]], from[corner[3]], share[0]);
        out[f] = r_grid_mix(upper, lower, share[1]);
    }
}

enum { SPAN = 128 }; /* pixels of a row that are enlarged together */

/* The same for many pixels: first along x, once for all rows that need it, then along y. */
typedef struct Enlarged {
    int32_t low[SPAN], high[SPAN]; /* numbers of the picture's row */
    Real share[SPAN], row[2][NPH_SAMPLE_FIELDS][SPAN];
    int32_t number[2]; /* of the two rows of the small picture that are there */
} Enlarged;

R_OUTLINE void stretch(Real *restrict to, const Real *restrict from, const int32_t *restrict low, const int32_t *restrict high,
                       const Real *restrict share, int count) {
    for (int i = 0; i < count; i++) to[i] = r_grid_mix(from[low[i]], from[high[i]], share[i]); /* vec */
}

R_OUTLINE void mix_rows(Real *restrict to, const Real *restrict upper, const Real *restrict lower, Real share, int count) {
    for (int i = 0; i < count; i++) to[i] = r_grid_mix(upper[i], lower[i], share); /* vec */
}

/* The slot of a row; the other one is the row `kept`, which stays. */
static int stretched(Enlarged *e, const RTpmScene *scene, const Real *picture, int32_t number, int32_t kept, int count) {
    int slot = e->number[0] == number ? 0 : e->number[1] == number ? 1 : e->number[0] == kept ? 1 : 0;
    if (e->number[slot] == number) return slot;
    e->number[slot] = number;
    for (int f = 0; f < NPH_SAMPLE_FIELDS; f++)
        stretch(e->row[slot][f], picture + (int64_t)number * scene->small[0] * NPH_SAMPLE_FIELDS + f, e->low, e->high, e->share, count);
    return slot;
}

/* Rows [first, end) of the crop, columns [column, column + count). */
static void enlarge_span(const RTpmScene *scene, const Real *picture, const int crop[4], int column, int count, int first, int end, Real *image) {
    int64_t width = crop[2] - crop[0], pixels = width * (crop[3] - crop[1]);
    Enlarged e = {.number = {-1, -1}};
    for (int i = 0; i < count; i++) {
        e.share[i] = place_between(scene, 0, place_of(scene, crop[0] + column + i), &e.low[i], &e.high[i]);
        e.low[i] *= NPH_SAMPLE_FIELDS;
        e.high[i] *= NPH_SAMPLE_FIELDS;
    }
    for (int row = first; row < end; row++) {
        int32_t low, high;
        Real share = place_between(scene, 1, place_of(scene, crop[1] + row), &low, &high);
        int upper = stretched(&e, scene, picture, low, high, count), lower = stretched(&e, scene, picture, high, low, count);
        for (int f = 0; f < NPH_SAMPLE_FIELDS; f++)
            mix_rows(image + f * pixels + row * width + column, e.row[upper][f], e.row[lower][f], share, count);
    }
}

static double product(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Through the middle of a pixel, of any length. */
static void pixel_way(const NphSensor *sensor, int x, int y, double d[3]) {
    double s = sensor->half_size[0] * (2.0 * ((double)x + 0.5) / (double)sensor->width - 1.0);
    double t = sensor->half_size[1] * (1.0 - 2.0 * ((double)y + 0.5) / (double)sensor->height);
    for (int a = 0; a < 3; a++) d[a] = sensor->forward[a] + s * sensor->right[a] + t * sensor->up[a];
}

/* Where the view's ray meets the impostor, in pixels of the picture's sensor: that is a plane through the middle of the cloud, across
 * the way on which it was seen. 0: nowhere. */
static int meet(const RTpmScene *scene, const RTpmScene *view, const double d[3], double at[2]) {
    const NphSensor *from = &scene->local.sensor, *to = &view->local.sensor;
    double normal[3], away[3], hit[3];
    for (int a = 0; a < 3; a++) {
        normal[a] = scene->centre[a] - from->position[a];
        away[a] = view->centre[a] - to->position[a];
    }
    double slope = product(d, normal), distance = product(away, normal) / slope;
    if (!(slope > 0.0) || !(distance > 0.0)) return 0;
    for (int a = 0; a < 3; a++) hit[a] = normal[a] + distance * d[a] - away[a]; /* from where the picture was taken */
    double depth = product(hit, from->forward);
    if (!(depth > 0.0)) return 0;
    at[0] = 0.5 * (1.0 + product(hit, from->right) / (depth * from->half_size[0])) * (double)from->width;
    at[1] = 0.5 * (1.0 - product(hit, from->up) / (depth * from->half_size[1])) * (double)from->height;
    return at[0] > -1.0 && at[1] > -1.0 && at[0] < (double)from->width + 1.0 && at[1] < (double)from->height + 1.0;
}

/* The same camera and cloud: the picture is where it was, to the bit. */
static int stands_still(const RTpmScene *scene, const RTpmScene *view) {
    const NphSensor *a = &scene->local.sensor, *b = &view->local.sensor;
    int same = 1;
    for (int x = 0; x < 3; x++)
        same &= !(a->position[x] < b->position[x] || a->position[x] > b->position[x] || a->right[x] < b->right[x] || a->right[x] > b->right[x] ||
                  a->up[x] < b->up[x] || a->up[x] > b->up[x] || a->forward[x] < b->forward[x] || a->forward[x] > b->forward[x] ||
                  scene->centre[x] < view->centre[x] || scene->centre[x] > view->centre[x]);
    for (int x = 0; x < 2; x++) same &= !(a->half_size[x] < b->half_size[x] || a->half_size[x] > b->half_size[x]);
    return same;
}

/* The cloud's picture, this frame's or an earlier one's, before what is behind it now. */
static void show_impostor(const RTpmScene *scene, const RTpmScene *view, int still, const Real *picture, int x, int y, Real out[NPH_SAMPLE_FIELDS]) {
    double way[3], place[2] = {(double)x + 0.5, (double)y + 0.5};
    Real radiance[3] = {R(0.0), R(0.0), R(0.0)}, d[3], at[2];
    pixel_way(&view->local.sensor, x, y, way);
    double inverse = 1.0 / nph_sqrt(product(way, way));
    for (int a = 0; a < 3; a++) d[a] = (Real)(way[a] * inverse);
    int seen = still || meet(scene, view, way, place);
    for (int f = 0; f < NPH_SAMPLE_FIELDS; f++) out[f] = R(0.0);
    for (int c = 0; c < 3; c++) out[NPH_SAMPLE_T0 + c] = R(1.0);
    for (int a = 0; a < 2; a++) at[a] = (Real)((scene->half ? 0.5 * place[a] : place[a]) - 0.5);
    if (seen) blend(scene, picture, at, out);
    r_lights_at_infinity(&view->local, d, R(-1.0), radiance);
    for (int c = 0; c < 3; c++) out[NPH_SAMPLE_L0 + c] += out[NPH_SAMPLE_T0 + c] * radiance[c];
}

void NPH_KERNEL(nph_tpm_enlarge)(const void *memory, const void *seen, const void *picture, const int crop[4], int first, int end, void *image) {
    const RTpmScene *scene = memory, *view = seen;
    int width = crop[2] - crop[0], still = scene == view || stands_still(scene, view);
    int64_t pixels = (int64_t)width * (crop[3] - crop[1]);
    for (int column = 0; column < width && !scene->impostor; column += SPAN)
        enlarge_span(scene, picture, crop, column, width - column < SPAN ? width - column : SPAN, first, end, image);
    for (int row = first; row < end && scene->impostor; row++)
        for (int column = 0; column < width; column++) {
            Real out[NPH_SAMPLE_FIELDS];
            show_impostor(scene, view, still, picture, crop[0] + column, crop[1] + row, out);
            for (int f = 0; f < NPH_SAMPLE_FIELDS; f++) ((Real *)image)[f * pixels + (int64_t)row * width + column] = out[f];
        }
}
