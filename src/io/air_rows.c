/* SPDX-License-Identifier: Apache-2.0
 *
 * Rows of a profile of the atmosphere, turned upside down: heights rise. */
#include "io/air_rows.h"

#include "core/message.h"
#include "core/text.h"
#include "io/text_rows.h"

static const double MOST_KM = 1e5;

enum { HEIGHT, PRESSURE, TEMPERATURE, AIR, COLUMNS };

static NphStatus check(NphContext *context, const char *path, long long line, const double *row, const double *before) {
    char shown[NPH_DOUBLE_TEXT];
    if (!(row[HEIGHT] >= 0.0 && row[HEIGHT] <= MOST_KM))
        return nph_error(context, NPH_BAD_INPUT, "%s:%lld: the height is %s; heights are 0 to 1e5 km", path, line,
                         nph_format_double(row[HEIGHT], shown));
    if (!(row[AIR] > 0.0))
        return nph_error(context, NPH_BAD_INPUT, "%s:%lld: the air is %s; there are more than 0 molecules", path, line,
                         nph_format_double(row[AIR], shown));
    if (before && !(row[HEIGHT] < before[HEIGHT]))
        return nph_error(context, NPH_BAD_INPUT, "%s:%lld: the height does not lie below the one before", path, line);
    if (before && !(row[AIR] > before[AIR]))
        return nph_error(context, NPH_BAD_INPUT, "%s:%lld: the air is not denser than in the level above", path, line);
    return NPH_OK;
}

NphStatus nph_air_rows_read(NphContext *context, const char *path, NphArray *rows) {
    static const NphTextRows form = {"height in km, pressure, temperature and molecules of air per cm3",
                                     {"height", "pressure", "temperature", "air"}, COLUMNS, 1, check};
    char shown[NPH_DOUBLE_TEXT];
    NphArray levels = {0}, made = {0};
    NPH_TRY(nph_text_rows_read(context, path, &form, &levels));
    int64_t count = levels.shape[0];
    const double *from = levels.data, *lowest = from + COLUMNS * (count - 1);
    NphStatus status = lowest[HEIGHT] == 0.0
                           ? nph_array_new(context, NPH_F64, 2, (int64_t[]){count, 2}, path, &made)
                           : nph_error(context, NPH_BAD_INPUT, "%s: the lowest level lies at %s km; a profile ends at height 0",
                                       path, nph_format_double(lowest[HEIGHT], shown));
    for (int64_t i = 0; i < count && status == NPH_OK; i++) {
        double *to = (double *)made.data + 2 * i;
        to[0] = 1000.0 * from[COLUMNS * (count - 1 - i) + HEIGHT];
        to[1] = from[COLUMNS * (count - 1 - i) + AIR];
    }
    nph_array_free(context, &levels);
    if (status == NPH_OK) *rows = made;
    return status;
}
