/* SPDX-License-Identifier: Apache-2.0
 *
 * The sensor as photons meet it. A pixel is the mean over its area A of the sensor (in tangents, metres, radians), so
 * what a vertex at r from the sensor sends towards it with intensity I [W/sr], T of which arrives, adds I T factor:
 *   pinhole       z the depth, c = z / r        dA / d omega = 1 / c^3          factor = 1 / (r^2 c^3 A)
 *   fisheye       angle q from the axis         dA / d omega = q / sin q        factor = q / (sin q r^2 A)
 *   orthographic, radiance: seen along v, n the rectangle's normal              factor = 1 / (A |v . n|)
 * A flux sensor counts the power of photons that cross it from its side: 1 / A each; fluence 1 / (A |cos|).
 *
 * Where sides repeat, or nothing changes along x and y, every crossing stands for a lattice of them. */
#ifndef NPH_TRUTH_LIGHT_2_CONNECT_LOOKUP_H
#define NPH_TRUTH_LIGHT_2_CONNECT_LOOKUP_H

#include "truth/light/light_state.h"

/* What a vertex, or a crossing, finds. */
typedef struct RArrival {
    Real d[3], distance; /* towards the sensor */
    Real factor;
    double s, t;         /* on the sensor, -1 to 1 */
} RArrival;

