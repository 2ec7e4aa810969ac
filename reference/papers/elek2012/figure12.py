# SPDX-License-Identifier: Apache-2.0
"""Figure 12: 270, 2080 and 16640 cells with 102 k, 819 k and 4096 k beams, m = 100: quality and time.

The paper shows pictures and says 4.8, 9.1 and 33.4 ms for photons. Here rico, 300, 2400 and 19200 cells, against its converged picture; milliseconds are of
a generation's photons. More than 2400 cells have no grid of their own in a block: they add deposit by deposit, as in print."""
PAPER = ((300, 102400, 4.8), (2400, 819200, 9.1), (19200, 4096000, 33.4))


def run(lab):
    rows = []
    for cells, photons, paper in PAPER:
        knobs = {'tpm.cells': cells, 'tpm.photons': photons // 4, 'tpm.generations': 25}
        stats = lab.render(lab.root / 'reference/golden/rico.yaml', f'figure12_{cells}', knobs, words=('--spp', 16))
        told = lab.compare(f'figure12_{cells}', lab.root / 'reference/golden/rico.exr')
        trace = next(stage for stage in stats['stages'] if stage['name'] == 'tpm.trace')
        rows.append({'cells': cells, 'photons': photons, 'bias': told['relative_bias'], 'rmse': told['relative_rmse'], 'percentile_99': told['percentile_99'],
                     'threads': lab.threads, 'ms_of_a_generation': trace['seconds'] / lab.threads / 16 / 25 * 1000, 'paper_ms': paper})
    lab.write(rows)
