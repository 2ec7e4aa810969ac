/* SPDX-License-Identifier: Apache-2.0
 *
 * Renders a scene written as YAML text and gives means with their standard errors. Used by tests/agreement and
 * tests/determinism. */
#ifndef NPH_TESTS_RENDER_CASE_H
#define NPH_TESTS_RENDER_CASE_H

#include "nephos/compare.h"
#include "nephos/render.h"

typedef struct RenderCase {
    NphContext *context;
    NphScene *scene;
    NphFilm *film;
    NphImage image;
    NphRenderStatistics statistics;
} RenderCase;

/* Fails the test case (with the messages) when anything goes wrong. threads 0: all. */
void render_case(RenderCase *render, const char *yaml, const NphRenderOptions *options, int threads);
/* The same, giving the status of parsing or rendering instead of failing; free with render_free whatever it was. */
NphStatus render_try(RenderCase *render, const char *yaml, const NphRenderOptions *options, int threads);
void render_free(RenderCase *render);

/* Mean of a channel ("R") over the picture, and its standard error from Variance.* (VarianceImage.* where pixels share
 * samples). */
double render_mean(const RenderCase *render, const char *channel);
double render_error(const RenderCase *render, const char *channel);

/* Every allocation of the run fails once: each fails the run with NPH_NO_MEMORY, and nothing is left behind. */
void render_without_memory(const char *yaml, const NphRenderOptions *options);
/* What the plan says and what the run takes differ by less than a tenth. */
void render_as_planned(const char *yaml, const NphRenderOptions *options);

/* Options with samples and precision set. */
NphRenderOptions render_options(int64_t samples, int precision);

/* snprintf into a rotating set of buffers. */
const char *render_text(const char *format, ...);

/* The comparator's verdict against a picture that is `value` everywhere, with a margin for the image (tiles: ten times
 * that). */
NphVerdict render_verdict(const RenderCase *render, double value, double margin, NphComparison *comparison);

#endif
