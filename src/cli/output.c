/* SPDX-License-Identifier: Apache-2.0
 *
 * See output.h. */
#include "cli/output.h"

#include <math.h>
#include <string.h>

#include "core/message.h"

void output_add_options(OptionTable *table, Output *output) {
    option_add(table, (Option){.name = "output", .letter = 'o', .kind = OPTION_TEXT, .target = &output->path,
                               .value_name = "OUT.exr", .meaning = "the picture, or the part file with --part"});
    option_add(table, (Option){.name = "png", .kind = OPTION_SUFFIXED, .target = &output->png, .value_name = "[FILE]",
                               .suffix = ".png", .meaning = "an 8-bit preview too; FILE ends in .png, default: OUT.png"});
    option_add(table, (Option){.name = "exposure", .kind = OPTION_NUMBER, .target = &output->exposure_stops,
                               .value_name = "STOPS", .min = -60, .max = 60, .given = &output->exposure_given,
                               .meaning = "of the preview; default: its 99th percentile becomes 0.8"});
    option_add(table, (Option){.name = "part", .kind = OPTION_FLAG, .target = &output->part,
                               .meaning = "write a part file, which merge joins to the byte, instead of a picture"});
}

static int ends_in(const char *text, const char *suffix) {
    size_t n = strlen(text), m = strlen(suffix);
    return n > m && strcmp(text + n - m, suffix) == 0;
}

NphStatus output_check(const char *command, Session *session, Output *output) {
    if (!output->path) return usage_error(command, "where to? -o OUT.exr");
    if (!output->part && !ends_in(output->path, ".exr"))
        return usage_error(command, "-o %s: the picture is OpenEXR; name it *.exr (and --png for a preview)", output->path);
    if (output->part && ends_in(output->path, ".exr"))
        return usage_error(command, "-o %s: --part writes no OpenEXR; name it *.part", output->path);
    NPH_TRY(check_writable(session, output->path));
    if (!output->png) return NPH_OK;
    const char *name = strrchr(output->path, '/') ? strrchr(output->path, '/') : output->path;
    const char *dot = strrchr(name, '.');
    int stem = (int)(dot && dot > name ? dot - output->path : (long)strlen(output->path));
    int length = *output->png ? snprintf(output->png_path, sizeof output->png_path, "%s", output->png)
                              : snprintf(output->png_path, sizeof output->png_path, "%.*s.png", stem, output->path);
    if (length >= (int)sizeof output->png_path) return usage_error(command, "--png: the path is too long");
    if (!ends_in(output->png_path, ".png"))
        return usage_error(command, "--png=%s: expected a name that ends in .png", output->png);
    return check_writable(session, output->png_path);
}

static NphStatus write_picture(Session *session, const char *path, const NphFilm *film) {
    NphImage image = {0};
    NPH_TRY(nph_film_image(session->context, film, &image));
    NphStatus status = nph_exr_write(session->context, path, &image);
    nph_image_free(session->context, &image);
    return status;
}

NphStatus output_write(Session *session, const Output *output, const NphFilm *film) {
    NPH_TRY(output->part ? nph_film_write_part(session->context, film, output->path)
                         : write_picture(session, output->path, film));
    if (!output->png) return NPH_OK;
    return nph_film_write_png(session->context, film, output->exposure_given ? output->exposure_stops : (double)NAN,
                              output->png_path);
}
