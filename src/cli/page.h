/* SPDX-License-Identifier: Apache-2.0
 *
 * Lines and words on a page, in pixels from the upper left: as SVG, or as pixels with soft edges. */
#ifndef NPH_CLI_PAGE_H
#define NPH_CLI_PAGE_H

#include <stdint.h>
#include <stdio.h>

#include "nephos/context.h"

typedef enum PageAlign { PAGE_LEFT, PAGE_MIDDLE, PAGE_RIGHT } PageAlign;

typedef struct Page {
    int width, height;
    FILE *svg;    /* or */
    uint8_t *rgb; /* [height][width][3] */
} Page;

void page_begin(Page *page);
void page_end(Page *page);
/* points: x, y, x, y, ... */
void page_lines(Page *page, int count, const double *points, double width, const uint8_t rgb[3]);
/* y is that of the letters' foot; letters outside of the glyphs' set become blanks in pixels. */
void page_text(Page *page, double x, double y, PageAlign align, const char *text, const uint8_t rgb[3]);

#endif
