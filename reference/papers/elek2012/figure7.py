# SPDX-License-Identifier: Apache-2.0
"""Figure 7: the mean cosine of light in the cells of a cloud, against the sun's direction.

The paper shows a slice in shades of grey and lobes that turn from narrow, where the light comes in, to round. Here rico, cells by their mean number of
scatterings (the cache's own penetration depth), sun's photons only: mean cosine, the cosine g^n that a photon has after n scatterings with nothing
else happening to it, and the fraction of cells. In the variant `paper` the cosine is a mean over photons, not over their flux. Claimed: the trend."""
import numpy

G, EDGES = 0.85, (0, 1, 2, 5, 10, 20, 50, 1e9)
SUN_G, SUN, DEPTH = 3, 0, 8


def run(lab):
    rows, cells = [], {}
    for variant in (0, 1):
        _, arrays = lab.dump(lab.root / 'reference/golden/rico.yaml', 'figure7',
                             {'tpm.variant': variant, 'tpm.photons': 819200, 'tpm.generations': 1},
                             words=('--spp', 16, '--crop', '0,0,4,4'), select=('stage=tpm.resolve',))
        cells[variant] = numpy.mean([launch['tpm.coarse'] for launch in arrays], axis=0).reshape(-1, arrays[0]['tpm.coarse'].shape[-1])
    depth = cells[0][:, DEPTH]
    lit = cells[0][:, SUN] > 0.02 * cells[0][:, SUN].max()
    for low, high in zip(EDGES, EDGES[1:]):
        here = lit & (depth >= low) & (depth < high)
        if here.any():
            rows.append({'scatterings': float(depth[here].mean()), 'cells': int(here.sum()), 'mean_cosine': float(cells[0][here, SUN_G].mean()),
                         'as_printed': float(cells[1][here, SUN_G].mean()), 'g_to_the_n': float((G ** depth[here]).mean())})
    lab.write(rows)
