/* SPDX-License-Identifier: Apache-2.0
 *
 * See compare_picture.h. Both pictures are shown with one exposure, which the reference's 99th percentile of luminance
 * sets to 0.8 as in previews. Differences are of luminance, relative to the mean of both, so that noise gives no cast of
 * one colour, or to a tenth of the reference's mean where that is larger. */
#include "oracle/compare_picture.h"

#include <stdio.h>
#include <string.h>

#include "core/fmath.h"
#include "core/memory.h"
#include "core/message.h"
#include "core/text.h"
#include "oracle/compare_parts.h"

enum { PANELS = 4, NARROWEST = 256, TALLEST = 2048, LETTERS = 26, ADVANCE = NPH_GLYPH_WIDTH + 1 };

static const double percentile_shown = 0.8, dark = 0.1;
static const uint8_t ink[3] = {30, 30, 30}, paper = 255;

typedef struct Stops {
    int count;
    uint8_t rgb[9][3];
} Stops;

/* Less than the reference blue, more red. */
static const Stops diverging = {7, {{8, 29, 88}, {33, 102, 172}, {146, 197, 222}, {247, 247, 247}, {244, 165, 130},
                                    {178, 24, 43}, {80, 0, 20}}};
/* Nine points of the map magma by Smith and van der Walt (CC0), which FLIP is shown in [Andersson20 section 5]. */
static const Stops magma = {9, {{0, 0, 4}, {29, 17, 71}, {81, 18, 124}, {130, 38, 129}, {182, 54, 121}, {230, 81, 100},
                                {251, 136, 97}, {254, 194, 135}, {252, 253, 191}}};

typedef struct Canvas {
    NphPicturePair pair;
    const float *flip;
    NphComparePicture *picture;
    int zoom, scale, panel_width, gap, top; /* scale: of letters; top: first row of the panels */
    double factor, range, floor;            /* exposure; of the differences; least luminance that they are relative to */
} Canvas;

static uint8_t byte_of(double x) { return (uint8_t)nph_rint(255.0 * (x < 0.0 ? 0.0 : x > 1.0 ? 1.0 : x)); }

/* The transfer of sRGB [IEC 61966-2-1]. */
static double encode(double x) {
    if (!(x > 0.0)) return 0.0;
    if (x >= 1.0) return 1.0;
    return x <= 0.0031308 ? 12.92 * x : 1.055 * nph_pow(x, 1.0 / 2.4) - 0.055;
}

/* at in [0, 1]; what is outside takes the colour of the end. */
static void colour_of(const Stops *stops, double at, uint8_t rgb[3]) {
    double x = (at < 0.0 ? 0.0 : at > 1.0 ? 1.0 : at) * (stops->count - 1);
    int i = (int)x < stops->count - 1 ? (int)x : stops->count - 2;
    for (int c = 0; c < 3; c++) {
        double from = stops->rgb[i][c], to = stops->rgb[i + 1][c];
        rgb[c] = byte_of((from + (x - i) * (to - from)) / 255.0);
    }
}

static double difference_of(const Canvas *canvas, int64_t i) {
    double a = nph_pixel_luminance(&canvas->pair.a, i), b = nph_pixel_luminance(&canvas->pair.b, i);
    double size = 0.5 * (nph_abs(a) + nph_abs(b));
    return (a - b) / (size > canvas->floor ? size : canvas->floor);
}

static void panel_colour(const Canvas *canvas, int panel, int64_t i, uint8_t rgb[3]) {
    const NphPicture *shown = panel == 0 ? &canvas->pair.b : &canvas->pair.a;
    if (panel == 2) {
        colour_of(&diverging, 0.5 + 0.5 * difference_of(canvas, i) / canvas->range, rgb);
    } else if (panel == 3) {
        colour_of(&magma, (double)canvas->flip[i], rgb);
    } else {
        for (int c = 0; c < 3; c++) rgb[c] = byte_of(encode((double)shown->value[c][i] * canvas->factor));
    }
}

