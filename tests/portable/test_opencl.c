/* SPDX-License-Identifier: Apache-2.0
 *
 * nephos/portable.h as OpenCL C 1.2 against reference/vectors, on the first device of the first platform. Skipped where there
 * is no OpenCL or the device does not round as IEEE 754 says. */
#include "rows.h"

#include "harness.h"

#ifndef NPH_HAVE_OPENCL
START_TEST(vectors_are_met_to_the_bit_in_opencl) { nph_test_skip("OpenCL: built without it (ocl-icd-opencl-dev)"); }
END_TEST
#else
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char source[] =
    "#include \"nephos/portable.h\"\n"
    "#include \"evaluate.h\"\n"
    "#include \"vectors.h\"\n"
    "__kernel void rows(__global const int *function, __global const uint *in, __global uint *out) {\n"
    "    size_t i = get_global_id(0);\n"
    "    uint words[NPH_WORDS_IN], results[NPH_WORDS_OUT] = {0, 0, 0, 0, 0, 0, 0};\n"
    "    for (int k = 0; k < NPH_WORDS_IN; k++) words[k] = in[i * NPH_WORDS_IN + k];\n"
    "    nph_evaluate(function[i], words, results);\n"
    "    for (int k = 0; k < NPH_WORDS_OUT; k++) out[i * NPH_WORDS_OUT + k] = results[k];\n"
    "}\n"
    "__kernel void constants(__global uint *differ) {\n"
    "    uint count = 0, got[4];\n"
    "    for (int i = 0; i < nph_philox_count; i++) {\n"
    "        __constant const uint *in = &nph_philox_in[i * 6], *out = &nph_philox_out[i * 4];\n"
    "        nph_put_words(nph_philox(in[0], in[1], in[2], in[3], in[4], in[5]), got);\n"
    "        for (int k = 0; k < 4; k++) count += got[k] != out[k];\n"
    "    }\n"
    "    *differ = count;\n"
    "}\n";

typedef struct Device {
    cl_device_id id;
    cl_context context;
    cl_command_queue queue;
    cl_program program;
} Device;

/* 0, with a reason, where there is nothing to test on. */
static int find_device(cl_device_id *device) {
    cl_platform_id platform;
    cl_uint count = 0;
    cl_device_fp_config has = 0, wanted = CL_FP_DENORM | CL_FP_INF_NAN | CL_FP_ROUND_TO_NEAREST | CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT;
    if (getenv("NEPHOS_TEST_QUICK")) nph_test_skip("OpenCL: not under sanitizers, which find fault with the platform's compiler");
    else if (clGetPlatformIDs(1, &platform, &count) != CL_SUCCESS || count == 0)
        nph_test_skip("OpenCL: no platform (pocl-opencl-icd is one)");
    else if (clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 1, device, &count) != CL_SUCCESS || count == 0)
        nph_test_skip("OpenCL: no device");
    else if (clGetDeviceInfo(*device, CL_DEVICE_SINGLE_FP_CONFIG, sizeof has, &has, NULL) != CL_SUCCESS || (has & wanted) != wanted)
        nph_test_skip("OpenCL: the device flushes subnormal numbers, or does not round division and square roots correctly");
    else return 1;
    return 0;
}

static void build(Device *device) {
    static char log[8192];
    const char *text = source, *root = getenv("NEPHOS_PROGRAM_ROOT");
    char options[2048];
    cl_int status;
    device->context = clCreateContext(NULL, 1, &device->id, NULL, NULL, &status);
    ck_assert_int_eq(status, CL_SUCCESS);
    device->queue = clCreateCommandQueue(device->context, device->id, 0, &status);
    ck_assert_int_eq(status, CL_SUCCESS);
    device->program = clCreateProgramWithSource(device->context, 1, &text, NULL, &status);
    ck_assert_int_eq(status, CL_SUCCESS);
    snprintf(options, sizeof options, "-cl-std=CL1.2 -cl-fp32-correctly-rounded-divide-sqrt -I%s/include -I%s -I%s", root ? root : "build",
             nph_test_path("tests/portable"), nph_test_path("reference/vectors"));
    status = clBuildProgram(device->program, 1, &device->id, options, NULL, NULL);
    if (status != CL_SUCCESS)
        clGetProgramBuildInfo(device->program, device->id, CL_PROGRAM_BUILD_LOG, sizeof log, log, NULL);
    ck_assert_msg(status == CL_SUCCESS, "clBuildProgram: %d\n%s", status, log);
}

