/* SPDX-License-Identifier: Apache-2.0
 *
 * JSON files read back: manifests and tolerances. JSON is YAML to libyaml, whose nodes know their lines. */
#ifndef NPH_ORACLE_JSON_READ_H
#define NPH_ORACLE_JSON_READ_H

#include <yaml.h>

#include "nephos/context.h"

typedef struct NphJsonReader {
    NphContext *context;
    const char *path;
    yaml_document_t document;
} NphJsonReader;

/* Opens the file and hands its root to take, NULL where it is empty. What take made is of the caller, whatever the status. */
typedef NphStatus (*NphJsonTakeFn)(NphJsonReader *reader, const yaml_node_t *root, void *out);
NphStatus nph_json_read(NphContext *context, const char *path, NphJsonTakeFn take, void *out);

/* NPH_BAD_INPUT with file, line, what, and key where it is not NULL. */
NphStatus nph_json_refuse(const NphJsonReader *reader, const yaml_node_t *at, const char *what, const char *key);

/* NULL where the node is no scalar; where the map has no such key, or is none. */
const char *nph_json_text_of(const yaml_node_t *node);
const yaml_node_t *nph_json_get(NphJsonReader *reader, const yaml_node_t *map, const char *key);

/* Of a list, -1: it is none; its i-th item. */
int nph_json_count(const yaml_node_t *list);
const yaml_node_t *nph_json_item(NphJsonReader *reader, const yaml_node_t *list, int i);

#endif
