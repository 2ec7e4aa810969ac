/* SPDX-License-Identifier: Apache-2.0
 *
 * Options are checked here, once, for plan, render and replay. */
#include "method/job.h"

#include <stdio.h>
#include <string.h>

#include "core/message.h"
#include "core/text.h"

void nph_render_options_default(NphRenderOptions *options) {
    memset(options, 0, sizeof *options);
    options->method = "path";
    options->precision = 32;
}

static NphStatus check_samples(NphContext *context, const NphScene *scene, const NphRenderOptions *o, NphJob *job) {
    if (o->samples < 0 || o->samples > NPH_MAX_SAMPLES)
        return nph_error(context, NPH_BAD_USAGE, "samples: %lld is not in 1 to %d", (long long)o->samples, NPH_MAX_SAMPLES);
    if (o->sample_begin || o->sample_end) {
        if (o->sample_begin < 0 || o->sample_end <= o->sample_begin || o->sample_end > NPH_MAX_SAMPLES ||
            o->sample_begin % NPH_CHUNK || o->sample_end % NPH_CHUNK)
            return nph_error(context, NPH_BAD_USAGE,
                             "samples %lld:%lld: a range takes multiples of %d, the first below the second",
                             (long long)o->sample_begin, (long long)o->sample_end, NPH_CHUNK);
        if (o->target_error > 0.0 || o->time_budget_s > 0.0)
            return nph_error(context, NPH_BAD_USAGE, "a range of samples goes with neither a target error nor a time budget");
        job->sample_begin = o->sample_begin;
        job->sample_end = o->sample_end;
        return NPH_OK;
    }
    int open_ended = (o->target_error > 0.0 || o->time_budget_s > 0.0) && o->samples == 0;
    int64_t samples = o->samples ? o->samples : open_ended ? 1 << 20 : scene->default_spp;
    job->sample_begin = 0;
    job->sample_end = (samples + NPH_CHUNK - 1) / NPH_CHUNK * NPH_CHUNK;
    return NPH_OK;
}

static NphStatus check_crop(NphContext *context, const NphScene *scene, const NphRenderOptions *o, NphJob *job) {
    const NphSensor *s = &scene->sensor;
    const int *crop = o->crop_given ? o->crop : s->crop;
    if (crop[0] < 0 || crop[1] < 0 || crop[2] > s->width || crop[3] > s->height || crop[0] >= crop[2] || crop[1] >= crop[3])
        return nph_error(context, NPH_BAD_USAGE, "crop %d,%d,%d,%d: x0 < x1 <= %d and y0 < y1 <= %d are needed", crop[0],
                         crop[1], crop[2], crop[3], s->width, s->height);
    memcpy(job->crop, crop, sizeof job->crop);
    return NPH_OK;
}

static NphStatus set_knob(NphContext *context, const NphMethod *method, const char *setting, NphJob *job) {
    const char *equals = strchr(setting, '=');
    size_t length = equals ? (size_t)(equals - setting) : strlen(setting);
    for (int k = 0; k < method->knob_count; k++) {
        const NphKnob *knob = &method->knobs[k];
        if (strlen(knob->name) != length || strncmp(knob->name, setting, length) != 0) continue;
        double value = 0.0;
        if (!equals || !nph_parse_double(equals + 1, &value) || !(value >= knob->min && value <= knob->max))
            return nph_error(context, NPH_BAD_USAGE, "knob %s: '%s' is not a number in %g to %g", knob->name,
                             equals ? equals + 1 : "", knob->min, knob->max);
        job->knobs[k] = value;
        return NPH_OK;
    }
    char known[512] = "";
    for (int k = 0; k < method->knob_count; k++) {
        size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, "%s%s", k ? ", " : "", method->knobs[k].name);
    }
    return nph_error(context, NPH_BAD_USAGE, "method %s has no knob '%.*s'; it has: %s", method->name, (int)length, setting,
                     known);
}

/* With the same random numbers for all frames, or samples of which nobody knows how many there will be, each frame is for itself. */
static int keeps_frames(const NphRenderOptions *o) { return !o->lock_noise && !(o->target_error > 0.0) && !(o->time_budget_s > 0.0); }

NphStatus nph_job_make(NphContext *context, const NphScene *scene, const NphRenderOptions *o, const NphMethod **method,
                       NphJob *job) {
    NphJob made = {.context = context, .scene = scene, .precision = o->precision, .plan_full = o->plan_full};
    const NphMethod *found = NULL;
    NPH_TRY(nph_method_find(context, o->method ? o->method : "path", &found));
    if (nph_scene_is_spectral(scene) && !found->takes_wavelengths)
        return nph_error(context, NPH_BAD_USAGE, "method %s does not render wavelengths, and %s has %d; path does",
                         found->name, scene->name, scene->wavelength_count);
    if (o->precision != 32 && o->precision != 64)
        return nph_error(context, NPH_BAD_USAGE, "precision: f32 and f64 exist, not %d bits", o->precision);
    if (!(o->target_error >= 0.0) || !(o->time_budget_s >= 0.0))
        return nph_error(context, NPH_BAD_USAGE, "target error and time budget must not be negative");
    if (o->frame > 0xffffffu) return nph_error(context, NPH_BAD_USAGE, "frame: %u is above 16777215", o->frame);
    NPH_TRY(check_samples(context, scene, o, &made));
    NPH_TRY(check_crop(context, scene, o, &made));
    made.seed = o->seed_given ? o->seed : scene->default_seed;
    made.frame = o->lock_noise ? 0 : o->frame;
    made.sequence = o->sequence && keeps_frames(o);
    for (int k = 0; k < found->knob_count; k++) made.knobs[k] = found->knobs[k].value;
    for (int k = 0; k < o->knob_count; k++) NPH_TRY(set_knob(context, found, o->knobs[k], &made));
    *method = found;
    *job = made;
    return NPH_OK;
}

NphStatus nph_job_describe(const NphJob *job, const NphMethod *method, NphFilm *film) {
    NphContext *context = job->context;
    char text[1024] = "", number[NPH_DOUBLE_TEXT];
    for (int i = 0; i < 16; i++) snprintf(text + 2 * i, 3, "%02x", job->scene->digest[i]);
    NPH_TRY(nph_film_set_text(context, film, "digest", text));
    snprintf(text, sizeof text, "%u", job->seed);
    NPH_TRY(nph_film_set_text(context, film, "seed", text));
    snprintf(text, sizeof text, "%u", job->frame);
    NPH_TRY(nph_film_set_text(context, film, "frame", text));
    NPH_TRY(nph_film_set_text(context, film, "method", method->name));
    NPH_TRY(nph_film_set_text(context, film, "precision", job->precision == 32 ? "f32" : "f64"));
    text[0] = 0;
    for (int k = 0; k < method->knob_count; k++) {
        size_t used = strlen(text);
        nph_format_double(job->knobs[k], number);
        snprintf(text + used, sizeof text - used, "%s%s=%s", k ? " " : "", method->knobs[k].name, number);
    }
    NPH_TRY(nph_film_set_text(context, film, "knobs", text));
    snprintf(text, sizeof text, "nephos %s", nph_version());
    return nph_film_set_text(context, film, "software", text);
}
