# SPDX-License-Identifier: Apache-2.0
"""Fig. 12 and 13 of [Elek14]: a cube of 1 m, sigma_s = 4/m, albedo 1, under parallel light along +x, and what is under way in a horizontal slice of the grid of 16^3
cells that lies along it. Slices are [across][along] of cells (y, x), the plane through the middles of the ninth layer in z.

Of the grid: light and mean cosine before each iteration, dumped. An iteration adds to the fluence of a cell light times the path of a visit (docs/principal_ordinates.md),
the first one half of it; the unscattered beam adds its mean transmittance. In print every visit counts 1, the first none, and the beam is among the light. Of the
truth: sensors of `path` that look from the same plane, whose pixels are the cells."""
import struct
import zlib

import numpy

import make_scenes as make

CELLS, SIGMA = 16, 4.0
LAYER = CELLS // 2
ANGLES = tuple(range(0, 181, 30))
WAYS = {'corrected': {}, 'corrected, a visit is an edge': {'pop.paths': 0}, 'paper': {'pop.variant': 1}}
SUN = '{type: sun, direction: [-1, 0, 0], irradiance: 1}'
PLANE = f'resolution: [{CELLS}, {CELLS}], position: [0.5, 0.5, {(LAYER + 0.5) / CELLS}], direction: [0, 0, -1], up: [0, 1, 0], extent: 1'


def medium(g):
    return f'box: [[0, 0, 0], [1, 1, 1]], extinction: {SIGMA}, albedo: 1, phase: {{type: hg, g: {g}}}'


def lobe(mu, a):
    return (1 - a * a) / (4 * numpy.pi * (1 + a * a - 2 * a * mu) ** 1.5)


def beam():
    """Mean transmittance to the cells, [along]."""
    depth = SIGMA / CELLS
    return numpy.exp(-depth * numpy.arange(CELLS)) * -numpy.expm1(-depth) / depth


def sensor(lab, name, camera, g, samples, method='path'):
    """Values in the slice and their variance; rows of a picture run downwards."""
    scene = make.scene(lab, name, camera, medium(g), [SUN])
    told = make.truth(lab, scene, name, samples, method)
    return told['R'][::-1], told['Variance.R'][::-1]


def true_fluence(lab, g, samples, method='path'):
    return sensor(lab, f'slice_{g}_{method}', f'type: fluence, {PLANE}', g, samples, method)


def true_radiance(lab, g, samples):
    """[angle][y][x] of what goes that many degrees off +x towards +y and has been scattered; variance too. Mirrored in y it goes towards -y."""
    seen = [(-numpy.cos(numpy.radians(a)), -numpy.sin(numpy.radians(a))) for a in ANGLES]
    told = [sensor(lab, f'slice_{g}_{a}', f'type: radiance, seen: [{x:.17g}, {y:.17g}, 0], {PLANE}', g, samples) for a, (x, y) in zip(ANGLES, seen)]
    return tuple(numpy.array(values) for values in zip(*told))


