# SPDX-License-Identifier: Apache-2.0
"""Figure 11: a plume 10 m across, sigma_s {2.9, 3.6, 4.2}/m, sigma_a {3.4, 3.35, 3.4}/m, g = 0.9, under an environment map: POP and SHDOM against light tracing.

The paper shows pictures, with 64 ordinates of 20^3 cells and 10 iterations, 125 of 50^3 and 30, and SHDOM of 5 and 10 bands, which it finds to fail. Here the plume of
smoke128 ten times as large, its densest place having those coefficients; the map `courtyard` for Uffizi. METHODS with others than principal_ordinates are run when the
program knows them."""
import make_scenes as make

CAMERA = 'resolution: [80, 80], position: [5, -19, 6], look_at: [5, 5, 5], fov: 26'
METHODS = (('principal_ordinates', '64, 20, 10', {'pop.ordinates': 64, 'pop.cells': 20, 'pop.iterations': 10}),
           ('principal_ordinates', '125, 50, 30', {'pop.ordinates': 125, 'pop.cells': 50, 'pop.iterations': 30}),
           ('shdom', 'its own', {}))


def known(lab, method):
    return method in lab.run('render', '--help')


def run(lab):
    rows = []
    scattering, absorption = ([f'{s / 13.94:.6g}' for s in of] for of in ((2.9, 3.6, 4.2), (3.4, 3.35, 3.4)))
    medium = (make.SMOKE + f', transform: [{{scale: 10}}], scattering: [{", ".join(scattering)}], absorption: [{", ".join(absorption)}], '
              'phase: {type: hg, g: 0.9}')
    scene = make.scene(lab, 'figure11', CAMERA, medium, [make.COURTYARD])
    true = make.truth(lab, scene, 'figure11_path', 1024)
    line = ['figure11_path']
    for method, label, knobs in METHODS:
        if not known(lab, method):
            continue
        for variant in (0, 1) if method == 'principal_ordinates' else (0,):
            name = f'figure11_{method}_{label.replace(", ", "_").replace(" ", "_")}_{variant}'
            stats = lab.render(scene, name, {**knobs, **({'pop.variant': variant} if variant else {})}, method, ('--spp', 16))
            rows.append({'method': method, 'ordinates, cells, iterations': label, 'variant': make.VARIANTS[variant], **make.errors(make.pixels(lab, name), true, 15),
                         'truth_error': make.truth_error(true), 'threads': lab.threads, 'cpu_s': float(stats['cpu_seconds'])})
            line.append(name)
    make.sheet(lab, 'figure11', [line])
    lab.write(rows)
