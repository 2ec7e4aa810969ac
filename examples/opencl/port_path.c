/* SPDX-License-Identifier: Apache-2.0
 *
 * path.majorant (majorant.cl) and path.track (track.cl) of scenes with one grey medium, a grid or a box, and no surfaces. */
#include <string.h>

#include "port.h"
#include "shared.h"

enum { IDS = 4096, TILE = 16 }; /* samples of a batch; pixels of a tile's side */

static Medium medium;
static cl_mem density, bounds; /* the reference's: what path.track is given */

/* The one medium of the scene, and that what the kernels leave out is not there. */
static void read_medium(void) {
    double values[16];
    float triple[3];
    if (nph_dump_run_options(port.run)->precision != 32 || number("transport.channels", 0) > 1 || number("transport.surfaces", 1) > 0 ||
        nph_dump_run_numbers(port.run, "transport.period_size", 2, values) || nph_dump_run_numbers(port.run, "media.1.position", 1, values))
        stop(NPH_BAD_INPUT, "these kernels know one grey medium without surfaces or periodic sides, in f32");
    numbers("media.0.medium_from_local", 12, medium.from_local);
    numbers("media.0.lo", 3, medium.lo);
    numbers("media.0.hi", 3, medium.hi);
    numbers("media.0.sigma", 3, triple);
    medium.sigma = triple[0];
    numbers("media.0.collide", 1, &medium.collide);
    numbers("transport.split", 1, &medium.split);
    medium.weighed = number("transport.weighed", 0) > 0;
    medium.number = (int)number("media.0.medium", 0);
    medium.is_grid = nph_dump_run_numbers(port.run, "media.0.samples", 3, values) == 3;
    medium.nearest = number("media.0.nearest", 0) > 0;
    for (int a = 0; a < 3 && medium.is_grid; a++) medium.samples[a] = (int)values[a];
    nph_dump_run_numbers(port.run, "media.0.cells", 3, values);
    for (int a = 0; a < 3 && medium.is_grid; a++) medium.cells[a] = (int)values[a];
}

static void run_majorant(int64_t index, const NphDumpLaunch *of) {
    NphArray samples = array_of(index, "path.density"), reference = array_of(index, "path.bound");
    int64_t shape[3] = {medium.cells[2], medium.cells[1], medium.cells[0]};
    int items = medium.cells[0] * medium.cells[1] * medium.cells[2];
    size_t bytes = (size_t)items * 4;
    cl_mem cells = upload(NULL, bytes), row = upload(NULL, bytes), plane = upload(NULL, bytes);
    density = upload(samples.data, (size_t)nph_array_count(&samples) * 4);
    bounds = upload(reference.data, (size_t)nph_array_count(&reference) * 4);
    launch("bound", items, 1, 3, (Argument[]){{sizeof medium, &medium}, {sizeof(cl_mem), &density}, {sizeof(cl_mem), &cells}});
    launch("near_x", items, 1, 3, (Argument[]){{sizeof medium, &medium}, {sizeof(cl_mem), &cells}, {sizeof(cl_mem), &row}});
    launch("near_y", items, 1, 3, (Argument[]){{sizeof medium, &medium}, {sizeof(cl_mem), &row}, {sizeof(cl_mem), &plane}});
    launch("near_z", items, 1, 3, (Argument[]){{sizeof medium, &medium}, {sizeof(cl_mem), &plane}, {sizeof(cl_mem), &cells}});
    begin_launch(of);
    record_array("path.density", &samples);
    begin_outputs();
    record_from("path.bound", NPH_F32, 3, shape, cells, 0);
    end_launch();
    clReleaseMemObject(cells);
    clReleaseMemObject(row);
    clReleaseMemObject(plane);
    nph_array_free(port.context, &samples);
    nph_array_free(port.context, &reference);
}

/* Batches are tiles of 16 x 16 pixels, counted row by row within the crop, times 16 samples of each. */
static Launch place(const NphDumpLaunch *of, int count) {
    const NphRenderOptions *options = nph_dump_run_options(port.run);
    int tile = (int)argument(of, "tile"), first_x = options->crop[0] / TILE, first_y = options->crop[1] / TILE;
    int across = (options->crop[2] - 1) / TILE - first_x + 1;
    Launch made = {options->seed, options->frame & 0xffffffu, (uint32_t)argument(of, "vertex"), 0, 0, 0, (uint32_t)(TILE * argument(of, "chunk")), count};
    made.width = (uint32_t)number("resolution", 0);
    made.tile_x = (uint32_t)((first_x + tile % across) * TILE);
    made.tile_y = (uint32_t)((first_y + tile / across) * TILE);
    return made;
}

