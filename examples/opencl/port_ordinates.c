/* SPDX-License-Identifier: Apache-2.0
 *
 * pop.propagate (propagate.cl) of principal_ordinates: grids of directions and of points, any number of channels. The first iteration
 * starts from what the dump says that it was given; then two pairs of buffers take turns on the device, and every iteration is written
 * with what it really read. An iteration whose predecessor the dump has not starts from the dump again. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "grid.h"
#include "port.h"

enum { FLAT, RADIAL };                         /* kinds of grids */
enum { WAY, ROW = 12 };                        /* of a row of pop.ordinate: the way of the light or the place of the point; its length */
enum { INJECTED, LEFT, POWERS, LANES = 16 };   /* of pop.power; sums of add_up */

/* The medium's box, scene-local. */
typedef struct Box {
    double corner[8][3], side[3][3], middle[3];
} Box;

static Box box;
static double extinction[3], albedo[3], epsilon, inner;
static int cells[2][3], grids[2], channels, paths;
static float mean_cosine, observer[3];
static int parallel;

/* What the device holds while iterations follow each other. */
static struct {
    int64_t next;                              /* the iteration that is due; -1: nothing is loaded */
    int now;                                   /* which of the pairs is read */
    int parts;                                 /* grids times channels */
    Grid *grid;
    double *power;
    cl_mem density, light[2], cosine[2], seen;
} run = {.next = -1};

/* The scene ------------------------------------------------------------------------------------------------------------ */

static void read_box(void) {
    doubles("transport.corners", 24, &box.corner[0][0]);
    for (int a = 0; a < 3; a++) {
        double length = 0.0;
        for (int b = 0; b < 3; b++) {
            box.side[a][b] = box.corner[1 << a][b] - box.corner[0][b];
            length += box.side[a][b] * box.side[a][b];
        }
        for (int b = 0; b < 3; b++) box.side[a][b] /= sqrt(length);
        for (int k = 0; k < 8; k++) box.middle[a] += 0.125 * box.corner[k][a];
    }
}

static void read_scene(void) {
    static const char *const shapes[2] = {"transport.flat_cells", "transport.radial_cells"};
    double values[3];
    if (nph_dump_run_options(port.run)->precision != 32 || number("knobs.pop.variant", 1) > 0)
        stop(NPH_BAD_INPUT, "these kernels know the corrected variant in f32, pop.variant 0");
    for (int kind = 0; kind < 2; kind++) {
        doubles(shapes[kind], 3, values);
        for (int a = 0; a < 3; a++) cells[kind][a] = (int)values[a];
    }
    doubles("transport.grids_of_suns_sky_points", 3, values);
    grids[FLAT] = (int)(values[0] + values[1]);
    grids[RADIAL] = (int)values[2];
    channels = (int)number("transport.propagated_channels", 1);
    if (number("transport.virtual_points", 0) > 0) stop(NPH_BAD_INPUT, "these kernels know no virtual point lights: pop.vpls=0 leaves them out");
    read_box();
    doubles("media.0.extinction_per_m", 3, extinction);
    doubles("media.0.albedo", 3, albedo);
    numbers("transport.mean_cosine", 1, &mean_cosine);
    numbers("transport.observer", 3, observer);
    parallel = number("transport.observer_parallel", 0) > 0;
    epsilon = (float)number("knobs.pop.epsilon_l", 0);
    inner = (float)number("knobs.pop.inner", 0);
    paths = number("knobs.pop.paths", 1) > 0.5;
}

/* Grids: in double, rounded once --------------------------------------------------------------------------------------- */

