/* SPDX-License-Identifier: Apache-2.0
 *
 * The C library converts correctly but follows the thread's locale and rounding mode; both are set around each call and
 * put back. Syntax is checked here beforehand, so that nothing else than a plain decimal reaches it. */
#include "core/text.h"

#include <fenv.h>
#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct Neutral {
    locale_t neutral, before;
    int rounding;
} Neutral;

/* 0 when the system has no memory for a locale (glibc and musl keep "C" statically and never fail). */
static int enter_neutral(Neutral *state) {
    state->neutral = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    if (!state->neutral) return 0;
    state->before = uselocale(state->neutral);
    state->rounding = fegetround();
    fesetround(FE_TONEAREST);
    return 1;
}

static void leave_neutral(const Neutral *state) {
    fesetround(state->rounding);
    uselocale(state->before);
    freelocale(state->neutral);
}

static const char *skip_digits(const char *text, const char *end) {
    while (text < end && *text >= '0' && *text <= '9') text++;
    return text;
}

static const char *skip_sign(const char *text, const char *end) {
    return text < end && (*text == '+' || *text == '-') ? text + 1 : text;
}

int nph_is_decimal(const char *begin, const char *end) {
    const char *at = skip_sign(begin, end), *digits = at;
    at = skip_digits(at, end);
    int64_t count = at - digits;
    if (at < end && *at == '.') {
        digits = ++at;
        at = skip_digits(at, end);
        count += at - digits;
    }
    if (count == 0) return 0;
    if (at < end && (*at == 'e' || *at == 'E')) {
        digits = skip_sign(at + 1, end);
        at = skip_digits(digits, end);
        if (at == digits) return 0;
    }
    return at == end;
}

int nph_parse_double_range(const char *begin, const char *end, double *value) {
    char copy[NPH_NUMBER_MAX + 1];
    size_t length = (size_t)(end - begin);
    Neutral state;
    if (length > NPH_NUMBER_MAX || !nph_is_decimal(begin, end) || !enter_neutral(&state)) return 0;
    memcpy(copy, begin, length);
    copy[length] = 0;
    double number = strtod(copy, NULL);
    leave_neutral(&state);
    if (number == HUGE_VAL || number == -HUGE_VAL) return 0;
    *value = number;
    return 1;
}

int nph_parse_int_range(const char *begin, const char *end, int64_t *value) {
    const char *at = skip_sign(begin, end);
    int negative = at > begin && *begin == '-';
    if (at == end || skip_digits(at, end) != end) return 0;
    int64_t number = 0; /* counted downwards: the most negative value has no positive twin */
    for (; at < end; at++) {
        int digit = *at - '0';
        if (number < (INT64_MIN + digit) / 10) return 0;
        number = number * 10 - digit;
    }
    if (!negative && number == INT64_MIN) return 0;
    *value = negative ? number : -number;
    return 1;
}

int nph_parse_double(const char *text, double *value) {
    return nph_parse_double_range(text, text + strlen(text), value);
}

int nph_parse_int(const char *text, int64_t *value) {
    return nph_parse_int_range(text, text + strlen(text), value);
}

const char *nph_format_double(double value, char text[NPH_DOUBLE_TEXT]) {
    char digits[NPH_DOUBLE_TEXT];
    Neutral state;
    if (value != value) return strcpy(text, "nan");
    if (value == HUGE_VAL || value == -HUGE_VAL) return strcpy(text, value > 0 ? "inf" : "-inf");
    int neutral = enter_neutral(&state);
    for (int count = 15; count <= 17; count++) {
        snprintf(digits, sizeof digits, "%.*g", count, value);
        if (strtod(digits, NULL) == value) break;
    }
    if (neutral) leave_neutral(&state);
    return strcpy(text, digits);
}

const char *nph_format_rounded(double value, int digits, char text[NPH_DOUBLE_TEXT]) {
    Neutral state;
    if (value != value) return strcpy(text, "nan");
    if (value == HUGE_VAL || value == -HUGE_VAL) return strcpy(text, value > 0 ? "inf" : "-inf");
    int neutral = enter_neutral(&state);
    snprintf(text, NPH_DOUBLE_TEXT, "%.*g", digits, value);
    if (neutral) leave_neutral(&state);
    return text;
}
