/* SPDX-License-Identifier: Apache-2.0
 *
 * The file of tolerances that `nephos tolerance` writes, read back for verify: docs/oracle.md, section 3. */
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/text.h"
#include "nephos/verify.h"
#include "oracle/json_read.h"

static NphStatus read_text(NphJsonReader *r, const yaml_node_t *map, const char *key, size_t bytes, char *out) {
    const yaml_node_t *node = nph_json_get(r, map, key);
    const char *text = nph_json_text_of(node);
    if (!text) return nph_json_refuse(r, node ? node : map, "expected a text:", key);
    if (strlen(text) >= bytes) return nph_json_refuse(r, node, "is too long:", key);
    memcpy(out, text, strlen(text) + 1);
    return NPH_OK;
}

/* Not negative. */
static NphStatus read_number(NphJsonReader *r, const yaml_node_t *map, const char *key, double *out) {
    const yaml_node_t *node = nph_json_get(r, map, key);
    const char *text = nph_json_text_of(node);
    if (!text || !nph_parse_double(text, out) || !(*out >= 0.0)) return nph_json_refuse(r, node ? node : map, "expected a number from 0 on:", key);
    return NPH_OK;
}

static NphStatus read_rows(NphJsonReader *r, const yaml_node_t *root, NphTolerances *out) {
    const yaml_node_t *list = nph_json_get(r, root, "tolerances");
    int count = nph_json_count(list);
    if (count < 0) return nph_json_refuse(r, root, "no list", "tolerances");
    NPH_TRY(NPH_NEW(r->context, count > 0 ? count : 1, "tolerances", &out->rows));
    for (; out->count < count; out->count++) {
        const yaml_node_t *row = nph_json_item(r, list, out->count);
        NphTolerance *tolerance = &out->rows[out->count];
        NPH_TRY(read_text(r, row, "stage", sizeof tolerance->stage, tolerance->stage));
        NPH_TRY(read_text(r, row, "buffer", sizeof tolerance->buffer, tolerance->buffer));
        NPH_TRY(read_text(r, row, "cause", sizeof tolerance->cause, tolerance->cause));
        NPH_TRY(read_number(r, row, "ulp", &tolerance->ulp));
        NPH_TRY(read_number(r, row, "flips", &tolerance->flips));
        NPH_TRY(read_number(r, row, "typical_ulp", &tolerance->typical));
        NPH_TRY(read_number(r, row, "tail", &tolerance->tail));
        NPH_TRY(read_number(r, row, "gap_ulp", &tolerance->gap));
    }
    return NPH_OK;
}

static NphStatus read_root(NphJsonReader *r, const yaml_node_t *root, void *made) {
    NphTolerances *out = made;
    const char *version = nph_json_text_of(nph_json_get(r, root, "nephos_tolerances"));
    char precision[8];
    if (!version || strcmp(version, "1") != 0) return nph_json_refuse(r, root, "holds no tolerances: expected \"nephos_tolerances\": 1", NULL);
    NPH_TRY(read_text(r, root, "method", sizeof out->method, out->method));
    NPH_TRY(read_text(r, root, "scene_digest", sizeof out->scene_digest, out->scene_digest));
    NPH_TRY(read_text(r, root, "precision", sizeof precision, precision));
    out->precision = strcmp(precision, "f64") == 0 ? 64 : 32;
    return read_rows(r, root, out);
}

NphStatus nph_tolerances_read(NphContext *context, const char *path, NphTolerances *tolerances) {
    NphTolerances made = {0};
    NphStatus status = nph_json_read(context, path, read_root, &made);
    if (status != NPH_OK) nph_tolerances_free(context, &made);
    else *tolerances = made;
    return status;
}

void nph_tolerances_free(NphContext *context, NphTolerances *tolerances) {
    nph_free(context, tolerances->rows);
    memset(tolerances, 0, sizeof *tolerances);
}
