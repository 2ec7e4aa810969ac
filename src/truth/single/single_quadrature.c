/* SPDX-License-Identifier: Apache-2.0
 *
 * See single_quadrature.h. The panel that promises most is halved first, as in [Piessens83]; its nodes are kept, so
 * half a panel costs two more optical depths. The estimate of a panel's error is the difference between what five nodes
 * make of it (degree 4, the value) and what three make of it (degree 2): larger than the error of the value wherever
 * more nodes help at all. */
#include "truth/single/single_quadrature.h"

#include "transport/vertex_lookup.h"
#include "truth/single/single_shadow.h"
#include "truth/single/single_walk.h"

#define BLACK 750.0 /* e^-750 is 0 */

/* One integral under way. */
typedef struct Integral {
    const NphSingleScene *scene;
    NphSingleScratch *scratch;
    const NphBeam *beam;
    const double *p, *d;
    double middle, off; /* of a point light: where the ray passes it, and how near */
    double value[3], error[3];
    int count;
    int crowded; /* no room for a panel: part of the ray is missing */
    int shadows; /* in air: of media with ends, where they fall on the ray */
    double shadow[NPH_MAX_MEDIA][2];
} Integral;

void nph_single_transmittance(const RScene *scene, const double x[3], const double d[3], double limit,
                              NphWalked *walked, double T[3]) {
    double tau[3] = {0.0, 0.0, 0.0};
    for (int m = 0; m < scene->medium_count; m++) {
        const RMedium *medium = &scene->media[m];
        double depth = nph_single_depth(medium, x, d, limit, nph_single_opaque(scene, medium, BLACK), walked);
        for (int c = 0; c < scene->channels; c++) tau[c] += scene->media[m].sigma[c] * depth;
    }
    for (int c = 0; c < scene->channels; c++) T[c] = r_exp(-tau[c]);
}

static double t_of(const Integral *q, double v) { return q->beam->point ? q->middle + q->off * nph_tan(v) : v; }
static double v_of(const Integral *q, double t) { return q->beam->point ? r_atan2(t - q->middle, q->off) : t; }

static double node_of(const NphPanel *panel, int k) {
    return k == NPH_NODES - 1 ? panel->v1 : panel->v0 + 0.25 * (double)k * (panel->v1 - panel->v0);
}

/* From the point at t: direction towards the light, and how far it is. */
static double towards(const Integral *q, double t, double x[3], double to[3]) {
    double squared = 0.0;
    for (int a = 0; a < 3; a++) x[a] = q->p[a] + t * q->d[a];
    for (int a = 0; a < 3; a++) {
        to[a] = q->beam->point ? q->beam->position[a] - x[a] : q->beam->d[a];
        squared += to[a] * to[a];
    }
    if (!q->beam->point) return R_HUGE;
    double distance = r_sqrt(squared);
    for (int a = 0; a < 3 && distance > 0.0; a++) to[a] /= distance;
    return distance;
}

static int is_lit(const Integral *q, double v) {
    if (q->scene->local.surfaces.count == 0) return 1;
    double x[3], to[3], distance = towards(q, t_of(q, v), x, to);
    return !r_blocked(&q->scene->local, x, to, distance);
}

static void light_node(Integral *q, NphPanel *panel, int k) {
    double v = node_of(panel, k), x[3], to[3], distance = towards(q, t_of(q, v), x, to);
    panel->lit[k] = is_lit(q, v);
    for (int c = 0; c < 3; c++) panel->T[k][c] = 0.0;
    if (!panel->lit[k]) return;
    q->scratch->tally.points++;
    nph_single_transmittance(&q->scene->local, x, to, distance, &q->scratch->tally.walked, panel->T[k]);
}

/* Of a point light phase functions change along the ray. */
static double phase_node(const Integral *q, const NphPanel *panel, int medium, int k) {
    if (!q->beam->point) return q->beam->phase[medium];
    double x[3], to[3];
    towards(q, t_of(q, node_of(panel, k)), x, to);
    return r_phase_at(&q->scene->local.media[medium].phase, r_angle_between(to, q->d));
}

