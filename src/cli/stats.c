/* SPDX-License-Identifier: Apache-2.0
 *
 * See stats.h. */
#include "cli/stats.h"

#include <sys/utsname.h>
#include <time.h>

#include "core/message.h"
#include "io/file.h"

void stats_environment(NphJson *json, const Session *session) {
    struct utsname machine;
    struct tm utc;
    time_t now = time(NULL);
    char date[32] = "";
    if (gmtime_r(&now, &utc)) strftime(date, sizeof date, "%Y-%m-%dT%H:%M:%SZ", &utc);
    nph_json_object(json, "program");
    nph_json_text(json, "version", nph_version());
    nph_json_text(json, "compiler", NPH_BUILD_COMPILER);
    nph_json_text(json, "vector_level", nph_isa_name(nph_context_isa(session->context)));
    nph_json_integer(json, "threads", nph_context_threads(session->context));
    nph_json_close(json);
    nph_json_object(json, "machine");
    nph_json_text(json, "host", uname(&machine) == 0 ? machine.nodename : NULL);
    nph_json_text(json, "architecture", uname(&machine) == 0 ? machine.machine : NULL);
    nph_json_text(json, "date", date);
    nph_json_close(json);
}

static void write_noise(NphJson *json, const NphFilmNoise *noise) {
    nph_json_object(json, "noise");
    nph_json_number(json, "mean_luminance", noise->mean_luminance);
    nph_json_number(json, "relative_error", noise->relative_error);
    nph_json_number(json, "relative_rmse", noise->relative_rmse);
    nph_json_integer(json, "samples_min", noise->samples_min);
    nph_json_integer(json, "samples_max", noise->samples_max);
    nph_json_close(json);
}

void stats_run(NphJson *json, const char *key, const NphRenderStatistics *run) {
    nph_json_object(json, key);
    nph_json_integer(json, "samples", run->samples);
    nph_json_integer(json, "samples_per_pixel", run->samples_per_pixel);
    nph_json_number(json, "seconds", run->seconds);
    nph_json_number(json, "cpu_seconds", run->cpu_seconds);
    nph_json_integer(json, "collisions", run->collisions);
    nph_json_integer(json, "tentative_collisions", run->tentative);
    nph_json_integer(json, "integrals", run->integrals);
    nph_json_integer(json, "integrand_points", run->integrand_points);
    nph_json_integer(json, "unconverged_integrals", run->unconverged);
    nph_json_number(json, "worst_residual", run->worst_residual);
    nph_json_integer(json, "nonfinite", run->nonfinite);
    nph_json_integer(json, "majorant_violations", run->majorant_violations);
    nph_json_boolean(json, "target_error_reached", run->reached);
    write_noise(json, &run->noise);
    nph_json_array(json, "stages");
    for (int i = 0; i < run->stage_count; i++) {
        const NphStageStatistics *stage = &run->stages[i];
        nph_json_object(json, NULL);
        nph_json_text(json, "name", stage->name);
        nph_json_text(json, "source", stage->source);
        nph_json_integer(json, "launches", stage->launches);
        nph_json_integer(json, "items", stage->items);
        nph_json_number(json, "seconds", stage->seconds);
        nph_json_close(json);
    }
    nph_json_close(json);
    nph_json_close(json);
}

NphStatus stats_write(Session *session, const char *path, const char *scene, NphStatus status,
                      const NphRenderStatistics *run) {
    NphWriter writer = {0};
    NphJson json;
    NPH_TRY(nph_writer_open(session->context, path, &writer));
    nph_json_begin(&json, nph_json_to_file, writer.stream);
    nph_json_object(&json, NULL);
    nph_json_text(&json, "scene", scene);
    nph_json_text(&json, "status", nph_status_name(status));
    stats_environment(&json, session);
    nph_json_integer(&json, "peak_bytes", (int64_t)nph_context_peak_bytes(session->context));
    stats_run(&json, "run", run);
    nph_json_close(&json);
    return nph_writer_commit(session->context, &writer);
}
