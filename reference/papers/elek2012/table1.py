# SPDX-License-Identifier: Apache-2.0
"""Table 1: milliseconds of the stages of a frame of 1920 x 1200 pixels, 8192 new beams, conservative and with impostors.

The paper: GTX 485 Mobile. Here: the threads that are named, clouds of the paper's sizes (make_clouds.py) whose shapes are others. One sample is one
frame; its generation is one of 100, so a frame traces 8192 photons, and updates, resolves, upsamples and marches all. With impostors at m = 100
every fifth frame is marched while nothing moves; the others enlarge the picture that is there."""
import statistics

import make_clouds

PAPER = {'altostratus': (6.1, 2.3, 22.2, 7.4, 30.6, 15.8), 'congestus': (9.1, 3.0, 20.7, 7.9, 32.8, 20.0), 'smoke': (7.8, 3.3, 33.2, 9.5, 44.3, 20.6)}
REPEATS = 3
STAGES = {'trace': ('tpm.trace', 'tpm.update', 'tpm.resolve'), 'upsample': ('tpm.upsample',), 'march': ('tpm.march', 'tpm.enlarge')}


def run(lab):
    rows = []
    for cloud, paper in PAPER.items():
        scene, knobs = make_clouds.make(lab, cloud, (1920, 1200))
        knobs |= {'tpm.photons': 8192, 'tpm.generations': 1}
        runs = [lab.render(scene, f'table1_{cloud}', knobs, words=('--spp', 16)) for _ in range(REPEATS)]
        of = lambda name, key: statistics.median(next(s for s in r['stages'] if s['name'] == name)[key] for r in runs)
        ms = {label: sum(of(name, 'seconds') for name in names) / 16 / lab.threads * 1000 for label, names in STAGES.items()}
        enlarge = of('tpm.enlarge', 'seconds') / 16 / lab.threads * 1000
        impostors = (ms['march'] - enlarge) / 5 + enlarge
        numbers = {'trace': (ms['trace'], paper[0]), 'upsample': (ms['upsample'], paper[1]), 'march': (ms['march'], paper[2]),
                   'march, impostors': (impostors, paper[3]), 'frame': (sum(ms.values()), paper[4]),
                   'frame, impostors': (ms['trace'] + ms['upsample'] + impostors, paper[5])}
        events = statistics.median(r['tentative_collisions'] for r in runs) / 16
        for stage, (ours, theirs) in numbers.items():
            rows.append({'cloud': cloud, 'stage': stage, 'threads': lab.threads, 'ms': float(ours), 'paper_ms': theirs, 'ratio': ours / theirs,
                         'events_and_steps': int(events) if stage == 'frame' else ''})
    lab.write(rows)
