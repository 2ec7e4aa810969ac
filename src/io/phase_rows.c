/* SPDX-License-Identifier: Apache-2.0
 *
 * Rows of angle and value. */
#include "io/phase_rows.h"

#include "core/message.h"
#include "core/text.h"
#include "io/text_rows.h"

static NphStatus check(NphContext *context, const char *path, long long line, const double *row, const double *before) {
    char shown[NPH_DOUBLE_TEXT];
    if (!(row[0] >= 0.0 && row[0] <= 180.0))
        return nph_error(context, NPH_BAD_INPUT, "%s:%lld: the angle is %s; angles are 0 to 180 degrees", path, line,
                         nph_format_double(row[0], shown));
    if (!(row[1] >= 0.0))
        return nph_error(context, NPH_BAD_INPUT, "%s:%lld: the value is %s; values are at least 0", path, line,
                         nph_format_double(row[1], shown));
    if (before && !(row[0] > before[0]))
        return nph_error(context, NPH_BAD_INPUT, "%s:%lld: the angle does not lie above the one before", path, line);
    return NPH_OK;
}

NphStatus nph_phase_rows_read(NphContext *context, const char *path, NphArray *rows) {
    static const NphTextRows form = {"an angle in degrees and a value", {"angle", "value"}, 2, 0, check};
    return nph_text_rows_read(context, path, &form, rows);
}
