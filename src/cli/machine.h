/* SPDX-License-Identifier: Apache-2.0
 *
 * Arithmetic speed and memory bandwidth of this machine at the context's vector level and number of threads, measured. */
#ifndef NPH_CLI_MACHINE_H
#define NPH_CLI_MACHINE_H

#include "core/cpu.h"

enum { MACHINE_LANES = 1024, MACHINE_LANE_FLOPS = 8 * 16 * 2, MACHINE_TABLE = 1 << 16, MACHINE_LOOKS = 8 };

NPH_KERNEL_DECLARE(void, nph_machine_flops, (void *restrict lanes));
NPH_KERNEL_DECLARE(void, nph_machine_triad,
                   (void *restrict to, const void *restrict from, const void *restrict more, int64_t count));

/* MACHINE_LOOKS numbers for every lane from a table of MACHINE_TABLE. */
NPH_KERNEL_DECLARE(void, nph_machine_gather, (void *restrict lanes, const void *restrict table, const int32_t *restrict index));

typedef struct Machine {
    double flops_f32, flops_f64;    /* operations per second, all threads; multiply and add count one each */
    double bytes_per_second;        /* triad, two reads and a write */
    double gathers_per_second;      /* numbers (f32) from places of their own in 256 KiB */
} Machine;

/* About a second. */
NphStatus machine_measure(NphContext *context, Machine *machine);

#endif
