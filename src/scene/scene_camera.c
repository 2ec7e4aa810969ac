/* SPDX-License-Identifier: Apache-2.0
 *
 * The camera section to NphSensor: an orthonormal frame right, up, forward with right = forward x up, and the half size
 * of the picture: the tangent of the field of view, its angle (fisheye), or metres across the shorter side. */
#include <stdio.h>
#include <string.h>

#include "core/fmath.h"
#include "core/text.h"
#include "scene/scene_read.h"

static const double NEARLY_PARALLEL = 1e-6; /* sine of the smallest angle between up and the viewing direction */

static int read_forward(NphSceneReader *reader, const NphSceneSection *camera, double forward[3]) {
    const NphSceneValue *target = nph_section_value(camera, "look_at"),
                        *direction = nph_section_value(camera, "direction");
    const NphSceneValue *position = nph_section_value(camera, "position");
    if (camera->chosen[0] == 1 && direction) {
        if (nph_vector_normalise(direction->number, forward)) return 1;
        nph_scene_mistake(reader, direction->place, "direction has length 0");
    } else if (camera->chosen[0] == 0 && target && position) {
        double way[3];
        for (int i = 0; i < 3; i++) way[i] = target->number[i] - position->number[i];
        if (nph_vector_normalise(way, forward)) return 1;
        nph_scene_mistake(reader, target->place, "look_at is the camera's own position; it must lie elsewhere");
    }
    return 0;
}

static void read_frame(NphSceneReader *reader, const NphSceneSection *camera, NphSensor *sensor) {
    const NphSceneValue *up = nph_section_value(camera, "up");
    double unit[3], right[3];
    if (!read_forward(reader, camera, sensor->forward) || !up) return;
    if (!nph_vector_normalise(up->number, unit)) {
        nph_scene_mistake(reader, up->place, "up has length 0");
        return;
    }
    nph_vector_cross(sensor->forward, unit, right);
    double sine = nph_sqrt(right[0] * right[0] + right[1] * right[1] + right[2] * right[2]);
    if (sine < NEARLY_PARALLEL) {
        nph_scene_mistake(reader, up->place,
                          "up%s is parallel to the viewing direction; give another, such as [0, 1, 0]",
                          up->given ? "" : " (default [0, 0, 1])");
        return;
    }
    nph_vector_normalise(right, sensor->right);
    nph_vector_cross(sensor->right, sensor->forward, sensor->up);
}

static void read_size(const NphSceneSection *camera, NphSensor *sensor) {
    const NphSceneValue *resolution = nph_section_value(camera, "resolution"), *fov = nph_section_value(camera, "fov");
    const NphSceneValue *extent = nph_section_value(camera, "extent");
    double half = 1;
    if (!resolution) return;
    double width = resolution->number[0], height = resolution->number[1], shorter = width < height ? width : height;
    sensor->width = (int)width;
    sensor->height = (int)height;
    if (sensor->kind == NPH_SENSOR_FISHEYE && fov) {
        half = fov->number[0] * (3.14159265358979323846 / 360);
    } else if (sensor->kind == NPH_SENSOR_PERSPECTIVE && fov) {
        double sine, cosine;
        nph_sincos2pi(fov->number[0] / 720, &sine, &cosine);
        half = sine / cosine;
    } else if (extent) {
        half = extent->number[0] / 2;
    }
    sensor->half_size[0] = half * (width / shorter);
    sensor->half_size[1] = half * (height / shorter);
}

/* Parallel rays of a radiance sensor run where the scene says, of an orthographic camera along its direction. */
static void read_seen(NphSceneReader *reader, const NphSceneSection *camera, NphSensor *sensor) {
    const NphSceneValue *seen = nph_section_value(camera, "seen");
    memcpy(sensor->seen, sensor->forward, sizeof sensor->seen);
    if (sensor->kind != NPH_SENSOR_RADIANCE || !seen) return;
    if (!nph_vector_normalise(seen->number, sensor->seen))
        nph_scene_mistake(reader, seen->place, "seen has length 0; give the direction that one looks along");
}

static void read_crop(NphSceneReader *reader, const NphSceneSection *camera, NphSensor *sensor) {
    const NphSceneValue *crop = nph_section_value(camera, "crop");
    int whole[4] = {0, 0, sensor->width, sensor->height};
    memcpy(sensor->crop, whole, sizeof whole);
    if (!crop || !sensor->width) return;
    for (int i = 0; i < 4; i++) sensor->crop[i] = (int)crop->number[i];
    const int *c = sensor->crop;
    if (c[0] < c[2] && c[2] <= whole[2] && c[1] < c[3] && c[3] <= whole[3]) return;
    nph_scene_mistake(reader, crop->place,
                      "crop [%d, %d, %d, %d] is not within the picture; allowed: 0 <= x0 < x1 <= %d and "
                      "0 <= y0 < y1 <= %d",
                      c[0], c[1], c[2], c[3], whole[2], whole[3]);
}

void nph_scene_read_camera(NphSceneReader *reader, const yaml_node_t *node) {
    NphSceneSection camera;
    NphSensor *sensor = &reader->scene->sensor;
    if (!nph_section_read(reader, node, "camera", &camera)) return;
    const NphSceneValue *type = nph_section_value(&camera, "type"), *position = nph_section_value(&camera, "position");
    if (type) sensor->kind = (NphSensorKind)type->word;
    if (position) memcpy(sensor->position, position->number, sizeof sensor->position);
    read_frame(reader, &camera, sensor);
    read_size(&camera, sensor);
    read_seen(reader, &camera, sensor);
    read_crop(reader, &camera, sensor);
}
