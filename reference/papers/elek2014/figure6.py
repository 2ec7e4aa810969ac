# SPDX-License-Identifier: Apache-2.0
"""Figure 6: prefiltering on a thin, strongly scattering slab of rising anisotropy: without it the ordinates show as spots.

The paper shows pictures and names no numbers. Here a box of 2 x 0.25 x 2 m, two mean free paths thick, albedo 1, before the map `courtyard` (theirs is not
to be had), seen so that the picture spans 50 degrees, 64 ordinates of 20^3 cells without importance, four seeds. Truth: path. `spots` is what is left
of the RMSE when the mean of the difference in windows of 15 x 15 pixels, 12 degrees, is taken off."""
import make_scenes as make

CAMERA = 'resolution: [64, 64], position: [0, -2.2, 0], look_at: [0, 0, 0], fov: 50'
SEEDS = range(1, 5)


def run(lab):
    rows, shown = [], []
    for g in (0.3, 0.6, 0.9):
        medium = f'box: [[-1, -0.125, -1], [1, 0.125, 1]], extinction: 8, albedo: 1, phase: {{type: hg, g: {g}}}'
        scene = make.scene(lab, f'figure6_{g}', CAMERA, medium, [make.COURTYARD])
        true = make.truth(lab, scene, f'figure6_{g}_path', 2048)
        line = [f'figure6_{g}_path']
        for variant in (0, 1):
            for prefilter, label in enumerate(('none', 'cap', 'region')):
                told = []
                for seed in SEEDS:
                    name = f'figure6_{g}_{variant}{prefilter}'
                    lab.render(scene, name, {'pop.variant': variant, 'pop.prefilter': prefilter, 'pop.importance': 0}, 'principal_ordinates',
                               ('--spp', 16, '--seed', seed))
                    told.append(make.errors(make.pixels(lab, name), true, 15))
                line.append(name)
                rows.append({'g': g, 'variant': make.VARIANTS[variant], 'prefilter': label, **make.mean_of(told), 'truth_error': make.truth_error(true)})
        shown.append(line)
    make.sheet(lab, 'figure6', shown)
    lab.write(rows)
