/* SPDX-License-Identifier: Apache-2.0
 *
 * docs/scene.md from the table of keys. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "core/message.h"
#include "core/text.h"
#include "scene/scene_keys.h"

typedef struct Page {
    NphTextFn write;
    void *user;
} Page;

static void say(const Page *page, const char *format, ...) NPH_PRINTF(2, 3);

static void say(const Page *page, const char *format, ...) {
    char text[2048];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    page->write(page->user, text, strlen(text));
}

static const char INTRODUCTION[] =
    "# Scene files\n"
    "\n"
    "This page and docs/scene.schema.json (for editors and other programs) are made from one table,\n"
    "src/scene/scene_keys_table.c.\n"
    "\n"
    "A scene is YAML 1.1, and so may be JSON. Lengths are metres, angles degrees, z is up unless the camera says\n"
    "otherwise. Where a value has three channels, one number stands for all of them.\n"
    "\n"
    "```yaml\n"
    "nephos: 1\n"
    "camera:\n"
    "  resolution: [400, 300]\n"
    "  position: [0, -4, 1]\n"
    "  look_at: [0, 0, 0.5]\n"
    "  fov: 35\n"
    "media:\n"
    "  - density: {file: cloud.nvdb}\n"
    "    transform: [{scale: 2}, {rotate: {axis: [0, 0, 1], angle: 30}}, {translate: [0, 0, 1]}]\n"
    "    extinction: 40\n"
    "    albedo: [1, 0.99, 0.98]\n"
    "    phase: {type: hg, g: 0.85}\n"
    "lights:\n"
    "  - {type: sun, elevation: 30, azimuth: 120, irradiance: [9, 8, 7]}\n"
    "  - {type: constant, radiance: [0.2, 0.3, 0.5]}\n"
    "render: {samples: 64, seed: 1}\n"
    "```\n"
    "\n"
    "- Numbers are plain decimals, without quotes: `40`, `-3.5`, `.5`, `+3`, `1e5`. Hex, octal (a leading zero),\n"
    "  `1_000`, `1:30`, infinities and NaN are refused.\n"
    "- Paths are relative to the folder of the scene file. In them `####` stands for the number of the frame with at least as many\n"
    "  digits as there are `#`: `smoke.####.vdb` is smoke.0007.vdb at frame 7.\n"
    "- A value that consists of numbers may change from frame to frame, see [animated](#animated):\n"
    "  `azimuth: {frames: [0, 24, 48], values: [120, 150, 120]}`. What is read is the scene as of one frame: `--frame` of the\n"
    "  command line, `nph_scene_load_frame`, else frame 0.\n"
    "- Anchors and aliases (`&a`, `*a`) may be used; merge keys (`<<`), tags (`!!float`) and several documents in one\n"
    "  file are refused. A file is UTF-8, at most 1 MiB.\n"
    "- Unknown and doubled keys are mistakes. Every mistake is reported as `FILE:LINE:COLUMN: what is wrong, what is\n"
    "  allowed`, as many as can be found in one run (exit status 3; 4 when a file it names is missing or damaged).\n";

static const char *type_text(NphKeyType type) {
    switch (type) {
    case NPH_KEY_NUMBER: return "number";
    case NPH_KEY_WHOLE: return "whole number";
    case NPH_KEY_RGB: return "number or [r, g, b]";
    case NPH_KEY_SPECTRUM: return "list of numbers";
    case NPH_KEY_FACTORS: return "number or [x, y, z]";
    case NPH_KEY_VECTOR: return "[x, y, z]";
    case NPH_KEY_RESOLUTION: return "[width, height]";
    case NPH_KEY_CROP: return "[x0, y0, x1, y1]";
    case NPH_KEY_INTERVAL: return "[low, high]";
    case NPH_KEY_BOX: return "[[x0, y0, z0], [x1, y1, z1]]";
    case NPH_KEY_MATRIX: return "12 numbers";
    case NPH_KEY_WORD: return "word";
    case NPH_KEY_TEXT: return "text";
    case NPH_KEY_FILE: return "path";
    case NPH_KEY_FRAMES: return "list of whole numbers";
    case NPH_KEY_VALUES: return "list of values";
    case NPH_KEY_SECTION: return "mapping";
    case NPH_KEY_LIST: return "list";
    }
    return "";
}

/* "a|b" as a list: before each word `lead`, after it `tail`. */
static void say_words(const Page *page, const char *words, const char *lead, const char *tail) {
    char word[64];
    for (int n = 0; nph_words_get(words, n, word, sizeof word); n++)
        say(page, "%s%s%s%s", n ? ", " : "", lead, word, tail);
}