static inline double r_dot64(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* p seen from the sensor's position. */
static inline void r_from_sensor(const RScene *scene, const Real p[3], double out[3]) {
    for (int a = 0; a < 3; a++) out[a] = (double)p[a] - (scene->sensor.position[a] - scene->origin[a]);
}

static inline double r_pixel_area(const RScene *scene) {
    const double *half = scene->sensor.half_size;
    return 4.0 * half[0] * half[1] / ((double)scene->width * (double)scene->height);
}

/* Towards a point: pinhole and fisheye. 0: not in the picture. */
static inline int r_arrive_at_point(const RScene *scene, const Real p[3], RArrival *arrival) {
    const NphSensor *sensor = &scene->sensor;
    double rel[3], squared, r, side, factor;
    r_from_sensor(scene, p, rel);
    squared = r_dot64(rel, rel);
    if (!(squared > 0.0)) return 0;
    r = nph_sqrt(squared);
    double z = r_dot64(rel, sensor->forward), x = r_dot64(rel, sensor->right), y = r_dot64(rel, sensor->up);
    if (sensor->kind == NPH_SENSOR_PERSPECTIVE) {
        if (!(z > 0.0)) return 0;
        side = 1.0 / z;
        factor = r / (z * z * z);
    } else {
        double across = nph_sqrt(x * x + y * y), angle = nph_atan2(across, z), *half = (double *)sensor->half_size;
        if (angle > (half[0] < half[1] ? half[0] : half[1])) return 0;
        side = across > 0.0 ? angle / across : 1.0 / r;
        factor = side / r; /* angle / (sin angle r^2) */
    }
    arrival->s = x * side / sensor->half_size[0];
    arrival->t = y * side / sensor->half_size[1];
    if (!(nph_abs(arrival->s) < 1.0) || !(nph_abs(arrival->t) < 1.0)) return 0;
    for (int a = 0; a < 3; a++) arrival->d[a] = (Real)(-rel[a] / r);
    arrival->distance = (Real)r;
    arrival->factor = (Real)(factor / r_pixel_area(scene));
    return 1;
}

/* The point of the sensor's plane that lies along the unit direction d from p; 0 when none does. */
static inline int r_arrive_at_plane(const RScene *scene, const Real p[3], const double d[3], RArrival *arrival) {
    const NphSensor *sensor = &scene->sensor;
    double rel[3], slope = r_dot64(d, sensor->forward);
    r_from_sensor(scene, p, rel);
    double distance = -r_dot64(rel, sensor->forward) / slope;
    if (!(distance > 0.0 && distance < 1e30)) return 0;
    for (int a = 0; a < 3; a++) {
        rel[a] += distance * d[a];
        arrival->d[a] = (Real)d[a];
    }
    arrival->distance = (Real)distance;
    arrival->s = r_dot64(rel, sensor->right) / sensor->half_size[0];
    arrival->t = r_dot64(rel, sensor->up) / sensor->half_size[1];
    arrival->factor = (Real)(1.0 / (r_pixel_area(scene) * nph_abs(slope)));
    return 1;
}

/* Along the one direction in which an orthographic camera or a radiance sensor sees. A camera outside all that repeats
 * is met wherever it is reached. */
static inline int r_arrive_along(const RScene *scene, const NphLightAim *aim, const Real p[3], RArrival *arrival) {
    const double *seen = scene->sensor.seen;
    double d[3] = {-seen[0], -seen[1], -seen[2]};
    if (aim->wrapped && scene->sensor.kind == NPH_SENSOR_ORTHOGRAPHIC) {
        double rel[3];
        r_from_sensor(scene, p, rel);
        for (int a = 0; a < 3; a++) arrival->d[a] = (Real)d[a];
        arrival->distance = R_HUGE;
        arrival->s = r_dot64(rel, scene->sensor.right) / scene->sensor.half_size[0];
        arrival->t = r_dot64(rel, scene->sensor.up) / scene->sensor.half_size[1];
        arrival->factor = (Real)(1.0 / r_pixel_area(scene));
        return 1;
    }
    return r_arrive_at_plane(scene, p, d, arrival);
}

/* A photon at p that goes along d and crosses a sensor that gathers: its factor is 1 / A for flux, 1 / (A |cos|) for
 * fluence. */
static inline int r_arrive_by_flight(const RScene *scene, const Real p[3], const Real d[3], RArrival *arrival) {
    const NphSensor *sensor = &scene->sensor;
    double along[3] = {(double)d[0], (double)d[1], (double)d[2]};
    if (sensor->kind == NPH_SENSOR_FLUX && !(r_dot64(along, sensor->forward) < 0.0)) return 0;
    if (!r_arrive_at_plane(scene, p, along, arrival)) return 0;
    if (sensor->kind == NPH_SENSOR_FLUX) arrival->factor = (Real)(1.0 / r_pixel_area(scene));
    return 1;
}

/* Calls of `one` for every point of the lattice that lies on the sensor; a single one where nothing repeats. */
typedef void (*RArrivedFn)(void *user, int x, int y);

static inline void r_arrive_one(const RScene *scene, double s, double t, RArrivedFn one, void *user) {
    if (!(s >= -1.0 && s < 1.0 && t > -1.0 && t <= 1.0)) return;
    int x = (int)((s + 1.0) * 0.5 * (double)scene->width), y = (int)((1.0 - t) * 0.5 * (double)scene->height);
    one(user, x < scene->width ? x : scene->width - 1, y < scene->height ? y : scene->height - 1);
}

static inline void r_arrive(const RScene *scene, const NphLightAim *aim, const RArrival *arrival, RArrivedFn one,
                            void *user) {
    if (!aim->wrapped) {
        r_arrive_one(scene, arrival->s, arrival->t, one, user);
        return;
    }
    double lo[2] = {1e300, 1e300}, hi[2] = {-1e300, -1e300};
    for (int corner = 0; corner < 4; corner++) { /* the sensor's rectangle in steps of the lattice */
        double s = (corner & 1 ? 1.0 : -1.0) - arrival->s, t = (corner & 2 ? 1.0 : -1.0) - arrival->t;
        for (int k = 0; k < 2; k++) {
            double step = aim->steps_from_st[k][0] * s + aim->steps_from_st[k][1] * t;
            lo[k] = step < lo[k] ? step : lo[k];
            hi[k] = step > hi[k] ? step : hi[k];
        }
    }
    double first[2] = {nph_floor(lo[0]), nph_floor(lo[1])};
    int steps[2];
    for (int k = 0; k < 2; k++) { /* whole numbers have no end near 2^53, where nearly level flights arrive */
        double span = hi[k] - first[k];
        steps[k] = span < 1e9 ? (int)span : 0;
    }
    for (int m = 0; m <= steps[0]; m++)
        for (int n = 0; n <= steps[1]; n++) {
            double i = first[0] + (double)m, j = first[1] + (double)n;
            r_arrive_one(scene, arrival->s + i * aim->st_from_steps[0][0] + j * aim->st_from_steps[0][1],
                         arrival->t + i * aim->st_from_steps[1][0] + j * aim->st_from_steps[1][1], one, user);
        }
}

#endif
