/* SPDX-License-Identifier: Apache-2.0
 *
 * tpm.trace: a block's photons through the medium, all at once, one tentative event after another [Elek12 sec. 4.1.1].
 *
 * A beam starts at a scattering (or at the border) and runs along one direction through tentative events at the rate of the
 * majorant s_T. Of every one, real or not, w / s_T is the part of the beam's path length that falls to its cell, where w is what
 * the earlier ones have left: w_1 = 1, w_(i+1) = w_i (1 - s / s_T). The first that is real, with probability s / s_T, is where
 * the photon scatters and its next beam starts; the beam itself runs on to the border, or until less than `threshold` is left.
 *
 * Lanes do not see each other, and deposits are added in the order of the lanes, whatever the width of vectors. Where a photon is
 * over, the last one takes its lane. Random words: counter (photon, sample, scatterings, event / 2). */
#include <string.h>

#include "method/temporal_photons/tpm_state.h"

size_t NPH_KERNEL(nph_tpm_trace_bytes)(int64_t cells, int shared);
void NPH_KERNEL(nph_tpm_trace)(const void *memory, const NphTpmBlock *block);

enum { LANES = NPH_TPM_BLOCK };

/* What a lane does next. */
enum { FLIES, SCATTERS, OVER };

typedef struct Lanes {
    Real u[3][LANES], du[3][LANES]; /* the medium's space; per metre */
    Real d[3][LANES];               /* scene-local */
    Real next[3][LANES];            /* the first real event, once found */
    Real left[LANES], collided[LANES];
    Real inverse[LANES], gain[LANES];
    Real flux[3][LANES];
    int32_t found[LANES], deposits[LANES], state[LANES], cell[2][LANES], reduced[LANES];
    Real amount[2][LANES];
    uint32_t photon[LANES], order[LANES], draw[LANES];
    Real value[LANES][8];           /* what a deposit of weight 1 adds to a cell; NPH_TPM_VALUES of them */
} Lanes;

/* Lanes that scatter, gathered. */
typedef struct Turns {
    uint32_t photon[LANES], order[LANES];
    Real d[3][LANES], g[LANES], rest[LANES], chance[LANES];
    int32_t lane[LANES];
    int count;
} Turns;

typedef struct Tracer {
    const RTpmScene *scene;
    const NphTpmBlock *block;
    Lanes lanes;
    Turns turns;
    int alive;
    Real grid[]; /* [cell][NPH_TPM_VALUES], where blocks have one */
} Tracer;

size_t NPH_KERNEL(nph_tpm_trace_bytes)(int64_t cells, int shared) {
    return sizeof(Tracer) + (shared ? (size_t)cells * NPH_TPM_VALUES * sizeof(Real) : 0);
}

static uint32_t key_of(const Tracer *t, uint32_t stage) { return stage << 24 | (t->block->generation & 0xffffffu); }

/* In units of fixed point, to the nearest. */
static int64_t units_of(const Tracer *t, double value) {
    double scaled = value * t->scene->scale;
    if (!(nph_abs(scaled) < 4611686018427387904.0)) {
        if (scaled != scaled) t->block->ledger->nonfinite++;
        else t->block->ledger->overflow++;
        return 0;
    }
    return (int64_t)(scaled + (scaled < 0.0 ? -0.5 : 0.5));
}

static double energy_of(const Lanes *l, int i) {
    return ((double)l->flux[0][i] + (double)l->flux[1][i] + (double)l->flux[2][i]) * (1.0 / 3.0);
}

/* The march scatters what is deposited once more. */
static int is_shown(int orders, uint32_t order) {
    return orders == 0 || (orders < 3 ? order + 1u == (uint32_t)orders : order + 1u >= 3u);
}

