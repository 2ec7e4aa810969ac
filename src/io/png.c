/* SPDX-License-Identifier: Apache-2.0
 *
 * 8-bit sRGB previews through libpng: chunks IHDR, sRGB, IDAT, IEND and no others (no time, no text). Compression level
 * and row filter are fixed, so equal pixels are equal bytes. Errors leave libpng by longjmp, with its text kept. */
#include <png.h>
#include <setjmp.h>
#include <string.h>

#include "core/message.h"
#include "io/file.h"
#include "io/volume.h"

enum { ZIP_LEVEL = 6, MAX_SIZE = 1000000 /* libpng's own limit for width and height */ };

typedef struct Writer {
    NphWriter file;
    char text[128];
} Writer;

static void note_error(png_structp png, png_const_charp text) {
    Writer *writer = png_get_error_ptr(png);
    snprintf(writer->text, sizeof writer->text, "%s", text);
    png_longjmp(png, 1);
}

static void ignore_warning(png_structp png, png_const_charp text) {
    (void)png;
    (void)text;
}

static void write_bytes(png_structp png, png_bytep bytes, png_size_t size) {
    Writer *writer = png_get_io_ptr(png);
    if (fwrite(bytes, 1, size, writer->file.stream) != size) png_error(png, "write error");
}

static void flush_nothing(png_structp png) { (void)png; }

/* 1 when the picture is in the stream; nothing here changes between setjmp and longjmp. */
static int write_picture(Writer *writer, png_structp png, png_infop info, const int size[2], const uint8_t *rgb) {
    if (setjmp(png_jmpbuf(png))) return 0;
    png_set_write_fn(png, writer, write_bytes, flush_nothing);
    png_set_IHDR(png, info, (png_uint_32)size[0], (png_uint_32)size[1], 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_set_compression_level(png, ZIP_LEVEL);
    png_set_filter(png, PNG_FILTER_TYPE_DEFAULT, PNG_FILTER_PAETH);
    png_write_info(png, info);
    for (int y = 0; y < size[1]; y++) png_write_row(png, rgb + (size_t)y * (size_t)size[0] * 3);
    png_write_end(png, NULL);
    return 1;
}

NphStatus nph_png_write(NphContext *context, const char *path, int width, int height, const uint8_t *rgb) {
    if (width < 1 || height < 1 || width > MAX_SIZE || height > MAX_SIZE)
        return nph_error(context, NPH_BAD_USAGE, "%s: a PNG of %d x %d pixels; 1 to %d are possible", path, width,
                         height, MAX_SIZE);
    Writer writer = {{0}, ""};
    NPH_TRY(nph_writer_open(context, path, &writer.file));
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &writer, note_error, ignore_warning);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    NphStatus status = NPH_OK;
    if (!info)
        status = nph_error(context, NPH_NO_MEMORY, "%s: libpng cannot start", path);
    else if (!write_picture(&writer, png, info, (const int[]){width, height}, rgb) && !ferror(writer.file.stream))
        status = nph_error(context, NPH_BAD_OUTPUT, "%s: cannot write PNG: %s", path, writer.text);
    if (png) png_destroy_write_struct(&png, &info);
    if (status == NPH_OK) status = nph_writer_commit(context, &writer.file); /* tells the reason of a failed write */
    nph_writer_abandon(context, &writer.file);
    return status;
}
