/* SPDX-License-Identifier: Apache-2.0
 *
 * What pictures and part files hold. */
#include <float.h>
#include <math.h>

#include "cli/info.h"
#include "core/message.h"
#include "nephos/film.h"

static void tell_channel(Info *info, const NphImage *image, const NphChannel *channel) {
    int64_t count = (int64_t)image->width * image->height, finite = 0;
    double sum = 0, min = 0, max = 0;
    for (int64_t i = 0; i < count; i++) {
        double value = channel->pixels[i];
        if (!isfinite(value)) continue;
        min = !finite || value < min ? value : min;
        max = !finite || value > max ? value : max;
        sum += value;
        finite++;
    }
    facts_row(&info->facts);
    facts_text(&info->facts, "name", channel->name);
    facts_text(&info->facts, "type", channel->was_half ? "half" : channel->was_uint ? "uint" : "float");
    facts_number(&info->facts, "min", min);
    facts_number(&info->facts, "max", max);
    facts_number(&info->facts, "mean", finite ? sum / (double)finite : 0);
    if (finite < count) facts_integer(&info->facts, "not_finite", count - finite);
    facts_end(&info->facts);
}

static void tell_attributes(Info *info, const NphImage *image) {
    facts_group(&info->facts, "attributes");
    for (int i = 0; i < image->attribute_count; i++) {
        const NphAttribute *attribute = &image->attributes[i];
        if (attribute->type == NPH_ATTRIBUTE_STRING) facts_text(&info->facts, attribute->name, attribute->text);
        else facts_number(&info->facts, attribute->name, attribute->number);
    }
    facts_end(&info->facts);
}

static void tell_image(Info *info, const NphImage *image) {
    facts_numbers(&info->facts, "size", 2, (double[]){image->width, image->height});
    facts_numbers(&info->facts, "upper_left", 2, (double[]){image->x0, image->y0});
    facts_numbers(&info->facts, "full_size", 2, (double[]){image->full_width, image->full_height});
    facts_list(&info->facts, "channels");
    for (int i = 0; i < image->channel_count; i++) tell_channel(info, image, &image->channels[i]);
    facts_end(&info->facts);
    tell_attributes(info, image);
}

/* The error of the picture's mean when R G B carry their variances. */
static void tell_noise(Info *info, const NphImage *image) {
    static const double weights[3] = {0.2126, 0.7152, 0.0722}; /* Rec. 709 luminance */
    static const char *const names[2][3] = {{"R", "G", "B"}, {"Variance.R", "Variance.G", "Variance.B"}};
    static const char *const own_names[3] = {"VarianceImage.R", "VarianceImage.G", "VarianceImage.B"};
    const NphChannel *planes[2][3];
    double mean = 0, variance = 0;
    int64_t count = (int64_t)image->width * image->height;
    for (int i = 0; i < 6; i++)
        if (!(planes[i / 3][i % 3] = nph_image_channel(image, names[i / 3][i % 3]))) return;
    for (int64_t i = 0; i < count; i++) {
        double deviation = 0;
        for (int c = 0; c < 3; c++) {
            mean += weights[c] * planes[0][c]->pixels[i];
            deviation += weights[c] * sqrt(planes[1][c]->pixels[i]);
        }
        variance += deviation * deviation;
    }
    if (!(mean > 0)) return;
    double error = sqrt(variance), own = 0;
    for (int c = 0; c < 3; c++) { /* where pixels share samples the picture states the error of its mean */
        const NphChannel *plane = nph_image_channel(image, own_names[c]);
        own = plane && own >= 0 ? own + weights[c] * sqrt((double)plane->pixels[0]) : -1;
    }
    if (own >= 0) error = own * (double)count;
    facts_number(&info->facts, "relative_error", error / mean);
    facts_number(&info->facts, "relative_rmse", sqrt(variance * (double)count) / mean);
}

NphStatus info_exr(Info *info) {
    NphImage image = {0};
    NPH_TRY(nph_exr_read(info->context, info->path, &image));
    tell_image(info, &image);
    tell_noise(info, &image);
    nph_image_free(info->context, &image);
    return NPH_OK;
}

NphStatus info_part(Info *info) {
    NphFilm *film = NULL;
    NphImage image = {0};
    NphFilmNoise noise;
    NPH_TRY(nph_film_read_part(info->context, info->path, &film));
    NphStatus status = nph_film_image(info->context, film, &image);
    nph_film_noise(film, &noise);
    nph_film_free(info->context, film);
    if (status != NPH_OK) return status;
    tell_image(info, &image);
    facts_number(&info->facts, "relative_error", noise.relative_error);
    facts_number(&info->facts, "relative_rmse", noise.relative_rmse);
    facts_integer(&info->facts, "samples_min", noise.samples_min);
    facts_integer(&info->facts, "samples_max", noise.samples_max);
    nph_image_free(info->context, &image);
    return NPH_OK;
}
