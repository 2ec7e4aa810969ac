/* SPDX-License-Identifier: Apache-2.0
 *
 * See options.h. */
#include "cli/options.h"

#include <stdarg.h>
#include <string.h>

#include "core/text.h"

void option_add(OptionTable *table, Option option) {
    if (table->count < MAX_OPTIONS) table->options[table->count++] = option;
}

NphStatus usage_error(const char *command, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fprintf(stderr, "nephos %s: ", command);
    vfprintf(stderr, format, arguments);
    fprintf(stderr, "\nTry: nephos %s --help\n", command);
    va_end(arguments);
    return NPH_BAD_USAGE;
}

static int smallest(int a, int b, int c) { return a < b ? (a < c ? a : c) : (b < c ? b : c); }

/* Edits (insert, delete, replace, swap neighbours) from a to b; words of up to 31 letters. */
static int distance(const char *a, const char *b) {
    int rows[32][32];
    int n = (int)strlen(a), m = (int)strlen(b);
    if (n > 31 || m > 31) return 99;
    for (int i = 0; i <= n; i++) {
        for (int j = 0; j <= m; j++) {
            if (i == 0 || j == 0) {
                rows[i][j] = i + j;
                continue;
            }
            rows[i][j] = smallest(rows[i - 1][j] + 1, rows[i][j - 1] + 1, rows[i - 1][j - 1] + (a[i - 1] != b[j - 1]));
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] && rows[i - 2][j - 2] + 1 < rows[i][j])
                rows[i][j] = rows[i - 2][j - 2] + 1;
        }
    }
    return rows[n][m];
}

const char *closest_word(const char *word, const char *const *words, int count) {
    const char *best = NULL;
    int least = (int)strlen(word) / 3 + 1;
    for (int i = 0; i < count; i++) {
        int edits = distance(word, words[i]);
        if (edits <= least && edits < (int)strlen(words[i])) {
            best = words[i];
            least = edits - 1;
        }
    }
    return best;
}

static NphStatus unknown_option(const OptionTable *table, const char *command, const char *word, const char *name) {
    const char *names[MAX_OPTIONS + 1] = {"help"};
    int count = 1;
    for (int i = 0; i < table->count; i++) names[count++] = table->options[i].name;
    const char *near = closest_word(name, names, count);
    if (near) return usage_error(command, "unknown option %s; did you mean --%s?", word, near);
    return usage_error(command, "unknown option %s", word);
}

static NphStatus parse_bytes(const char *command, const Option *option, const char *text) {
    static const char letters[] = "kMGT";
    size_t length = strlen(text);
    const char *letter = length ? strchr(letters, text[length - 1] == 'K' ? 'k' : text[length - 1]) : NULL;
    double number = 0, scale = 1;
    for (const char *l = letters; letter && l <= letter; l++) scale *= 1024;
    if (!nph_parse_double_range(text, text + length - (letter != NULL), &number) || number < 0 || number * scale > 9e18)
        return usage_error(command, "--%s %s: expected bytes, such as 512M or 2G", option->name, text);
    *(uint64_t *)option->target = (uint64_t)(number * scale);
    return NPH_OK;
}

static NphStatus parse_integers(const char *command, const Option *option, const char *text) {
    int64_t *values = option->target;
    const char *begin = text;
    for (int i = 0; i < option->count; i++) {
        const char *end = i + 1 < option->count ? strchr(begin, option->separator) : begin + strlen(begin);
        if (!end || !nph_parse_int_range(begin, end, &values[i]))
            return usage_error(command, "--%s %s: expected %s, whole numbers", option->name, text, option->value_name);
        begin = end + 1;
    }
    return NPH_OK;
}

static NphStatus parse_number(const char *command, const Option *option, const char *text) {
    double number = 0;
    if (!nph_parse_double(text, &number)) return usage_error(command, "--%s %s: expected a number", option->name, text);
    if (number < option->min || number > option->max)
        return usage_error(command, "--%s %s: expected a number from %g to %g", option->name, text, option->min, option->max);
    *(double *)option->target = number;
    return NPH_OK;
}