enum { ID, RAY, WEIGHT, DISTANCE, MEDIUM, FLOWN, COLLIDED, QUEUES, LENGTHS, BUFFERS };

static void write_outputs(const Launch *at, const cl_mem *buffer) {
    int splits = medium.split > 0 && at->vertex == 0;
    int64_t count = at->count;
    cl_int lengths[2];
    download(buffer[LENGTHS], 0, sizeof lengths, lengths);
    begin_outputs();
    record_from("path.weight", NPH_F32, 2, (int64_t[]){1, count}, buffer[WEIGHT], 0);
    record_from("path.distance", NPH_F32, 1, &count, buffer[DISTANCE], 0);
    record_from("path.medium", NPH_I32, 1, &count, buffer[MEDIUM], 0);
    if (medium.weighed || splits) record_from("path.flown", NPH_F32, 2, (int64_t[]){2, count}, buffer[FLOWN], 0);
    record_from("path.colliding", NPH_I32, 1, (int64_t[]){lengths[0]}, buffer[QUEUES], 0);
    record_from("path.leaving", NPH_I32, 1, (int64_t[]){lengths[1]}, buffer[QUEUES], (size_t)count * 4);
    if (medium.split > 0) record_from("path.collided", NPH_F32, 1, (int64_t[]){IDS}, buffer[COLLIDED], 0);
}

static void run_track(int64_t index, const NphDumpLaunch *of) {
    static const char *const names[] = {"path.id", "path.hero", "path.ray", "path.weight", "path.collided"};
    NphArray in[5];
    int inputs = medium.split > 0 ? 5 : 4;
    begin_launch(of);
    for (int i = 0; i < inputs; i++) {
        in[i] = array_of(index, names[i]);
        record_array(names[i], &in[i]);
    }
    size_t count = (size_t)in[0].shape[0];
    Launch at = place(of, (int)count);
    cl_mem buffer[BUFFERS] = {upload(in[0].data, count * 4), upload(in[2].data, count * 24), upload(in[3].data, count * 4), upload(NULL, count * 4),
                              upload(NULL, count * 4), upload(NULL, count * 8), upload(inputs == 5 ? in[4].data : NULL, IDS * 4),
                              upload(NULL, count * 8), upload(NULL, 8)};
    Argument values[4 + BUFFERS] = {{sizeof at, &at}, {sizeof medium, &medium}, {sizeof(cl_mem), &density}, {sizeof(cl_mem), &bounds}};
    for (int b = 0; b < BUFFERS; b++) values[4 + b] = (Argument){sizeof(cl_mem), &buffer[b]};
    launch("track", (int)count, 1, 4 + BUFFERS, values);
    write_outputs(&at, buffer);
    end_launch();
    for (int b = 0; b < BUFFERS; b++) clReleaseMemObject(buffer[b]);
    for (int i = 0; i < inputs; i++) nph_array_free(port.context, &in[i]);
}

static void run_launch(int64_t index, const NphDumpLaunch *of) {
    if (strcmp(of->stage, "path.majorant") == 0) run_majorant(index, of);
    if (strcmp(of->stage, "path.track") != 0) return;
    if (!density && medium.is_grid) stop(NPH_BAD_INPUT, "the dump has no path.majorant, which says what the grid holds");
    if (!density) density = upload(NULL, 4);
    if (!bounds) bounds = upload(NULL, 4);
    run_track(index, of);
}

static void release(void) {
    if (density) clReleaseMemObject(density);
    if (bounds) clReleaseMemObject(bounds);
}

const Method path_port = {
    .name = "path",
    .source = "#include \"majorant.cl\"\n#include \"track.cl\"\n",
    .plants = {{"transposed_axis", "-DPLANT_TRANSPOSED_AXIS"}, {"dropped_factor", "-DPLANT_DROPPED_FACTOR"},
               {"block_off_by_one", "-DPLANT_BLOCK_OFF_BY_ONE"}, {"half", "-DPLANT_HALF"}},
    .read_scene = read_medium,
    .run_launch = run_launch,
    .release = release,
};