static void put_pixel(const Canvas *canvas, int x, int y, const uint8_t rgb[3]) {
    const NphComparePicture *picture = canvas->picture;
    if (x < 0 || y < 0 || x >= picture->width || y >= picture->height) return;
    memcpy(picture->rgb + 3 * ((int64_t)y * picture->width + x), rgb, 3);
}

static void put_square(const Canvas *canvas, int x, int y, int size, const uint8_t rgb[3]) {
    for (int row = 0; row < size; row++)
        for (int column = 0; column < size; column++) put_pixel(canvas, x + column, y + row, rgb);
}

static const NphGlyph *glyph_of(char letter) {
    char capital = letter >= 'a' && letter <= 'z' ? (char)(letter - 'a' + 'A') : letter;
    for (int i = 0; i < nph_glyph_count; i++)
        if (nph_glyphs[i].letter == capital) return &nph_glyphs[i];
    return &nph_glyphs[0];
}

static void put_text(const Canvas *canvas, int x, int y, const char *text) {
    int scale = canvas->scale;
    for (; *text; text++, x += ADVANCE * scale) {
        const NphGlyph *glyph = glyph_of(*text);
        for (int row = 0; row < NPH_GLYPH_HEIGHT; row++)
            for (int column = 0; column < NPH_GLYPH_WIDTH; column++)
                if (glyph->rows[row] >> (NPH_GLYPH_WIDTH - 1 - column) & 1)
                    put_square(canvas, x + column * scale, y + row * scale, scale, ink);
    }
}

static int text_width(const Canvas *canvas, const char *text) { return ((int)strlen(text) * ADVANCE - 1) * canvas->scale; }

static int panel_left(const Canvas *canvas, int panel) {
    return canvas->gap + panel * (canvas->panel_width + canvas->gap);
}

static void put_panel(const Canvas *canvas, int panel, const char *title) {
    int left = panel_left(canvas, panel), zoom = canvas->zoom;
    put_text(canvas, left, canvas->gap, title);
    for (int y = 0; y < canvas->pair.height; y++)
        for (int x = 0; x < canvas->pair.width; x++) {
            uint8_t rgb[3];
            panel_colour(canvas, panel, (int64_t)y * canvas->pair.width + x, rgb);
            put_square(canvas, left + x * zoom, canvas->top + y * zoom, zoom, rgb);
        }
}

/* The scale of colours below a panel and what its ends and its middle stand for. */
static void put_legend(const Canvas *canvas, int panel, const Stops *stops, const char *const words[3]) {
    int left = panel_left(canvas, panel), bar = NPH_GLYPH_HEIGHT * canvas->scale, last = canvas->panel_width - 1;
    int y = canvas->top + canvas->pair.height * canvas->zoom + canvas->gap;
    for (int x = 0; x <= last; x++) {
        uint8_t rgb[3];
        colour_of(stops, (double)x / last, rgb);
        for (int row = 0; row < bar; row++) put_pixel(canvas, left + x, y + row, rgb);
    }
    for (int i = 0; i < 3; i++)
        put_text(canvas, left + i * (canvas->panel_width - text_width(canvas, words[i])) / 2, y + bar + canvas->gap / 2,
                 words[i]);
}

static void put_words(const Canvas *canvas, int panel, const char *words) {
    put_text(canvas, panel_left(canvas, panel), canvas->top + canvas->pair.height * canvas->zoom + canvas->gap, words);
}

static double percentile_99(double *values, int64_t count) {
    int64_t rank = count - 1 - count / 100;
    nph_select_rank(values, count, rank);
    return values[rank];
}

/* The next number above x of 1, 2 or 5 times a power of ten. */
static double round_up(double x) {
    static const double digits[3] = {1.0, 2.0, 5.0};
    double decade = 1e-6;
    while (decade * 10.0 <= x) decade *= 10.0;
    for (int i = 0; i < 3; i++)
        if (digits[i] * decade >= x) return digits[i] * decade;
    return 10.0 * decade;
}

