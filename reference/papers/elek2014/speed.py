# SPDX-License-Identifier: Apache-2.0
"""Speed: is the cost of the propagation linear in ordinates, cells and iterations; all stages of Figure 14's setting against the paper's times; a roofline.

The paper says that its cost is, and prints stages' times on a GTX 770 for Figure 14: 800 x 600 pixels, 20^3 cells, 10 iterations; the number of ordinates is not in the text, 64 is what it
calls typical elsewhere. Here the scene smoke of reference/scenes before its white sky, 64 ordinates, 50 steps. Other work falsifies times: `chrt -f 1 scripts/reproduce elek2014 speed`, as root.

speed.csv: processor time of pop.propagate, all threads, median of RUNS, one of the three varied; ms = c x^exponent by least squares over the logarithms of all runs, with the interval of 95% (Student's
t of the settings' medians); `fixed` of what a grid costs before its first iteration, in iterations, from the line through the iterations' medians.
speed_stages.csv: medians of RUNS, one thread and lab.threads; the march and what follows are a sixteenth of 16 samples, one a pixel. Roofline, of one thread: vector arithmetic of a lane in the
compiled loops (AVX-512, f32), by the formulas where loops are not vectorised; quotients and roots, which have a unit of their own that one vector of 16 keeps busy for 16 cycles; numbers
that lanes gather (a cell of four numbers read at once is one); bytes that a stage must read or write once in memory. `nephos bench` tells what the machine does of each, but for
quotients, which go by a sixteenth of its arithmetic; the bound is the slowest as if the others were free and every lane had work."""
import json
import statistics

import numpy

RUNS = 7
VARIED = {'ordinates': (16, 32, 64, 128, 256, 512), 'cells': (8, 12, 16, 20, 28, 40), 'iterations': (5, 10, 20, 40, 80, 160)}
PLAIN = {'ordinates': 64, 'cells': 20, 'iterations': 10}
STUDENT = 2.776  # 97.5%, six settings less two
LATE = ('pop.march', 'pop.accumulate')
PAPER = (('importance', 5.0, ('pop.importance',)), ('ordinates', 2.0, ('pop.ordinates',)), ('grids', 2.0, ('pop.medium', 'pop.grids', 'pop.inject')), ('propagation', 12.0, ('pop.propagate',)),
         ('residuum', 2.0, ('pop.join', 'pop.spread')), ('merging, upsampling', 4.0, ('pop.merge', 'pop.upsample')), ('march', 5.0, LATE))
ORDINATES, RIM = 64, 6 * 16 * 16  # grids; sides of cells at the rim of the importance's grid
KINDS = ('operations', 'quotients', 'gathers', 'bytes')
EXP = 22  # an exponential, in operations


def scene_of(lab, name, width, height):
    text = (lab.root / 'reference/scenes/smoke.yaml').read_text(encoding='utf-8').replace('[400, 300]', f'[{width}, {height}]')
    path = lab.work / f'{name}.yaml'
    path.write_text(text.replace('../data', str(lab.root / 'reference/data')), encoding='utf-8')
    return path


def stages_of(told):
    return {stage['name']: stage for stage in told['stages']}


def scaling(lab):
    """Runs of all settings in turns, so that a slow minute falls on all of them."""
    scene = scene_of(lab, 'speed_small', 8, 8)
    settings = [(what, x) for what, xs in VARIED.items() for x in xs]
    times = {setting: [] for setting in settings}
    for _ in range(RUNS):
        for what, x in settings:
            knobs = {f'pop.{key}': value for key, value in {**PLAIN, what: x}.items()}
            knobs |= {'pop.epsilon_l': 0, 'pop.importance': 0, 'pop.residuum': 0, 'pop.upsampling': 0, 'pop.merged': 0.25}
            told = lab.render(scene, 'speed', knobs, 'principal_ordinates', ('--spp', 16))
            times[what, x].append(1000 * stages_of(told)['pop.propagate']['seconds'])
    rows = []
    for what, xs in VARIED.items():
        size = numpy.array(xs, float) ** (3 if what == 'cells' else 1)
        middle = numpy.array([statistics.median(times[what, x]) for x in xs])
        x, y = numpy.log(size) - numpy.log(size).mean(), numpy.log(middle)
        exponent = (x * y).sum() / (x * x).sum()
        away = STUDENT * numpy.sqrt(((y - y.mean() - exponent * x) ** 2).sum() / (len(xs) - 2) / (x * x).sum())
        slope, start = numpy.polyfit(size, middle, 1, w=1 / middle)
        print(f'{what}: ms ~ x^{exponent:.3f}, 95% {exponent - away:.3f} to {exponent + away:.3f}' + (f'; before the first iteration {start / slope:.2f} iterations' if what == 'iterations' else ''))
        for k, at in enumerate(xs):
            rows.append({'varied': what, 'size': int(size[k]), 'threads': lab.threads, 'runs': RUNS, 'ms': float(middle[k]), 'ms_least': min(times[what, at]), 'ms_most': max(times[what, at]),
                         'ns_a_cell_and_iteration': 1e6 * float(middle[k]) / numpy.prod([{**PLAIN, what: at}[key] ** (3 if key == 'cells' else 1) for key in PLAIN]),
                         'exponent': float(exponent), 'exponent_low': float(exponent - away), 'exponent_high': float(exponent + away),
                         'fixed': float(start / slope) if what == 'iterations' else ''})
    lab.write(rows)


