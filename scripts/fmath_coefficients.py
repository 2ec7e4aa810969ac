#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Polynomial coefficients of src/core/fmath_*.h, derived by weighted least squares (needs mpmath).

For each kernel: the polynomial P of a given degree that nearly minimises max |weight (P - f)| on an interval, its coefficients
rounded to float or double one after the other, lowest first, the remaining ones fitted again after each rounding.
Prints the coefficients, lowest first, and log2 of the largest weighted error with the rounded coefficients.

    scripts/fmath_coefficients.py [NAME...]      all kernels when no name is given
"""
import struct
import sys

from mpmath import (asin, atan, atanh, cbrt, cos, exp, expm1, floor, fsum, linspace, log, log1p, lu_solve, matrix, mp, mpf, pi,
                    polyval, sin, sqrt, tan)

mp.dps = 150  # (f - c0 - ...) / x^n near 0 loses most of them


def rounded(value, bits):
    """Nearest float (24) or double (53)."""
    if bits == 53:
        return mpf(float(value))
    return mpf(struct.unpack("f", struct.pack("f", float(value)))[0])


def minimax(f, weight, lo, hi, degree):
    """Nearly the best weighted polynomial, lowest coefficient first: least squares, reweighted by its own errors."""
    count = 6 * (degree + 2)
    points = [(lo + hi) / 2 - (hi - lo) / 2 * cos(pi * (i + mpf(1) / 2) / count) for i in range(count)]
    points = [x for x in points if abs(x) > (hi - lo) / 10000]
    values = [f(x) for x in points]
    squares = [weight(x) ** 2 for x in points]
    lawson = [mpf(1)] * len(points)
    for _ in range(12):
        terms = [w * l for w, l in zip(squares, lawson)]
        moments = []
        for k in range(2 * degree + 1):
            moments.append(fsum(terms))
            terms = [t * x for t, x in zip(terms, points)]
        system = matrix(degree + 1, degree + 1)
        right = matrix(degree + 1, 1)
        terms = [w * l * y for w, l, y in zip(squares, lawson, values)]
        for i in range(degree + 1):
            right[i] = fsum(terms)
            terms = [t * x for t, x in zip(terms, points)]
            for j in range(degree + 1):
                system[i, j] = moments[i + j]
        solution = lu_solve(system, right)
        coefficients = [solution[j] for j in range(degree + 1)]
        errors = [sqrt(w) * abs(polyval(coefficients[::-1], x) - y) for w, x, y in zip(squares, points, values)]
        largest = max(errors)
        if largest == 0:
            break
        lawson = [l * (e / largest + mpf("1e-6")) for l, e in zip(lawson, errors)]
        lawson = [l / max(lawson) for l in lawson]
    return coefficients


def fit(f, weight, lo, hi, degree, bits):
    """Rounded coefficients: after c0 is fixed, (f - c0) / x is fitted with weight * x, and so on."""
    lo, hi = mpf(lo), mpf(hi)
    done = []
    for step in range(degree + 1):
        fixed = list(done)

        def rest(x, fixed=fixed, step=step):
            return (f(x) - polyval(fixed[::-1], x)) / x ** step if step else f(x)

        def heavier(x, step=step):
            return weight(x) * abs(x) ** step if step else weight(x)

        done.append(rounded(minimax(rest, heavier, lo, hi, degree - step)[0], bits))
    points = [x for x in linspace(lo, hi, 2001) if x != 0]
    worst = max(abs(weight(x) * (polyval(done[::-1], x) - f(x))) for x in points)
    return done, worst


def parts(value, bits_each, count, bits):
    """value as count numbers of bits_each bits each (their products with small integers are exact) and a full rest."""
    out, rest = [], value
    for _ in range(count):
        scale = mpf(2) ** (bits_each - 1 - floor(log(abs(rest), 2)))
        part = mpf(int(rest * scale)) / scale
        out.append(part)
        rest -= part
    return out + [rounded(rest, bits)]


def text(value, bits):
    if bits == 53:
        return repr(float(value))
    for digits in range(1, 10):
        out = "%.*g" % (digits, float(value))
        if rounded(mpf(out), 24) == value:
            break
    return out + ("f" if "." in out or "e" in out else ".0f")


half_log2 = log(2) / 2 * mpf("1.0001")
quarter_pi = pi / 4 * mpf("1.0001")
log_lo, log_hi = sqrt(mpf(1) / 2) - 1 - mpf("1e-6"), sqrt(mpf(2)) - 1 + mpf("1e-6")
log_s2 = ((sqrt(mpf(2)) - 1) / (sqrt(mpf(2)) + 1)) ** 2 * mpf("1.0001")
tiny = mpf(10) ** -20


def root(z):
    return sqrt(z) if z > tiny else sqrt(tiny)


def odd(function, slope):
    """(function(r) - slope r) / r^3 of z = r^2, and the weight that makes its error relative to function(r)."""
    def f(z):
        r = root(z)
        return (function(r) - slope * r) / r ** 3
    return f, lambda z: root(z) ** 3 / function(root(z))


def power(scale):
    """(exp(scale r) - 1 - scale r) / r^2 and its weight relative to exp."""
    def f(r):
        r = r if abs(r) > tiny else tiny
        return (exp(scale * r) - 1 - scale * r) / r ** 2
    return f


def exp_weight(r):
    r = r if abs(r) > tiny else tiny
    return abs(r ** 2 / expm1(r))


def log_rest(f):
    f = f if abs(f) > tiny else tiny
    return (log1p(f) - f + f * f / 2) / f ** 3


def kernels():
    out = {}
    for bits, name in ((24, "f"), (53, "")):
        single = bits == 24
        # exp(r) = 1 + r + r^2 P(r)
        out["exp" + name] = (power(mpf(1)), exp_weight, -half_log2, half_log2, 5 if single else 10, bits)
        # 2^r = 1 + r log 2 + r^2 P(r)
        out["exp2" + name] = (power(log(2)), lambda r: r * r / exp(r * log(2)), mpf(-1) / 2, mpf(1) / 2,
                              5 if single else 10, bits)
        # sin(r) = r + r^3 P(z), cos(r) = 1 - z/2 + z^2 P(z), z = r^2
        out["sin" + name] = (*odd(sin, 1), 0, quarter_pi ** 2, 2 if single else 5, bits)
        out["cos" + name] = (lambda z: (cos(root(z)) - 1 + root(z) ** 2 / 2) / root(z) ** 4,
                             lambda z: z * z / cos(root(z)), 0, quarter_pi ** 2, 2 if single else 5, bits)
        # sin(2 pi r) = 2 pi r + r^3 P(z), cos(2 pi r) = 1 - 2 pi^2 z + z^2 P(z), |r| <= 1/8
        out["sin2pi" + name] = (*odd(lambda r: sin(2 * pi * r), 2 * pi), 0, mpf(1) / 64, 2 if single else 5, bits)
        out["cos2pi" + name] = (lambda z: (cos(2 * pi * root(z)) - 1 + 2 * pi ** 2 * root(z) ** 2) / root(z) ** 4,
                                lambda z: z * z / cos(2 * pi * root(z)), 0, mpf(1) / 64, 2 if single else 5, bits)
        # tan(r) = r + r^3 P(z)
        out["tan" + name] = (*odd(tan, 1), 0, quarter_pi ** 2, 6 if single else 13, bits)
        # asin(x) = x + x^3 P(x^2), |x| <= 1/2
        out["asin" + name] = (*odd(asin, 1), 0, mpf(1) / 4, 4 if single else 12, bits)
        # atan(q) = q + q^3 P(q^2), |q| <= 1
        out["atan" + name] = (*odd(atan, 1), 0, mpf(1), 8 if single else 19, bits)
        # cbrt(m) on [1, 2): a start for the iteration
        out["cbrt" + name] = (cbrt, lambda m: 1 / cbrt(m), mpf(1), mpf(2), 2, bits)
        # (atanh(s)/s - 1 - z/3) / z^2, z = s^2
        out["powlog" + name] = (lambda z: (atanh(root(z)) / root(z) - 1 - root(z) ** 2 / 3) / root(z) ** 4,
                                lambda z: z * z, 0, log_s2, 2 if single else 6, bits)
    # atanh(s) = s + s^3 P(s^2), log(1 + f) = 2 atanh(f / (2 + f))
    out["atanh"] = (*odd(atanh, 1), 0, log_s2, 6, 53)
    # log(1 + f) = f - f^2/2 + f^3 P(f)
    out["logf"] = (log_rest, lambda f: abs(f ** 3 / log1p(f)) if abs(f) > tiny else tiny, log_lo, log_hi, 8, 24)
    return out


def main():
    chosen = sys.argv[1:]
    for name, (f, weight, lo, hi, degree, bits) in kernels().items():
        if chosen and name not in chosen:
            continue
        coefficients, worst = fit(f, weight, lo, hi, degree, bits)
        print("%-8s 2^%.1f  %s" % (name, float(log(worst, 2)), ", ".join(text(c, bits) for c in coefficients)), flush=True)
    if not chosen:
        for bits, small, count in ((24, 11, 4), (53, 33, 3)):
            print("pi/2    ", ", ".join(text(p, bits) for p in parts(pi / 2, small, count, bits)))
            for label, value, width in (("log 2", log(2), 15 if bits == 24 else 42), ("1/log 2", 1 / log(2), bits),
                                        ("log 2", log(2), bits), ("2 pi", 2 * pi, bits), ("2 pi^2", 2 * pi ** 2, bits),
                                        ("pi", pi, bits), ("pi/2", pi / 2, bits), ("2/pi", 2 / pi, bits), ("1/3", mpf(1) / 3, bits)):
                head = rounded(value, bits) if width == bits else parts(value, width, 1, bits)[0]
                print("%-8s" % label, text(head, bits), text(rounded(value - head, bits), bits))


if __name__ == "__main__":
    main()
