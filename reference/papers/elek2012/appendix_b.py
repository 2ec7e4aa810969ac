# SPDX-License-Identifier: Apache-2.0
"""Appendix B: the relative error of a cell against the photons that it has: 2% at 2500.

Here rico, 16 frames, each from photons of its own, of 1600 to 102400 beams: of every cell with light the mean number of deposits (weighed with what is
left of their beams) and the standard deviation of its fluence over the frames, relative; medians over cells. Independent deposits of equal flux would
give 1/sqrt(n), 2% at 2500. The last row is the fit at 2500, whose exponent is printed."""
import numpy

PHOTONS = (1600, 6400, 25600, 102400)


def run(lab):
    rows = []
    for photons in PHOTONS:
        knobs = {'tpm.variant': 1, 'tpm.photons': photons, 'tpm.generations': 1}
        manifest, arrays = lab.dump(lab.root / 'reference/golden/rico.yaml', 'appendix_b', knobs, words=('--spp', 16, '--crop', '0,0,4,4'), select=('stage=tpm.trace',))
        sums = numpy.array([launch['tpm.partial'] for launch in arrays], dtype=float) / manifest['transport']['fixed_point_scale']
        sums = sums.reshape(len(arrays), 2, -1, 6)
        flux, deposits = sums[:, 0, :, 0], sums[:, 0, :, 5].mean(0)
        lit = deposits > 0.25 * numpy.median(deposits)
        relative = flux.std(0, ddof=1)[lit] / flux.mean(0)[lit]
        rows.append({'photons': photons, 'cells': int(lit.sum()), 'deposits': float(numpy.median(deposits[lit])), 'relative_error': float(numpy.median(relative)),
                     'of_independent': float(numpy.median(deposits[lit]) ** -0.5)})
    fit = numpy.polyfit(numpy.log([row['deposits'] for row in rows]), numpy.log([row['relative_error'] for row in rows]), 1)
    print(f'exponent {fit[0]:.3f}')
    rows.append({'photons': '', 'cells': '', 'deposits': 2500.0, 'relative_error': float(numpy.exp(numpy.polyval(fit, numpy.log(2500.0)))), 'of_independent': 0.02})
    lab.write(rows)
