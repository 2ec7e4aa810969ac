# SPDX-License-Identifier: Apache-2.0
"""Figure 8: the isotropic residuum: 100 iterations of 64 ordinates on 16^3 cells take 120 and 90 ms, 20 and 20 of one grid of 32^3 take 28 and 24 ms.

Milk as printed, of sigma_s {0.91, 1.07, 1.25}/m, albedo 0.9995, g = 0.95; a ball of 2 m of radius stands in for the dragon (16 cells of 0.25 m), the maps `courtyard` and
`studio` for theirs. Time is of propagation, joining and the residuum, processor time of all threads, median of 5. `difference`: RMSE of 20 + 20 iterations
(and of 20 alone) against 100; rmse: against path. Thresholds are 0, so all iterations are done. `enough`: the print's m' by its Eq. 10 (pop.iterations=0)."""
import statistics

import make_scenes as make

CAMERA = 'resolution: [64, 64], position: [0, -8, 1.5], look_at: [0, 0, 0], fov: 36'
SETTINGS = {'100': (100, 0, 0), '20 + 20': (20, 1, 20), '20': (20, 0, 0), 'enough + 20': (0, 1, 20)}
PAPER = {'courtyard': {'100': 120.0, '20 + 20': 28.0}, 'studio': {'100': 90.0, '20 + 20': 24.0}}
STAGES = ('pop.propagate', 'pop.join', 'pop.spread')


def run(lab):
    rows, shown = [], []
    ball = make.BALL.replace('2.5', '2')
    medium = ball + f', scattering: [{0.91 / 255:g}, {1.07 / 255:g}, {1.25 / 255:g}], absorption: [{0.91 / 255 * 5e-4:g}, {1.07 / 255 * 5e-4:g}, {1.25 / 255 * 5e-4:g}]'
    for light, what in (('courtyard', make.COURTYARD), ('studio', make.STUDIO)):
        scene = make.scene(lab, f'figure8_{light}', CAMERA, medium + ', phase: {type: hg, g: 0.95}', [what])
        true = make.truth(lab, scene, f'figure8_{light}_path', 1024)
        line, whole, first = [f'figure8_{light}_path'], None, 0.0
        for label, (iterations, residuum, more) in SETTINGS.items():
            name = f'figure8_{light}_{label.replace(" ", "")}'
            knobs = {'pop.cells': 16, 'pop.iterations': iterations, 'pop.residuum': residuum, 'pop.residuum_iterations': more, 'pop.residuum_cells': 32, 'pop.epsilon_l': 0}
            runs = [lab.render(scene, name, knobs, 'principal_ordinates', ('--spp', 16)) for _ in range(5)]
            ms = 1000 * statistics.median(sum(stage['seconds'] for stage in r['stages'] if stage['name'] in STAGES) for r in runs)
            cells = sum(stage['items'] for stage in runs[0]['stages'] if stage['name'] == 'pop.propagate')
            told = make.pixels(lab, name)
            whole, first = (told, ms) if whole is None else (whole, first)
            here = true['A'] > 0.02
            away = make.luminance(told)[here] - make.luminance(whole)[here]
            difference = float((away ** 2).mean() ** 0.5 / make.luminance(whole)[here].mean())
            paper = PAPER[light].get(label, '')
            rows.append({'light': light, 'iterations': label, 'threads': lab.threads, 'cpu_ms': float(ms), 'speed_up': first / ms, 'updates': cells,
                         'difference': difference, **make.errors(told, true), 'truth_error': make.truth_error(true), 'paper_ms': paper,
                         'paper_speed_up': PAPER[light]['100'] / paper if paper else ''})
            line.append(name)
        shown.append(line)
    make.sheet(lab, 'figure8', shown)
    lab.write(rows)
