/* SPDX-License-Identifier: Apache-2.0
 *
 * See manifest.h. */
#include "oracle/manifest.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/text.h"
#include "io/volume.h"
#include "oracle/json_read.h"

static NphStatus copy_text(NphJsonReader *r, const yaml_node_t *node, const char *key, char **out) {
    const char *text = nph_json_text_of(node);
    if (!text) return nph_json_refuse(r, node, "expected a text:", key);
    size_t bytes = strlen(text) + 1;
    NPH_TRY(NPH_NEW(r->context, bytes, "text of a manifest", out));
    memcpy(*out, text, bytes);
    return NPH_OK;
}

static NphStatus read_text(NphJsonReader *r, const yaml_node_t *map, const char *key, int required, char **out) {
    const yaml_node_t *node = nph_json_get(r, map, key);
    if (!node && required) return nph_json_refuse(r, map, "no", key);
    return node ? copy_text(r, node, key, out) : NPH_OK;
}

static NphStatus read_integer(NphJsonReader *r, const yaml_node_t *map, const char *key, int64_t fallback, int64_t *out) {
    const yaml_node_t *node = nph_json_get(r, map, key);
    const char *text = nph_json_text_of(node);
    *out = fallback;
    if (!node) return NPH_OK;
    return text && nph_parse_int(text, out) ? NPH_OK : nph_json_refuse(r, node, "expected a whole number:", key);
}

static NphStatus read_integers(NphJsonReader *r, const yaml_node_t *map, const char *key, int count, int64_t *out, int *given) {
    const yaml_node_t *node = nph_json_get(r, map, key);
    if (given) *given = node != NULL;
    if (!node) return NPH_OK;
    if (node->type != YAML_SEQUENCE_NODE || node->data.sequence.items.top - node->data.sequence.items.start != count)
        return nph_json_refuse(r, node, "expected a list of whole numbers:", key);
    for (int i = 0; i < count; i++) {
        const char *text = nph_json_text_of(nph_json_item(r, node, i));
        if (!text || !nph_parse_int(text, &out[i])) return nph_json_refuse(r, node, "expected a list of whole numbers:", key);
    }
    return NPH_OK;
}

/* "buffer": "file" pairs, or a list of {buffer, file}. */
static NphStatus read_files(NphJsonReader *r, const yaml_node_t *node, const char *key, NphManifestFile **out, int *count) {
    if (!node) return NPH_OK;
    int map = node->type == YAML_MAPPING_NODE;
    if (!map && node->type != YAML_SEQUENCE_NODE) return nph_json_refuse(r, node, "expected buffers and their files:", key);
    int files = map ? (int)(node->data.mapping.pairs.top - node->data.mapping.pairs.start)
                    : (int)(node->data.sequence.items.top - node->data.sequence.items.start);
    NPH_TRY(NPH_NEW(r->context, files > 0 ? files : 1, "files of a launch", out));
    *count = files; /* those not read yet are empty */
    for (int i = 0; i < files; i++) {
        NphManifestFile *file = &(*out)[i];
        if (map) {
            yaml_node_pair_t *pair = &node->data.mapping.pairs.start[i];
            NPH_TRY(copy_text(r, yaml_document_get_node(&r->document, pair->key), key, &file->buffer));
            NPH_TRY(copy_text(r, yaml_document_get_node(&r->document, pair->value), key, &file->file));
        } else {
            const yaml_node_t *item = nph_json_item(r, node, i);
            NPH_TRY(read_text(r, item, "buffer", 1, &file->buffer));
            NPH_TRY(read_text(r, item, "file", 1, &file->file));
            NPH_TRY(read_text(r, item, "digest", 0, &file->digest));
        }
    }
    return NPH_OK;
}

static NphStatus read_arguments(NphJsonReader *r, const yaml_node_t *node, NphManifestLaunch *launch) {
    if (!node) return NPH_OK;
    if (node->type != YAML_MAPPING_NODE) return nph_json_refuse(r, node, "expected names and whole numbers:", "arguments");
    yaml_node_pair_t *pair = node->data.mapping.pairs.start;
    for (; pair < node->data.mapping.pairs.top; pair++) {
        int i = launch->argument_count;
        const char *value = nph_json_text_of(yaml_document_get_node(&r->document, pair->value));
        if (i == 8 || !value || !nph_parse_int(value, &launch->arguments[i]))
            return nph_json_refuse(r, node, "expected names and whole numbers, at most 8:", "arguments");
        NPH_TRY(copy_text(r, yaml_document_get_node(&r->document, pair->key), "arguments", &launch->argument_names[i]));
        launch->argument_count++;
    }
    return NPH_OK;
}

