/* SPDX-License-Identifier: Apache-2.0
 *
 * The device: the first one of the first platform, if it rounds as nephos/portable.h needs. */
#include <stdio.h>
#include <stdlib.h>

#include "port.h"

enum { GROUP = 64 }; /* work-items */

static cl_context device_context;
static cl_program program;

void cl(cl_int status, const char *what) {
    if (status != CL_SUCCESS) stop(NPH_BAD_OUTPUT, "OpenCL: %s: error %d", what, (int)status);
}

void open_device(const char *source, const char *options) {
    static char words[4096], log[16384], name[200];
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
    port.queue = clCreateCommandQueue(device_context, device, 0, &status);
    cl(status, "queue");
    program = clCreateProgramWithSource(device_context, 1, &source, NULL, &status);
    cl(status, "program");
    snprintf(words, sizeof words, "-cl-std=CL1.2 -cl-fp32-correctly-rounded-divide-sqrt -I%s -I%s %s", EXAMPLE_KERNELS, EXAMPLE_INCLUDE, options);
    status = clBuildProgram(program, 1, &device, words, NULL, NULL);
    if (status != CL_SUCCESS) clGetProgramBuildInfo(program, device, CL_PROGRAM_BUILD_LOG, sizeof log, log, NULL);
    if (status != CL_SUCCESS) stop(NPH_BAD_INPUT, "OpenCL: the kernels cannot be built:\n%s", log);
    fprintf(stderr, "%s\n", name);
}

void close_device(void) {
    clReleaseProgram(program);
    clReleaseCommandQueue(port.queue);
    clReleaseContext(device_context);
}

cl_mem upload(const void *data, size_t bytes) {
    cl_int status;
    void *zeros = data ? NULL : calloc(1, bytes ? bytes : 4);
    union { const void *from; void *to; } content = {data ? data : zeros};
    cl_mem made = clCreateBuffer(device_context, CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, bytes ? bytes : 4, content.to, &status);
    cl(status, "buffer");
    free(zeros);
    return made;
}

void download(cl_mem from, size_t offset, size_t bytes, void *data) {
    if (bytes) cl(clEnqueueReadBuffer(port.queue, from, CL_TRUE, offset, bytes, data, 0, NULL, NULL), "read");
}

void launch(const char *name, int items, int rows, int count, const Argument *arguments) {
    cl_int status;
    cl_kernel kernel = clCreateKernel(program, name, &status);
    size_t group[2] = {GROUP, 1}, all[2] = {((size_t)items + GROUP - 1) / GROUP * GROUP, (size_t)rows};
    cl(status, name);
    for (int a = 0; a < count; a++) cl(clSetKernelArg(kernel, (cl_uint)a, arguments[a].size, arguments[a].value), name);
    cl(clEnqueueNDRangeKernel(port.queue, kernel, 2, NULL, all, group, 0, NULL, NULL), name);
    clReleaseKernel(kernel);
}
