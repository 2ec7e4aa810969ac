# SPDX-License-Identifier: Apache-2.0
"""Figure 7: importance propagation with 27 ordinates at g = 0.98, albedo near 1: bright regions behind the medium become visible.

The paper shows pictures and names no numbers. Here the plume of smoke128 at eight times its extinction, albedo 1, before the map `sunset` (theirs is not
to be had) turned by the rows' angle: at 120 degrees its sun stands behind the plume, at 300 behind the camera. 27 ordinates of 20^3 cells, four seeds: mean of
biases, root mean square of the others. Truth: path."""
import make_scenes as make

CAMERA = 'resolution: [64, 64], position: [0.5, -1.9, 0.6], look_at: [0.5, 0.5, 0.5], fov: 26'
SEEDS = range(1, 5)


def run(lab):
    rows, shown = [], []
    for turned in (120, 300):
        medium = make.SMOKE + ', extinction: 8, albedo: 1, phase: {type: hg, g: 0.98}'
        scene = make.scene(lab, f'figure7_{turned}', CAMERA, medium, [make.SUNSET.replace('rotation: 0', f'rotation: {turned}')])
        true = make.truth(lab, scene, f'figure7_{turned}_path', 256)
        line = [f'figure7_{turned}_path']
        for variant in (0, 1):
            for importance in (0, 1):
                told, name = [], f'figure7_{turned}_{variant}{importance}'
                for seed in SEEDS:
                    lab.render(scene, name, {'pop.variant': variant, 'pop.ordinates': 27, 'pop.importance': importance}, 'principal_ordinates',
                               ('--spp', 16, '--seed', seed))
                    told.append(make.errors(make.pixels(lab, name), true, 15))
                line.append(name)
                rows.append({'sun': {120: 'behind the plume', 300: 'behind the camera'}[turned], 'variant': make.VARIANTS[variant], 'importance': importance,
                             **make.mean_of(told), 'truth_error': make.truth_error(true)})
        shown.append(line)
    make.sheet(lab, 'figure7', shown)
    lab.write(rows)
