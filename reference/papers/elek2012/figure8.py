# SPDX-License-Identifier: Apache-2.0
"""Figure 8: the coarse cache marched as it is, upsampled, and with noise.

The paper shows pictures. Here rico against its converged picture: linear interpolation of I, the joint bilateral filter, the physical one, and that with
three octaves of noise of half a voxel, which is detail that the truth does not have: its error is what it costs where the density is the truth."""


def run(lab):
    rows = []
    for label, knobs in {'linear interpolation': {'tpm.upsampling': 0}, 'joint bilateral': {'tpm.upsampling': 1}, 'physical': {},
                         'physical, 5 x 5 x 5': {'tpm.neighbourhood': 2}, 'physical, noise': {'tpm.noise': 0.5}}.items():
        lab.render(lab.root / 'reference/golden/rico.yaml', 'figure8', {'tpm.photons': 204800, 'tpm.generations': 25, **knobs}, words=('--spp', 16))
        told = lab.compare('figure8', lab.root / 'reference/golden/rico.exr')
        rows.append({'upsampling': label, 'bias': told['relative_bias'], 'rmse': told['relative_rmse'], 'percentile_99': told['percentile_99']})
    lab.write(rows)