static cl_mem buffer(Device *device, size_t bytes, void *content) {
    cl_int status;
    cl_mem made = clCreateBuffer(device->context, CL_MEM_READ_WRITE | (content ? CL_MEM_COPY_HOST_PTR : 0), bytes, content, &status);
    ck_assert_int_eq(status, CL_SUCCESS);
    return made;
}

/* Runs a kernel over count items and reads its last buffer back. */
static void run(Device *device, const char *name, cl_mem *buffers, int count_buffers, size_t items, size_t bytes, void *out) {
    cl_int status;
    cl_kernel kernel = clCreateKernel(device->program, name, &status);
    ck_assert_int_eq(status, CL_SUCCESS);
    for (int i = 0; i < count_buffers; i++)
        ck_assert_int_eq(clSetKernelArg(kernel, (cl_uint)i, sizeof buffers[i], &buffers[i]), CL_SUCCESS);
    ck_assert_int_eq(clEnqueueNDRangeKernel(device->queue, kernel, 1, NULL, &items, NULL, 0, NULL, NULL), CL_SUCCESS);
    ck_assert_int_eq(clEnqueueReadBuffer(device->queue, buffers[count_buffers - 1], CL_TRUE, 0, bytes, out, 0, NULL, NULL), CL_SUCCESS);
    for (int i = 0; i < count_buffers; i++) clReleaseMemObject(buffers[i]);
    clReleaseKernel(kernel);
}

static Row all[NPH_ROWS_MOST];
static cl_int functions[NPH_ROWS_MOST];
static uint32_t in[NPH_ROWS_MOST * NPH_WORDS_IN], got[NPH_ROWS_MOST * NPH_WORDS_OUT];

static void compare_rows(Device *device) {
    int count = 0, whole = nph_rows_read(all);
    for (int i = 0; i < whole; i++) {
        if (all[i].function == F_phase_of) continue; /* the host's */
        all[count] = all[i];
        functions[count] = all[i].function;
        memcpy(&in[count++ * NPH_WORDS_IN], all[i].in, sizeof all[i].in);
    }
    cl_mem buffers[3] = {buffer(device, sizeof functions, functions), buffer(device, sizeof in, in), buffer(device, sizeof got, NULL)};
    run(device, "rows", buffers, 3, (size_t)count, (size_t)count * NPH_WORDS_OUT * sizeof got[0], got);
    int wrong = 0, first = -1;
    for (int i = 0; i < count; i++) {
        int differs = 0;
        for (int k = 0; k < nph_rows_results(all[i].function); k++)
            differs |= nph_rows_comparable(all[i].function, k, got[i * NPH_WORDS_OUT + k]) != all[i].out[k];
        first = differs && first < 0 ? i : first;
        wrong += differs;
        if (differs) printf("%s(%08x %08x) = %08x, not %08x\n", nph_rows_function(all[i].function), (unsigned)all[i].in[0],
                            (unsigned)all[i].in[1], (unsigned)got[i * NPH_WORDS_OUT], (unsigned)all[i].out[0]);
    }
    ck_assert_msg(wrong == 0, "%d of %d rows differ, the first in %s", wrong, count, nph_rows_function(all[first < 0 ? 0 : first].function));
    printf("opencl: %d rows equal to the bit\n", count);
}

START_TEST(vectors_are_met_to_the_bit_in_opencl) {
    Device device;
    char name[200] = "";
    setenv("POCL_CACHE_DIR", nph_test_temporary(""), 0); /* else compiled programs would stay in the user's folder */
    if (!find_device(&device.id)) return;
    clGetDeviceInfo(device.id, CL_DEVICE_NAME, sizeof name, name, NULL);
    printf("opencl: %s\n", name);
    build(&device);
    compare_rows(&device);
    cl_mem differ = buffer(&device, sizeof(cl_uint), NULL);
    cl_uint count = 1;
    run(&device, "constants", &differ, 1, 1, sizeof count, &count);
    ck_assert_uint_eq(count, 0);
    clReleaseProgram(device.program);
    clReleaseCommandQueue(device.queue);
    clReleaseContext(device.context);
}
END_TEST
#endif

static void fill(TCase *cases) { tcase_add_test(cases, vectors_are_met_to_the_bit_in_opencl); }

int main(void) { return nph_test_main("opencl", fill); }
