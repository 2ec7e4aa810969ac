/* SPDX-License-Identifier: Apache-2.0
 *
 * See json_read.h. */
#include "oracle/json_read.h"

#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "io/file.h"

NphStatus nph_json_refuse(const NphJsonReader *r, const yaml_node_t *at, const char *what, const char *key) {
    return nph_error(r->context, NPH_BAD_INPUT, "%s:%d: %s%s%s", r->path, at ? (int)at->start_mark.line + 1 : 1, what, key ? " " : "",
                     key ? key : "");
}

const char *nph_json_text_of(const yaml_node_t *node) {
    return node && node->type == YAML_SCALAR_NODE ? (const char *)node->data.scalar.value : NULL;
}

const yaml_node_t *nph_json_get(NphJsonReader *r, const yaml_node_t *map, const char *key) {
    if (!map || map->type != YAML_MAPPING_NODE) return NULL;
    for (yaml_node_pair_t *pair = map->data.mapping.pairs.start; pair < map->data.mapping.pairs.top; pair++) {
        const char *name = nph_json_text_of(yaml_document_get_node(&r->document, pair->key));
        if (name && strcmp(name, key) == 0) return yaml_document_get_node(&r->document, pair->value);
    }
    return NULL;
}

int nph_json_count(const yaml_node_t *list) {
    if (!list || list->type != YAML_SEQUENCE_NODE) return -1;
    return (int)(list->data.sequence.items.top - list->data.sequence.items.start);
}

const yaml_node_t *nph_json_item(NphJsonReader *r, const yaml_node_t *list, int i) {
    return yaml_document_get_node(&r->document, list->data.sequence.items.start[i]);
}

static NphStatus parse(NphJsonReader *r, const char *bytes, size_t size, NphJsonTakeFn take, void *out) {
    yaml_parser_t parser;
    if (!yaml_parser_initialize(&parser)) return nph_error(r->context, NPH_NO_MEMORY, "%s: no memory to read it", r->path);
    yaml_parser_set_input_string(&parser, (const unsigned char *)bytes, size);
    int loaded = yaml_parser_load(&parser, &r->document), line = (int)parser.problem_mark.line + 1;
    NphStatus status = NPH_OK;
    if (!loaded)
        status = nph_error(r->context, NPH_BAD_INPUT, "%s:%d: %s", r->path, line, parser.problem ? parser.problem : "is not JSON");
    yaml_parser_delete(&parser);
    if (status != NPH_OK) return status;
    status = take(r, yaml_document_get_root_node(&r->document), out);
    yaml_document_delete(&r->document);
    return status;
}

NphStatus nph_json_read(NphContext *context, const char *path, NphJsonTakeFn take, void *out) {
    NphJsonReader reader = {.context = context, .path = path};
    char *bytes = NULL;
    size_t size = 0;
    NPH_TRY(nph_file_read(context, path, &bytes, &size));
    NphStatus status = parse(&reader, bytes, size, take, out);
    nph_free(context, bytes);
    return status;
}