/* Along the way of the light; across, one axis lies near to that side of the medium which is most across. */
static void find_axes(const double way[3], double axis[3][3]) {
    double best = 2.0, length = 0.0, along = 0.0;
    int across = 0;
    for (int s = 0; s < 3; s++) {
        const double *side = box.side[s];
        double size = fabs(side[0] * way[0] + side[1] * way[1] + side[2] * way[2]);
        if (size >= best - 1e-6) continue;
        best = size;
        across = s;
    }
    for (int a = 0; a < 3; a++) along += box.side[across][a] * way[a];
    for (int a = 0; a < 3; a++) {
        axis[2][a] = way[a];
        axis[0][a] = box.side[across][a] - along * way[a];
        length += axis[0][a] * axis[0][a];
    }
    for (int a = 0; a < 3; a++) axis[0][a] /= sqrt(length);
    for (int a = 0; a < 3; a++) {
        int b = (a + 1) % 3, c = (a + 2) % 3;
        axis[1][a] = axis[2][b] * axis[0][c] - axis[2][c] * axis[0][b];
    }
}

/* The box that the medium's has along the axes; cells that are no cubes have another cone to the next one. */
static void prepare_flat(const double way[3], Grid *grid) {
    double axis[3][3], edge[3];
    find_axes(way, axis);
    for (int b = 0; b < 3; b++) {
        double lo = 1e300, hi = -1e300;
        for (int k = 0; k < 8; k++) {
            double at = 0.0;
            for (int a = 0; a < 3; a++) at += (box.corner[k][a] - box.middle[a]) * axis[b][a];
            lo = at < lo ? at : lo;
            hi = at > hi ? at : hi;
        }
        edge[b] = (hi - lo) / (double)grid->n[b];
        grid->middle[b] = (float)box.middle[b];
        grid->low[b] = (float)lo;
        grid->edge[b] = (float)edge[b];
        for (int a = 0; a < 3; a++) grid->axis[3 * b + a] = (float)axis[b][a];
    }
    double turn = acos(edge[0] / sqrt(edge[0] * edge[0] + edge[1] * edge[1])) * 0.31830988618379067; /* half the angle of an x face, over pi */
    grid->cone = (float)(edge[2] / sqrt(edge[2] * edge[2] + edge[0] * edge[1]));
    grid->side[0] = (float)turn;
    grid->side[1] = (float)(0.5 - turn);
    for (int a = 0; a < 2 && paths; a++) grid->wide += 2.0f * grid->side[a] * (grid->edge[a] / grid->edge[2] - 1.0f);
}

/* Shells around a point, from the nearest place of the medium's box, or from a part of the farthest's distance, to the farthest. */
static void prepare_radial(const double place[3], Grid *grid) {
    double close = 0.0, distant = 0.0, solid = 0.0;
    for (int k = 0; k < 8; k++) {
        double square = 0.0;
        for (int a = 0; a < 3; a++) square += (box.corner[k][a] - place[a]) * (box.corner[k][a] - place[a]);
        distant = square > distant ? square : distant;
    }
    for (int a = 0; a < 3; a++) {
        double at = 0.0, half = 0.0;
        for (int b = 0; b < 3; b++) at += (place[b] - box.middle[b]) * box.side[a][b];
        for (int b = 0; b < 3; b++) half += 0.5 * (box.corner[1 << a][b] - box.corner[0][b]) * box.side[a][b];
        double off = fabs(at) > half ? fabs(at) - half : 0.0;
        close += off * off;
        grid->middle[a] = (float)place[a];
    }
    distant = sqrt(distant) * 1.0001;
    close = sqrt(close) * 0.9999;
    double innermost = close > inner * distant ? close : inner * distant;
    grid->inner = (float)innermost;
    grid->log_ratio = (float)(log(distant / innermost) / (double)grid->n[2]);
    for (int y = 0; y < grid->n[1]; y++)
        for (int x = 0; x < grid->n[0]; x++) {
            float u = 2.0f * ((float)x + 0.5f) / (float)grid->n[0] - 1.0f, v = 2.0f * ((float)y + 0.5f) / (float)grid->n[1] - 1.0f;
            solid += (double)octahedron_solid(u, v, grid->n[0]);
        }
    grid->per_solid = (float)((double)grid->n[0] * (double)grid->n[1] / solid);
    grid->cone = 0.70710678118654752f;
    grid->side[0] = grid->side[1] = 0.25f;
}