static NphStatus read_launch(NphJsonReader *r, const yaml_node_t *node, NphManifestLaunch *launch) {
    NPH_TRY(read_integer(r, node, "batch", 0, &launch->batch));
    NPH_TRY(read_integer(r, node, "number", 0, &launch->number));
    NPH_TRY(read_text(r, node, "stage", 1, &launch->stage));
    NPH_TRY(read_arguments(r, nph_json_get(r, node, "arguments"), launch));
    NPH_TRY(read_files(r, nph_json_get(r, node, "inputs"), "inputs", &launch->inputs, &launch->input_count));
    return read_files(r, nph_json_get(r, node, "outputs"), "outputs", &launch->outputs, &launch->output_count);
}

static int by_launch(const void *a, const void *b) {
    const NphManifestLaunch *x = a, *y = b;
    if (x->batch != y->batch) return x->batch < y->batch ? -1 : 1;
    return (x->number > y->number) - (x->number < y->number);
}

static NphStatus read_launches(NphJsonReader *r, const yaml_node_t *root, NphManifest *m) {
    const yaml_node_t *node = nph_json_get(r, root, "launches");
    if (!node || node->type != YAML_SEQUENCE_NODE) return nph_json_refuse(r, root, "no list", "launches");
    int count = (int)(node->data.sequence.items.top - node->data.sequence.items.start);
    NPH_TRY(NPH_NEW(r->context, count > 0 ? count : 1, "launches of a manifest", &m->launches));
    for (int i = 0; i < count; i++) {
        m->launch_count++;
        NPH_TRY(read_launch(r, nph_json_item(r, node, i), &m->launches[i]));
    }
    qsort(m->launches, (size_t)count, sizeof *m->launches, by_launch);
    return NPH_OK;
}

static NphStatus read_knobs(NphJsonReader *r, const yaml_node_t *root, NphManifest *m) {
    const yaml_node_t *node = nph_json_get(r, root, "knobs");
    if (!node || node->type != YAML_MAPPING_NODE) return NPH_OK;
    yaml_node_pair_t *pair = node->data.mapping.pairs.start;
    for (; pair < node->data.mapping.pairs.top && m->knob_count < NPH_MANIFEST_KNOBS; pair++) {
        const char *name = nph_json_text_of(yaml_document_get_node(&r->document, pair->key));
        const char *value = nph_json_text_of(yaml_document_get_node(&r->document, pair->value));
        if (!name || !value) return nph_json_refuse(r, node, "expected names and numbers:", "knobs");
        size_t bytes = strlen(name) + strlen(value) + 2;
        NPH_TRY(NPH_NEW(r->context, bytes, "knob of a manifest", &m->knobs[m->knob_count]));
        snprintf(m->knobs[m->knob_count++], bytes, "%s=%s", name, value);
    }
    return NPH_OK;
}

static NphStatus add_numbers(NphJsonReader *r, NphManifest *m, const char *name, int count, const double *values) {
    if ((m->number_count & (m->number_count + 1)) == 0) { /* 0, 1, 3, 7 ...: full */
        NphManifestNumbers *larger = NULL;
        NPH_TRY(NPH_NEW(r->context, 2 * m->number_count + 1, "numbers of a manifest", &larger));
        if (m->number_count) memcpy(larger, m->numbers, (size_t)m->number_count * sizeof *larger);
        nph_free(r->context, m->numbers);
        m->numbers = larger;
    }
    NphManifestNumbers *made = &m->numbers[m->number_count];
    *made = (NphManifestNumbers){.count = count};
    NPH_TRY(NPH_NEW(r->context, strlen(name) + 1, "name of numbers", &made->name));
    m->number_count++;
    memcpy(made->name, name, strlen(name) + 1);
    NPH_TRY(NPH_NEW(r->context, count, "numbers of a manifest", &made->values));
    memcpy(made->values, values, (size_t)count * sizeof *values);
    return NPH_OK;
}

