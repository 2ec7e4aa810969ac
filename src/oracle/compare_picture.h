/* SPDX-License-Identifier: Apache-2.0
 *
 * A comparison as a picture for people: reference, candidate, signed relative difference and FLIP side by side, each with
 * its title and scale. */
#ifndef NPH_ORACLE_COMPARE_PICTURE_H
#define NPH_ORACLE_COMPARE_PICTURE_H

#include <stdint.h>

#include "nephos/flip.h"

enum { NPH_GLYPH_WIDTH = 5, NPH_GLYPH_HEIGHT = 7 };

typedef struct NphGlyph {
    char letter;
    uint8_t rows[NPH_GLYPH_HEIGHT];
} NphGlyph;
extern const NphGlyph nph_glyphs[];
extern const int nph_glyph_count;

/* 8-bit sRGB, height x width x 3, from the top row; freed with nph_free. */
typedef struct NphComparePicture {
    int width, height;
    uint8_t *rgb;
} NphComparePicture;

/* map: of nph_flip(a, b). Pictures narrower than 256 pixels are enlarged by a whole factor. */
NphStatus nph_compare_picture(NphContext *context, const NphImage *a, const NphImage *b, const NphFlip *flip,
                              const NphImage *map, NphComparePicture *picture);

#endif
