/* SPDX-License-Identifier: Apache-2.0
 *
 * The container of nephos/image.h: planes by name, attributes by name. Names are checked here, so that whatever an
 * NphImage holds can be written. */
#include "nephos/image.h"

#include <float.h>
#include <limits.h>
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "io/exr.h"

enum { NAME_BYTES = 255 /* of OpenEXR's long names */ };

static NphStatus check_name(NphContext *context, const char *what, const char *name) {
    if (!name[0]) return nph_error(context, NPH_BAD_USAGE, "an image's %s has an empty name", what);
    if (strlen(name) > NAME_BYTES)
        return nph_error(context, NPH_BAD_USAGE, "an image's %s has a name of %zu bytes; %d are allowed: \"%.40s...\"",
                         what, strlen(name), NAME_BYTES, name);
    return NPH_OK;
}

NphStatus nph_image_new(NphContext *context, int width, int height, NphImage *image) {
    if (width < 1 || height < 1)
        return nph_error(context, NPH_BAD_USAGE, "an image of %d x %d pixels; both must be 1 or more", width, height);
    NphImage made = {.width = width, .height = height, .full_width = width, .full_height = height};
    *image = made;
    return NPH_OK;
}

NphStatus nph_image_add_channel(NphContext *context, NphImage *image, const char *name, float **pixels) {
    NPH_TRY(check_name(context, "channel", name));
    if (nph_image_channel(image, name))
        return nph_error(context, NPH_BAD_USAGE, "an image's channel \"%s\" is added twice", name);
    NPH_TRY(nph_realloc(context, (size_t)image->channel_count + 1, sizeof *image->channels, "channels of an image",
                        (void **)&image->channels));
    NphChannel made = {0};
    NPH_TRY(nph_strdup(context, name, &made.name));
    /* nph_alloc sees one product: width * height < 2^62 fits a size_t */
    NphStatus status =
        nph_alloc(context, (size_t)image->width * (size_t)image->height, sizeof(float), name, (void **)&made.pixels);
    if (status != NPH_OK) {
        nph_free(context, made.name);
        return status;
    }
    image->channels[image->channel_count++] = made;
    if (pixels) *pixels = made.pixels;
    return NPH_OK;
}

const NphChannel *nph_image_channel(const NphImage *image, const char *name) {
    for (int i = 0; i < image->channel_count; i++)
        if (strcmp(image->channels[i].name, name) == 0) return &image->channels[i];
    return NULL;
}

const NphAttribute *nph_image_attribute(const NphImage *image, const char *name) {
    for (int i = 0; i < image->attribute_count; i++)
        if (strcmp(image->attributes[i].name, name) == 0) return &image->attributes[i];
    return NULL;
}

/* Puts *made (whose text is owned by the image from here on, also on failure) under its name, in place of an older one. */
static NphStatus set_attribute(NphContext *context, NphImage *image, const char *name, NphAttribute *made) {
    NphAttribute *old = (NphAttribute *)nph_image_attribute(image, name);
    NphStatus status = NPH_OK;
    if (!old) {
        status = nph_realloc(context, (size_t)image->attribute_count + 1, sizeof *image->attributes,
                             "attributes of an image", (void **)&image->attributes);
        if (status == NPH_OK) status = nph_strdup(context, name, &made->name);
    }
    if (status != NPH_OK) {
        nph_free(context, made->text);
        return status;
    }
    if (old) {
        made->name = old->name;
        nph_free(context, old->text);
        *old = *made;
    } else {
        image->attributes[image->attribute_count++] = *made;
    }
    return NPH_OK;
}

static NphStatus check_attribute_name(NphContext *context, const char *name) {
    NPH_TRY(check_name(context, "attribute", name));
    if (nph_exr_reserved_name(name))
        return nph_error(context, NPH_BAD_USAGE, "an image's attribute \"%s\": OpenEXR keeps this name for itself",
                         name);
    return NPH_OK;
}

NphStatus nph_image_set_text(NphContext *context, NphImage *image, const char *name, const char *text) {
    NPH_TRY(check_attribute_name(context, name));
    if (strlen(text) > INT_MAX / 2)
        return nph_error(context, NPH_BAD_USAGE, "an image's attribute \"%s\" holds more than a gigabyte", name);
    NphAttribute made = {.type = NPH_ATTRIBUTE_STRING};
    NPH_TRY(nph_strdup(context, text, &made.text));
    return set_attribute(context, image, name, &made);
}

NphStatus nph_image_set_number(NphContext *context, NphImage *image, const char *name, NphAttributeType type,
                               double number) {
    NPH_TRY(check_attribute_name(context, name));
    if (type == NPH_ATTRIBUTE_STRING)
        return nph_error(context, NPH_BAD_USAGE, "an image's attribute \"%s\": a number cannot be of type string",
                         name);
    if (type == NPH_ATTRIBUTE_INT && !(number >= INT32_MIN && number <= INT32_MAX && (double)(int32_t)number == number))
        return nph_error(context, NPH_BAD_USAGE, "an image's attribute \"%s\": %.17g is not a 32-bit integer", name,
                         number);
    if (type == NPH_ATTRIBUTE_FLOAT && (number < -FLT_MAX || number > FLT_MAX) && number - number == 0)
        return nph_error(context, NPH_BAD_USAGE, "an image's attribute \"%s\": %.17g is beyond a float", name, number);
    NphAttribute made = {.type = type, .number = type == NPH_ATTRIBUTE_FLOAT ? (double)(float)number : number};
    return set_attribute(context, image, name, &made);
}

void nph_image_free(NphContext *context, NphImage *image) {
    for (int i = 0; i < image->channel_count; i++) {
        nph_free(context, image->channels[i].name);
        nph_free(context, image->channels[i].pixels);
    }
    for (int i = 0; i < image->attribute_count; i++) {
        nph_free(context, image->attributes[i].name);
        nph_free(context, image->attributes[i].text);
    }
    nph_free(context, image->channels);
    nph_free(context, image->attributes);
    memset(image, 0, sizeof *image);
}
