/* SPDX-License-Identifier: Apache-2.0
 *
 * See page.h. A pixel is covered by a line as far as its middle lies within half the line's width, softly over one pixel. */
#include "cli/page.h"

#include <string.h>

#include "core/fmath.h"
#include "core/xml.h"
#include "oracle/compare_picture.h"

enum { LETTER_SCALE = 2, ADVANCE = (NPH_GLYPH_WIDTH + 1) * LETTER_SCALE };

void page_begin(Page *page) {
    if (page->rgb) memset(page->rgb, 255, (size_t)page->width * (size_t)page->height * 3);
    if (page->svg)
        fprintf(page->svg, "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" height=\"%d\" viewBox=\"0 0 %d %d\" font-family=\"sans-serif\" "
                "font-size=\"14\">\n<rect width=\"100%%\" height=\"100%%\" fill=\"#ffffff\"/>\n", page->width, page->height, page->width, page->height);
}

void page_end(Page *page) {
    if (page->svg) fputs("</svg>\n", page->svg);
}

static void cover(Page *page, int x, int y, double part, const uint8_t rgb[3]) {
    if (x < 0 || y < 0 || x >= page->width || y >= page->height || !(part > 0.0)) return;
    uint8_t *pixel = page->rgb + ((int64_t)y * page->width + x) * 3;
    for (int c = 0; c < 3; c++) {
        double mixed = pixel[c] + (part < 1.0 ? part : 1.0) * (rgb[c] - pixel[c]);
        pixel[c] = (uint8_t)(mixed + 0.5);
    }
}

static double square(double x) { return x * x; }

/* Middles of pixels stand at halves. */
static void draw_line(Page *page, const double a[2], const double b[2], double width, const uint8_t rgb[3]) {
    double reach = 0.5 * width + 1.0, length = square(b[0] - a[0]) + square(b[1] - a[1]);
    int lo[2], hi[2], most[2] = {page->width - 1, page->height - 1};
    for (int i = 0; i < 2; i++) {
        double low = (a[i] < b[i] ? a[i] : b[i]) - reach, high = (a[i] < b[i] ? b[i] : a[i]) + reach;
        lo[i] = low < 0.0 ? 0 : low > most[i] ? most[i] : (int)low;
        hi[i] = high < 0.0 ? 0 : high > most[i] ? most[i] : (int)high;
    }
    for (int y = lo[1]; y <= hi[1]; y++)
        for (int x = lo[0]; x <= hi[0]; x++) {
            double at[2] = {x + 0.5, y + 0.5}, along = 0.0;
            if (length > 0.0) along = ((at[0] - a[0]) * (b[0] - a[0]) + (at[1] - a[1]) * (b[1] - a[1])) / length;
            along = along < 0.0 ? 0.0 : along > 1.0 ? 1.0 : along;
            double away = nph_sqrt(square(at[0] - a[0] - along * (b[0] - a[0])) + square(at[1] - a[1] - along * (b[1] - a[1])));
            cover(page, x, y, 0.5 + 0.5 * width - away, rgb);
        }
}

void page_lines(Page *page, int count, const double *points, double width, const uint8_t rgb[3]) {
    if (count < 2) return;
    for (int i = 0; i + 1 < count && page->rgb; i++) draw_line(page, points + 2 * i, points + 2 * i + 2, width, rgb);
    if (!page->svg) return;
    fprintf(page->svg, "<polyline fill=\"none\" stroke=\"#%02x%02x%02x\" stroke-width=\"%.2g\" points=\"", rgb[0], rgb[1], rgb[2], width);
    for (int i = 0; i < count; i++) fprintf(page->svg, "%s%.2f,%.2f", i ? " " : "", points[2 * i], points[2 * i + 1]);
    fputs("\"/>\n", page->svg);
}

static const NphGlyph *glyph_of(char letter) {
    char capital = letter >= 'a' && letter <= 'z' ? (char)(letter - 'a' + 'A') : letter;
    for (int i = 0; i < nph_glyph_count; i++)
        if (nph_glyphs[i].letter == capital) return &nph_glyphs[i];
    return &nph_glyphs[0];
}

static void draw_text(Page *page, int left, int top, const char *text, const uint8_t rgb[3]) {
    for (; *text; text++, left += ADVANCE) {
        const NphGlyph *glyph = glyph_of(*text);
        for (int y = 0; y < NPH_GLYPH_HEIGHT * LETTER_SCALE; y++)
            for (int x = 0; x < NPH_GLYPH_WIDTH * LETTER_SCALE; x++)
                if (glyph->rows[y / LETTER_SCALE] >> (NPH_GLYPH_WIDTH - 1 - x / LETTER_SCALE) & 1) cover(page, left + x, top + y, 1.0, rgb);
    }
}

void page_text(Page *page, double x, double y, PageAlign align, const char *text, const uint8_t rgb[3]) {
    static const char *const anchors[] = {"start", "middle", "end"};
    double width = (double)strlen(text) * ADVANCE;
    int left = (int)(align == PAGE_LEFT ? x : align == PAGE_MIDDLE ? x - 0.5 * width : x - width);
    if (page->rgb) draw_text(page, left, (int)y - NPH_GLYPH_HEIGHT * LETTER_SCALE, text, rgb);
    if (!page->svg) return;
    fprintf(page->svg, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\" fill=\"#%02x%02x%02x\">", x, y, anchors[align], rgb[0], rgb[1], rgb[2]);
    nph_xml_text(nph_json_to_file, page->svg, text);
    fputs("</text>\n", page->svg);
}