def work_of(stages, told, seen):
    """Per stage of a frame: operations, quotients and roots, gathered numbers, bytes."""
    items = {name: stage['items'] for name, stage in stages.items()}
    cells, medium, joined, merged, fine = (items[f'pop.{name}'] for name in ('inject', 'medium', 'join', 'merge', 'upsample'))
    steps, rays = told['tentative_collisions'] / 16, 800 * 600
    lookup = numpy.array([43 + 28 + 6, 0, 8, 0])  # a place in a grid, the mean of eight cells, added to three channels
    parts = {  # how often, and what each takes
        'pop.medium': [(medium, (64 * 4, 0, 0, 64 * 4))],  # f64 takes two lanes
        'pop.importance': [(32 * 4096, (6 * (2 * 10 + 14), 6 * 4 + 1, 0, 0)), (RIM * 512, (21, 2, 0, 0))],
        'pop.grids': [(cells, (116, 3, 8, 4))],
        'pop.inject': [(cells, (114 + 39 + 1, 3 + 2, 0, 20))],
        'pop.propagate': [(items['pop.propagate'], (70 + 31 + 1, 5 + 1, 0, 0)), (cells, (39 + 3 * 80, 2, 0, 28))],  # send, arrive, the sum; angles and factors, once
        'pop.join': [(joined * ORDINATES, lookup), (cells, (0, 0, 0, 4))],
        'pop.spread': [(items['pop.spread'], (3 * (19 + 2), 0, 0, 0))],
        'pop.merge': [(merged * (ORDINATES + 1), lookup), (cells, (0, 0, 0, 4)), (merged, (0, 0, 0, 16))],
        'pop.upsample': [(seen, (3 * 5 + 24 + 8 * (7 + EXP) + 8 * 9, 3 + 1 + 4, 8, 0)), (fine, (0, 0, 0, 20))],
        'pop.march': [(steps, (65 + 63 + 37 + 84 + 77, 1, 10 + 8, 0)), (rays, (516, 17, 0, 36))],  # to the next step, density, place, mean of eight cells, light
    }
    return {name: sum(often * numpy.array(each, float) for often, each in of) for name, of in parts.items()}


def run(lab):
    scaling(lab)
    lab.table = lab.table.with_name('speed_stages.csv')
    scene, knobs = scene_of(lab, 'speed_full', 800, 600), {'pop.iterations': 10, 'pop.steps': 50}
    words = [word for knob, value in knobs.items() for word in ('-D', f'{knob}={value}')]
    runs = {threads: [] for threads in dict.fromkeys((lab.threads, 1))}
    rates, had = [0.0, 0.0, 0.0], []
    for turn in range(RUNS):
        for threads, of in runs.items():
            of.append(lab.render(scene, 'speed', knobs, 'principal_ordinates', ('--spp', 16, '-t', threads)))
        had.append(of[-1]['cpu_seconds'] / of[-1]['seconds'])
        if turn < 2:  # the best counts: other work only slows down
            told = json.loads(lab.run('bench', scene, '-m', 'principal_ordinates', '-t', 1, '--spp', 16, '--repeat', 1, '--crop', '0,0,2,2', '--json', *words))
            rates = [max(rate, told[key]) for rate, key in zip(rates, ('flops_f32_per_s', 'gathers_per_s', 'memory_bytes_per_s'))]
    small = scene_of(lab, 'speed_small', 8, 8)
    _, launches = lab.dump(small, 'speed', knobs, 'principal_ordinates', ('--spp', 16), ('stage=pop.upsample',))
    seen = int((next(launch['pop.fine'] for launch in launches if 'pop.fine' in launch) > 0).any(-1).sum())
    print(f'{seen} voxels are seen; the last runs had {min(had):.2f} to {max(had):.2f} of a processor; {rates[0] / 1e9:.1f} G operations, {rates[1] / 1e9:.2f} G gathers, {rates[2] / 1e9:.1f} GB a second')
    ms = {threads: {name: statistics.median(1000 * stages_of(told)[name]['seconds'] for told in of) / (16 if name in LATE else 1) for name in stages_of(of[0])} for threads, of in runs.items()}
    stages = stages_of(runs[1][0])
    work = work_of(stages, runs[1][0], seen)
    alone = ('pop.importance', 'pop.ordinates')  # of one thread whatever there are
    rows, frame = [], 0.0
    for group, paper, names in PAPER:
        both = sum(ms[lab.threads][name] / (1 if name in alone else lab.threads) for name in names)
        frame += both
        for name in names:
            amounts = work.get(name, numpy.zeros(4))
            bounds = 1000 * amounts / (rates[0], rates[0] / 16, *rates[1:])
            rows.append({'stage': name, 'items': int(stages[name]['items'] / (16 if name in LATE else 1)), 'threads': lab.threads, 'runs': RUNS,
                         'ms': ms[lab.threads][name] / (1 if name in alone else lab.threads), 'group': group, 'group_ms': both, 'paper_ms': paper, 'over_paper': both / paper,
                         'ms_one_thread': ms[1][name], **{f'million_{what}': float(amount / 1e6) for what, amount in zip(KINDS, amounts)},
                         **{f'bound_{what}_ms': float(bound) for what, bound in zip(KINDS, bounds)}, 'bound_ms': float(max(bounds)),
                         'ratio': float(ms[1][name] / max(bounds)) if max(bounds) > 0 else ''})
    print(f'a frame: {frame:.1f} ms, the paper {sum(paper for _, paper, _ in PAPER):g}')
    lab.write(rows)
