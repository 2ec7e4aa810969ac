# SPDX-License-Identifier: Apache-2.0
"""Scenes of the figures of [Elek14], and how pictures are held against the truth: of pixels that show the medium (opacity above 2%), luminance
differences over the mean luminance of the truth there. Squares of differences lose the truth's own variance, which its file tells."""
import struct
import zlib

import numpy

SMOKE = 'density: {file: ROOT/reference/data/smoke128/smoke128.zip.nvdb, centring: cell, lookup: trilinear}'
BALL = 'density: {file: ROOT/reference/data/sphere/sphere.npy, box: [[-2.5, -2.5, -2.5], [2.5, 2.5, 2.5]]}'
STUDIO = '{type: environment, file: ROOT/reference/data/env/indoors/studio128.exr, rotation: 0}'
COURTYARD = '{type: environment, file: ROOT/reference/data/env/indoors/courtyard128.exr, rotation: 0}'
SUNSET = '{type: environment, file: ROOT/reference/data/env/exr_variants/sunset256_half_zip.exr, rotation: 0}'
VARIANTS = ('corrected', 'paper')


def scene(lab, name, camera, medium, lights, surfaces=()):
    """Writes a scene; its path."""
    path = lab.work / f'{name}.yaml'
    lines, walls = (''.join(f'  - {one}\n' for one in of) for of in (lights, surfaces))
    text = f'nephos: 1\ncamera: {{{camera}}}\nmedia:\n  - {{{medium}}}\nlights:\n{lines}' + (f'surfaces:\n{walls}' if walls else '')
    path.write_text(text.replace('ROOT', str(lab.root)), encoding='utf-8')
    return path


def luminance(told, prefix=''):
    return 0.2126 * told[prefix + 'R'] + 0.7152 * told[prefix + 'G'] + 0.0722 * told[prefix + 'B']


def noise(told):
    """Variance of the luminance, channels taken as one."""
    return sum(w * numpy.sqrt(told[f'Variance.{c}']) for c, w in zip('RGB', (0.2126, 0.7152, 0.0722))) ** 2


def pixels(lab, name):
    return lab.pixels(lab.work / f'{name}.exr')


def truth(lab, path, name, samples, method='path', words=()):
    """Renders it unless it is there already, of this scene and these samples."""
    told, mark = lab.work / f'{name}.exr', lab.work / f'{name}.of'
    wanted = f'{path.read_text(encoding="utf-8")}{method} {samples} {words}'
    if not (told.exists() and mark.exists() and mark.read_text(encoding='utf-8') == wanted):
        lab.render(path, name, method=method, words=('--spp', samples, *words))
        mark.write_text(wanted, encoding='utf-8')
    return lab.pixels(told)


def windows(values, size):
    """Means over windows of size^2 pixels around each, smaller at the rim."""
    for axis in (0, 1):
        sums = numpy.cumsum(numpy.insert(values, 0, 0.0, axis), axis)
        at = numpy.arange(values.shape[axis])
        low, high = numpy.maximum(at - size // 2, 0), numpy.minimum(at + size // 2 + 1, values.shape[axis])
        count = (high - low).reshape((-1, 1) if axis == 0 else (1, -1))
        values = (numpy.take(sums, high, axis) - numpy.take(sums, low, axis)) / count
    return values


def errors(told, true, window=0):
    """Bias and RMSE of the medium's pixels, the same after the factor that makes it least; with a window what of the RMSE is left when the differences' local mean is taken off: spots."""
    here = true['A'] > 0.02
    mean = luminance(true)[here].mean()
    off = numpy.where(here, luminance(told) - luminance(true), 0.0)
    own = noise(true)
    ours, theirs = luminance(told)[here], luminance(true)[here]
    scale = (ours * theirs).sum() / max((ours * ours).sum(), 1e-300)
    out = {'bias': float(off[here].mean() / mean), 'rmse': float(numpy.sqrt(max((off[here] ** 2 - own[here]).mean(), 0.0)) / mean)}
    out['scaled_rmse'] = float(numpy.sqrt(max(((scale * ours - theirs) ** 2 - own[here]).mean(), 0.0)) / mean)
    if window:
        part = windows(here.astype(float), window)
        local = numpy.where(here, off - windows(off, window) / numpy.maximum(part, 1e-9), 0.0)
        out['spots'] = float(numpy.sqrt(max((local[here] ** 2 - own[here] * (1 - 1 / window ** 2)).mean(), 0.0)) / mean)
    return out


def mean_of(rows):
    """Of several pictures' errors: mean of the biases, root mean square of the others."""
    return {key: float(numpy.mean([r[key] for r in rows]) if key == 'bias' else numpy.sqrt(numpy.mean([r[key] ** 2 for r in rows]))) for key in rows[0]}


def truth_error(true):
    """Standard error of a pixel of the truth, root mean square, over the mean."""
    here = true['A'] > 0.02
    return float(numpy.sqrt(noise(true)[here].mean()) / luminance(true)[here].mean())


def chunk(kind, data):
    return struct.pack('>I', len(data)) + kind + data + struct.pack('>I', zlib.crc32(kind + data))


def sheet(lab, file, rows, scale=2):
    """Pictures side by side at one exposure, to look at: lists of names, a row each; the first one of all sets the exposure."""
    first = pixels(lab, rows[0][0])
    white = numpy.percentile(luminance(first), 99) / 0.8
    lines = [numpy.concatenate([numpy.stack([pixels(lab, name)[c] for c in 'RGB'], -1) for name in row], 1) for row in rows]
    wide = max(line.shape[1] for line in lines)
    picture = numpy.concatenate([numpy.pad(line, ((0, 0), (0, wide - line.shape[1]), (0, 0))) for line in lines], 0)
    shown = (numpy.clip(picture / max(white, 1e-30), 0, 1) ** (1 / 2.2) * 255).astype('u1').repeat(scale, 0).repeat(scale, 1)
    raw = b''.join(b'\0' + line.tobytes() for line in shown)
    header = struct.pack('>IIBBBBB', shown.shape[1], shown.shape[0], 8, 2, 0, 0, 0)
    (lab.work / f'{file}.png').write_bytes(b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', header) + chunk(b'IDAT', zlib.compress(raw)) + chunk(b'IEND', b''))