def solution(lab, g, way, iterations):
    """Of the slice, [iteration][y][x]: what a visit adds to the fluence, and its mean cosine; and the light in the grid before each."""
    knobs = {'pop.cells': CELLS, 'pop.iterations': iterations, 'pop.residuum': 0, 'pop.epsilon_l': 0, **WAYS[way]}
    scene = make.scene(lab, f'slice_{g}', 'resolution: [8, 8], position: [0.5, -1.5, 0.5], look_at: [0.5, 0.5, 0.5], fov: 35', medium(g), [SUN])
    manifest, launches = lab.dump(scene, 'slice', knobs, 'principal_ordinates', ('--spp', 16))
    stages = [launch['stage'] for launch in manifest['launches']]
    begin, end = stages.index('pop.inject'), stages.index('pop.propagate') + iterations
    box = lambda name: numpy.array([launch[name].reshape(CELLS, CELLS, CELLS) for launch in launches[begin:end]], float)  # [launch][along x][z][y]
    light, cosine = box('pop.light'), box('pop.cosine')
    isotropic = 0.5 * SIGMA * (1 - g) / CELLS if way == 'corrected' else 1.0
    shown = numpy.where(numpy.arange(len(light)) > 0, 1.0, 0.0 if way == 'paper' else 0.5).reshape(-1, 1, 1, 1)
    if way != 'paper':  # what comes out of the last iteration is left, not shown
        shown[-1] = 0.0
    added = shown * (abs(cosine) + (1 - abs(cosine)) * isotropic) * light
    if g == 0 and way != 'paper':  # isotropic scattering: what the stages have added up is the fluence over 4 pi
        seen = 4 * numpy.pi * numpy.asarray(launches[end - 1]['pop.seen'], float).reshape(CELLS, CELLS, CELLS)
        away = abs(added.sum(0) + beam().reshape(-1, 1, 1) - seen).max() / seen.max()
        if away > 1e-5:
            raise SystemExit(f'the fluence of cells is not what the grid shows: {away}')
    pick = lambda array: array[:, :, LAYER].transpose(0, 2, 1)
    return pick(added), pick(cosine), light.sum((1, 2, 3))


def fluence_of(added, way, iterations=None):
    return added[:iterations].sum(0) + (0.0 if way == 'paper' else beam())


def radiance_of(added, cosines, iterations=None):
    """[angle][y][x] of lobes; in print the beam is among them, a lobe of mean cosine 1 that no direction but the first one has."""
    mu = numpy.cos(numpy.radians(ANGLES))
    return numpy.array([(added[:iterations] * lobe(m, numpy.minimum(cosines[:iterations], 1 - 1e-6))).sum(0) for m in mu])


def glyphs(radiance, white, size=24, every=2):
    """A picture: of every second cell the distribution around its middle, drawn to the root of the radiance, as the paper draws lobes; `radiance` [angle][y][x]."""
    sizes = numpy.sqrt(numpy.clip(radiance[:, ::every, ::every] / white, 0, 1)) * (size / 2 - 1)
    mirrored = numpy.sqrt(numpy.clip(radiance[:, ::-1][:, (every - 1) % CELLS::every, ::every] / white, 0, 1)) * (size / 2 - 1)
    y, x = size / 2 - 0.5 - numpy.mgrid[0:size, 0:size][0], numpy.mgrid[0:size, 0:size][1] - size / 2 + 0.5
    angle, far = numpy.degrees(numpy.arctan2(y, x)), numpy.hypot(x, y)
    rows = []
    for j in range(sizes.shape[1])[::-1]:
        tiles = []
        for i in range(sizes.shape[2]):
            up, down = numpy.interp(abs(angle), ANGLES, sizes[:, j, i]), numpy.interp(abs(angle), ANGLES, mirrored[:, j, i])
            tiles.append(numpy.where(far <= numpy.where(angle >= 0, up, down), 1.0, 0.15))
        rows.append(numpy.concatenate(tiles, 1))
    return numpy.concatenate(rows, 0)


def grey(lab, file, rows):
    """Lists of pictures [row][column] of 0 to 1, side by side."""
    picture = numpy.concatenate([numpy.concatenate([numpy.pad(part, 2, constant_values=0.4) for part in row], 1) for row in rows], 0)
    shown = (numpy.clip(picture, 0, 1) ** (1 / 2.2) * 255).astype('u1')
    raw = b''.join(b'\0' + line.tobytes() for line in shown)
    header = struct.pack('>IIBBBBB', shown.shape[1], shown.shape[0], 8, 0, 0, 0, 0)
    data = b'\x89PNG\r\n\x1a\n' + make.chunk(b'IHDR', header) + make.chunk(b'IDAT', zlib.compress(raw)) + make.chunk(b'IEND', b'')
    (lab.work / f'{file}.png').write_bytes(data)
