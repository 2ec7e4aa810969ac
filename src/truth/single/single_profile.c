/* SPDX-License-Identifier: Apache-2.0
 *
 * See single_profile.h. */
#include "truth/single/single_profile.h"

const double nph_gauss_point[NPH_GAUSS] = {0.046910077030668003601, 0.23076534494715845448, 0.5, 0.76923465505284154552,
                                           0.9530899229693319964};
const double nph_gauss_weight[NPH_GAUSS] = {0.11846344252809454376, 0.23931433524968323402, 0.28444444444444444444,
                                            0.23931433524968323402, 0.11846344252809454376};

static double piece_density(const NphPiece *piece, double x) {
    if (piece->air) return piece->c[0] * r_exp(-x * (piece->c[1] + x * piece->c[2]));
    return piece->c[0] + x * (piece->c[1] + x * (piece->c[2] + x * piece->c[3]));
}

/* Of air: closed where the exponent is linear; a curved one has Gauss points, 1e-13 in pieces of half a scale height. */
static double air_depth(const NphPiece *piece, double x) {
    double fall = piece->c[1] * x, sum = 0.0;
    if (!(nph_abs(piece->c[2]) > 0.0)) return piece->c[0] * x * (nph_abs(fall) > 0.0 ? -r_expm1(-fall) / fall : 1.0);
    for (int g = 0; g < NPH_GAUSS; g++) sum += nph_gauss_weight[g] * piece_density(piece, x * nph_gauss_point[g]);
    return x * sum;
}

static double piece_depth(const NphPiece *piece, double x) {
    const double *c = piece->c;
    if (piece->air) return piece->depth + (piece->t1 - piece->t0) * air_depth(piece, x);
    return piece->depth +
           (piece->t1 - piece->t0) * x * (c[0] + x * (0.5 * c[1] + x * ((1.0 / 3.0) * c[2] + x * 0.25 * c[3])));
}

/* Through the densities at x = 0, 1/3, 2/3, 1. */
static void fit(const double f[4], double c[4]) {
    c[0] = f[0];
    c[1] = -5.5 * f[0] + 9.0 * f[1] - 4.5 * f[2] + f[3];
    c[2] = 9.0 * f[0] - 22.5 * f[1] + 18.0 * f[2] - 4.5 * f[3];
    c[3] = -4.5 * f[0] + 13.5 * f[1] - 13.5 * f[2] + 4.5 * f[3];
}

double nph_single_opaque(const RScene *scene, const RMedium *medium, double tau) {
    double least = medium->sigma[0];
    for (int c = 1; c < scene->channels; c++) least = medium->sigma[c] < least ? medium->sigma[c] : least;
    return least > 0.0 ? tau / least : 1e300;
}

static const RMedium *field_of(const NphSingleScene *scene, int f) {
    return f < scene->local.medium_count ? &scene->local.media[f] : &scene->glow[f - scene->local.medium_count];
}

/* The pieces of one medium under way. */
typedef struct Filling {
    NphPiece *pieces;
    int count;
    double opaque, depth;
    int full; /* opaque, or no room: the stretch ends behind the last piece */
    NphWalked *walked;
} Filling;

static void add_piece(Filling *filling, double t0, double t1, const double c[4], int air) {
    NphPiece *piece = &filling->pieces[filling->count++];
    *piece = (NphPiece){t0, t1, filling->depth, {c[0], c[1], c[2], c[3]}, air};
    filling->depth = piece_depth(piece, 1.0);
    filling->full = filling->depth >= filling->opaque || filling->count == NPH_SINGLE_PIECES;
}

static void add_voxels(const RMedium *medium, const NphLine *line, Filling *filling) {
    NphVoxelWalk walk = nph_walk_enter(medium, line);
    double corner[8], t, e;
    int32_t v[3];
    while (!filling->full && nph_walk_voxel(medium, line, &walk, v, &t, &e)) {
        double f[4], c[4];
        filling->walked->voxels++;
        if (!nph_voxel_corners(medium, v, corner)) continue;
        for (int i = 0; i < 4; i++) {
            f[i] = nph_voxel_density(line, v, corner, t + (double)i * (1.0 / 3.0) * (e - t));
            f[i] = f[i] > 0.0 ? f[i] : 0.0; /* rounding at a face where the density is 0 */
        }
        fit(f, c);
        add_piece(filling, t, e, c, 0);
    }
}

