# SPDX-License-Identifier: Apache-2.0
"""Shortcuts: what each does to the fluence of cells, against the path tracer and light tracing.

The paper states no number: it cuts beams of which little is left (Section 4.1.1), turns isotropic by similarity (4.1.3) and shows pictures. Here
the scenes of the test without_shortcuts_the_fluence_of_cells_is_that_of_path_and_light: the medium's box in n^3 cells, fluence sensors of `path` and of `light` in planes
of every layer. `bias` is of the mean over cells, `error` one standard error of both together; `rms` and `largest` are of cells against the same caches
without shortcuts, which share their random numbers: the part
that noise does not explain. Pixels of light share photons; its error counts them as independent."""
import math

import numpy

SUN = '  - {type: sun, direction: [-1, 0, 0], irradiance: 2}\n'
CUBE = 'box: [[0, 0, 0], [1, 1, 1]], extinction: %s, albedo: %s, phase: {type: hg, g: %s}'
RICO = ('density: {file: ROOT/reference/data/gpl/rico122x106x39.txt, centring: cell, lookup: trilinear}, transform: [{translate: [10, 10, -420]}, '
        '{scale: [1, 1.1509433962264151, 1]}], extinction: 1, albedo: 1, phase: {type: hg, g: 0.85}')
SPHERE = ('density: {file: ROOT/reference/data/sphere/sphere.npy, box: [[-1, -1, -1], [1, 1, 1]]}, extinction: 0.011764705882352941, albedo: 0.99, '
          'phase: {type: hg, g: 0.3}')
# name: medium, lights, n, planes of a layer (3: Gauss), low corner, edge, height, light that cells keep away from, samples of path and light
SCENES = {
    'cube, g 0.7': (CUBE % (4, 1, 0.7), SUN, 4, 3, (0, 0, 0), 1, 1, None, 8192, 512),
    'cube, g 0.96': (CUBE % (20, 0.99, 0.96), SUN + '  - {type: constant, radiance: 1}\n', 4, 3, (0, 0, 0), 1, 1, None, 8192, 512),
    'sphere': (SPHERE, '  - {type: point, position: [0.3, 0.2, 0.4], intensity: 1}\n', 8, 6, (-1, -1, -1), 2, 2, (0.3, 0.2, 0.4, 0.45), 2048, 128),
    'rico': (RICO, '  - {type: sun, direction: [-1, -1, 1.41421], irradiance: 3.14159}\n  - {type: constant, radiance: 0.18}\n', 8, 12, (0, 0, 0), 2440, 1560,
             None, 512, 64),
}
PLAIN = {'tpm.similarity': 0, 'tpm.threshold': 0}
SETTINGS = (
    ('none', {}),
    ('threshold 0.001', {'tpm.threshold': 0.001}),
    ('threshold 0.01', {'tpm.threshold': 0.01}),
    ('threshold 0.1', {'tpm.threshold': 0.1}),
    ('threshold 1', {'tpm.threshold': 1}),
    ('similarity 0.05', {'tpm.similarity': 0.05}),
    ('similarity 0.05, as printed', {'tpm.similarity': 0.05, 'tpm.variant': 1}),
    ('similarity 0.3', {'tpm.similarity': 0.3}),
    ('similarity 0.3, as printed', {'tpm.similarity': 0.3, 'tpm.variant': 1}),
    ('similarity at once', {'tpm.similarity': 1}),
    ('similarity at once, as printed', {'tpm.similarity': 1, 'tpm.variant': 1}),
    ('the method\'s own: both', {'tpm.similarity': 0.05, 'tpm.threshold': 0.01}),
    ('100 generations', {'tpm.generations': 100}),
    ('generations of unequal size', {'tpm.vary': 0.5}),
    ('a tenth of the photons', {'tpm.photons': 5000}),
)
GAUSS = ((0.11270166537925831, 5 / 18), (0.5, 8 / 18), (0.88729833462074169, 5 / 18))


def write_scene(lab, camera, medium, lights):
    path = lab.work / 'shortcuts.yaml'
    medium = medium.replace('ROOT', str(lab.root))
    path.write_text(f'nephos: 1\ncamera: {{{camera}}}\nmedia:\n  - {{{medium}}}\nlights:\n{lights}', encoding='utf-8')
    return path


