/* SPDX-License-Identifier: Apache-2.0
 *
 * See dump_facts.h. Of a medium first what the scene says, then what the method's kernels have made of it. */
#include "oracle/dump_facts.h"

typedef struct Facts {
    NphJson *json;
    const NphScene *scene;
    int medium; /* whose object is open; -1: that of the whole */
} Facts;

static void json_phase(NphJson *json, const NphPhase *phase) {
    static const char *const names[NPH_PHASE_KINDS] = {"isotropic", "hg", "two_lobe", "rayleigh", "draine", "tabulated"};
    nph_json_object(json, "phase");
    nph_json_text(json, "type", names[phase->kind]);
    if (phase->kind == NPH_PHASE_HG || phase->kind == NPH_PHASE_TWO_LOBE || phase->kind == NPH_PHASE_DRAINE)
        nph_json_number(json, "g", phase->g[0]);
    if (phase->kind == NPH_PHASE_TWO_LOBE) {
        nph_json_number(json, "g2", phase->g[1]);
        nph_json_number(json, "weight", phase->weight);
    }
    if (phase->kind == NPH_PHASE_DRAINE) nph_json_number(json, "alpha", phase->alpha);
    nph_json_number(json, "mean_cosine", nph_phase_mean_cosine(phase));
    nph_json_close(json);
}

static void begin_medium(Facts *facts, int number) {
    static const char *const shapes[] = {[NPH_SHAPE_GRID] = "grid", [NPH_SHAPE_BOX] = "box", [NPH_SHAPE_LAYER] = "layer", [NPH_SHAPE_AIR] = "air"};
    const NphMedium *medium = &facts->scene->media[number];
    nph_json_close(facts->json);
    if (facts->medium < 0) nph_json_array(facts->json, "media");
    facts->medium = number;
    nph_json_object(facts->json, NULL);
    nph_json_integer(facts->json, "medium", number);
    nph_json_text(facts->json, "name", medium->name);
    nph_json_text(facts->json, "shape", shapes[medium->shape]);
    nph_json_numbers(facts->json, medium->shape == NPH_SHAPE_GRID ? "world_from_grid" : "world_from_medium", 12, medium->world_from_medium);
    nph_json_numbers(facts->json, "extinction_per_m", 3, medium->extinction_per_m);
    nph_json_numbers(facts->json, "albedo", 3, medium->albedo);
    json_phase(facts->json, &medium->phase);
}

static void put_fact(void *user, int medium, const char *name, int count, const double *values) {
    Facts *facts = user;
    if (medium != facts->medium) begin_medium(facts, medium);
    if (count == 1) nph_json_number(facts->json, name, values[0]);
    else nph_json_numbers(facts->json, name, count, values);
}

NphStatus nph_json_facts(NphJson *json, const NphMethod *method, const NphJob *job) {
    Facts facts = {json, job->scene, -1};
    if (!method->facts) return NPH_OK;
    nph_json_object(json, "transport");
    NphStatus status = method->facts(job, put_fact, &facts);
    nph_json_close(json);
    if (facts.medium >= 0) nph_json_close(json);
    return status;
}