static void add_whole(const NphLine *line, Filling *filling) {
    static const double constant[4] = {1.0, 0.0, 0.0, 0.0};
    double most = filling->opaque - filling->depth, end = line->far - line->near < most ? line->far : line->near + most;
    if (end > line->near) add_piece(filling, line->near, end, constant, 0);
    filling->full |= end < line->far;
}

/* Flat air: pieces whose ends are half a scale height apart, which five Gauss points integrate to 1e-12, up to where it is
 * opaque. */
static void add_air(const RMedium *medium, const NphLine *line, Filling *filling) {
    double rise = line->d[2], t = line->near;
    while (!filling->full && t < line->far) {
        double height = line->o[2] + t * rise, left = line->far - t, c[4] = {r_air_density(medium, height), 0.0, 0.0, 0.0};
        double most = r_air_reach(medium, height, rise, filling->opaque - filling->depth);
        double half = nph_abs(rise) > 1e-300 ? 0.5 * medium->scale_height / nph_abs(rise) : 1e300;
        double length = half < left ? half : left, e = t + length;
        int ends = most < length;
        if (ends) e = t + most;
        else if (length == left) e = line->far;
        if (!(e > t)) return;
        c[1] = (e - t) * rise / medium->scale_height;
        add_piece(filling, t, e, c, 1);
        filling->full |= ends;
        t = e;
    }
}

/* Around a sphere: the height is taken through three points of a piece, which its cubic term changes by less than a micrometre. */
static void add_curved_air(const RMedium *medium, const RArc *arc, double from, Filling *filling) {
    double scale = medium->scale_height, bend = 0.5 * r_sqrt(scale * medium->radius), t = arc->near > from ? arc->near : from;
    while (!filling->full && t < arc->far) {
        double h[3], c[4] = {0.0, 0.0, 0.0, 0.0}, rise = nph_abs(arc->b + t) / medium->radius;
        double length = rise * bend > 0.5 * scale ? 0.5 * scale / rise : bend, e = arc->far - t > length ? t + length : arc->far;
        for (int k = 0; k < 3; k++) h[k] = r_air_height(medium, r_air_e(arc, t + 0.5 * k * (e - t)));
        c[0] = r_air_density(medium, h[0]);
        c[1] = (4.0 * (h[1] - h[0]) - (h[2] - h[0])) / scale;
        c[2] = (2.0 * (h[2] - h[0]) - 4.0 * (h[1] - h[0])) / scale;
        add_piece(filling, t, e, c, 1);
        t = e;
    }
}

static void add_medium(const RMedium *medium, const double p[3], const double d[3], const double range[2],
                       Filling *filling) {
    NphLine line;
    NphLineImage image;
    if (medium->shape == NPH_SHAPE_AIR && medium->radius > 0.0) {
        RArc arc = r_air_arc(medium, p, d, range[1]);
        if (arc.inside) add_curved_air(medium, &arc, range[0], filling);
        return;
    }
    if (!nph_image_first(medium, p, d, range[0], range[1], &image)) return;
    do {
        if (!nph_line_clip(medium, image.q, d, image.from, image.to, &line)) continue;
        if (medium->shape == NPH_SHAPE_GRID)
            add_voxels(medium, &line, filling);
        else if (medium->shape == NPH_SHAPE_AIR)
            add_air(medium, &line, filling);
        else
            add_whole(&line, filling);
    } while (!filling->full && nph_image_next(medium, p, d, &image));
    filling->walked->exhausted += image.left == 0;
}

