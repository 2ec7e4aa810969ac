/* SPDX-License-Identifier: Apache-2.0
 *
 * Two stages of nephos on an OpenCL device, fed from a dump, written down as a dump of its own for `nephos verify`:
 *
 *     nephos render reference/scenes/smoke.yaml -o smoke.exr --spp 16 --crop 192,144,208,160 --dump dump
 *     build/examples/example_opencl dump mine
 *     nephos verify dump mine
 *
 * path.majorant (majorant.cl) and path.track (track.cl) of scenes with one grey medium, a grid or a box, and no surfaces. --plant MISTAKE
 * makes one of four mistakes, for verify to find. */
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "nephos/nephos.h"
#include "shared.h"

enum { GROUP = 64, IDS = 4096, TILE = 16 }; /* work-items of a group; samples of a batch; pixels of a tile's side */

static NphContext *context;
static NphDumpRun *run;
static Medium medium;
static cl_context device_context;
static cl_command_queue queue;
static cl_program program;
static FILE *manifest;
static const char *output;
static int launches_written;

static void stop(int status, const char *format, ...) {
    va_list words;
    va_start(words, format);
    vfprintf(stderr, format, words);
    va_end(words);
    fputc('\n', stderr);
    exit(status);
}

/* What the library refuses it has explained to on_message. */
static void need(NphStatus status) {
    if (status != NPH_OK) exit((int)status);
}

static void cl(cl_int status, const char *what) {
    if (status != CL_SUCCESS) stop(NPH_BAD_OUTPUT, "OpenCL: %s: error %d", what, (int)status);
}

static void on_message(void *user, NphMessageLevel level, const char *text) {
    (void)user;
    fprintf(stderr, "%s%s\n", level == NPH_MESSAGE_ERROR ? "error: " : "", text);
}

/* The device ----------------------------------------------------------------------------------------------------- */

static void open_device(const char *plant) {
    static const char source[] = "#include \"majorant.cl\"\n#include \"track.cl\"\n";
    static char options[4096], log[16384], name[200];
    const char *text = source;
    cl_platform_id platform;
    cl_device_id device;
    cl_device_fp_config has = 0, wanted = CL_FP_DENORM | CL_FP_INF_NAN | CL_FP_ROUND_TO_NEAREST | CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT;
    cl_int status;
    if (clGetPlatformIDs(1, &platform, NULL) != CL_SUCCESS) stop(NPH_BAD_INPUT, "OpenCL: there is no platform");
    if (clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 1, &device, NULL) != CL_SUCCESS) stop(NPH_BAD_INPUT, "OpenCL: there is no device");
    cl(clGetDeviceInfo(device, CL_DEVICE_NAME, sizeof name, name, NULL), "device");
    cl(clGetDeviceInfo(device, CL_DEVICE_SINGLE_FP_CONFIG, sizeof has, &has, NULL), "device");
    if ((has & wanted) != wanted) stop(NPH_BAD_INPUT, "OpenCL: %s rounds otherwise than nephos/portable.h needs", name);
    device_context = clCreateContext(NULL, 1, &device, NULL, NULL, &status);
    cl(status, "context");
    queue = clCreateCommandQueue(device_context, device, 0, &status);
    cl(status, "queue");
    program = clCreateProgramWithSource(device_context, 1, &text, NULL, &status);
    cl(status, "program");
    snprintf(options, sizeof options, "-cl-std=CL1.2 -cl-fp32-correctly-rounded-divide-sqrt -I%s -I%s %s", EXAMPLE_KERNELS, EXAMPLE_INCLUDE, plant);
    status = clBuildProgram(program, 1, &device, options, NULL, NULL);
    if (status != CL_SUCCESS) clGetProgramBuildInfo(program, device, CL_PROGRAM_BUILD_LOG, sizeof log, log, NULL);
    if (status != CL_SUCCESS) stop(NPH_BAD_INPUT, "OpenCL: the kernels cannot be built:\n%s", log);
    fprintf(stderr, "%s\n", name);
}

/* A buffer with a copy of what `data` holds; NULL: zeros. */
static cl_mem upload(const void *data, size_t bytes) {
    cl_int status;
    void *zeros = data ? NULL : calloc(1, bytes ? bytes : 4);
    union { const void *from; void *to; } content = {data ? data : zeros};
    cl_mem made = clCreateBuffer(device_context, CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, bytes ? bytes : 4, content.to, &status);
    cl(status, "buffer");
    free(zeros);
    return made;
}