static int cells_of(int kind) { return cells[kind][0] * cells[kind][1] * cells[kind][2]; }

/* A channel of a grid. */
static Grid grid_of(const float *row, int which, int channel) {
    int kind = which < grids[FLAT] ? FLAT : RADIAL, before = kind == FLAT ? which : grids[FLAT];
    Grid grid = {.radial = kind == RADIAL, .g = mean_cosine, .thick = paths ? 0.0f : 1.0f, .parallel = parallel};
    double way[3] = {(double)row[WAY], (double)row[WAY + 1], (double)row[WAY + 2]};
    for (int a = 0; a < 3; a++) {
        grid.n[a] = cells[kind][a];
        grid.observer[a] = observer[a];
    }
    grid.first_cell = before * cells_of(FLAT) + (which - before) * cells_of(RADIAL);
    grid.first_number = channels * grid.first_cell + channel * cells_of(kind);
    grid.sigma_a = (float)(extinction[channel] * (1.0 - albedo[channel]));
    grid.sigma_s = (float)(extinction[channel] * albedo[channel]);
    grid.thin = paths ? 0.5f * (grid.sigma_a + grid.sigma_s * (1.0f - grid.g)) : 0.0f;
    (kind == FLAT ? prepare_flat : prepare_radial)(way, &grid);
    return grid;
}

/* Iterations ----------------------------------------------------------------------------------------------------------- */

static void release(void) {
    if (run.next < 0) return;
    cl_mem all[] = {run.density, run.light[0], run.light[1], run.cosine[0], run.cosine[1], run.seen};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) clReleaseMemObject(all[i]);
    free(run.grid);
    free(run.power);
    run.next = -1;
}

static cl_mem loaded(int64_t index, const char *buffer, int64_t count) {
    NphArray array = array_of(index, buffer);
    if (nph_array_count(&array) != count)
        stop(NPH_BAD_INPUT, "%s: %lld numbers, but the manifest makes it %lld", buffer, (long long)nph_array_count(&array), (long long)count);
    cl_mem made = upload(array.data, (size_t)count * 4);
    nph_array_free(port.context, &array);
    return made;
}

/* From what the dump says that the launch was given. */
static void load(int64_t index) {
    NphArray ordinate = array_of(index, "pop.ordinate"), power = array_of(index, "pop.power");
    int64_t count = (int64_t)grids[FLAT] * cells_of(FLAT) + (int64_t)grids[RADIAL] * cells_of(RADIAL), all = count * channels;
    run.parts = (grids[FLAT] + grids[RADIAL]) * channels;
    if (nph_array_count(&ordinate) != (int64_t)(grids[FLAT] + grids[RADIAL]) * ROW || nph_array_count(&power) != (int64_t)run.parts * POWERS)
        stop(NPH_BAD_INPUT, "pop.ordinate, pop.power: other shapes than the manifest makes them");
    run.grid = calloc((size_t)run.parts, sizeof *run.grid);
    run.power = calloc((size_t)run.parts, POWERS * sizeof *run.power);
    if (!run.grid || !run.power) stop(NPH_NO_MEMORY, "no memory for %d grids", run.parts);
    for (int p = 0; p < run.parts; p++)
        run.grid[p] = grid_of((const float *)ordinate.data + (ptrdiff_t)(p / channels) * ROW, p / channels, p % channels);
    memcpy(run.power, power.data, (size_t)run.parts * POWERS * sizeof *run.power);
    run.density = loaded(index, "pop.density", count);
    run.light[0] = loaded(index, "pop.light", all);
    run.cosine[0] = loaded(index, "pop.cosine", all);
    run.seen = loaded(index, "pop.seen", all);
    run.light[1] = upload(NULL, (size_t)all * 4);
    run.cosine[1] = upload(NULL, (size_t)all * 4);
    run.now = 0;
    nph_array_free(port.context, &ordinate);
    nph_array_free(port.context, &power);
}