static int number_of(const yaml_node_t *node, double *value) { return nph_json_text_of(node) && nph_parse_double(nph_json_text_of(node), value); }

/* A list of numbers, but not of something else; 0 where it is none. */
static int list_of(NphJsonReader *r, const yaml_node_t *node, double values[NPH_MANIFEST_LIST]) {
    int count = (int)(node->data.sequence.items.top - node->data.sequence.items.start);
    for (int i = 0; i < count; i++)
        if (i >= NPH_MANIFEST_LIST || !number_of(nph_json_item(r, node, i), &values[i]))
            return 0;
    return count;
}

/* All numbers below a node, under the name of where they stand. A document may be deep; what is of use is not. */
static NphStatus read_numbers(NphJsonReader *r, const yaml_node_t *node, const char *name, int depth, NphManifest *m) {
    char below[256];
    double values[NPH_MANIFEST_LIST];
    int list = node->type == YAML_SEQUENCE_NODE ? list_of(r, node, values) : number_of(node, values);
    if (list) return add_numbers(r, m, name, list, values);
    if (depth == 4) return NPH_OK;
    if (node->type == YAML_SEQUENCE_NODE)
        for (yaml_node_item_t *item = node->data.sequence.items.start; item < node->data.sequence.items.top; item++) {
            if (snprintf(below, sizeof below, "%s.%d", name, (int)(item - node->data.sequence.items.start)) >= (int)sizeof below) continue;
            NPH_TRY(read_numbers(r, yaml_document_get_node(&r->document, *item), below, depth + 1, m));
        }
    if (node->type != YAML_MAPPING_NODE) return NPH_OK;
    for (yaml_node_pair_t *pair = node->data.mapping.pairs.start; pair < node->data.mapping.pairs.top; pair++) {
        const char *key = nph_json_text_of(yaml_document_get_node(&r->document, pair->key));
        int large = depth == 0 && key && (strcmp(key, "stages") == 0 || strcmp(key, "buffers") == 0 || strcmp(key, "launches") == 0);
        if (!key || large || snprintf(below, sizeof below, "%s%s%s", name, *name ? "." : "", key) >= (int)sizeof below) continue;
        NPH_TRY(read_numbers(r, yaml_document_get_node(&r->document, pair->value), below, depth + 1, m));
    }
    return NPH_OK;
}

/* "buffers": [{"name": "path.weight", "type": "f16"}]: those that a port keeps as halves. */
static NphStatus read_halves(NphJsonReader *r, const yaml_node_t *root, NphManifest *m) {
    const yaml_node_t *node = nph_json_get(r, root, "buffers");
    if (!node || node->type != YAML_SEQUENCE_NODE) return NPH_OK;
    for (yaml_node_item_t *item = node->data.sequence.items.start; item < node->data.sequence.items.top; item++) {
        const yaml_node_t *buffer = yaml_document_get_node(&r->document, *item);
        const char *type = nph_json_text_of(nph_json_get(r, buffer, "type"));
        if (!type || strcmp(type, "f16") != 0 || m->half_count == NPH_MAX_BUFFERS) continue;
        NPH_TRY(read_text(r, buffer, "name", 1, &m->halves[m->half_count]));
        m->half_count++;
    }
    return NPH_OK;
}