/* Sizes and values of a kernel's arguments, from `first` on. */
static void launch(const char *name, int items, int count, const size_t *sizes, const void *const *values) {
    cl_int status;
    cl_kernel kernel = clCreateKernel(program, name, &status);
    size_t group = GROUP, all = ((size_t)items + GROUP - 1) / GROUP * GROUP;
    cl(status, name);
    for (int a = 0; a < count; a++) cl(clSetKernelArg(kernel, (cl_uint)a, sizes[a], values[a]), name);
    cl(clEnqueueNDRangeKernel(queue, kernel, 1, NULL, &all, &group, 0, NULL, NULL), name);
    clReleaseKernel(kernel);
}

/* Dumps ---------------------------------------------------------------------------------------------------------- */

static double number(const char *name, double otherwise) {
    double value = otherwise;
    nph_dump_run_numbers(run, name, 1, &value);
    return value;
}

static int64_t argument(const NphDumpLaunch *of, const char *name) {
    for (int a = 0; a < of->argument_count; a++)
        if (strcmp(of->argument_names[a], name) == 0) return of->arguments[a];
    stop(NPH_BAD_INPUT, "%s has no argument %s", of->stage, name);
    return 0;
}

static void numbers(const char *name, int count, float *out) {
    double values[16];
    if (nph_dump_run_numbers(run, name, 16, values) != count) stop(NPH_BAD_INPUT, "the manifest has no %s of %d numbers", name, count);
    for (int i = 0; i < count; i++) out[i] = (float)values[i];
}

/* The one medium of the scene, and that what the kernels leave out is not there. */
static void read_medium(void) {
    double values[16];
    float triple[3];
    if (nph_dump_run_options(run)->precision != 32 || number("transport.channels", 0) > 1 || number("transport.surfaces", 1) > 0 ||
        nph_dump_run_numbers(run, "transport.period_size", 2, values) || nph_dump_run_numbers(run, "media.1.position", 1, values))
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
    medium.is_grid = nph_dump_run_numbers(run, "media.0.samples", 3, values) == 3;
    medium.nearest = number("media.0.nearest", 0) > 0;
    for (int a = 0; a < 3 && medium.is_grid; a++) medium.samples[a] = (int)values[a];
    nph_dump_run_numbers(run, "media.0.cells", 3, values);
    for (int a = 0; a < 3 && medium.is_grid; a++) medium.cells[a] = (int)values[a];
}

/* A .npy file: 128 bytes of header, and the elements. */
static void write_npy(const char *path, int real, int rank, const int64_t *shape, const void *data) {
    static const unsigned char version[4] = {1, 0, 118, 0}; /* 1.0, and how long the rest of the header is */
    char header[129], text[64] = "";
    size_t count = 1;
    for (int a = 0; a < rank; a++) {
        count *= (size_t)shape[a];
        snprintf(text + strlen(text), sizeof text - strlen(text), "%lld,%s", (long long)shape[a], a + 1 < rank ? " " : "");
    }
    int used = snprintf(header, sizeof header, "\x93NUMPY%c%c%c%c{'descr': '<%s', 'fortran_order': False, 'shape': (%s), }", 1, 1, 1, 1,
                        real ? "f4" : "i4", text);
    memcpy(header + 6, version, sizeof version);
    memset(header + used, ' ', 127 - (size_t)used);
    header[127] = '\n';
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(header, 1, 128, file) != 128 || fwrite(data, 4, count, file) != count || fclose(file) != 0)
        stop(NPH_BAD_OUTPUT, "%s: cannot be written: %s", path, strerror(errno));
}

/* A buffer of the launch under way: written, and named in the manifest. */
static void record(const NphDumpLaunch *of, const char *prefix, const char *buffer, int real, int rank, const int64_t *shape,
                   const void *data, int *first) {
    char path[4096];
    snprintf(path, sizeof path, "%s/batch%lld.%lld.%s%s.npy", output, (long long)of->batch, (long long)of->number, prefix, buffer);
    write_npy(path, real, rank, shape, data);
    fprintf(manifest, "%s\"%s\": \"%s\"", *first ? "" : ", ", buffer, path + strlen(output) + 1);
    *first = 0;
}

static void record_input(const NphDumpLaunch *of, const char *buffer, const NphArray *array, int *first) {
    record(of, "in.", buffer, array->type == NPH_F32, array->rank, array->shape, array->data, first);
}

static void record_output(const NphDumpLaunch *of, const char *buffer, int real, int rank, const int64_t *shape, cl_mem from, size_t offset,
                          int *first) {
    size_t bytes = 4;
    for (int a = 0; a < rank; a++) bytes *= (size_t)shape[a];
    void *data = malloc(bytes ? bytes : 4);
    if (!data) stop(NPH_NO_MEMORY, "no memory for %s", buffer);
    if (bytes) cl(clEnqueueReadBuffer(queue, from, CL_TRUE, offset, bytes, data, 0, NULL, NULL), buffer);
    record(of, "", buffer, real, rank, shape, data, first);
    free(data);
}

