#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The sky of a night with a full moon, and moonlit ground below: a latitude-longitude map, 128 x 64, OpenEXR, half, ZIP.

usage: make_night.py OUT.exr

Moonlight scattered once by a flat exponential atmosphere (Riley et al. 2004, Eq. 14, by quadrature over height), as seen from
HEIGHT; the light of airglow and stars, 22 mag/arcsec2 in the zenith (Leinert et al. 1998), brighter towards the horizon as a
layer 90 km up is; ground of albedo 0.15. Extinction as the scene's air has it (Bodhaine et al. 1999). No star is drawn."""
import math
import struct
import sys
import zlib

WIDTH, HEIGHT_PIXELS = 128, 64
MOON = (5.1e-4, 4.7e-4, 3.7e-4)          # W/m2 above the air: reference/scenes/night.yaml
ELEVATION, AZIMUTH = 30.0, 215.0         # degrees
BETA = (4.848e-6, 1.149e-5, 2.871e-5)    # 1/m at sea level: 680, 550, 440 nm
SCALE, HEIGHT = 8000.0, 880.0            # m
GLOW = 10.8e4 * 10 ** (-0.4 * 22) / 683  # W/m2/sr: 10.8e4 cd/m2 is 0 mag/arcsec2
ALBEDO = 0.15


def column(height, sine):
    return SCALE * math.exp(-height / SCALE) / sine


def scattered(sine, cosine):
    """Radiance over irradiance of what is scattered once; 400 midpoints of e^(-h/H) along the way up."""
    phase, eye, rise = 3 / (16 * math.pi) * (1 + cosine * cosine), math.exp(-HEIGHT / SCALE), math.sin(math.radians(ELEVATION))
    out = []
    for beta in BETA:
        total = 0.0
        for i in range(400):
            here = eye * (i + 0.5) / 400  # density; column from the eye: (eye - here) H / sine
            total += math.exp(-beta * SCALE * ((eye - here) / sine + here / rise)) * eye / 400
        out.append(phase * beta * SCALE / sine * total)
    return out


def texel(row, col):
    sine = math.cos(math.pi * (row + 0.5) / HEIGHT_PIXELS)
    rise = math.sin(math.radians(ELEVATION))
    if sine < 0:
        return [ALBEDO / math.pi * e * rise * math.exp(-b * column(0, rise)) for e, b in zip(MOON, BETA)]
    azimuth = 2 * math.pi * (0.5 - (col + 0.5) / WIDTH)  # column 0 begins at azimuth 180 degrees and it falls
    flat = math.sqrt(1 - sine * sine) * math.cos(math.radians(ELEVATION))
    cosine = sine * rise + flat * math.cos(azimuth - math.radians(AZIMUTH))
    layer = 1 / math.sqrt(1 - (1 - sine * sine) * (6371 / (6371 + 90)) ** 2)
    return [e * s + GLOW * layer * math.exp(-b * column(HEIGHT, sine))
            for e, s, b in zip(MOON, scattered(sine, cosine), BETA)]


def attribute(name, kind, value):
    return name.encode() + b'\0' + kind.encode() + b'\0' + struct.pack('<i', len(value)) + value


def exr(pixels):
    names = sorted('RGB')
    box = struct.pack('<4i', 0, 0, WIDTH - 1, HEIGHT_PIXELS - 1)
    channels = b''.join(n.encode() + b'\0' + struct.pack('<iB3xii', 1, 0, 1, 1) for n in names) + b'\0'
    header = struct.pack('<ii', 20000630, 2)
    for entry in (('channels', 'chlist', channels), ('compression', 'compression', b'\3'), ('dataWindow', 'box2i', box),
                  ('displayWindow', 'box2i', box), ('lineOrder', 'lineOrder', b'\0'),
                  ('pixelAspectRatio', 'float', struct.pack('<f', 1)), ('screenWindowCenter', 'v2f', bytes(8)),
                  ('screenWindowWidth', 'float', struct.pack('<f', 1))):
        header += attribute(*entry)
    header += b'\0'
    blocks = []
    for first in range(0, HEIGHT_PIXELS, 16):
        data = b''.join(struct.pack(f'<{WIDTH}e', *(p['RGB'.index(n)] for p in pixels[row]))
                        for row in range(first, first + 16) for n in names)
        turned = data[0::2] + data[1::2]
        turned = turned[:1] + bytes((b - a + 128) & 255 for a, b in zip(turned, turned[1:]))
        packed = zlib.compress(turned, 9)
        blocks.append(struct.pack('<ii', first, len(packed)) + packed)
    at, offsets = len(header) + 8 * len(blocks), []
    for block in blocks:
        offsets.append(at)
        at += len(block)
    return header + struct.pack(f'<{len(blocks)}Q', *offsets) + b''.join(blocks)


SCALED = 1024  # half floats have few digits below 6e-5: the map holds radiance times this
with open(sys.argv[1], 'wb') as out:
    out.write(exr([[[SCALED * v for v in texel(row, col)] for col in range(WIDTH)] for row in range(HEIGHT_PIXELS)]))