/* A beam starts: what its deposits are. */
static void begin_beam(Tracer *t, int i) {
    const RTpmScene *scene = t->scene;
    Lanes *l = &t->lanes;
    const Real *towards = scene->towards[t->block->kind];
    Real flux[3] = {l->flux[0][i], l->flux[1][i], l->flux[2][i]}, bright = r_luminance(flux);
    Real cosine = l->d[0][i] * towards[0] + l->d[1][i] * towards[1] + l->d[2][i] * towards[2];
    Real order = (Real)l->order[i], *value = l->value[i];
    int reduced = scene->similarity && l->order[i] >= (uint32_t)scene->switch_order;
    for (int a = 0; a < 3; a++) {
        const Real *row = scene->medium.from_local + 4 * a;
        l->du[a][i] = row[0] * l->d[0][i] + row[1] * l->d[1][i] + row[2] * l->d[2][i];
        value[a] = flux[a];
    }
    value[NPH_TPM_COSINE] = scene->paper ? cosine : bright * cosine;
    value[NPH_TPM_ORDER] = scene->paper ? order : bright * order;
    value[NPH_TPM_COUNT] = scene->paper ? R(1.0) : R(0.0);
    l->reduced[i] = reduced;
    l->inverse[i] = scene->inverse_majorant[reduced];
    l->gain[i] = is_shown(scene->orders, l->order[i]) ? scene->gain[reduced] : R(0.0);
    l->left[i] = R(1.0);
    l->collided[i] = R(0.0);
    l->found[i] = 0;
    l->deposits[i] = 1;
    l->draw[i] = 0;
    t->block->ledger->begun += units_of(t, energy_of(l, i));
    t->block->ledger->beams++;
}

static void emit(Tracer *t) {
    const RTpmScene *scene = t->scene;
    const NphTpmBlock *block = t->block;
    Lanes *l = &t->lanes;
    for (int i = 0; i < block->count; i++) {
        uint32_t photon = (uint32_t)(block->first + i);
        NphWords words = nph_philox(scene->local.seed, key_of(t, NPH_RNG_TPM_EMIT), photon, block->sample, (uint32_t)block->kind, 0);
        NphWords more = nph_philox(scene->local.seed, key_of(t, NPH_RNG_TPM_EMIT), photon, block->sample, (uint32_t)block->kind, 1);
        int number = scene->dominant;
        double chance = 1.0;
        if (block->kind == NPH_TPM_SKY) {
            number = r_cdf_find(scene->choose, scene->local.light_count, nph_uniform(words.w0));
            chance = scene->choose[number + 1] - scene->choose[number];
        }
        REntry entry = r_entry(&scene->local, number, chance, &scene->from[number], words, more);
        RSpan span = r_clip(&scene->medium, entry.p, entry.d, R_HUGE);
        Real start = span.inside ? span.near : R(0.0);
        for (int a = 0; a < 3; a++) {
            Real u = span.o[a] + start * span.d[a];
            l->u[a][i] = span.inside ? r_clamp(u, scene->medium.lo[a], scene->medium.hi[a]) : R_FAR;
            l->d[a][i] = entry.d[a];
            l->flux[a][i] = (Real)((double)entry.flux[a] / scene->unit * block->relative);
        }
        l->photon[i] = photon | (uint32_t)block->kind << 31;
        l->order[i] = 0;
        begin_beam(t, i);
        block->ledger->emitted += units_of(t, energy_of(l, i));
    }
    t->alive = block->count;
    block->ledger->photons += block->count;
}

typedef struct Flight {
    int32_t n[3];
    Real lo[3], hi[3], cell_lo[3], per_unit[3], inverse_density, threshold;
    uint32_t key0, key1, sample;
} Flight;

/* The state of a lane while it flies. */
typedef struct Lane {
    Real x, y, z, left, collided, next0, next1, next2;
    int inside, found, deposits;
} Lane;

/* One tentative event: word for its distance, decision whether it is real. Comparisons are joined by & and lookups always made,
 * so that no lane branches. */
