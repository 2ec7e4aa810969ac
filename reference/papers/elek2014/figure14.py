# SPDX-License-Identifier: Apache-2.0
"""Figure 14: smoke with 4 to 250 ordinates, with and without importance: 20^3 cells, 10 iterations, g = 0.9.

The paper shows pictures, under the map "kitchen", and says that only very few ordinates show, and that importance helps those most; it prints no number of ordinates. Here
smoke128 at four times its extinction, albedo 0.95, before the map `courtyard`; eight seeds, mean of biases and root mean square of the others, and `seeds`, the standard
deviation of pictures' means over the truth's (one seed where pop.regions draws nothing). Truth: path. `solution_ms`: processor time of all stages before the march, all threads,
median of the seeds; `march_ms`: that of the march, a sixteenth of the 16 samples, of these 64 x 64 pixels. Clean times need the processors: `chrt -f 1`, a second time, as truths are kept."""
import statistics

import numpy

import make_scenes as make

CAMERA = 'resolution: [64, 64], position: [0.5, -1.9, 0.6], look_at: [0.5, 0.5, 0.5], fov: 26'
SEEDS = range(1, 9)
LATE = ('pop.march', 'pop.accumulate')


def milliseconds(stats):
    ms = {stage['name']: 1000 * stage['seconds'] for stage in stats['stages']}
    return sum(time for name, time in ms.items() if name not in LATE), ms['pop.march'] / 16


def run(lab):
    rows, shown = [], {}
    medium = make.SMOKE + ', extinction: 4, albedo: 0.95, phase: {type: hg, g: 0.9}'
    scene = make.scene(lab, 'figure14', CAMERA, medium, [make.COURTYARD])
    true = make.truth(lab, scene, 'figure14_path', 4096)
    for variant, regions in ((0, 0), (0, 1), (1, 0)):
        for importance in (0, 1):
            for ordinates in (4, 8, 16, 27, 64, 125, 250):
                told, times, name = [], [], f'figure14_{variant}{regions}{importance}_{ordinates}'
                for seed in SEEDS if not regions else (1,) * len(SEEDS):
                    knobs = {'pop.variant': variant, 'pop.ordinates': ordinates, 'pop.importance': importance, 'pop.iterations': 10, 'pop.regions': regions}
                    times.append(milliseconds(lab.render(scene, name, knobs, 'principal_ordinates', ('--spp', 16, '--seed', seed))))
                    told.append(make.errors(make.pixels(lab, name), true, 15))
                rows.append({'variant': make.VARIANTS[variant], 'regions': regions, 'importance': importance, 'ordinates': ordinates, **make.mean_of(told),
                             'seeds': float(numpy.std([each['bias'] for each in told], ddof=1)), 'truth_error': make.truth_error(true), 'threads': lab.threads,
                             'solution_ms': statistics.median(time[0] for time in times), 'march_ms': statistics.median(time[1] for time in times)})
                shown.setdefault((variant, regions, importance), ['figure14_path']).append(name)
    make.sheet(lab, 'figure14', list(shown.values()))
    lab.write(rows)