/* Short enough for 1 / r^2: half of the distance from the light. */
static double near_point(const Integral *q, double t, double e) {
    for (;;) {
        double s = q->middle < t ? t - q->middle : q->middle > e ? q->middle - e : 0.0, half = 0.5 * (t + e);
        double length = e - t;
        if (!(4.0 * length * length > s * s + q->off * q->off) || !(half > t && half < e)) return e;
        e = half;
    }
}

/* Lagrange's polynomials of the nodes 0, 1, 2, 3, 4 at x. */
static void lagrange(double x, double l[NPH_NODES]) {
    double a = x, b = x - 1.0, c = x - 2.0, d = x - 3.0, e = x - 4.0;
    l[0] = b * c * d * e * (1.0 / 24.0);
    l[1] = a * c * d * e * (-1.0 / 6.0);
    l[2] = a * b * d * e * 0.25;
    l[3] = a * b * c * e * (-1.0 / 6.0);
    l[4] = a * b * c * d * (1.0 / 24.0);
}

typedef struct Weights {
    double of[NPH_MAX_MEDIA][3][NPH_NODES];
} Weights;

/* One Gauss point: adds h rho s albedo e^-tau [/ r^2] l_k. */
static void add_point(const Integral *q, const NphPanel *panel, const NphPlace *place, double t, double h,
                      Weights *weights) {
    const RScene *scene = &q->scene->local;
    double density[NPH_SINGLE_FIELDS], tau[3], l[NPH_NODES], s = t - q->middle;
    nph_profile_at(&q->scratch->profile, place, t, density, tau);
    lagrange(4.0 * (v_of(q, t) - panel->v0) / (panel->v1 - panel->v0), l);
    if (q->beam->point) h /= s * s + q->off * q->off;
    for (int c = 0; c < scene->channels; c++) {
        double arrives = h * r_exp(-tau[c]);
        for (int m = 0; m < scene->medium_count; m++) {
            if (!(density[m] > 0.0)) continue;
            double weight = arrives * density[m] * scene->media[m].sigma[c] * scene->media[m].albedo[c];
            for (int k = 0; k < NPH_NODES; k++) weights->of[m][c][k] += weight * l[k];
        }
    }
}

static void weigh(const Integral *q, const NphPanel *panel, Weights *weights) {
    const NphProfile *profile = &q->scratch->profile;
    double t = t_of(q, panel->v0), end = t_of(q, panel->v1);
    NphPlace place;
    for (int m = 0; m < q->scene->local.medium_count; m++)
        for (int c = 0; c < 3; c++)
            for (int k = 0; k < NPH_NODES; k++) weights->of[m][c][k] = 0.0;
    t = t > profile->begin ? t : profile->begin;
    end = end < profile->end ? end : profile->end;
    nph_profile_seek(profile, t, &place);
    while (t < end) {
        double e = nph_profile_move(profile, &place, t, end);
        while (place.active && t < e) {
            double thin = nph_profile_thin(profile, &place, t, e);
            if (q->beam->point) thin = near_point(q, t, thin);
            for (int g = 0; g < NPH_GAUSS; g++)
                add_point(q, panel, &place, t + (thin - t) * nph_gauss_point[g], (thin - t) * nph_gauss_weight[g],
                          weights);
            t = thin;
        }
        t = e;
    }
}

/* Value and error of a panel whose nodes are known; and the sums of the integral with it. */
static void sum_panel(Integral *q, NphPanel *panel) {
    const RScene *scene = &q->scene->local;
    Weights weights;
    weigh(q, panel, &weights);
    for (int c = 0; c < 3; c++) panel->value[c] = panel->error[c] = 0.0;
    for (int m = 0; m < scene->medium_count; m++) {
        double phase[NPH_NODES];
        for (int k = 0; k < NPH_NODES; k++) phase[k] = phase_node(q, panel, m, k);
        for (int c = 0; c < scene->channels; c++) {
            const double *w = weights.of[m][c];
            double f[NPH_NODES];
            for (int k = 0; k < NPH_NODES; k++) {
                f[k] = phase[k] * panel->T[k][c];
                panel->value[c] += w[k] * f[k];
            }
            double off1 = f[1] - (0.375 * f[0] + 0.75 * f[2] - 0.125 * f[4]);
            double off3 = f[3] - (0.375 * f[4] + 0.75 * f[2] - 0.125 * f[0]);
            panel->error[c] += nph_abs(w[1] * off1) + nph_abs(w[3] * off3);
        }
    }
    for (int c = 0; c < scene->channels; c++) {
        q->value[c] += panel->value[c];
        q->error[c] += panel->error[c];
    }
}

