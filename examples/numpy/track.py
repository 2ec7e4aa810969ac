#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The stage path.track of nephos for a box in thirty lines of NumPy, fed from a dump of reference/scenes/cube_g070.yaml:

  nephos render reference/scenes/cube_g070.yaml -o cube.exr --spp 16 --crop 96,96,160,144 --dump dump
  examples/numpy/track.py dump mine [--mistake]
  nephos verify dump mine

With --mistake its random words are those of the vertex before."""
import json
import pathlib
import sys

import numpy as np

ours, mine = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
run = json.loads((ours / 'manifest.json').read_text(encoding='utf-8'))
HALF, SIGMA, TRACK = np.float32(0.5), np.float32(4), 2  # the cube about its own middle, 1/m, the stage's random stream


def philox(key0, key1, a, b, c, d):
    """Philox4x32-10 [Salmon11], the first word."""
    m0, m1, low = np.uint64(0xD2511F53), np.uint64(0xCD9E8D57), np.uint64(0xffffffff)
    a, b, c, d = (np.broadcast_to(np.asarray(x, np.uint64), a.shape) for x in (a, b, c, d))
    for step in range(10):
        x, y = m0 * a, m1 * c
        k0, k1 = (np.uint64((key + step * weyl) & 0xffffffff) for key, weyl in ((key0, 0x9E3779B9), (key1, 0xBB67AE85)))
        a, b, c, d = (y >> np.uint64(32)) ^ b ^ k0, y & low, (x >> np.uint64(32)) ^ d ^ k1, x & low
    return a


def track(launch, ids, rays):
    tile, chunk, vertex = (launch['arguments'][name] for name in ('tile', 'chunk', 'vertex'))
    x0, y0, x1, _ = run['crop']
    across = (x1 - 1) // 16 - x0 // 16 + 1
    x, y = (x0 // 16 + tile % across) * 16 + (ids >> 4 & 15), (y0 // 16 + tile // across) * 16 + (ids >> 8)
    word = philox(run['seed'], TRACK << 24 | run['frame'], y * run['resolution'][0] + x, 16 * chunk + (ids & 15),
                  vertex - (vertex > 0 and '--mistake' in sys.argv), 0)
    with np.errstate(divide='ignore'):
        inverse = np.float32(1) / rays[3:]
    a, b = (-HALF - rays[:3]) * inverse, (HALF - rays[:3]) * inverse
    near, far = np.maximum(np.minimum(a, b).max(0), 0), np.maximum(a, b).min(0)
    t = near - np.log(np.float32(1) - (word >> np.uint64(8)).astype(np.float32) * np.float32(2**-24)) / SIGMA
    hits = (near < far) & (t < far)
    return {'path.distance': np.where(hits, t, np.float32(1e30)), 'path.medium': np.where(hits, 0, -1).astype(np.int32),
            'path.colliding': np.flatnonzero(hits).astype(np.int32), 'path.leaving': np.flatnonzero(~hits).astype(np.int32)}


def load(name):
    file, _, offset = name.partition('@')
    with open(file, 'rb') as stream:
        stream.seek(int(offset or 0))
        return np.load(stream)


launches = []
for one in (one for one in run['launches'] if one['stage'] == 'path.track'):
    inputs = {buffer: str(ours / file) for buffer, file in one['inputs'].items()}
    outputs = track(one, load(inputs['path.id']), load(inputs['path.ray'])) | {'path.weight': load(inputs['path.weight'])}
    folder = mine / f"{one['batch']}.{one['number']}"
    folder.mkdir(parents=True)
    for buffer, array in outputs.items():
        np.save(folder / f'{buffer}.npy', array)
    launches.append({key: one[key] for key in ('batch', 'number', 'stage', 'arguments')}
                    | {'inputs': inputs, 'outputs': {buffer: f'{folder.name}/{buffer}.npy' for buffer in outputs}})
(mine / 'manifest.json').write_text(json.dumps({'nephos_dump': 1, 'method': 'path', 'launches': launches}), encoding='utf-8')