static int begin_launch(const NphDumpLaunch *of) {
    fprintf(manifest, "%s\n  {\"batch\": %lld, \"number\": %lld, \"stage\": \"%s\", \"arguments\": {", launches_written++ ? "," : "",
            (long long)of->batch, (long long)of->number, of->stage);
    for (int a = 0; a < of->argument_count; a++)
        fprintf(manifest, "%s\"%s\": %lld", a ? ", " : "", of->argument_names[a], (long long)of->arguments[a]);
    fprintf(manifest, "},\n   \"inputs\": {");
    return 1;
}

static int begin_outputs(void) {
    fprintf(manifest, "},\n   \"outputs\": {");
    return 1;
}

static void end_launch(void) { fprintf(manifest, "}}"); }

/* Stages --------------------------------------------------------------------------------------------------------- */

static NphArray array_of(int64_t index, const char *buffer) {
    NphArray array;
    need(nph_dump_run_array(context, run, index, buffer, &array));
    return array;
}

static void run_majorant(int64_t index, const NphDumpLaunch *of) {
    NphArray density = array_of(index, "path.density");
    int64_t shape[3] = {medium.cells[2], medium.cells[1], medium.cells[0]};
    int items = medium.cells[0] * medium.cells[1] * medium.cells[2], first = begin_launch(of);
    size_t bytes = (size_t)items * 4;
    cl_mem from = upload(density.data, (size_t)nph_array_count(&density) * 4), cells = upload(NULL, bytes);
    cl_mem row = upload(NULL, bytes), plane = upload(NULL, bytes);
    const size_t sizes[3] = {sizeof medium, sizeof(cl_mem), sizeof(cl_mem)};
    launch("bound", items, 3, sizes, (const void *[]){&medium, &from, &cells});
    launch("near_x", items, 3, sizes, (const void *[]){&medium, &cells, &row});
    launch("near_y", items, 3, sizes, (const void *[]){&medium, &row, &plane});
    launch("near_z", items, 3, sizes, (const void *[]){&medium, &plane, &cells});
    record_input(of, "path.density", &density, &first);
    first = begin_outputs();
    record_output(of, "path.bound", 1, 3, shape, cells, 0, &first);
    end_launch();
    clReleaseMemObject(from);
    clReleaseMemObject(cells);
    clReleaseMemObject(row);
    clReleaseMemObject(plane);
    nph_array_free(context, &density);
}

/* Batches are tiles of 16 x 16 pixels, counted row by row within the crop, times 16 samples of each. */
static Launch place(const NphDumpLaunch *of, int count) {
    const NphRenderOptions *options = nph_dump_run_options(run);
    int tile = (int)argument(of, "tile"), first_x = options->crop[0] / TILE, first_y = options->crop[1] / TILE;
    int across = (options->crop[2] - 1) / TILE - first_x + 1;
    Launch made = {options->seed, options->frame & 0xffffffu, (uint32_t)argument(of, "vertex"), 0, 0, 0, (uint32_t)(TILE * argument(of, "chunk")), count};
    made.width = (uint32_t)number("resolution", 0);
    made.tile_x = (uint32_t)((first_x + tile % across) * TILE);
    made.tile_y = (uint32_t)((first_y + tile / across) * TILE);
    return made;
}

enum { ID, RAY, WEIGHT, DISTANCE, MEDIUM, FLOWN, COLLIDED, QUEUES, LENGTHS, BUFFERS };

static void write_outputs(const NphDumpLaunch *of, const Launch *at, const cl_mem *buffer) {
    int splits = medium.split > 0 && at->vertex == 0, first = begin_outputs();
    int64_t count = at->count;
    cl_int lengths[2];
    cl(clEnqueueReadBuffer(queue, buffer[LENGTHS], CL_TRUE, 0, sizeof lengths, lengths, 0, NULL, NULL), "lengths");
    record_output(of, "path.weight", 1, 2, (int64_t[]){1, count}, buffer[WEIGHT], 0, &first);
    record_output(of, "path.distance", 1, 1, &count, buffer[DISTANCE], 0, &first);
    record_output(of, "path.medium", 0, 1, &count, buffer[MEDIUM], 0, &first);
    if (medium.weighed || splits) record_output(of, "path.flown", 1, 2, (int64_t[]){2, count}, buffer[FLOWN], 0, &first);
    record_output(of, "path.colliding", 0, 1, (int64_t[]){lengths[0]}, buffer[QUEUES], 0, &first);
    record_output(of, "path.leaving", 0, 1, (int64_t[]){lengths[1]}, buffer[QUEUES], (size_t)count * 4, &first);
    if (medium.split > 0) record_output(of, "path.collided", 1, 1, (int64_t[]){IDS}, buffer[COLLIDED], 0, &first);
    end_launch();
}

