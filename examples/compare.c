/* SPDX-License-Identifier: Apache-2.0
 *
 * Are two pictures the same within their own error bars?
 *
 *     cc compare.c -o compare $(pkg-config --cflags --libs nephos)
 *     ./compare mine.exr reference.exr
 *
 * Both need the channels R G B, and Variance.R .G .B beside them as nephos writes them; without, only equal pixels are
 * the same. Exit status 0: same. 1: different, or too noisy to tell. docs/compare.md says how it is decided. */
#include <stdio.h>

#include "nephos/nephos.h"

static void on_message(void *user, NphMessageLevel level, const char *text) {
    (void)user;
    (void)level;
    fprintf(stderr, "%s\n", text);
}

static NphStatus judge(NphContext *context, const NphImage *a, const NphImage *b) {
    NphCompareOptions options;
    NphComparison comparison;

    /* Same means: within 0.2% over the whole image and 1% over its tiles. These are the margins to change. */
    nph_compare_options_default(&options);
    NphStatus status = nph_compare(context, a, b, &options, &comparison, NULL);
    if (status != NPH_OK) return status; /* the pictures cannot be compared: sizes, channels, NaN */

    printf("%s: %s\n", nph_verdict_name(comparison.verdict), comparison.reason);
    for (int c = NPH_RED; c <= NPH_BLUE; c++)
        printf("%c  %g against %g: %+.3g%% +- %.2g%%\n", "RGB"[c], comparison.mean_a[c], comparison.mean_b[c],
               100 * comparison.difference[c], 100 * comparison.standard_error[c]);
    return comparison.verdict == NPH_SAME ? NPH_OK : NPH_DIFFERENT;
}

int main(int argc, char **argv) {
    NphSettings settings;
    NphContext *context = NULL;
    NphImage a, b;
    if (argc != 3) {
        fprintf(stderr, "usage: %s A.exr B.exr\n", argv[0]);
        return NPH_BAD_USAGE;
    }
    nph_settings_default(&settings);
    settings.message = on_message;
    settings.threads = 1;
    NphStatus status = nph_context_open(&context, &settings);
    if (status != NPH_OK) return (int)status;

    status = nph_exr_read(context, argv[1], &a);
    if (status == NPH_OK) {
        status = nph_exr_read(context, argv[2], &b);
        if (status == NPH_OK) {
            status = judge(context, &a, &b);
            nph_image_free(context, &b);
        }
        nph_image_free(context, &a);
    }
    nph_context_close(context);
    return (int)status;
}
