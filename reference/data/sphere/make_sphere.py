#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes sphere.npy: 48^3 cells of the cube [-1, 1]^3 as u8, the part of each cell's 8^3 subcells within the unit sphere,
from 0 to 255 (rounded; 255 is all of it)."""
import pathlib
import struct

n, sub = 48, 8
step = 2.0 / (n * sub)
squares = [(-1.0 + (i + 0.5) * step) ** 2 for i in range(n * sub)]


def part(x, y, z):
    inside = sum(a + b + c < 1.0 for c in squares[z * sub:(z + 1) * sub] for b in squares[y * sub:(y + 1) * sub]
                 for a in squares[x * sub:(x + 1) * sub])
    return (inside * 255 * 2 + sub ** 3) // (2 * sub ** 3)


half = n // 2
octant = {(x, y, z): part(half + x, half + y, half + z) for x in range(half) for y in range(half) for z in range(half)}


def fold(i):
    return i - half if i >= half else half - 1 - i


values = bytes(octant[fold(x), fold(y), fold(z)] for z in range(n) for y in range(n) for x in range(n))
header = "{'descr': '|u1', 'fortran_order': False, 'shape': (%d, %d, %d), }" % (n, n, n)
header += ' ' * (63 - (10 + len(header)) % 64) + '\n'
path = pathlib.Path(__file__).resolve().parent / 'sphere.npy'
path.write_bytes(b'\x93NUMPY\x01\x00' + struct.pack('<H', len(header)) + header.encode() + values)