static void record_state(int which) {
    const Grid *last = &run.grid[run.parts - 1];
    int64_t all = last->first_number + (int64_t)last->n[0] * last->n[1] * last->n[2];
    record_from("pop.light", NPH_F32, 1, &all, run.light[which], 0);
    record_from("pop.cosine", NPH_F32, 1, &all, run.cosine[which], 0);
    record_from("pop.seen", NPH_F32, 1, &all, run.seen, 0);
    record("pop.power", NPH_F64, 3, (int64_t[]){run.parts / channels, channels, POWERS}, run.power);
}

/* A grid's channel whose light has fallen below epsilon of what was injected stands still. */
static void prepare_iteration(int64_t iteration) {
    for (int p = 0; p < run.parts; p++) {
        const double *power = run.power + (ptrdiff_t)p * POWERS;
        run.grid[p].still = !(power[LEFT] > epsilon * power[INJECTED]);
        run.grid[p].shown = iteration > 0 ? 1.0f : 0.5f;
    }
}

static void iterate(int then) {
    int most = grids[FLAT] && (!grids[RADIAL] || cells_of(FLAT) > cells_of(RADIAL)) ? cells_of(FLAT) : cells_of(RADIAL);
    cl_mem grid = upload(run.grid, (size_t)run.parts * sizeof *run.grid), sums = upload(NULL, (size_t)run.parts * LANES * 4);
    float *sum = calloc((size_t)run.parts, LANES * sizeof *sum);
    if (!sum) stop(NPH_NO_MEMORY, "no memory for sums");
    const cl_mem *all[7] = {&grid, &run.density, &run.light[run.now], &run.cosine[run.now], &run.light[then], &run.cosine[then], &run.seen};
    Argument arguments[7];
    for (int a = 0; a < 7; a++) arguments[a] = (Argument){sizeof(cl_mem), all[a]};
    launch("propagate", most, run.parts, 7, arguments);
    launch("add_up", LANES, run.parts, 3, (Argument[]){{sizeof grid, &grid}, {sizeof grid, &run.light[then]}, {sizeof sums, &sums}});
    download(sums, 0, (size_t)run.parts * LANES * sizeof *sum, sum);
    for (int p = 0; p < run.parts; p++) {
        if (run.grid[p].still) continue;
        double left = 0.0;
        for (int k = 0; k < LANES; k++) left += (double)sum[p * LANES + k];
        run.power[p * POWERS + LEFT] = left;
    }
    clReleaseMemObject(grid);
    clReleaseMemObject(sums);
    free(sum);
}

static void run_launch(int64_t index, const NphDumpLaunch *of) {
    if (strcmp(of->stage, "pop.propagate") != 0) return;
    int64_t iteration = argument(of, "iteration");
    if (run.next != iteration) {
        release();
        load(index);
    }
    NphArray ordinate = array_of(index, "pop.ordinate"), density = array_of(index, "pop.density");
    int then = strcmp(port.plant, "in_place") == 0 ? run.now : 1 - run.now; /* the mistake: what others still read is written over */
    begin_launch(of);
    record_array("pop.ordinate", &ordinate);
    record_array("pop.density", &density);
    record_state(run.now);
    prepare_iteration(iteration);
    iterate(then);
    begin_outputs();
    record_state(then);
    end_launch();
    run.now = then;
    run.next = iteration + 1;
    nph_array_free(port.context, &ordinate);
    nph_array_free(port.context, &density);
}

const Method ordinates_port = {
    .name = "principal_ordinates",
    .source = "#include \"propagate.cl\"\n",
    .plants = {{"swapped_direction", "-DPLANT_SWAPPED_DIRECTION"}, {"printed_decay", "-DPLANT_PRINTED_DECAY"},
               {"half_an_edge", "-DPLANT_HALF_AN_EDGE"}, {"in_place", ""}},
    .read_scene = read_scene,
    .run_launch = run_launch,
    .release = release,
};
