/* SPDX-License-Identifier: Apache-2.0
 *
 * What the methods of the port share: the device (port_device.c), the dump that it is fed from, and the one that it writes
 * (port_dump.c). A method is a file port_METHOD.c and its kernels. Whatever fails ends the program. */
#ifndef EXAMPLE_PORT_H
#define EXAMPLE_PORT_H

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#include "nephos/nephos.h"

typedef struct Port {
    NphContext *context;
    NphDumpRun *run;     /* the reference's */
    const char *output;  /* folder that is written */
    const char *plant;   /* mistake that is made; "" */
    cl_command_queue queue;
} Port;
extern Port port;

/* Prints a line and exits. */
void stop(int status, const char *format, ...);
/* What the library refuses it has explained to the context's message function. */
void need(NphStatus status);

/* The device: source is OpenCL C, options the compiler's. */
void open_device(const char *source, const char *options);
void close_device(void);
void cl(cl_int status, const char *what);
/* A buffer with a copy of what `data` holds; NULL: zeros. Released by clReleaseMemObject. */
cl_mem upload(const void *data, size_t bytes);
void download(cl_mem from, size_t offset, size_t bytes, void *data);
/* A kernel over items x rows, groups of 64 items. */
typedef struct Argument {
    size_t size;
    const void *value;
} Argument;
void launch(const char *name, int items, int rows, int count, const Argument *arguments);

/* Numbers of the reference's manifest; `otherwise` where it has none of that name. */
double number(const char *name, double otherwise);
void doubles(const char *name, int count, double *out);
void numbers(const char *name, int count, float *out);
int64_t argument(const NphDumpLaunch *of, const char *name);
/* A buffer of the reference's launch; freed by nph_array_free. */
NphArray array_of(int64_t index, const char *buffer);

/* The dump that is written: of each launch its inputs, then its outputs. */
void begin_dump(const char *method);
void begin_launch(const NphDumpLaunch *of);
void begin_outputs(void);
void end_launch(void);
void end_dump(void);
/* A buffer of the launch under way, from the host or from the device. */
void record(const char *buffer, NphType type, int rank, const int64_t *shape, const void *data);
void record_array(const char *buffer, const NphArray *array);
void record_from(const char *buffer, NphType type, int rank, const int64_t *shape, cl_mem from, size_t offset);

/* A method: its kernels, the mistakes that it can make, with what the kernels' compiler is told of them, and its stages. */
typedef struct Method {
    const char *name, *source;
    const char *plants[4][2];
    void (*read_scene)(void); /* refuses what the kernels leave out */
    void (*run_launch)(int64_t index, const NphDumpLaunch *of);
    void (*release)(void);
} Method;
extern const Method path_port, ordinates_port;

#endif
