/* SPDX-License-Identifier: Apache-2.0
 *
 * See usable.h. /proc/self/cgroup names the group: "0::/path" in version 2, "4:cpu,cpuacct:/path" in version 1. In a
 * container that path may be the host's, which is not mounted; the walk up from it ends at the root of what is. */
#define _GNU_SOURCE /* sched_getaffinity */
#include "core/usable.h"

#include <limits.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { MOST_THREADS = 1024, LINE_BYTES = PATH_MAX + 256 };

/* The first line of ROOT MOUNT GROUP /NAME without its newline; 0 when there is none. */
static int read_line(const char *root, const char *mount, const char *group, const char *name, char line[64]) {
    char path[2 * LINE_BYTES];
    int length = snprintf(path, sizeof path, "%s%s%s/%s", root, mount, group, name);
    if (length < 0 || (size_t)length >= sizeof path) return 0;
    FILE *file = fopen(path, "r");
    if (!file) return 0;
    char *got = fgets(line, 64, file);
    fclose(file);
    return got != NULL;
}

/* Processors that a quota per period (both in microseconds) comes to; 0 for none or nonsense. */
static int whole_processors(long quota, long period) {
    if (quota <= 0 || period <= 0) return 0;
    long whole = quota / period + (quota % period != 0);
    return whole < MOST_THREADS ? (int)whole : MOST_THREADS;
}

static int quota_v2(const char *root, const char *group) {
    char line[64], *rest;
    if (!read_line(root, "/sys/fs/cgroup", group, "cpu.max", line)) return 0;
    long quota = strtol(line, &rest, 10); /* "max" gives 0 */
    return whole_processors(quota, strtol(rest, NULL, 10));
}

static int quota_v1(const char *root, const char *group) {
    char quota[64], period[64];
    if (!read_line(root, "/sys/fs/cgroup/cpu", group, "cpu.cfs_quota_us", quota)) return 0;
    if (!read_line(root, "/sys/fs/cgroup/cpu", group, "cpu.cfs_period_us", period)) return 0;
    return whole_processors(strtol(quota, NULL, 10), strtol(period, NULL, 10));
}

/* The least quota of a group and those around it; group is cut to its parents in place. */
static int least_quota(const char *root, char *group, int (*quota)(const char *root, const char *group)) {
    int least = 0;
    if (strcmp(group, "/") == 0) group[0] = 0;
    for (;;) {
        int here = quota(root, group);
        if (here > 0 && (least == 0 || here < least)) least = here;
        char *slash = strrchr(group, '/');
        if (!slash) return least;
        *slash = 0;
    }
}

/* Whether a comma-separated list holds "cpu". */
static int lists_cpu(const char *list) {
    for (const char *at = list; at; at = strchr(at, ',')) {
        if (*at == ',') at++;
        size_t length = strcspn(at, ",");
        if (length == 3 && strncmp(at, "cpu", 3) == 0) return 1;
    }
    return 0;
}

int nph_cgroup_threads(const char *root) {
    char path[LINE_BYTES], line[LINE_BYTES];
    int least = 0, length = snprintf(path, sizeof path, "%s/proc/self/cgroup", root);
    if (length < 0 || (size_t)length >= sizeof path) return 0;
    FILE *file = fopen(path, "r");
    if (!file) return 0;
    while (fgets(line, sizeof line, file)) {
        line[strcspn(line, "\n")] = 0;
        char *list = strchr(line, ':'), *group = list ? strchr(list + 1, ':') : NULL;
        if (!group) continue;
        *group++ = 0;
        int version_2 = list[1] == 0;
        if (!version_2 && !lists_cpu(list + 1)) continue;
        int quota = least_quota(root, group, version_2 ? quota_v2 : quota_v1);
        if (quota > 0 && (least == 0 || quota < least)) least = quota;
    }
    fclose(file);
    return least;
}

/* A machine with more processors than the set holds makes the call fail; then those online count. */
static int bound_processors(void) {
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) == 0) return CPU_COUNT(&set);
    long online = sysconf(_SC_NPROCESSORS_ONLN);
    return online < 1 ? 1 : online < MOST_THREADS ? (int)online : MOST_THREADS;
}

int nph_usable_threads(const char *root) {
    int count = bound_processors(), limit = nph_cgroup_threads(root);
    if (limit > 0 && limit < count) count = limit;
    return count < 1 ? 1 : count < MOST_THREADS ? count : MOST_THREADS;
}
