# SPDX-License-Identifier: Apache-2.0
"""Figure 11: a plume 10 m across, sigma_s {2.9, 3.6, 4.2}/m, sigma_a {3.4, 3.35, 3.4}/m, g = 0.9, under an environment map: POP and SHDOM against light tracing.

The paper shows pictures, with 64 ordinates of 20^3 cells and 10 iterations, 125 of 50^3 and 30, and SHDOM of 5 and 10 bands on the same grids, which needs strong prefiltering
against ringing and loses the anisotropy by false scattering. Here the plume of smoke128 ten times as large, its densest place having those coefficients; the map
`courtyard` for Uffizi. Truth is path; light tracing stands beside it, with its own noise in it. SHDOM: `ours` is shdom as it is by default (delta-M, single scattering by
quadrature); `plain` is without both, as the method was published; `filtered` is that with a Hann window over the bands, for the paper's filter, which it does not print.
`least`: the least luminance of the medium's pixels, means of 3 x 3, over the mean: below 0 it rings."""
import numpy

import make_scenes as make

CAMERA = 'resolution: [80, 80], position: [5, -19, 6], look_at: [5, 5, 5], fov: 26'
POP = (('64, 20, 10', {'pop.ordinates': 64, 'pop.cells': 20, 'pop.iterations': 10}), ('125, 50, 30', {'pop.ordinates': 125, 'pop.cells': 50, 'pop.iterations': 30}))
SHDOM = (('5 bands, 20', {'shdom.bands': 5, 'shdom.cells': 20}), ('10 bands, 50', {'shdom.bands': 10, 'shdom.cells': 50}))
PLAIN = {'shdom.delta_m': 0, 'shdom.single': 0}
METHODS = [('light', '1024 samples', '', {})]
METHODS += [('principal_ordinates', label, variant, {**knobs, **more}) for label, knobs in POP for variant, more in (('corrected', {}), ('paper', {'pop.variant': 1}))]
METHODS += [('shdom', label, variant, {**knobs, **more}) for label, knobs in SHDOM
            for variant, more in (('ours', {}), ('plain', PLAIN), ('filtered', {**PLAIN, 'shdom.prefilter': 1}))]


def run(lab):
    rows, line = [], ['figure11_path']
    scattering, absorption = ([f'{s / 13.94:.6g}' for s in of] for of in ((2.9, 3.6, 4.2), (3.4, 3.35, 3.4)))
    medium = (make.SMOKE + f', transform: [{{scale: 10}}], scattering: [{", ".join(scattering)}], absorption: [{", ".join(absorption)}], '
              'phase: {type: hg, g: 0.9}')
    scene = make.scene(lab, 'figure11', CAMERA, medium, [make.COURTYARD])
    true = make.truth(lab, scene, 'figure11_path', 1024)
    here = true['A'] > 0.02
    for method, label, variant, knobs in METHODS:
        name = f'figure11_{method}_{label.replace(", ", "_").replace(" ", "_")}_{variant}'
        stats = lab.render(scene, name, knobs, method, ('--spp', 1024 if method == 'light' else 16))
        told = make.pixels(lab, name)
        rows.append({'method': method, 'ordinates, cells, iterations': label, 'variant': variant, **make.errors(told, true, 15),
                     'least': float(make.windows(make.luminance(told), 3)[here].min() / make.luminance(true)[here].mean()),
                     'truth_error': make.truth_error(true), 'threads': lab.threads, 'cpu_s': float(stats['cpu_seconds'])})
        print(rows[-1], flush=True)
        line.append(name)
        if method == 'light':
            own, theirs = (float(numpy.sqrt(make.noise(one)[here].mean()) / make.luminance(true)[here].mean()) for one in (told, true))
            print(f'a pixel is {own:.3f} (light) and {theirs:.3f} (path) noisy, over the mean')
    make.sheet(lab, 'figure11', [line[:7], line[:1] + line[7:]])
    lab.write(rows)
