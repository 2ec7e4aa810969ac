# SPDX-License-Identifier: Apache-2.0
"""Figure 9: full and half resolution: 77 and 21 ms of ray marching, no visible difference.

Here rico at the size of its converged picture: error of both against it, and milliseconds of march and enlargement."""
PAPER = {'full': 77.0, 'half': 21.0}


def run(lab):
    rows = []
    for half, (label, paper) in enumerate(PAPER.items()):
        knobs = {'tpm.half': half, 'tpm.photons': 204800, 'tpm.generations': 25}
        stats = lab.render(lab.root / 'reference/golden/rico.yaml', f'figure9_{label}', knobs, words=('--spp', 16))
        told = lab.compare(f'figure9_{label}', lab.root / 'reference/golden/rico.exr')
        seconds = sum(stage['seconds'] for stage in stats['stages'] if stage['name'] in ('tpm.march', 'tpm.enlarge'))
        rows.append({'resolution': label, 'bias': told['relative_bias'], 'rmse': told['relative_rmse'], 'percentile_99': told['percentile_99'],
                     'threads': lab.threads, 'ms': seconds / lab.threads / 16 * 1000, 'paper_ms': paper})
    lab.write(rows)