R_INLINE Lane event(Lane lane, Lanes *restrict l, int i, int e, const Flight *f, const RGrid *lattice, int grid, uint32_t word,
                    uint32_t decision) {
    Real length = -r_log(R(1.0) - r_uniform(word)) * l->inverse[i];
    lane.x += length * l->du[0][i];
    lane.y += length * l->du[1][i];
    lane.z += length * l->du[2][i];
    lane.inside &= (lane.x >= f->lo[0]) & (lane.x < f->hi[0]) & (lane.y >= f->lo[1]) & (lane.y < f->hi[1]) & (lane.z >= f->lo[2]) &
                   (lane.z < f->hi[2]);
    Real u = lane.inside ? lane.x : f->lo[0], v = lane.inside ? lane.y : f->lo[1], w = lane.inside ? lane.z : f->lo[2];
    Real part = grid ? r_grid_value(lattice, u, v, w) * f->inverse_density : R(1.0);
    int hits = lane.inside & (lane.found ^ 1) & (r_uniform(decision) < part), adds = lane.inside & lane.deposits;
    lane.next0 = hits ? lane.x : lane.next0;
    lane.next1 = hits ? lane.y : lane.next1;
    lane.next2 = hits ? lane.z : lane.next2;
    lane.found |= hits;
    int32_t c0 = (int32_t)((u - f->cell_lo[0]) * f->per_unit[0]), c1 = (int32_t)((v - f->cell_lo[1]) * f->per_unit[1]);
    int32_t c2 = (int32_t)((w - f->cell_lo[2]) * f->per_unit[2]);
    c0 = c0 < f->n[0] ? c0 : f->n[0] - 1;
    c1 = c1 < f->n[1] ? c1 : f->n[1] - 1;
    c2 = c2 < f->n[2] ? c2 : f->n[2] - 1;
    int32_t cell = (c2 * f->n[1] + c1) * f->n[0] + c0;
    Real lost = (adds ? lane.left : R(0.0)) * part;
    l->cell[e][i] = adds ? cell : -1;
    l->amount[e][i] = lane.left * l->gain[i];
    lane.collided += lost;
    lane.left -= lost;
    lane.deposits = lane.left < f->threshold ? 0 : lane.deposits;
    return lane;
}

/* Two events for every lane. */
R_INLINE void fly_lanes(Lanes *restrict l, const Flight *from, const RGrid *lattice, int grid, int alive) {
    const Flight f = *from;
    const RGrid view = *lattice;
    int count = r_whole_vectors(alive);
    for (int i = 0; i < count; i++) { /* vec */
        NphWords words = nph_philox(f.key0, f.key1, l->photon[i], f.sample, l->order[i], l->draw[i]);
        Lane lane = {l->u[0][i],    l->u[1][i],    l->u[2][i],    l->left[i], l->collided[i], l->next[0][i],
                     l->next[1][i], l->next[2][i], 1,             l->found[i], l->deposits[i]};
        lane = event(lane, l, i, 0, &f, &view, grid, words.w0, words.w1);
        lane = event(lane, l, i, 1, &f, &view, grid, words.w2, words.w3);
        l->u[0][i] = lane.x;
        l->u[1][i] = lane.y;
        l->u[2][i] = lane.z;
        l->next[0][i] = lane.next0;
        l->next[1][i] = lane.next1;
        l->next[2][i] = lane.next2;
        l->left[i] = lane.left;
        l->collided[i] = lane.collided;
        l->found[i] = lane.found;
        l->deposits[i] = lane.deposits;
        l->draw[i] += 1u;
        int over = (lane.inside ^ 1) | (lane.found & (lane.deposits ^ 1)), then = lane.found ? SCATTERS : OVER;
        l->state[i] = over ? then : FLIES;
    }
}

R_OUTLINE void fly_grid(Lanes *restrict l, const Flight *restrict f, const RGrid *restrict lattice, const int32_t *restrict brick_index,
                        const float *restrict values, int alive) {
    RGrid view = *lattice;
    view.brick_index = brick_index;
    view.values = values;
    fly_lanes(l, f, &view, 1, alive);
}

R_OUTLINE void fly_box(Lanes *restrict l, const Flight *restrict f, const RGrid *restrict lattice, int alive) {
    fly_lanes(l, f, lattice, 0, alive);
}

static void fly(Tracer *t, const Flight *flight) {
    const RGrid *grid = &t->scene->medium.grid;
    if (t->scene->medium.shape == NPH_SHAPE_GRID) fly_grid(&t->lanes, flight, grid, grid->brick_index, grid->values, t->alive);
    else fly_box(&t->lanes, flight, grid, t->alive);
}

