# SPDX-License-Identifier: Apache-2.0
"""Figure 12: one ordinate in a cube, sigma_s = 4/m, albedo 1, 16^3 cells: distributions of the incident radiance in a horizontal slice, against Monte Carlo.

The paper shows plots and says that they match well despite differences; its second g is 0.7 (Fig. 13), the others are not in the text: here 0, 0.7, 0.95.
Converged (1000 iterations; what is left is printed). Fluence with the unscattered beam, radiance without it, in seven directions 0 to 180 degrees off the light's way
(in print the beam is a lobe among the others). Columns: errors over the slice's 256 cells, over the truth's mean, without the truth's noise; fluence in the middle four
rows of the first, second, third and last four columns along the light; radiance in those directions, mean of the middle 4 x 4 cells. `light` is light tracing."""
import numpy

import make_scenes as make
import make_slice as cut

ANISOTROPIES = (0.0, 0.7, 0.95)
ITERATIONS = 1000


def told(values, variance, true):
    """Of cells against the truth's: bias and RMSE over its mean, and the RMSE after the best factor."""
    mean, noise = true.mean(), variance.mean()
    scale = (values * true).sum() / (values * values).sum()
    root = lambda off: float(numpy.sqrt(max((off ** 2).mean() - noise, 0.0)) / mean)
    return {'bias': float(values.mean() / mean - 1), 'rmse': root(values - true), 'scaled_rmse': root(scale * values - true)}


def row(g, method, fluence, radiance, truth):
    (true, variance), (ways, ways_variance) = truth
    middle = slice(cut.CELLS // 2 - 2, cut.CELLS // 2 + 2)
    out = {'g': g, 'method': method, 'mean_fluence': float(fluence.mean()), **{f'fluence_{k}': v for k, v in told(fluence, variance, true).items()}}
    if radiance is None:
        return out | {f'radiance_{k}': '' for k in ('bias', 'rmse', 'scaled_rmse')} | {f'at_{4 * k}': float(fluence[middle, 4 * k:4 * k + 4].mean()) for k in range(4)} | {
            f'degrees_{angle}': '' for angle in cut.ANGLES}
    out |= {f'radiance_{k}': v for k, v in told(radiance[1:], ways_variance[1:], ways[1:]).items()}
    out |= {f'at_{4 * k}': float(fluence[middle, 4 * k:4 * k + 4].mean()) for k in range(4)}
    return out | {f'degrees_{angle}': float(radiance[k][middle, middle].mean()) for k, angle in enumerate(cut.ANGLES)}


def run(lab):
    rows, slices, lobes = [], [], []
    for g in ANISOTROPIES:
        truth = cut.true_fluence(lab, g, 16384), cut.true_radiance(lab, g, 4096)
        (true, variance), (ways, ways_variance) = truth
        print(f'g = {g}: standard error of a cell of path, over the mean: fluence {variance.mean() ** 0.5 / true.mean():.2g}, radiance {ways_variance[1:].mean() ** 0.5 / ways[1:].mean():.2g}')
        rows.append(row(g, 'path', true, ways, truth))
        traced, traced_variance = cut.true_fluence(lab, g, 16384, 'light')
        rows.append(row(g, 'light', traced, None, truth))
        away = (traced.mean() - true.mean()) / numpy.sqrt((variance + traced_variance).mean() / true.size)
        print(f'    light - path: {away:.2g} standard errors, were pixels independent; a cell of light has {traced_variance.mean() ** 0.5 / true.mean():.2g}')
        slices.append([true])
        lobes.append([ways])
        for way in cut.WAYS:
            added, cosines, left = cut.solution(lab, g, way, ITERATIONS)
            fluence, radiance = cut.fluence_of(added, way), cut.radiance_of(added, cosines)
            print(f'    {way}: {left[-1] / left[0]:.2g} of the light is left')
            rows.append(row(g, way, fluence, radiance, truth))
            slices[-1].append(fluence)
            lobes[-1].append(radiance)
    enlarged = [[numpy.repeat(numpy.repeat(one[::-1] / line[0].max(), 12, 0), 12, 1) for one in line] for line in slices]
    cut.grey(lab, 'figure12_fluence', enlarged)
    cut.grey(lab, 'figure12', [[cut.glyphs(one, numpy.percentile(line[0], 98)) for one in line] for line in lobes])
    lab.write(rows)