/* Narrows [lo, hi] around a shadow's edge to what rounding leaves; `lit` tells what it is like at lo. */
static void find_edge(const Integral *q, int lit, double *lo, double *hi) {
    for (;;) {
        double middle = 0.5 * (*lo + *hi);
        if (!(middle > *lo && middle < *hi)) return;
        if (is_lit(q, middle) == lit)
            *lo = middle;
        else
            *hi = middle;
    }
}

static void copy_node(NphPanel *panel, int k, const NphPanel *from, int j) {
    panel->lit[k] = from->lit[j];
    for (int c = 0; c < 3; c++) panel->T[k][c] = from->T[j][c];
}

static double key_of(const Integral *q, const NphPanel *panel) {
    double key = 0.0;
    for (int c = 0; c < q->scene->local.channels; c++) {
        double share = panel->error[c] / (nph_abs(q->value[c]) > 1e-290 ? nph_abs(q->value[c]) : 1e-290);
        key = share > key ? share : key;
    }
    return key;
}

static void heap_down(Integral *q, int at) {
    int32_t *heap = q->scratch->heap;
    const NphPanel *panels = q->scratch->panels;
    for (;;) {
        int largest = at;
        for (int child = 2 * at + 1; child < 2 * at + 3 && child < q->count; child++)
            if (panels[heap[child]].key > panels[heap[largest]].key) largest = child;
        if (largest == at) return;
        int32_t swap = heap[at];
        heap[at] = heap[largest];
        heap[largest] = swap;
        at = largest;
    }
}

static void heap_up(Integral *q, int at) {
    int32_t *heap = q->scratch->heap;
    const NphPanel *panels = q->scratch->panels;
    while (at > 0 && panels[heap[at]].key > panels[heap[(at - 1) / 2]].key) {
        int32_t swap = heap[at];
        heap[at] = heap[(at - 1) / 2];
        heap[(at - 1) / 2] = swap;
        at = (at - 1) / 2;
    }
}

/* Panels from v = from to `to`, none longer than `length`. */
static void begin_lit(Integral *q, double from, double to, double length) {
    double wanted = nph_floor((to - from) / length) + 1.0;
    int room = NPH_SINGLE_PANELS_MAX - 1 - q->count, parts = wanted < (double)room ? (int)wanted : room;
    q->crowded |= parts < 1;
    for (int i = 0; i < parts; i++) {
        NphPanel *panel = &q->scratch->panels[q->count];
        panel->v0 = i == 0 ? from : from + (to - from) * (double)i / (double)parts;
        panel->v1 = i == parts - 1 ? to : from + (to - from) * (double)(i + 1) / (double)parts;
        for (int k = i > 0; k < NPH_NODES; k++) light_node(q, panel, k);
        if (i > 0) copy_node(panel, 0, panel - 1, NPH_NODES - 1);
        q->scratch->heap[q->count] = q->count;
        q->count++;
        sum_panel(q, panel);
    }
}

/* The same where surfaces may cast shadows: probed at sixteen points of such a panel, cut where the light comes and
 * goes. */
static void begin_panels(Integral *q, double from, double to, double length) {
    if (q->scene->local.surfaces.count == 0) {
        begin_lit(q, from, to, length);
        return;
    }
    int probes = (int)nph_floor(16.0 * (to - from) / length) + 16, lit = is_lit(q, from);
    double start = from, last = from;
    for (int i = 1; i <= probes; i++) {
        double v = i == probes ? to : from + (to - from) * (double)i / (double)probes;
        int now = is_lit(q, v);
        if (now != lit) {
            double lo = last, hi = v;
            find_edge(q, lit, &lo, &hi);
            if (lit) begin_lit(q, start, lo, length);
            start = hi;
            lit = now;
        }
        last = v;
    }
    if (lit) begin_lit(q, start, to, length);
}