static NphStatus choose_scales(NphContext *context, Canvas *canvas) {
    double *values = NULL;
    int64_t pixels = canvas->pair.pixels;
    NPH_TRY(NPH_NEW(context, pixels, "luminances of a picture", &values));
    for (int64_t i = 0; i < pixels; i++) values[i] = nph_pixel_luminance(&canvas->pair.b, i);
    double bright = percentile_99(values, pixels);
    canvas->floor = dark * nph_pair_scale(&canvas->pair);
    if (!(bright > 0.0)) bright = nph_pair_scale(&canvas->pair);
    canvas->factor = percentile_shown / bright;
    for (int64_t i = 0; i < pixels; i++) values[i] = nph_abs(difference_of(canvas, i));
    canvas->range = canvas->pair.identical == pixels ? 0.01 : round_up(percentile_99(values, pixels));
    nph_free(context, values);
    return NPH_OK;
}

/* Letters so large that LETTERS of them fill a panel. */
static NphStatus lay_out(NphContext *context, Canvas *canvas, NphComparePicture *picture) {
    int width = canvas->pair.width, height = canvas->pair.height;
    int wide = (NARROWEST + width - 1) / width, tall = TALLEST / height;
    canvas->zoom = wide < tall ? wide : tall > 1 ? tall : 1;
    canvas->panel_width = width * canvas->zoom > NARROWEST ? width * canvas->zoom : NARROWEST;
    canvas->scale = canvas->panel_width / (ADVANCE * LETTERS);
    canvas->gap = 8 * canvas->scale;
    canvas->top = 2 * canvas->gap + NPH_GLYPH_HEIGHT * canvas->scale;
    NphComparePicture made = {.width = PANELS * canvas->panel_width + (PANELS + 1) * canvas->gap,
                              .height = canvas->top + height * canvas->zoom + 3 * canvas->gap +
                                        2 * NPH_GLYPH_HEIGHT * canvas->scale};
    size_t bytes = 3 * (size_t)made.width * (size_t)made.height;
    NPH_TRY(NPH_NEW(context, bytes, "picture of a comparison", &made.rgb));
    memset(made.rgb, paper, bytes);
    *picture = made;
    canvas->picture = picture;
    return NPH_OK;
}

static void draw(const Canvas *canvas, const NphFlip *flip) {
    char title[64], shown[64], number[NPH_DOUBLE_TEXT], low[NPH_DOUBLE_TEXT + 2], high[NPH_DOUBLE_TEXT + 2];
    NphPair stops = nph_log2_pair(canvas->factor);
    snprintf(shown, sizeof shown, "exposure %s stops", nph_format_rounded(stops.high, 3, number));
    put_panel(canvas, 0, "reference B");
    put_panel(canvas, 1, "candidate A");
    put_words(canvas, 0, shown);
    put_words(canvas, 1, shown);
    put_panel(canvas, 2, "(A - B) / mean of both");
    nph_format_rounded(100.0 * canvas->range, 6, number);
    snprintf(low, sizeof low, "-%.30s%%", number);
    snprintf(high, sizeof high, "+%.30s%%", number);
    put_legend(canvas, 2, &diverging, (const char *const[]){low, "0", high});
    snprintf(title, sizeof title, "%s-FLIP, mean %s", flip->kind == NPH_FLIP_LDR ? "LDR" : "HDR",
             nph_format_rounded(flip->mean, 3, number));
    put_panel(canvas, 3, title);
    put_legend(canvas, 3, &magma, (const char *const[]){"0", "0.5", "1"});
}

NphStatus nph_compare_picture(NphContext *context, const NphImage *a, const NphImage *b, const NphFlip *flip,
                              const NphImage *map, NphComparePicture *picture) {
    Canvas canvas;
    memset(&canvas, 0, sizeof canvas);
    NPH_TRY(nph_pair_read(context, a, b, &canvas.pair));
    if (a->width > 200000 || a->height > 900000)
        return nph_error(context, NPH_BAD_USAGE, "pictures of %d x %d pixels are too large to be shown side by side",
                         a->width, a->height);
    canvas.flip = nph_image_channel(map, "FLIP")->pixels;
    NPH_TRY(choose_scales(context, &canvas));
    NPH_TRY(lay_out(context, &canvas, picture));
    draw(&canvas, flip);
    return NPH_OK;
}
