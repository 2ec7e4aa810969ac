/* SPDX-License-Identifier: Apache-2.0
 *
 * How many threads this process may use: processors it is bound to, and the quota of its control group. */
#ifndef NPH_CORE_USABLE_H
#define NPH_CORE_USABLE_H

/* The default number of threads, 1 to 1024. root: "" (tests: a folder that stands for /). */
int nph_usable_threads(const char *root);

/* Quota of the process's control group and of the groups around it, rounded up to whole processors; 0 without one.
 * Reads version 2 (cpu.max) and version 1 (cpu.cfs_quota_us). */
int nph_cgroup_threads(const char *root);

#endif