/* The same, with panels that end where shadows in air do, and are as fine in a shadow as they are along a cloud alone. */
static void begin_shadows(Integral *q, double from, double to, double length) {
    while (q->shadows > 0 && from < to) {
        double next = to, fine = length;
        for (int i = 0; i < q->shadows; i++) {
            const double *shadow = q->shadow[i];
            int begun = !(shadow[0] > from), over = !(shadow[1] > from);
            double end = begun ? shadow[1] : shadow[0], own = (shadow[1] - shadow[0]) / (double)q->scene->panels;
            if (over) continue;
            next = end < next ? end : next;
            fine = begun && own < fine ? own : fine;
        }
        begin_panels(q, from, next, fine);
        from = next;
    }
    if (from < to) begin_panels(q, from, to, length);
}

static void find_shadows(Integral *q) {
    const RScene *local = &q->scene->local;
    int air = 0;
    for (int m = 0; m < local->medium_count; m++) air |= local->media[m].shape == NPH_SHAPE_AIR;
    for (int m = 0; m < local->medium_count && air && !q->beam->point; m++) {
        const RMedium *medium = &local->media[m];
        int ends = medium->shape == NPH_SHAPE_GRID || medium->shape == NPH_SHAPE_BOX;
        if (ends && !medium->period.on) q->shadows += nph_shadow_on_ray(medium, q->p, q->d, q->beam->d, q->shadow[q->shadows]);
    }
}

/* What the panels to begin with look like. */
typedef struct Cuts {
    double first, last; /* where there is a medium */
    int pieces;         /* to a panel, at most */
    int gaps;           /* panels end where nothing scatters */
} Cuts;

/* Of P pieces come at most 2 P ends of pieces: the panels to begin with stay below three quarters of all. */
static Cuts cuts_of(const Integral *q) {
    const NphProfile *profile = &q->scratch->profile;
    Cuts cuts = {profile->end, profile->begin, 16, 1};
    int pieces = 0;
    for (int m = 0; m < q->scene->fields; m++) { /* glows too: their pieces are cuts */
        int count = profile->count[m];
        if (count == 0) continue;
        pieces += count;
        cuts.first = profile->pieces[m][0].t0 < cuts.first ? profile->pieces[m][0].t0 : cuts.first;
        cuts.last = profile->pieces[m][count - 1].t1 > cuts.last ? profile->pieces[m][count - 1].t1 : cuts.last;
    }
    cuts.gaps = pieces <= NPH_SINGLE_PANELS_MAX / 4;
    while (2 * pieces > cuts.pieces * (NPH_SINGLE_PANELS_MAX / 4)) cuts.pieces *= 2;
    cuts.first = cuts.first > profile->begin ? cuts.first : profile->begin;
    cuts.last = cuts.last < profile->end ? cuts.last : profile->end;
    return cuts;
}

static void begin(Integral *q) {
    const NphProfile *profile = &q->scratch->profile;
    Cuts cuts = cuts_of(q);
    if (!(cuts.first < cuts.last)) return;
    double length = (v_of(q, cuts.last) - v_of(q, cuts.first)) / (double)q->scene->panels, t = cuts.first, from = t;
    int pieces = 0;
    NphPlace place;
    nph_profile_seek(profile, t, &place);
    while (t < cuts.last) {
        double e = nph_profile_move(profile, &place, t, cuts.last);
        if (!(e > t)) break;
        int gap = cuts.gaps && !place.active;
        if (pieces == 0) from = t;
        pieces += !gap;
        if (pieces && (gap || pieces == cuts.pieces)) {
            begin_shadows(q, v_of(q, from), v_of(q, gap ? t : e), length);
            pieces = 0;
        }
        t = e;
    }
    if (pieces) begin_shadows(q, v_of(q, from), v_of(q, t), length);
}

static int is_converged(const Integral *q) {
    for (int c = 0; c < q->scene->local.channels; c++)
        if (q->error[c] > q->scene->tolerance * nph_abs(q->value[c])) return 0;
    return 1;
}

