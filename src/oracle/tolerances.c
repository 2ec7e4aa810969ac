/* SPDX-License-Identifier: Apache-2.0
 *
 * The file of tolerances that `nephos tolerance` writes, read back for verify: docs/oracle.md, section 3. JSON is YAML to
 * libyaml, whose nodes know their lines. */
#include <stdlib.h>
#include <string.h>
#include <yaml.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/text.h"
#include "io/file.h"
#include "nephos/verify.h"

typedef struct Reader {
    NphContext *context;
    const char *path;
    yaml_document_t document;
} Reader;

static NphStatus refuse(const Reader *r, const yaml_node_t *at, const char *what, const char *key) {
    return nph_error(r->context, NPH_BAD_INPUT, "%s:%d: %s%s%s", r->path, at ? (int)at->start_mark.line + 1 : 1, what, key ? " " : "",
                     key ? key : "");
}

static const char *text_at(Reader *r, const yaml_node_t *map, const char *key, const yaml_node_t **node) {
    *node = NULL;
    if (!map || map->type != YAML_MAPPING_NODE) return NULL;
    for (yaml_node_pair_t *pair = map->data.mapping.pairs.start; pair < map->data.mapping.pairs.top; pair++) {
        const yaml_node_t *name = yaml_document_get_node(&r->document, pair->key);
        if (name->type != YAML_SCALAR_NODE || strcmp((const char *)name->data.scalar.value, key) != 0) continue;
        *node = yaml_document_get_node(&r->document, pair->value);
        return (*node)->type == YAML_SCALAR_NODE ? (const char *)(*node)->data.scalar.value : NULL;
    }
    return NULL;
}

static NphStatus read_text(Reader *r, const yaml_node_t *map, const char *key, size_t bytes, char *out) {
    const yaml_node_t *node;
    const char *text = text_at(r, map, key, &node);
    if (!text) return refuse(r, node ? node : map, "expected a text:", key);
    if (strlen(text) >= bytes) return refuse(r, node, "is too long:", key);
    memcpy(out, text, strlen(text) + 1);
    return NPH_OK;
}

/* Not negative. */
static NphStatus read_number(Reader *r, const yaml_node_t *map, const char *key, double *out) {
    const yaml_node_t *node;
    const char *text = text_at(r, map, key, &node);
    if (!text || !nph_parse_double(text, out) || !(*out >= 0.0)) return refuse(r, node ? node : map, "expected a number from 0 on:", key);
    return NPH_OK;
}

static NphStatus read_rows(Reader *r, const yaml_node_t *root, NphTolerances *out) {
    const yaml_node_t *list;
    text_at(r, root, "tolerances", &list);
    if (!list || list->type != YAML_SEQUENCE_NODE) return refuse(r, root, "no list", "tolerances");
    int count = (int)(list->data.sequence.items.top - list->data.sequence.items.start);
    NPH_TRY(NPH_NEW(r->context, count > 0 ? count : 1, "tolerances", &out->rows));
    for (; out->count < count; out->count++) {
        const yaml_node_t *row = yaml_document_get_node(&r->document, list->data.sequence.items.start[out->count]);
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

static NphStatus read_root(Reader *r, NphTolerances *out) {
    const yaml_node_t *root = yaml_document_get_root_node(&r->document), *node;
    const char *version = text_at(r, root, "nephos_tolerances", &node);
    char precision[8];
    if (!version || strcmp(version, "1") != 0) return refuse(r, root, "holds no tolerances: expected \"nephos_tolerances\": 1", NULL);
    NPH_TRY(read_text(r, root, "method", sizeof out->method, out->method));
    NPH_TRY(read_text(r, root, "scene_digest", sizeof out->scene_digest, out->scene_digest));
    NPH_TRY(read_text(r, root, "precision", sizeof precision, precision));
    out->precision = strcmp(precision, "f64") == 0 ? 64 : 32;
    return read_rows(r, root, out);
}

static NphStatus parse(Reader *r, const char *bytes, size_t size, NphTolerances *out) {
    yaml_parser_t parser;
    if (!yaml_parser_initialize(&parser)) return nph_error(r->context, NPH_NO_MEMORY, "%s: no memory to read it", r->path);
    yaml_parser_set_input_string(&parser, (const unsigned char *)bytes, size);
    int loaded = yaml_parser_load(&parser, &r->document), line = (int)parser.problem_mark.line + 1;
    NphStatus status = NPH_OK;
    if (!loaded)
        status = nph_error(r->context, NPH_BAD_INPUT, "%s:%d: %s", r->path, line, parser.problem ? parser.problem : "is not JSON");
    yaml_parser_delete(&parser);
    if (status != NPH_OK) return status;
    status = read_root(r, out);
    yaml_document_delete(&r->document);
    return status;
}

NphStatus nph_tolerances_read(NphContext *context, const char *path, NphTolerances *tolerances) {
    Reader reader = {.context = context, .path = path};
    NphTolerances made = {0};
    char *bytes = NULL;
    size_t size = 0;
    NPH_TRY(nph_file_read(context, path, &bytes, &size));
    NphStatus status = parse(&reader, bytes, size, &made);
    nph_free(context, bytes);
    if (status != NPH_OK) nph_tolerances_free(context, &made);
    else *tolerances = made;
    return status;
}

void nph_tolerances_free(NphContext *context, NphTolerances *tolerances) {
    nph_free(context, tolerances->rows);
    memset(tolerances, 0, sizeof *tolerances);
}