def probe(lab, scene, method):
    """Fluence of cells, [z][y][x], and its variance."""
    medium, lights, n, planes, low, edge, height, _, path_samples, light_samples = scene
    mean, variance = numpy.zeros((n, n, n)), numpy.zeros((n, n, n))
    steps = GAUSS if planes == 3 else [((k + 0.5) / planes, 1 / planes) for k in range(planes)]
    for z in range(n):
        for k, (at, weight) in enumerate(steps):
            place = [low[0] + edge / 2, low[1] + edge / 2, low[2] + (z + at) * height / n]
            camera = (f'type: fluence, resolution: [{n}, {n}], position: {place}, direction: [0, 0, -1], up: [0, 1, 0], extent: {edge}')
            lab.render(write_scene(lab, camera, medium, lights), 'shortcuts', {'light.photons': 512} if method == 'light' else {}, method=method,
                       words=('--spp', path_samples if method == 'path' else light_samples, '--seed', 100 + planes * z + k))
            told = lab.pixels(lab.work / 'shortcuts.exr')
            mean[z] += weight * told['R'][::-1]
            variance[z] += weight ** 2 * told['Variance.R'][::-1]
    return mean, variance


def caches(lab, scene, knobs):
    """Fluence of cells of 16 caches."""
    medium, lights, n, _, low, edge, height, *_ = scene
    camera = f'resolution: [16, 16], position: {[low[0] - 2 * edge, low[1] - 2 * edge, low[2] + height / 2]}, look_at: {[low[0] + edge / 2, low[1] + edge / 2, low[2] + height / 2]}, fov: 30'
    _, arrays = lab.dump(write_scene(lab, camera, medium, lights), 'shortcuts',
                         {'tpm.photons': 50000, 'tpm.generations': 5, 'tpm.cells_x': n, 'tpm.cells_y': n, 'tpm.cells_z': n, **PLAIN, **knobs},
                         words=('--spp', 16, '--seed', 11), select=('stage=tpm.resolve',))
    cells = numpy.array([launch['tpm.coarse'] for launch in arrays], dtype=float).reshape(len(arrays), n, n, n, -1)
    return cells[..., 0] + cells[..., 4]


def kept(scene):
    _, _, n, _, low, edge, height, apart, *_ = scene
    if not apart:
        return numpy.ones((n, n, n), dtype=bool)
    z, y, x = numpy.meshgrid(*[numpy.arange(n) + 0.5] * 3, indexing='ij')
    squared = (low[0] + x * edge / n - apart[0]) ** 2 + (low[1] + y * edge / n - apart[1]) ** 2 + (low[2] + z * height / n - apart[2]) ** 2
    return squared >= apart[3] ** 2


def run(lab):
    rows = []
    for name, scene in SCENES.items():
        here, truths, plain = kept(scene), {}, None
        for method in ('path', 'light'):
            mean, variance = probe(lab, scene, method)
            truths[method] = mean[here].mean(), math.sqrt(variance[here].sum()) / here.sum()
        for label, knobs in SETTINGS:
            ours = caches(lab, scene, knobs)[:, here]
            plain = ours if plain is None else plain
            of_frames = ours.mean(1)
            error = of_frames.std(ddof=1) / math.sqrt(len(of_frames))
            off = (ours - plain).mean(0) / plain.mean(0)
            noise = ((ours - plain).var(0, ddof=1) / len(ours)) / plain.mean(0) ** 2
            # what is left of the squares without the differences' own noise; where that is more, nothing
            rms = math.sqrt(max((off ** 2 - noise).mean(), 0.0))
            row = {'scene': name, 'shortcut': label}
            for method, (mean, deviation) in truths.items():
                row[f'bias_{method}'] = float(of_frames.mean() / mean - 1)
                row[f'error_{method}'] = math.sqrt(error ** 2 + deviation ** 2) / mean
            row['bias_shortcut'] = float((ours - plain).mean() / plain.mean())
            row['error_shortcut'] = float((of_frames - plain.mean(1)).std(ddof=1) / math.sqrt(len(ours)) / plain.mean())
            row['rms'], row['largest'] = rms, float(abs(off).max())
            rows.append(row)
            print(row, flush=True)
    lab.write(rows)
