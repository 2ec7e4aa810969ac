# SPDX-License-Identifier: Apache-2.0
"""Figure 17: a directional light and the surfaces it falls on: sigma_s {3.2, 3.3, 3.4}/m, sigma_a {1.15, 1.2, 1.3}/m, g = 0.7, 20^3 m, very heterogeneous; a grid of 128^2 x 16
cells along the light, 125 virtual point lights with 8^3 cells each.

The paper shows pictures, and says 16 Hz with 30 ms for the virtual point lights and the indirect light of surfaces; its scene is not to be had. Here the plume of smoke128 20 times as large, its
densest place having those coefficients, in the sun over a plane and beside a mesh; the camera is level, all surfaces lie below the horizon, so the upper half shows the medium
alone. `added` is the mean luminance that surfaces with an albedo add there to that with black ones, over the same of path."""
import make_scenes as make

CAMERA = 'resolution: [96, 96], position: [10, -26, 3], look_at: [10, 10, 3], fov: 66'
GRIDS = {'pop.cells': 128, 'pop.along': 16, 'pop.vpl_cells': 8, 'pop.vpls': 125}
SETTINGS = (('as it is', {}), ('no virtual point lights', {'pop.vpls': 0}), ('no shadows', {'pop.shadows': 0}), ('16 virtual point lights', {'pop.vpls': 16}),
            ('1000 virtual point lights', {'pop.vpls': 1000}), ('their grids of 16^3', {'pop.vpl_cells': 16}), ('as printed', {'pop.variant': 1}))


def upper(told):
    return {name: plane[:plane.shape[0] // 2] for name, plane in told.items()}


def run(lab):
    scattering, absorption = ([f'{s / 13.94:.6g}' for s in of] for of in ((3.2, 3.3, 3.4), (1.15, 1.2, 1.3)))
    medium = (make.SMOKE + f', transform: [{{scale: 20}}, {{translate: [0, 0, 0.5]}}], scattering: [{", ".join(scattering)}], '
              f'absorption: [{", ".join(absorption)}], phase: {{type: hg, g: 0.7}}')
    sun = '{type: sun, elevation: 40, azimuth: 215, irradiance: [3, 2.8, 2.5]}'
    mesh = '{mesh: ROOT/reference/data/mesh/suzanne.obj, albedo: ALBEDO, transform: [{rotate: {axis: [1, 0, 0], angle: 90}}, {scale: 1.2}, {translate: [5, -3, 1.2]}]}'
    scenes = {}
    for name, ground, grey in (('lit', '[0.8, 0.5, 0.3]', '0.7'), ('black', '0', '0')):
        scenes[name] = make.scene(lab, f'figure17_{name}', CAMERA, medium, [sun], [f'{{plane: 0, albedo: {ground}}}', mesh.replace('ALBEDO', grey)])
    true, black = (make.truth(lab, scenes[name], f'figure17_path_{name}', 2048) for name in ('lit', 'black'))
    added = make.luminance(upper(true)).mean() - make.luminance(upper(black)).mean()
    rows, line = [], ['figure17_path_lit']
    for label, knobs in SETTINGS:
        names = [f'figure17_{label.replace(" ", "_").replace("^", "")}_{name}' for name in ('lit', 'black')]
        stats = lab.render(scenes['lit'], names[0], {**GRIDS, **knobs}, 'principal_ordinates', ('--spp', 16))
        lab.render(scenes['black'], names[1], {**GRIDS, **knobs, 'pop.vpls': 0}, 'principal_ordinates', ('--spp', 16))
        told, dark = (make.pixels(lab, name) for name in names)
        stages = {stage['name']: stage['seconds'] for stage in stats['stages']}
        plume = make.errors(upper(told), upper(true))
        rows.append({'setting': label, **make.errors(told, true), 'plume_bias': plume['bias'], 'plume_rmse': plume['rmse'],
                     'added': float((make.luminance(upper(told)).mean() - make.luminance(upper(dark)).mean()) / added),
                     'truth_error': make.truth_error(true), 'plume_truth_error': make.truth_error(upper(true)), 'threads': lab.threads,
                     'surfaces_ms': 1000 * (stages.get('pop.reflect', 0.0) + stages.get('pop.vpls', 0.0)), 'shadows_ms': 1000 * stages.get('pop.shadows', 0.0),
                     'cpu_s': float(stats['cpu_seconds'])})
        line.append(names[0])
    make.sheet(lab, 'figure17', [line[:4], line[4:]])
    lab.write(rows)
