/* SPDX-License-Identifier: Apache-2.0
 *
 * What a table of a phase function holds, and what becomes of it once it is normalised. */
#include "cli/info.h"
#include "core/message.h"
#include "io/phase_rows.h"
#include "optics/phase.h"

static void tell_rows(Info *info, const NphArray *rows) {
    const double *at = rows->data;
    int64_t last = rows->shape[0] - 1;
    double least = at[1], most = at[1], closest = 180.0;
    for (int64_t i = 0; i <= last; i++) {
        double step = i > 0 ? at[2 * i] - at[2 * i - 2] : 180.0;
        least = at[2 * i + 1] < least ? at[2 * i + 1] : least;
        most = at[2 * i + 1] > most ? at[2 * i + 1] : most;
        closest = step < closest ? step : closest;
    }
    facts_integer(&info->facts, "rows", last + 1);
    facts_numbers(&info->facts, "angles_from_to_degrees", 2, (double[]){at[0], at[2 * last]});
    facts_number(&info->facts, "closest_rows_degrees", closest);
    facts_numbers(&info->facts, "values_from_to", 2, (double[]){least, most});
}

NphStatus info_phase(Info *info) {
    NphArray rows = {0};
    NphPhase phase = {.kind = NPH_PHASE_ISOTROPIC};
    NPH_TRY(nph_phase_rows_read(info->context, info->path, &rows));
    tell_rows(info, &rows);
    NphStatus status = nph_phase_tabulate(info->context, &rows, info->path, &phase);
    nph_array_free(info->context, &rows);
    NPH_TRY(status);
    facts_number(&info->facts, "mean_cosine", nph_phase_mean_cosine(&phase));
    facts_numbers(&info->facts, "at_0_90_180_degrees_per_sr", 3,
                  (double[]){nph_phase_value(&phase, 1.0), nph_phase_value(&phase, 0.0), nph_phase_value(&phase, -1.0)});
    facts_number(&info->facts, "peak_per_sr", nph_phase_peak(&phase));
    facts_number(&info->facts, "part_beyond_90_degrees", phase.table->half[1].part[phase.table->half[1].count]);
    nph_phase_free(info->context, &phase);
    return NPH_OK;
}
