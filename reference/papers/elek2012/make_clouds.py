# SPDX-License-Identifier: Apache-2.0
"""Clouds of the sizes of Table 1. The paper's own were modelled by hand and are not to be had: the fields of RICO, of les_stcu and
frame 48 of smoke_seq stand in, resampled to its numbers of voxels and stretched to its kilometres; clipped at the upper quartile of the
density, which is 1, so that a cloud is a body as those of the paper are."""
import zlib

import numpy

# name: scene whose density is taken, voxels x y z, kilometres x y z, cells of I x y z; z is up (the paper's y)
CLOUDS = {
    'altostratus': ('les_stcu', (70, 71, 22), (1.4, 1.4, 0.4), (15, 15, 10)),
    'congestus': ('rico', (48, 90, 62), (0.9, 1.8, 1.2), (10, 18, 12)),
    'smoke': ('smoke_seq', (100, 100, 40), (2.0, 2.0, 0.8), (15, 15, 10)),
}
EXTINCTION, G, FRAME = 0.03, 0.96, 48
CELLS = {'tpm.cells_x': 0, 'tpm.cells_y': 1, 'tpm.cells_z': 2}


def resample(field, voxels):
    """Linear at the middles of the new voxels; field and result are [z][y][x]."""
    for axis, count in enumerate(reversed(voxels)):
        at = numpy.clip((numpy.arange(count) + 0.5) * field.shape[axis] / count - 0.5, 0, field.shape[axis] - 1)
        low = numpy.floor(at).astype(int)
        high = numpy.minimum(low + 1, field.shape[axis] - 1)
        part = (at - low).reshape([-1 if a == axis else 1 for a in range(3)])
        field = numpy.take(field, low, axis) * (1 - part) + numpy.take(field, high, axis) * part
    return (field / numpy.quantile(field[field > 0.01 * field.max()], 0.75)).clip(0, 1).astype(numpy.float32)


def density_of(lab, scene):
    """As the path tracer sees it, without the samples around it."""
    _, arrays = lab.dump(lab.root / f'reference/scenes/{scene}.yaml', scene, method='path', words=('--spp', 16, '--crop', '0,0,4,4', '--frame', FRAME),
                         select=('stage=path.majorant',))
    return arrays[0]['path.density'][1:-1, 1:-1, 1:-1]


def make(lab, name, resolution, sun='direction: [-0.6, -0.5, 0.62]'):
    """Path of the scene, and the knobs of its cells."""
    source, voxels, size, cells = CLOUDS[name]
    volume = lab.work / f'{name}.npy'
    numpy.save(volume, resample(density_of(lab, source), voxels))
    metres = [1000.0 * edge for edge in size]
    away = 1.5 * max(metres)
    middle = [0.5 * edge for edge in metres]
    scene = lab.work / f'{name}_{resolution[0]}_{zlib.crc32(sun.encode()):08x}.yaml'
    scene.write_text(f'''nephos: 1
camera:
  resolution: [{resolution[0]}, {resolution[1]}]
  position: [{middle[0] + 0.5 * away:g}, {middle[1] - away:g}, {0.2 * metres[2]:g}]
  look_at: [{middle[0]:g}, {middle[1]:g}, {middle[2]:g}]
  fov: 30
media:
  - density: {{file: {volume}, box: [[0, 0, 0], [{metres[0]:g}, {metres[1]:g}, {metres[2]:g}]]}}
    extinction: {EXTINCTION}
    albedo: 1
    phase: {{type: hg, g: {G}}}
lights:
  - {{type: sun, {sun}, irradiance: 3}}
  - {{type: constant, radiance: [0.12, 0.18, 0.30]}}
''', encoding='utf-8')
    return scene, {knob: cells[axis] for knob, axis in CELLS.items()}
