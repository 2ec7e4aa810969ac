# SPDX-License-Identifier: Apache-2.0
"""Figure 2: a cloud in light that was scattered once, twice and more often.

The paper shows pictures, and says that methods with a part of their own for single scattering are inconsistent, so subtle is the transition to higher
orders. Here rico with its sun alone, photons parted by `tpm.orders`: of each part its share of the picture's light, and how far the picture is off in
which it stands for the whole. What is scattered once is held against the quadrature of `single`, which shares nothing with it but the scene."""
import re

KNOBS = {'tpm.photons': 819200, 'tpm.generations': 25, 'tpm.exit': 0}


def run(lab):
    text = (lab.root / 'reference/golden/rico.yaml').read_text(encoding='utf-8').replace('../data', str(lab.root / 'reference/data'))
    scene = lab.work / 'figure2.yaml'
    scene.write_text(re.sub(r'  - \{type: constant.*\n', '', text), encoding='utf-8')
    lab.render(scene, 'figure2_single', method='single', words=('--spp', 64))
    for orders in range(4):
        lab.render(scene, f'figure2_{orders}', {**KNOBS, 'tpm.orders': orders}, words=('--spp', 16))
    truth = lab.compare('figure2_1', lab.work / 'figure2_single.exr')
    rows = []
    for orders, label in enumerate(('in all', 'once', 'twice', 'more often')):
        told = lab.compare(f'figure2_{orders}', lab.work / 'figure2_0.exr')
        rows.append({'scattered': label, 'share': 1.0 + told['relative_bias'], 'rmse_as_the_whole': told['relative_rmse'],
                     'bias_against_single': truth['relative_bias'] if orders == 1 else '', 'rmse_against_single': truth['relative_rmse'] if orders == 1 else ''})
    lab.write(rows)