static NphStatus parse_whole(const char *command, const Option *option, const char *text) {
    int64_t value = 0;
    if (!nph_parse_int(text, &value) || (double)value < option->min || (double)value > option->max)
        return usage_error(command, "--%s %s: expected a whole number from %.0f to %.0f", option->name, text, option->min,
                           option->max);
    *(int64_t *)option->target = value;
    return NPH_OK;
}

static NphStatus take_value(const char *command, const Option *option, const char *text) {
    if (option->given) *option->given = 1;
    switch (option->kind) {
    case OPTION_FLAG: *(int *)option->target = 1; return NPH_OK;
    case OPTION_TEXT:
    case OPTION_SUFFIXED: *(const char **)option->target = text; return NPH_OK;
    case OPTION_INT: return parse_whole(command, option, text);
    case OPTION_NUMBER: return parse_number(command, option, text);
    case OPTION_BYTES: return parse_bytes(command, option, text);
    case OPTION_INTS: return parse_integers(command, option, text);
    case OPTION_LIST: break;
    }
    TextList *list = option->target;
    if (list->count == MAX_LIST) return usage_error(command, "--%s: given more than %d times", option->name, MAX_LIST);
    list->items[list->count++] = text;
    return NPH_OK;
}

static int ends_in(const char *text, const char *suffix) {
    size_t n = strlen(text), m = strlen(suffix);
    return n > m && strcmp(text + n - m, suffix) == 0;
}

/* The option that `word` names; *value is what follows = or the letter, or NULL. */
static const Option *find_option(const OptionTable *table, const char *word, const char **value) {
    int is_long = word[1] == '-';
    const char *name = word + (is_long ? 2 : 1);
    size_t length = is_long ? strcspn(name, "=") : 1;
    *value = is_long ? (name[length] ? name + length + 1 : NULL) : (name[1] ? name + 1 : NULL);
    for (int i = 0; i < table->count; i++) {
        const Option *option = &table->options[i];
        if (is_long ? strlen(option->name) == length && strncmp(option->name, name, length) == 0 : option->letter == *name)
            return option;
    }
    return NULL;
}

NphStatus options_parse(const OptionTable *table, const char *command, int argc, char **argv, TextList *files) {
    for (int i = 1, ended = 0; i < argc; i++) {
        const char *word = argv[i], *value = NULL;
        if (ended || word[0] != '-' || !word[1]) {
            if (files->count == MAX_LIST) return usage_error(command, "more than %d files", MAX_LIST);
            files->items[files->count++] = word;
            continue;
        }
        if (strcmp(word, "--") == 0) {
            ended = 1;
            continue;
        }
        const Option *option = find_option(table, word, &value);
        if (!option) {
            char name[40];
            snprintf(name, sizeof name, "%.*s", (int)strcspn(word + 1 + (word[1] == '-'), "="), word + 1 + (word[1] == '-'));
            return unknown_option(table, command, word, name);
        }
        if (option->kind == OPTION_FLAG && value) return usage_error(command, "--%s takes no value", option->name);
        if (option->kind == OPTION_SUFFIXED && !value)
            value = i + 1 < argc && ends_in(argv[i + 1], option->suffix) ? argv[++i] : "";
        if (option->kind != OPTION_FLAG && !value) {
            if (i + 1 == argc) return usage_error(command, "--%s needs a value: %s", option->name, option->value_name);
            value = argv[++i];
        }
        NphStatus status = take_value(command, option, value);
        if (status != NPH_OK) return status;
    }
    return NPH_OK;
}

void options_print(const OptionTable *table, FILE *out) {
    enum { INDENT = 32, WIDTH = 100 };
    for (int i = 0; i < table->count; i++) {
        const Option *option = &table->options[i];
        char head[80];
        snprintf(head, sizeof head, "  %c%c%s--%s%s%s", option->letter ? '-' : ' ', option->letter ? option->letter : ' ',
                 option->letter ? ", " : "  ", option->name, option->value_name ? " " : "",
                 option->value_name ? option->value_name : "");
        int column = fprintf(out, "%-*s", INDENT - 1, head);
        for (const char *word = option->meaning; *word;) {
            int length = (int)strcspn(word, " ");
            if (column + 1 + length > WIDTH) column = fprintf(out, "\n%*s", INDENT - 1, "") - 1;
            column += fprintf(out, " %.*s", length, word);
            word += length;
            while (*word == ' ') word++;
        }
        fputc('\n', out);
    }
}