static NphStatus read_root(NphJsonReader *r, const yaml_node_t *root, void *made) {
    NphManifest *m = made;
    int64_t version, seed, frame, scene_frame, crop[4] = {0};
    char *word = NULL;
    NPH_TRY(read_integer(r, root, "nephos_dump", 0, &version));
    if (version != 1) return nph_json_refuse(r, root, "is no manifest of a dump: expected \"nephos_dump\": 1", NULL);
    NPH_TRY(read_text(r, root, "scene", 0, &m->scene));
    NPH_TRY(read_text(r, root, "scene_digest", 0, &m->scene_digest));
    NPH_TRY(read_text(r, root, "method", 1, &m->method));
    NPH_TRY(read_integer(r, root, "seed", 1, &seed));
    NPH_TRY(read_integer(r, root, "frame", 0, &frame));
    NPH_TRY(read_integer(r, root, "scene_frame", frame, &scene_frame));
    NPH_TRY(read_integers(r, root, "samples", 2, m->samples, NULL));
    NPH_TRY(read_integers(r, root, "crop", 4, crop, &m->crop_given));
    NPH_TRY(read_text(r, root, "precision", 0, &word));
    m->precision = word && strcmp(word, "f64") == 0 ? 64 : 32;
    nph_free(r->context, word);
    word = NULL;
    NPH_TRY(read_text(r, root, "plan", 0, &word));
    m->plan_full = word && strcmp(word, "full") == 0;
    nph_free(r->context, word);
    m->seed = (uint32_t)seed;
    m->frame = (uint32_t)frame;
    m->scene_frame = (uint32_t)scene_frame;
    for (int a = 0; a < 4; a++) m->crop[a] = (int)crop[a];
    NPH_TRY(read_knobs(r, root, m));
    NPH_TRY(read_numbers(r, root, "", 0, m));
    NPH_TRY(read_halves(r, root, m));
    return read_launches(r, root, m);
}

NphStatus nph_manifest_read(NphContext *context, const char *folder, NphManifest *manifest) {
    char path[4096];
    size_t length = strlen(folder), end = sizeof "manifest.json" - 1;
    int named = length >= end && strcmp(folder + length - end, "manifest.json") == 0;
    NphManifest made = {0};
    snprintf(path, sizeof path, "%s%s", folder, named ? "" : "/manifest.json");
    NphStatus status = NPH_NEW(context, strlen(path) + 1, "folder of a dump", &made.folder);
    if (status == NPH_OK) {
        memcpy(made.folder, path, strlen(path) - end);
        status = nph_json_read(context, path, read_root, &made);
    }
    if (status != NPH_OK) nph_manifest_free(context, &made);
    else *manifest = made;
    return status;
}

static void free_files(NphContext *context, NphManifestFile *files, int count) {
    for (int i = 0; i < count; i++) {
        nph_free(context, files[i].buffer);
        nph_free(context, files[i].file);
        nph_free(context, files[i].digest);
    }
    nph_free(context, files);
}

void nph_manifest_free(NphContext *context, NphManifest *m) {
    for (int l = 0; l < m->launch_count; l++) {
        NphManifestLaunch *launch = &m->launches[l];
        for (int a = 0; a < launch->argument_count; a++) nph_free(context, launch->argument_names[a]);
        free_files(context, launch->inputs, launch->input_count);
        free_files(context, launch->outputs, launch->output_count);
        nph_free(context, launch->stage);
    }
    for (int k = 0; k < m->knob_count; k++) nph_free(context, m->knobs[k]);
    for (int n = 0; n < m->number_count; n++) {
        nph_free(context, m->numbers[n].name);
        nph_free(context, m->numbers[n].values);
    }
    nph_free(context, m->numbers);
    for (int h = 0; h < m->half_count; h++) nph_free(context, m->halves[h]);
    nph_free(context, m->launches);
    nph_free(context, m->folder);
    nph_free(context, m->scene);
    nph_free(context, m->scene_digest);
    nph_free(context, m->method);
    memset(m, 0, sizeof *m);
}

const NphManifestLaunch *nph_manifest_find(const NphManifest *m, int64_t batch, int64_t number) {
    NphManifestLaunch key = {.batch = batch, .number = number};
    return m->launch_count ? bsearch(&key, m->launches, (size_t)m->launch_count, sizeof key, by_launch) : NULL;
}

NphStatus nph_manifest_array(NphContext *context, const NphManifest *m, const char *file, NphArray *array) {
    char path[4096];
    snprintf(path, sizeof path, "%s%s", file[0] == '/' ? "" : m->folder, file);
    return nph_npy_read(context, path, array);
}

void nph_manifest_options(const NphManifest *m, NphRenderOptions *options) {
    nph_render_options_default(options);
    options->method = m->method;
    options->precision = m->precision;
    options->plan_full = m->plan_full;
    options->seed_given = 1;
    options->seed = m->seed;
    options->frame = m->frame;
    options->sample_begin = m->samples[0];
    options->sample_end = m->samples[1];
    options->crop_given = m->crop_given;
    memcpy(options->crop, m->crop, sizeof options->crop);
    options->knob_count = m->knob_count;
    options->knobs = (const char *const *)m->knobs;
}