static void run_track(int64_t index, const NphDumpLaunch *of, const cl_mem *density, const cl_mem *bounds) {
    static const char *const names[] = {"path.id", "path.hero", "path.ray", "path.weight", "path.collided"};
    NphArray in[5];
    int inputs = medium.split > 0 ? 5 : 4, first = begin_launch(of);
    for (int i = 0; i < inputs; i++) {
        in[i] = array_of(index, names[i]);
        record_input(of, names[i], &in[i], &first);
    }
    size_t count = (size_t)in[0].shape[0];
    Launch at = place(of, (int)count);
    cl_mem buffer[BUFFERS] = {upload(in[0].data, count * 4), upload(in[2].data, count * 24), upload(in[3].data, count * 4), upload(NULL, count * 4),
                              upload(NULL, count * 4), upload(NULL, count * 8), upload(inputs == 5 ? in[4].data : NULL, IDS * 4),
                              upload(NULL, count * 8), upload(NULL, 8)};
    size_t sizes[4 + BUFFERS] = {sizeof at, sizeof medium, sizeof(cl_mem), sizeof(cl_mem)};
    const void *values[4 + BUFFERS] = {&at, &medium, density, bounds};
    for (int b = 0; b < BUFFERS; b++) {
        sizes[4 + b] = sizeof(cl_mem);
        values[4 + b] = &buffer[b];
    }
    launch("track", (int)count, 4 + BUFFERS, sizes, values);
    write_outputs(of, &at, buffer);
    for (int b = 0; b < BUFFERS; b++) clReleaseMemObject(buffer[b]);
    for (int i = 0; i < inputs; i++) nph_array_free(context, &in[i]);
}

/* Density and majorants are the reference's: what path.track is given. */
static void run_stages(void) {
    cl_mem density = upload(NULL, 4), bounds = upload(NULL, 4);
    for (int64_t l = 0; l < nph_dump_run_launch_count(run); l++) {
        NphDumpLaunch of;
        nph_dump_run_launch(run, l, &of);
        if (strcmp(of.stage, "path.majorant") == 0) {
            NphArray samples = array_of(l, "path.density"), cells = array_of(l, "path.bound");
            density = upload(samples.data, (size_t)nph_array_count(&samples) * 4);
            bounds = upload(cells.data, (size_t)nph_array_count(&cells) * 4);
            nph_array_free(context, &samples);
            nph_array_free(context, &cells);
            run_majorant(l, &of);
        }
        if (strcmp(of.stage, "path.track") == 0) run_track(l, &of, &density, &bounds);
    }
    clReleaseMemObject(density);
    clReleaseMemObject(bounds);
}

int main(int argc, char **argv) {
    static const char *const plants[][2] = {{"transposed_axis", "-DPLANT_TRANSPOSED_AXIS"}, {"dropped_factor", "-DPLANT_DROPPED_FACTOR"},
                                            {"block_off_by_one", "-DPLANT_BLOCK_OFF_BY_ONE"}, {"half", "-DPLANT_HALF"}};
    const char *plant = argc == 3 ? "" : NULL;
    char path[4096];
    NphSettings settings;
    for (int p = 0; p < 4 && argc == 5 && strcmp(argv[3], "--plant") == 0; p++)
        if (strcmp(argv[4], plants[p][0]) == 0) plant = plants[p][1];
    if (!plant) stop(NPH_BAD_USAGE, "usage: %s DUMP OUT [--plant transposed_axis|dropped_factor|block_off_by_one|half]", argv[0]);
    nph_settings_default(&settings);
    settings.message = on_message;
    need(nph_context_open(&context, &settings));
    need(nph_dump_run(context, argv[1], &run));
    read_medium();
    open_device(plant);
    output = argv[2];
    snprintf(path, sizeof path, "%s/manifest.json", output);
    manifest = mkdir(output, 0777) == 0 ? fopen(path, "w") : NULL;
    if (!manifest) stop(NPH_BAD_OUTPUT, "%s: cannot be made: %s", output, strerror(errno));
    fprintf(manifest, "{\"nephos_dump\": 1, \"method\": \"path\", \"launches\": [");
    run_stages();
    fprintf(manifest, "\n]}\n");
    if (fclose(manifest) != 0) stop(NPH_BAD_OUTPUT, "%s: cannot be written: %s", path, strerror(errno));
    clReleaseProgram(program);
    clReleaseCommandQueue(queue);
    clReleaseContext(device_context);
    nph_dump_run_free(context, run);
    nph_context_close(context);
    return 0;
}
