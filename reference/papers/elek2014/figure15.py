# SPDX-License-Identifier: Apache-2.0
"""Figure 15: clouds of g = 0.96 and of isotropic scattering: they look different, so anisotropy must not be left out.

The paper shows pictures of 64 ordinates, 20^3 cells and 15 iterations. Here one cumulus of RICO (rico32x37x26), seen from the side, under its sun and a blue sky. `ratio` is the mean
luminance at g = 0.96 over that at g = 0, and `ratio_rmse` the RMSE, over pixels, of the ratio of windows of 5 x 5 pixels against that of path."""
import numpy

import make_scenes as make

CAMERA = 'resolution: [64, 64], position: [320, -1500, 900], look_at: [320, 370, 960], fov: 36'
DENSITY = 'density: {file: ROOT/reference/data/gpl/rico32x37x26.txt, centring: cell, lookup: trilinear}, extinction: 1, albedo: 1'
LIGHTS = ('{type: sun, direction: [-1, -1, 1.41421], irradiance: 3.14159}', '{type: constant, radiance: [0.12, 0.18, 0.30]}')


def run(lab):
    rows, shown, pictures = [], [], {}
    for g in (0.96, 0.0):
        scene = make.scene(lab, f'figure15_{g}', CAMERA, DENSITY + f', phase: {{type: hg, g: {g}}}', LIGHTS)
        pictures['path', g] = make.truth(lab, scene, f'figure15_{g}_path', 512)
        for variant in (0, 1):
            lab.render(scene, f'figure15_{g}_{variant}', {'pop.variant': variant, 'pop.iterations': 15}, 'principal_ordinates', ('--spp', 16))
            pictures[variant, g] = make.pixels(lab, f'figure15_{g}_{variant}')
        shown.append([f'figure15_{g}_path', f'figure15_{g}_0', f'figure15_{g}_1'])
    here = (pictures['path', 0.0]['A'] > 0.9) & (pictures['path', 0.96]['A'] > 0.9)
    smooth = {key: make.windows(make.luminance(told), 5)[here] for key, told in pictures.items()}
    ratio = {key: smooth[key, 0.96] / smooth[key, 0.0] for key in ('path', 0, 1)}
    for key, label in (('path', 'path'), (0, 'corrected'), (1, 'paper')):
        row = {'method': label, 'ratio': float(smooth[key, 0.96].mean() / smooth[key, 0.0].mean()),
               'ratio_rmse': float(numpy.sqrt(((ratio[key] - ratio['path']) ** 2).mean()))}
        for g, name in ((0.96, '096'), (0.0, '000')):
            told = make.errors(pictures[key, g], pictures['path', g]) if key != 'path' else {'bias': 0.0, 'rmse': 0.0, 'scaled_rmse': 0.0}
            row |= {f'{what}_{name}': told[what] for what in ('bias', 'rmse', 'scaled_rmse')}
        rows.append(row)
    make.sheet(lab, 'figure15', shown)
    lab.write(rows)