void nph_profile_build(NphProfile *profile, const NphSingleScene *scene, const double p[3], const double d[3],
                       double limit, NphWalked *walked) {
    profile->scene = scene;
    profile->begin = profile->end;
    profile->end = limit;
    profile->opaque = 0;
    for (int f = 0; f < scene->fields; f++) {
        const RMedium *field = field_of(scene, f);
        double range[2] = {profile->begin, limit};
        Filling filling = {profile->pieces[f], 0, nph_single_opaque(&scene->local, field, NPH_SINGLE_OPAQUE),
                           profile->total[f],  0, walked};
        add_medium(field, p, d, range, &filling);
        profile->count[f] = filling.count;
        profile->total[f] = filling.depth;
        double end = filling.count > 0 ? filling.pieces[filling.count - 1].t1 : profile->begin;
        if (!filling.full || !(end < profile->end)) continue;
        profile->end = end;
        profile->opaque = filling.depth >= filling.opaque * (1.0 - 1e-12);
    }
    for (int f = 0; f < scene->fields; f++) { /* what lies behind the end belongs to the next stretch */
        NphPiece *pieces = profile->pieces[f];
        int count = profile->count[f];
        while (count > 0 && pieces[count - 1].t0 >= profile->end) profile->total[f] = pieces[--count].depth;
        profile->count[f] = count;
        if (count == 0 || !(pieces[count - 1].t1 > profile->end)) continue;
        const NphPiece *last = &pieces[count - 1];
        profile->total[f] = piece_depth(last, (profile->end - last->t0) / (last->t1 - last->t0));
    }
}

double nph_profile_move(const NphProfile *profile, NphPlace *place, double t, double limit) {
    double end = limit < profile->end ? limit : profile->end;
    place->active = 0;
    for (int m = 0; m < profile->scene->fields; m++) {
        const NphPiece *pieces = profile->pieces[m];
        int at = place->at[m], count = profile->count[m];
        while (at < count && !(pieces[at].t1 > t)) at++;
        place->at[m] = at;
        if (at == count) continue;
        int under_way = !(pieces[at].t0 > t);
        double next = under_way ? pieces[at].t1 : pieces[at].t0;
        end = next < end ? next : end;
        place->active += under_way;
    }
    return end;
}

void nph_profile_seek(const NphProfile *profile, double t, NphPlace *place) {
    for (int m = 0; m < profile->scene->fields; m++) {
        const NphPiece *pieces = profile->pieces[m];
        int low = 0, high = profile->count[m]; /* the first piece that ends behind t */
        while (low < high) {
            int middle = (low + high) / 2;
            if (pieces[middle].t1 > t)
                high = middle;
            else
                low = middle + 1;
        }
        place->at[m] = low;
    }
    place->active = 0;
}

void nph_profile_at(const NphProfile *profile, const NphPlace *place, double t, double density[NPH_SINGLE_FIELDS],
                    double tau[3]) {
    const RScene *scene = &profile->scene->local;
    for (int c = 0; c < scene->channels; c++) tau[c] = 0.0;
    for (int m = 0; m < profile->scene->fields; m++) {
        int at = place->at[m], count = profile->count[m];
        double depth = profile->total[m];
        density[m] = 0.0;
        if (at < count) {
            const NphPiece *piece = &profile->pieces[m][at];
            depth = piece->depth;
            if (t > piece->t0) {
                double x = (t - piece->t0) / (piece->t1 - piece->t0);
                density[m] = piece_density(piece, x);
                depth = piece_depth(piece, x);
            }
        }
        for (int c = 0; c < scene->channels && m < scene->medium_count; c++) tau[c] += scene->media[m].sigma[c] * depth;
    }
}

double nph_profile_thin(const NphProfile *profile, const NphPlace *place, double t, double e) {
    double density[NPH_SINGLE_FIELDS], from[3], to[3];
    nph_profile_at(profile, place, t, density, from);
    for (;;) {
        double most = 0.0, half = 0.5 * (t + e);
        nph_profile_at(profile, place, e, density, to);
        for (int c = 0; c < profile->scene->local.channels; c++) { /* behind its last visible depth a channel is 0 */
            double more = (to[c] < NPH_SINGLE_OPAQUE ? to[c] : NPH_SINGLE_OPAQUE) - from[c];
            most = more > most ? more : most;
        }
        if (!(most > 1.0) || !(half > t && half < e)) return e;
        e = half;
    }
}