static void deposit(Tracer *t) {
    const Lanes *l = &t->lanes;
    int64_t count = 0;
    for (int i = 0; i < t->alive; i++)
        for (int e = 0; e < 2; e++) {
            int32_t cell = l->cell[e][i];
            Real amount = l->amount[e][i];
            if (cell < 0) continue;
            count++;
            Real *at = t->grid + (int64_t)cell * NPH_TPM_VALUES;
            const Real *value = l->value[i];
            for (int v = 0; v < 4; v++) at[v] += amount * value[v];
            for (int v = 4; v < NPH_TPM_VALUES; v++) at[v] += amount * value[v];
        }
    t->block->ledger->deposits += count;
}

/* Without a grid of the block's own. */
static void deposit_each(Tracer *t) {
    const Lanes *l = &t->lanes;
    for (int i = 0; i < t->alive; i++)
        for (int e = 0; e < 2; e++) {
            if (l->cell[e][i] < 0) continue;
            int64_t *at = t->block->partial + (int64_t)l->cell[e][i] * NPH_TPM_VALUES;
            for (int v = 0; v < NPH_TPM_VALUES; v++) at[v] += units_of(t, (double)(l->amount[e][i] * l->value[i][v]));
            t->block->ledger->deposits++;
        }
}

static void end_beam(Tracer *t, int i) {
    const Lanes *l = &t->lanes;
    NphTpmLedger *ledger = t->block->ledger;
    double energy = energy_of(l, i);
    ledger->collided += units_of(t, energy * (double)l->collided[i]);
    if (l->deposits[i]) ledger->past += units_of(t, energy * (double)l->left[i]);
    else ledger->cut += units_of(t, energy * (double)l->left[i]);
}

static void copy_lane(Lanes *l, int to, int from) {
    for (int a = 0; a < 3; a++) {
        l->u[a][to] = l->u[a][from];
        l->du[a][to] = l->du[a][from];
        l->d[a][to] = l->d[a][from];
        l->next[a][to] = l->next[a][from];
        l->flux[a][to] = l->flux[a][from];
    }
    l->left[to] = l->left[from];
    l->collided[to] = l->collided[from];
    l->inverse[to] = l->inverse[from];
    l->gain[to] = l->gain[from];
    l->found[to] = l->found[from];
    l->deposits[to] = l->deposits[from];
    l->state[to] = l->state[from];
    l->reduced[to] = l->reduced[from];
    l->photon[to] = l->photon[from];
    l->order[to] = l->order[from];
    l->draw[to] = l->draw[from];
    memcpy(l->value[to], l->value[from], sizeof l->value[to]);
}

/* Directions of the lanes that scatter, and the word of their roulette. */
R_OUTLINE void turn(Turns *restrict turns, uint32_t key0, uint32_t key1, uint32_t sample, int number) {
    int count = r_whole_vectors(number);
    for (int k = 0; k < count; k++) { /* vec */
        NphWords words = nph_philox(key0, key1, turns->photon[k], sample, turns->order[k], 0);
        Real d[3] = {turns->d[0][k], turns->d[1][k], turns->d[2][k]}, out[3];
        RAngle angle = r_hg_sample(turns->g[k], turns->rest[k], r_uniform(words.w0));
        r_turn_by(d, angle, r_uniform(words.w1), out);
        turns->d[0][k] = out[0];
        turns->d[1][k] = out[1];
        turns->d[2][k] = out[2];
        turns->chance[k] = r_uniform(words.w3);
    }
}