/* Where to cut a panel: in the middle, or at the edge of a shadow, which lies between *left and *right. */
static void cut(const Integral *q, const NphPanel *panel, double *left, double *right) {
    for (int k = 0; k + 1 < NPH_NODES; k++) {
        if (panel->lit[k] == panel->lit[k + 1]) continue;
        *left = node_of(panel, k);
        *right = node_of(panel, k + 1);
        find_edge(q, panel->lit[k], left, right);
        if (*left > panel->v0 && *right < panel->v1) return;
    }
    *left = *right = 0.5 * (panel->v0 + panel->v1);
}

/* Cuts the panel on top of the heap; one that cannot be cut is not looked at again. */
static void halve(Integral *q) {
    NphPanel *panels = q->scratch->panels;
    int32_t *heap = q->scratch->heap;
    NphPanel whole = panels[heap[0]], *left = &panels[heap[0]], *right = &panels[q->count];
    if (!(whole.v1 - whole.v0 > 1e-13 * (nph_abs(whole.v0) + nph_abs(whole.v1)))) {
        left->key = 0.0;
        heap_down(q, 0);
        return;
    }
    for (int c = 0; c < q->scene->local.channels; c++) {
        q->value[c] -= whole.value[c];
        q->error[c] -= whole.error[c];
    }
    cut(q, &whole, &left->v1, &right->v0);
    right->v1 = whole.v1;
    int even = left->v1 == right->v0 && left->v1 == 0.5 * (whole.v0 + whole.v1); /* every other node is known */
    for (int k = 0; k < NPH_NODES; k++) {
        if (even && k % 2 == 0) {
            copy_node(left, k, &whole, k / 2);
            copy_node(right, k, &whole, 2 + k / 2);
        } else {
            light_node(q, left, k);
            light_node(q, right, k);
        }
    }
    sum_panel(q, left);
    sum_panel(q, right);
    left->key = key_of(q, left);
    right->key = key_of(q, right);
    heap_down(q, 0);
    heap[q->count] = q->count;
    heap_up(q, q->count++);
}

void nph_single_integrate(const NphSingleScene *scene, NphSingleScratch *scratch, const double p[3], const double d[3],
                          const NphBeam *beam, double result[3], double error[3]) {
    Integral q = {.scene = scene, .scratch = scratch, .beam = beam, .p = p, .d = d};
    if (beam->point) {
        double squared = 0.0, reach = 0.0;
        for (int a = 0; a < 3; a++) q.middle += (beam->position[a] - p[a]) * d[a];
        for (int a = 0; a < 3; a++) {
            double off = beam->position[a] - p[a] - q.middle * d[a];
            squared += off * off;
            reach += nph_abs(beam->position[a] - p[a]);
        }
        q.off = r_sqrt(squared);
        q.off = q.off > 1e-9 * reach ? q.off : 1e-9 * reach; /* a ray through the light itself would be infinite */
    }
    find_shadows(&q);
    begin(&q);
    if (q.count == 0) return;
    scratch->tally.integrals++;
    for (int i = 0; i < q.count; i++) scratch->panels[i].key = key_of(&q, &scratch->panels[i]);
    for (int i = q.count / 2 - 1; i >= 0; i--) heap_down(&q, i);
    while (!is_converged(&q) && q.count < NPH_SINGLE_PANELS_MAX && scratch->panels[scratch->heap[0]].key > 0.0)
        halve(&q);
    double worst = q.crowded ? 1.0 : 0.0;
    for (int c = 0; c < scene->local.channels; c++) { /* sums anew: nothing left over from what was subtracted */
        double value = 0.0, remains = 0.0;
        for (int i = 0; i < q.count; i++) {
            value += scratch->panels[i].value[c];
            remains += scratch->panels[i].error[c];
        }
        result[c] += value;
        error[c] += remains;
        if (remains > scene->tolerance * nph_abs(value)) {
            double part = value > 0.0 ? remains / value : 1.0;
            worst = part > worst ? part : worst;
        }
    }
    if (!(worst > 0.0)) return;
    scratch->tally.unconverged++;
    scratch->tally.worst = worst > scratch->tally.worst ? worst : scratch->tally.worst;
}
