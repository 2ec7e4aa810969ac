# SPDX-License-Identifier: Apache-2.0
"""Figure 13: convergence of the propagation over iterations, in the cube of Figure 12 at g = 0.7.

The paper shows plots after some iterations and says that a significant number is needed, even for 16^3 cells, as nothing is absorbed. Here after 1 to 1000: light left in the grid over
what was injected (in print over the most that there ever was: all cells begin with the beam); fluence of the slice's cells, mean and RMSE against the grid's own converged
state (2000) and against path, over the mean of that; mean cosine of the radiance that has been scattered (in print with the beam) in the middle 4 x 4 cells.
`needed`: the first iteration from which the fluence is within 1% (root mean square) of the converged state."""
import numpy

import make_slice as cut

G, ALL = 0.7, 2000
SHOWN = (1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1000)


def run(lab):
    rows, lines = [], []
    true, variance = cut.true_fluence(lab, G, 16384)
    middle = (slice(cut.CELLS // 2 - 2, cut.CELLS // 2 + 2),) * 2
    for way in cut.WAYS:
        added, cosines, left = cut.solution(lab, G, way, ALL)
        fluences = numpy.cumsum(added, 0) + (0.0 if way == 'paper' else cut.beam())
        whole, rms = fluences[-1], lambda off: numpy.sqrt((off ** 2).mean((-2, -1)))
        away = rms(fluences - whole) / whole.mean()
        needed = int(numpy.argmax(away < 0.01)) + 1
        weights = numpy.maximum(added[(slice(None), *middle)].sum((1, 2)), 1e-300)
        cosine = numpy.cumsum((added * cosines)[(slice(None), *middle)].sum((1, 2))) / numpy.cumsum(weights)
        lines.append([])
        for m in SHOWN:
            off = numpy.sqrt(max(((fluences[m - 1] - true) ** 2).mean() - variance.mean(), 0.0)) / true.mean()
            rows.append({'method': way, 'iterations': m, 'left': float(left[m] / left.max()), 'mean_fluence': float(fluences[m - 1].mean()), 'rmse_converged': float(away[m - 1]),
                         'bias': float(fluences[m - 1].mean() / true.mean() - 1), 'rmse': float(off), 'mean_cosine': float(cosine[m - 1]), 'needed': needed})
            lines[-1].append(cut.radiance_of(added, cosines, m))
    chosen = [SHOWN.index(m) for m in (1, 4, 16, 64, 256)]
    cut.grey(lab, 'figure13', [[cut.glyphs(line[k], numpy.percentile(line[-1], 98)) for k in chosen] for line in lines])
    lab.write(rows)