/* What a scattering takes, and whether the photon lives on. */
static int survive(Tracer *t, int i, Real chance) {
    const RTpmScene *scene = t->scene;
    Lanes *l = &t->lanes;
    int reduced = l->reduced[i];
    double taken = 0.0;
    if (!(chance < scene->survival[reduced])) {
        t->block->ledger->absorbed += units_of(t, energy_of(l, i));
        return 0;
    }
    for (int c = 0; c < 3; c++) {
        Real keep = scene->albedo[reduced][c] / scene->survival[reduced];
        taken += (double)(l->flux[c][i] * (R(1.0) - keep)) * (1.0 / 3.0);
        l->flux[c][i] *= keep;
    }
    t->block->ledger->absorbed += units_of(t, taken);
    if (++l->order[i] < NPH_TPM_ORDER_MAX) return 1;
    t->block->ledger->stopped += units_of(t, energy_of(l, i));
    return 0;
}

static void gather(Tracer *t) {
    const RTpmScene *scene = t->scene;
    Lanes *l = &t->lanes;
    Turns *turns = &t->turns;
    turns->count = 0;
    for (int i = 0; i < t->alive; i++) {
        if (l->state[i] == FLIES) continue;
        end_beam(t, i);
        if (l->state[i] == OVER) {
            t->block->ledger->escaped += units_of(t, energy_of(l, i));
            continue;
        }
        int k = turns->count++;
        /* after the switch, and where nothing else is known, all directions alike */
        int plain = l->reduced[i] || scene->medium.phase.kind != NPH_PHASE_HG;
        turns->lane[k] = i;
        turns->photon[k] = l->photon[i];
        turns->order[k] = l->order[i];
        turns->g[k] = plain ? R(0.0) : scene->medium.phase.g0;
        turns->rest[k] = plain ? R(1.0) : scene->medium.phase.rest0;
        for (int a = 0; a < 3; a++) turns->d[a][k] = l->d[a][i];
    }
}

static void scatter(Tracer *t) {
    Lanes *l = &t->lanes;
    Turns *turns = &t->turns;
    t->block->tally->collisions += turns->count;
    turn(turns, t->scene->local.seed, key_of(t, NPH_RNG_TPM_SCATTER), t->block->sample, turns->count);
    for (int k = 0; k < turns->count; k++) {
        int i = turns->lane[k];
        if (!survive(t, i, turns->chance[k])) {
            l->state[i] = OVER;
            continue;
        }
        for (int a = 0; a < 3; a++) {
            l->u[a][i] = l->next[a][i];
            l->d[a][i] = turns->d[a][k];
        }
        l->state[i] = FLIES;
        begin_beam(t, i);
    }
}

/* The block's grid joins the generation's. */
static void fold(Tracer *t, int64_t cells) {
    for (int64_t i = 0; i < cells * NPH_TPM_VALUES; i++)
        if (t->grid[i] != R(0.0)) t->block->partial[i] += units_of(t, (double)t->grid[i]);
}

void NPH_KERNEL(nph_tpm_trace)(const void *memory, const NphTpmBlock *block) {
    Tracer *t = block->scratch;
    const RTpmScene *scene = memory;
    const RMedium *medium = &scene->medium;
    int64_t cells = nph_tpm_cells(scene->coarse.n);
    t->scene = scene;
    t->block = block;
    for (int64_t i = 0; i < cells * NPH_TPM_VALUES && scene->shared; i++) t->grid[i] = R(0.0);
    Flight flight = {.inverse_density = R(1.0) / scene->density_max, .threshold = scene->threshold, .key0 = scene->local.seed,
                     .key1 = key_of(t, NPH_RNG_TPM_FLY), .sample = block->sample};
    for (int a = 0; a < 3; a++) {
        flight.n[a] = scene->coarse.n[a];
        flight.lo[a] = medium->lo[a];
        flight.hi[a] = medium->hi[a];
        flight.cell_lo[a] = scene->coarse.lo[a];
        flight.per_unit[a] = scene->coarse.per_unit[a];
    }
    emit(t);
    while (t->alive > 0) {
        fly(t, &flight);
        block->tally->tentative += 2 * (int64_t)t->alive;
        if (scene->shared) deposit(t);
        else deposit_each(t);
        gather(t);
        scatter(t);
        for (int i = 0; i < t->alive;)
            if (t->lanes.state[i] == OVER) copy_lane(&t->lanes, i, --t->alive);
            else i++;
    }
    if (scene->shared) fold(t, cells);
}
