/* SPDX-License-Identifier: Apache-2.0
 *
 * Numbers as text, the same in every locale, rounding mode and thread. A number is plain decimal: optional sign, digits
 * with at most one point (a digit on at least one side of it), optional exponent: 7, -3, +.5, 2., 1e5, 6.02E+23. Hex,
 * infinities, NaN, blanks and anything before or behind are refused. */
#ifndef NPH_CORE_TEXT_H
#define NPH_CORE_TEXT_H

#include <stddef.h>
#include <stdint.h>

enum {
    NPH_NUMBER_MAX = 1024, /* characters of a number that is still read */
    NPH_DOUBLE_TEXT = 32   /* bytes that hold any formatted double, its NUL included */
};

/* Whole string: 1 and *value, the nearest double; else 0, *value untouched. A magnitude that rounds to infinity is
 * refused; one too small becomes the nearest subnormal or 0. */
int nph_parse_double(const char *text, double *value);

/* Whole string of an optional sign and digits: 1 and *value; 0 when it is something else or does not fit. */
int nph_parse_int(const char *text, int64_t *value);

/* The same for the characters [begin, end), which need not end in NUL: tokens of a larger text. */
int nph_parse_double_range(const char *begin, const char *end, double *value);
int nph_parse_int_range(const char *begin, const char *end, int64_t *value);

/* 1 when [begin, end) is written like a number, whatever its size: tells "not a number" from "too large". */
int nph_is_decimal(const char *begin, const char *end);

/* The shortest of %.15g, %.16g, %.17g that reads back as the same double; else "nan", "inf", "-inf". Returns text. */
const char *nph_format_double(double value, char text[NPH_DOUBLE_TEXT]);

/* The value rounded to 1 to 17 significant digits (%.*g): for messages. Returns text. */
const char *nph_format_rounded(double value, int digits, char text[NPH_DOUBLE_TEXT]);

#endif