static void say_allowed(const Page *page, const NphSceneKey *key) {
    char low[NPH_DOUBLE_TEXT], high[NPH_DOUBLE_TEXT];
    if (key->type == NPH_KEY_WORD) {
        say_words(page, key->words, "`", "`");
    } else if (key->type == NPH_KEY_SECTION) {
        say(page, "see [%s](#%s)", key->words, key->words);
    } else if (key->type == NPH_KEY_LIST) {
        say(page, "at most %s, see [%s](#%s)", nph_limit_text(key->max, high), key->words, key->words);
    } else if (key->type == NPH_KEY_TEXT || key->type == NPH_KEY_FILE) {
        say(page, "%s to %s bytes", nph_limit_text(key->min, low), nph_limit_text(key->max, high));
    } else if (key->type == NPH_KEY_VALUES) {
        say(page, "as without frames");
    } else if (key->min == key->max) {
        say(page, "%s", nph_limit_text(key->min, low));
    } else {
        say(page, "%s to %s%s%s", nph_limit_text(key->min, low), nph_limit_text(key->max, high),
            key->unit[0] ? " " : "", key->unit);
    }
}

static int in_rule(const NphSceneKey *key) {
    for (int i = 0; i < nph_scene_rule_count; i++) {
        const char *all = nph_scene_rules[i].alternatives, *found = strstr(all, key->key);
        if (strcmp(nph_scene_rules[i].section, key->section) != 0 || !found) continue;
        if ((found == all || strchr(" |", found[-1])) && strchr(" |?", found[strlen(key->key)])) return 1;
    }
    return 0;
}

static void say_key(const Page *page, const NphSceneSectionInfo *info, const NphSceneKey *key) {
    const char *fallback = key->fallback ? key->fallback : in_rule(key) ? "one of" : "-";
    say(page, "| `%s` | %s | ", key->key, type_text(key->type));
    say_allowed(page, key);
    say(page, " | %s | ", fallback);
    if (key->applies) {
        int file = strcmp(info->variant_key, "file") == 0;
        say(page, "Only ");
        say_words(page, key->applies, file ? "`." : "`", "`");
        say(page, ". ");
    }
    say(page, "%s |\n", key->meaning);
}

static void say_rule(const Page *page, const NphSceneRule *rule) {
    say(page, "\n");
    if (rule->applies) say(page, "With `%s`, exactly one of: ", rule->applies);
    else say(page, "Exactly one of: ");
    int fresh = 1;
    for (const char *at = rule->alternatives; *at;) {
        size_t length = strcspn(at, " |?");
        int optional = at[length] == '?';
        say(page, "%s`%.*s`%s", fresh ? "" : " with ", (int)length, at, optional ? " (may be left out)" : "");
        at += length + (size_t)optional;
        fresh = *at == '|';
        if (fresh) say(page, "; ");
        if (*at) at++;
    }
    say(page, ".\n");
}

static void say_animated(const Page *page) {
    say(page, "\nValues that can be animated:");
    for (int type = NPH_KEY_NUMBER, n = 0; type <= NPH_KEY_LIST; type++)
        if (nph_key_animates((NphKeyType)type)) say(page, "%s %s", n++ ? ";" : "", type_text((NphKeyType)type));
    say(page, ". All others, among them whole numbers and `wavelengths`, are the same at every frame.\n");
}

static void say_section(const Page *page, const NphSceneSectionInfo *info) {
    int count;
    const NphSceneKey *keys = nph_scene_section_keys(info->name, &count);
    say(page, "\n## %s\n\n%s\n\n", info->name, info->meaning);
    say(page, "| key | value | allowed | default | meaning |\n|---|---|---|---|---|\n");
    for (int i = 0; i < count; i++) say_key(page, info, &keys[i]);
    for (int i = 0; i < nph_scene_rule_count; i++)
        if (strcmp(nph_scene_rules[i].section, info->name) == 0) say_rule(page, &nph_scene_rules[i]);
    if (strcmp(info->name, "animated") == 0) say_animated(page);
}

void nph_scene_keys_markdown(NphTextFn write, void *user) {
    Page page = {write, user};
    write(user, INTRODUCTION, sizeof INTRODUCTION - 1);
    for (int i = 0; i < nph_scene_section_count; i++) say_section(&page, &nph_scene_sections[i]);
}
