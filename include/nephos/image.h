/* SPDX-License-Identifier: Apache-2.0
 *
 * Images with named channels and attributes: what OpenEXR files hold. Row 0 is the top row, x runs to the right. */
#ifndef NEPHOS_IMAGE_H
#define NEPHOS_IMAGE_H

#include "nephos/context.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct NphChannel {
    char *name;      /* full name with layer: "R", "Variance.R" */
    int was_half;    /* stored as half; the plane always holds floats */
    int was_uint;    /* stored as 32-bit integer */
    float *pixels;   /* width * height, row by row from the top */
} NphChannel;

typedef enum NphAttributeType {
    NPH_ATTRIBUTE_STRING,
    NPH_ATTRIBUTE_INT,
    NPH_ATTRIBUTE_FLOAT,
    NPH_ATTRIBUTE_DOUBLE
} NphAttributeType;

typedef struct NphAttribute {
    char *name;
    NphAttributeType type;
    char *text;     /* NPH_ATTRIBUTE_STRING */
    double number;  /* the other types */
} NphAttribute;

typedef struct NphImage {
    int x0, y0, width, height;        /* data window: its upper left pixel in the display window, and its size */
    int full_width, full_height;      /* display window, which begins at (0, 0); another origin is taken off */
    int channel_count;
    NphChannel *channels;             /* sorted as in the file, or as added */
    int attribute_count;
    NphAttribute *attributes;
} NphImage;

/* Makes an image without channels. */
NphStatus nph_image_new(NphContext *context, int width, int height, NphImage *image);
/* Adds a zeroed float channel; *pixels (may be NULL) receives its plane. */
NphStatus nph_image_add_channel(NphContext *context, NphImage *image, const char *name, float **pixels);
/* The channel of that name, or NULL. */
const NphChannel *nph_image_channel(const NphImage *image, const char *name);
NphStatus nph_image_set_text(NphContext *context, NphImage *image, const char *name, const char *text);
NphStatus nph_image_set_number(NphContext *context, NphImage *image, const char *name, NphAttributeType type,
                               double number);
const NphAttribute *nph_image_attribute(const NphImage *image, const char *name);
void nph_image_free(NphContext *context, NphImage *image);

/* OpenEXR. Reading takes scanline and tiled files (level 0), half, float and uint channels, and every compression but
 * DWAA and DWAB, which are refused by name. Writing gives one scanline part, ZIP, float channels in the given order's
 * alphabetical sort as the format demands; through a temporary name, synced and renamed. Neither stores a time. */
NphStatus nph_exr_read(NphContext *context, const char *path, NphImage *image);
NphStatus nph_exr_write(NphContext *context, const char *path, const NphImage *image);

#ifdef __cplusplus
}
#endif
#endif
