# SPDX-License-Identifier: Apache-2.0
"""Figure 16: a smoke plume that expands, coherent from frame to frame; Section 7 tells that importance propagation flickers, and is filtered in time.

The paper shows pictures. Here frames 28 to 38 of smoke_seq, whose camera rises, lit by the map `courtyard`. Blocks of 5 x 5 pixels: change of their luminance from
frame to frame over the mean of the plume, largest and root mean square; `flicker` is the root mean square of what the method's change has more than that of path (with the
same random numbers in all frames). draws: ordinates drawn anew for every frame, drawn by the same numbers (--lock-noise), or regions (pop.regions)."""
import numpy

import make_scenes as make

CAMERA = ('resolution: [60, 80], position: {frames: [28, 48], values: [[1.5, -6.4, 1.2], [2.3, -6.2, 1.7]]}, '
          'look_at: {frames: [28, 48], values: [[1.5, 1.5, 1.3], [1.5, 1.5, 1.75]]}, fov: 32')
SMOKE = ('density: {file: ROOT/reference/data/smoke_seq/smoke_####.vdb, numbers: {first: 28, last: 48, step: 4}, centring: cell}, extinction: 40, albedo: 0.9, '
         'phase: {type: hg, g: 0.6}')
FRAMES = range(28, 39)
WAYS = {'new': (), 'same': ('--lock-noise',), 'regions': ('--lock-noise',)}


def blocks(told):
    return make.luminance(told).reshape(16, 5, 12, 5).mean((1, 3))


def run(lab):
    scene = make.scene(lab, 'figure16', CAMERA, SMOKE, [make.COURTYARD])
    true = [make.truth(lab, scene, f'figure16_path_{frame}', 128, words=('--frame', frame, '--lock-noise')) for frame in FRAMES]
    here = numpy.array([told['A'].reshape(16, 5, 12, 5).min((1, 3)) > 0.1 for told in true])
    both = here[1:] & here[:-1]
    light = numpy.array([blocks(told) for told in true])
    mean = light[here].mean()
    moved = numpy.diff(light, axis=0)[both] / mean
    error = numpy.sqrt(numpy.mean([make.noise(told).reshape(16, 5, 12, 5).mean((1, 3)) / 25 for told in true])) / mean
    rows = [{'method': 'path', 'variant': '', 'importance': '', 'frames': '', 'draws': '', 'bias': 0.0, 'largest': float(abs(moved).max()),
             'rms': float(numpy.sqrt((moved ** 2).mean())), 'flicker': 0.0, 'block_error': float(error)}]
    for variant, importance, frames, draws in ((0, 0, 1, 'new'), (0, 1, 1, 'new'), (0, 1, 4, 'new'), (0, 0, 1, 'same'), (0, 1, 1, 'same'), (0, 1, 4, 'same'),
                                               (0, 0, 1, 'regions'), (0, 1, 1, 'regions'), (0, 1, 4, 'regions'), (1, 1, 1, 'same'), (1, 1, 4, 'same')):
        knobs = {'pop.variant': variant, 'pop.importance': importance, 'pop.frames': frames, 'pop.regions': int(draws == 'regions')}
        ours = []
        for frame in FRAMES:
            name = f'figure16_{frame}'
            lab.render(scene, name, knobs, 'principal_ordinates', ('--spp', 16, '--frame', frame, *WAYS[draws]))
            ours.append(blocks(make.pixels(lab, name)))
        ours = numpy.array(ours)
        scale = light[here].mean() / ours[here].mean()
        change = numpy.diff(ours, axis=0)[both] / ours[here].mean()
        rows.append({'method': 'principal_ordinates', 'variant': make.VARIANTS[variant], 'importance': importance, 'frames': frames, 'draws': draws,
                     'bias': float(1 / scale - 1), 'largest': float(abs(change).max()), 'rms': float(numpy.sqrt((change ** 2).mean())),
                     'flicker': float(numpy.sqrt(((change - moved) ** 2).mean())), 'block_error': ''})
        print(rows[-1], flush=True)
    make.sheet(lab, 'figure16', [['figure16_path_38', 'figure16_38'], ['figure16_path_28', 'figure16_path_33']])
    lab.write(rows)
