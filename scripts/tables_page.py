# SPDX-License-Identifier: Apache-2.0
"""What scripts/tables and scripts/agreement have rendered, written down: reference/tables/results/TABLE-ESTIMATOR.csv and
docs/accuracy.md.

Per value z = (ours - published) / sqrt(standard error^2 + table's error^2). Of n values the largest |z| must stay below the
Bonferroni bound at 1%, and the root mean square between the roots of chi-square's 0.5% and 99.5% points over n: every value is a
run of its own, so all are independent. Values darker than 5 of their standard errors say little and follow no normal
law: they are counted apart, and must only not exceed the bound."""
import csv
import math
import pathlib
import textwrap
from statistics import NormalDist

ABOUT = {
    ('slab_fluxes', 'view'): ('Slabs, fluxes', 'reflected and transmitted flux of homogeneous slabs over the incident one, against '
                              '200-stream discrete ordinates; beams by exchanging light and sensor, uniform light by a flux sensor'),
    ('slab_fluxes', 'flux'): ('Slabs, fluxes of a sun', 'the same beams as they are posed: a sun, and a flux sensor'),
    ('slab_radiances', 'direct'): ('Slabs, radiances', 'scattered radiance in single directions'),
    ('slab_published_fluxes', 'direct'): ('Published slabs, fluxes', 'van de Hulst 1980, Sweigart 1970, as converged; Haze L and Cloud C.1, which '
                                        'need phase functions from files, are left out'),
    ('slab_published_radiances', 'direct'): ('Published slabs, radiances', 'the same, in single directions; three below 1e-12 are left out'),
    ('semi_infinite_isotropic', 'direct'): ('Half space', 'isotropic scattering: radiance under a beam, spherical albedo'),
    ('chandrasekhar_H', 'direct'): ('Plane albedo of a half space', '1 - H sqrt(1 - albedo)'),
}
FEW = 40  # so many values are listed, else the ten that differ most


def chi_square_quantile(p, n):
    """Wilson and Hilferty's: good to 1e-3 of sqrt(n) for the n here."""
    z = NormalDist().inv_cdf(p)
    return n * (1 - 2 / (9 * n) + z * math.sqrt(2 / (9 * n))) ** 3


def judged(results):
    for task, record in results:
        if not record:
            continue
        # where fewer than a thousand samples' worth of light was found: the variance is at most the value times the largest sample
        few = task['largest'] is not None and record['mean'] * record['samples'] < 1000
        record['error'] = max(record['error'], math.sqrt(task['published'] * task['largest'] / record['samples']) if few else 0.0)
        record['error'] = record['error'] or task['floor']  # nothing arrived at all: darker than what was asked to be told
        error = math.hypot(record['error'], task['error'])
        wanted = max(task['target'] * task['published'], task['floor'])
        yield dict(task, ours=record['mean'], se=record['error'], z=(record['mean'] - task['published']) / error if error else 0.0,
                   samples=record['samples'], seconds=record['seconds'], met=record['error'] <= 1.05 * wanted,
                   dark=task['published'] < 5 * record['error'])


def summary(values):
    lit = [v for v in values if not v['dark']]
    n = len(lit)
    worst = max(abs(v['z']) for v in values)
    bound = NormalDist().inv_cdf(1 - 0.01 / len(values) / 2)
    rms = math.sqrt(sum(v['z'] ** 2 for v in lit) / n)
    low, high = (math.sqrt(chi_square_quantile(p, n) / n) for p in (0.005, 0.995))
    return {'n': n, 'worst': worst, 'bound': bound, 'rms': rms, 'low': low, 'high': high}


def write_csv(path, values):
    lines = ['case,quantity,published,published_error,ours,standard_error,z,samples,cpu_seconds,target_met']
    for v in values:
        lines.append(f"\"{v['case']}\",\"{v['quantity']}\",{v['published']:.9g},{v['error']:.2g},{v['ours']:.9g},{v['se']:.3g},"
                     f"{v['z']:.2f},{v['samples']},{v['seconds']:.1f},{'yes' if v['met'] else 'no'}")
    path.write_text('\n'.join(lines) + '\n', encoding='utf-8')


def rows(values):
    yield '| case | quantity | published | ours | standard error | z |'
    yield '|---|---|---|---|---|---|'
    for v in values:
        yield (f"| {v['case']} | {v['quantity']} | {v['published']:.7g} | {v['ours']:.7g} | {v['se']:.1e} | {v['z']:+.2f} |")


def section(key, results):
    title, what = ABOUT[key]
    values = list(judged(results))
    lines = [f'## {title}', '', textwrap.fill(f'{what[0].upper()}{what[1:]}.', 128)]
    if not values:
        return lines + ['', f'None of {len(results)} values has been rendered.', '']
    s = summary(values)
    met = sum(v['met'] for v in values)
    seconds = sum(v['seconds'] for v in values)
    late = f', {len(results) - len(values)} are still to be rendered' if len(values) < len(results) else ''
    lines += ['', textwrap.fill(f'{len(values)} of {len(results)} values{late}; {met} have the standard error asked for; {seconds:.0f} CPU seconds. '
              f"Largest |z| {s['worst']:.2f}, Bonferroni's bound {s['bound']:.2f}. RMS z of {s['n']} independent values that are not dark "
              f"{s['rms']:.3f}, chi-square's 99% limits {s['low']:.3f} to {s['high']:.3f}. "
              f"[All of them](../reference/tables/results/{key[0]}-{key[1]}.csv).", 128,
                                break_long_words=False, break_on_hyphens=False)]
    few = len(values) <= FEW
    chosen = values if few else sorted(values, key=lambda v: -abs(v['z']))[:10]
    return lines + ['', 'All:' if few else 'The ten that differ most:', '', *rows(chosen), '']


def agreement(folder):
    """What scripts/agreement has found."""
    with open(folder / 'agreement.csv', encoding='utf-8', newline='') as file:
        found = list(csv.DictReader(file))
    what = ('Path and light share the free flights and nothing else; path and single share the scene. Single is compared where the albedo is a '
            'ten thousandth of the scene\'s. Pictures of 16 x 16 pixels or a little less, other cameras and lights where a method cannot see '
            'the scene as it is (all in the script). Difference and standard error are relative to the mean of the image. '
            'Rows that are inconclusive were rendered with the samples that stand there; the script asks for more since.')
    lines = ['## Path against light tracing and single scattering', '', textwrap.fill(what, 128), '', '    scripts/agreement', '',
             '| scene | against | samples of path | of the other | difference | standard error | verdict at 0.2% | CPU seconds |', '|---|---|---|---|---|---|---|---|']
    for row in found:
        lines.append(f"| {row['scene']} | {row['against']} | {row['path_samples']} | {row['other_samples']} | {100 * float(row['relative_difference']):+.3f}% "
                     f"| {100 * float(row['standard_error']):.3f}% | `{row['verdict']}` | {row['cpu_path']} + {row['cpu_other']} |")
    return lines + ['']


def write(root, results):
    folder = root / 'reference/tables/results'
    folder.mkdir(exist_ok=True)
    parts = [(folder / name).read_text(encoding='utf-8').rstrip('\n') for name in ('head.md', 'statistics.md')]
    lines = '\n\n'.join(parts).split('\n') + [''] + agreement(folder)
    for key, found in results.items():
        values = list(judged(found))
        if values:
            write_csv(folder / f'{key[0]}-{key[1]}.csv', values)
        if values or key[1] != 'flux':
            lines += section(key, found)
    pathlib.Path(root / 'docs/accuracy.md').write_text('\n'.join(lines).rstrip('\n') + '\n', encoding='utf-8')
