# SPDX-License-Identifier: Apache-2.0
"""Roofline: what arithmetic, memory and gathers of this machine allow for the stages of Table 1, and how near they come.

The paper has none. `nephos bench` measures the machine (multiplications and additions in registers, a triad over arrays larger than the caches, numbers
gathered from 256 KiB) beside the stages. Work per item: vector arithmetic of a lane in the compiled loops (AVX-512, f32: floating point and whole
numbers, which share the ports; a quotient or a root counts as the 16 for which it keeps one busy), numbers that lanes gather, bytes that the stage must
read and write once. The bound is the slowest of the three as if the others were free and every lane had work."""
import json

import numpy

import make_clouds

TURNS = 2
# per item: operations, gathered numbers, bytes
EVENT = (205 + 24, 9, 0)                # flight of a photon to a tentative event, and its deposit
STEP = (48 + 64 + 45 + 240 + 142, 10, 0)  # march: pass empty cells, density, place and mean of eight cells of ten fields, light
RAY = (792, 0, 36)                      # camera, two sets of random words, box
VOXEL = (27 * (131 + 28 + 20) + 60, 8, 45)  # upsampling: 27 neighbours' weights, distances and sums, and the division
PIXEL = (49, 14, 45)                    # enlargement


def voxels_seen(lab, cloud):
    """Voxels around which there is any density."""
    density = numpy.pad(numpy.load(lab.work / f'{cloud}.npy') > 0, 1)
    seen = sum(numpy.roll(density, (z, y, x), (0, 1, 2)) for z in (-1, 0, 1) for y in (-1, 0, 1) for x in (-1, 0, 1)) > 0
    return int(seen[1:-1, 1:-1, 1:-1].sum())


def measure(lab, cloud):
    """The machine; and photons' events of a frame, from a picture of four pixels."""
    scene, knobs = make_clouds.make(lab, cloud, (1920, 1200))
    words = [word for knob, value in {**knobs, 'tpm.photons': 8192, 'tpm.generations': 1}.items() for word in ('-D', f'{knob}={value}')]
    return json.loads(lab.run('bench', scene, '-m', 'temporal_photons', '-t', 1, '--spp', 16, '--repeat', 1, '--crop', '0,0,2,2', '--json', *words))


def run(lab):
    rows, told_of, rates = [], {}, [0.0, 0.0, 0.0]
    for _ in range(TURNS):  # the best counts: other work only slows down
        for cloud in make_clouds.CLOUDS:
            told = measure(lab, cloud)
            told_of[cloud] = told
            rates = [max(rate, told[key]) for rate, key in zip(rates, ('flops_f32_per_s', 'gathers_per_s', 'memory_bytes_per_s'))]
    for cloud in make_clouds.CLOUDS:
        scene, knobs = make_clouds.make(lab, cloud, (1920, 1200))
        knobs |= {'tpm.photons': 8192, 'tpm.generations': 1}
        photons = told_of[cloud]['scenes'][0]['run']['tentative_collisions'] / 16
        run_of = lab.render(scene, 'roofline', knobs, words=('--spp', 16, '-t', 1))
        had = run_of['cpu_seconds'] / run_of['seconds']
        seconds = {stage['name']: stage['seconds'] / 16 * had for stage in run_of['stages']}
        steps = run_of['tentative_collisions'] / 16 - photons
        work = {'trace': [(photons, EVENT)], 'upsample': [(voxels_seen(lab, cloud), VOXEL)], 'march': [(steps, STEP), (960 * 600, RAY)],
                'enlarge': [(1920 * 1200, PIXEL)]}
        for stage, parts in work.items():
            amounts = [sum(items * each[k] for items, each in parts) for k in range(3)]
            bounds = [1000 * amount / rate for amount, rate in zip(amounts, rates)]
            measured = 1000 * seconds[f'tpm.{stage}']
            rows.append({'cloud': cloud, 'stage': stage, 'items': int(parts[0][0]), 'million_operations': amounts[0] / 1e6,
                         'million_gathers': amounts[1] / 1e6, 'megabytes': amounts[2] / 1e6, 'ms_operations': bounds[0], 'ms_gathers': bounds[1],
                         'ms_bytes': bounds[2], 'bound_ms': max(bounds), 'ms': measured, 'ratio': measured / max(bounds), 'part_of_processor': had,
                         'gflops': rates[0] / 1e9, 'ggathers': rates[1] / 1e9, 'gbytes': rates[2] / 1e9})
    lab.write(rows)
