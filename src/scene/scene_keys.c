/* SPDX-License-Identifier: Apache-2.0
 *
 * Look-ups in the table of keys, and the distance between what was written and what may have been meant. */
#include "scene/scene_keys.h"

#include <string.h>

#include "core/text.h"

enum { NPH_WORD_MAX = 64 };

const NphSceneSectionInfo *nph_scene_section_info(const char *name) {
    for (int i = 0; i < nph_scene_section_count; i++)
        if (strcmp(nph_scene_sections[i].name, name) == 0) return &nph_scene_sections[i];
    return NULL;
}

const NphSceneKey *nph_scene_section_keys(const char *section, int *count) {
    const NphSceneKey *first = NULL;
    *count = 0;
    for (int i = 0; i < nph_scene_key_count; i++) {
        if (strcmp(nph_scene_keys[i].section, section) != 0) continue;
        if (!first) first = &nph_scene_keys[i];
        ++*count;
    }
    return first;
}

/* The n-th word's begin and length; NULL beyond the last. */
static const char *nth_word(const char *words, int n, size_t *length) {
    for (; n > 0 && words; n--) {
        words = strchr(words, '|');
        if (words) words++;
    }
    if (words) *length = strcspn(words, "|");
    return words;
}

int nph_words_index(const char *words, const char *word) {
    size_t length, wanted = strlen(word);
    const char *found;
    for (int n = 0; (found = nth_word(words, n, &length)); n++)
        if (length == wanted && memcmp(found, word, wanted) == 0) return n;
    return -1;
}

int nph_words_get(const char *words, int n, char *word, size_t size) {
    size_t length;
    const char *found = nth_word(words, n, &length);
    if (!found) return 0;
    if (length > size - 1) length = size - 1;
    memcpy(word, found, length);
    word[length] = 0;
    return 1;
}

int nph_words_apply(const char *words, const char *variant) {
    return !words || !variant || nph_words_index(words, variant) >= 0;
}

int nph_key_animates(NphKeyType type) {
    return type == NPH_KEY_NUMBER || type == NPH_KEY_RGB || type == NPH_KEY_FACTORS || type == NPH_KEY_VECTOR ||
           type == NPH_KEY_INTERVAL || type == NPH_KEY_BOX || type == NPH_KEY_MATRIX;
}

int nph_edit_distance(const char *a, const char *b) {
    int rows[3][NPH_WORD_MAX + 1];
    size_t na = strlen(a), nb = strlen(b);
    if (na >= NPH_WORD_MAX || nb >= NPH_WORD_MAX) return NPH_WORD_MAX;
    int *before = rows[0], *above = rows[1], *row = rows[2];
    for (size_t j = 0; j <= nb; j++) above[j] = (int)j;
    for (size_t i = 1; i <= na; i++) {
        row[0] = (int)i;
        for (size_t j = 1; j <= nb; j++) {
            int best = above[j - 1] + (a[i - 1] != b[j - 1]);
            if (above[j] + 1 < best) best = above[j] + 1;
            if (row[j - 1] + 1 < best) best = row[j - 1] + 1;
            int swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
            if (swapped && before[j - 2] + 1 < best) best = before[j - 2] + 1;
            row[j] = best;
        }
        int *spare = before;
        before = above;
        above = row;
        row = spare;
    }
    return above[nb];
}

int nph_edit_close(const char *a, const char *b) {
    size_t shorter = strlen(a) < strlen(b) ? strlen(a) : strlen(b);
    return nph_edit_distance(a, b) <= (shorter >= 6 ? 3 : shorter >= 4 ? 2 : shorter >= 2 ? 1 : 0);
}

const char *nph_limit_text(double value, char *text) {
    nph_format_double(value, text);
    size_t length = strlen(text), digits = length;
    while (digits > 1 && text[digits - 1] == '0') digits--;
    if (strchr(text, '.')) digits = length;
    char *power = strchr(text, 'e');
    if (power) { /* 1e+35 -> 1e35, 1e-09 -> 1e-9 */
        power += power[1] == '-' ? 2 : 1;
        size_t skip = strspn(power, "+0");
        memmove(power, power + skip, strlen(power + skip) + 1);
        return text;
    }
    size_t zeros = length - digits;
    if (zeros >= 6) { /* 1000000000 -> 1e9 */
        char *at = text + digits;
        *at++ = 'e';
        if (zeros >= 10) *at++ = (char)('0' + zeros / 10);
        *at++ = (char)('0' + zeros % 10);
        *at = 0;
    }
    return text;
}
