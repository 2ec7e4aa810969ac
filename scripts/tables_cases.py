# SPDX-License-Identifier: Apache-2.0
"""The rows of reference/tables as scenes for scripts/tables: every published number becomes one value to be rendered.

All are plane-parallel layers of height 1 m, so that extinction is optical depth, above them z = 1.

Fluxes of a beam have two estimators. `flux` is the problem as it is posed: a sun, and a flux sensor above or below. `view` turns
it around: light and sensor of a slab may be exchanged [Chandrasekhar60], so the part of a beam of cosine mu0 that is reflected
is the radiance seen at mu0 when radiance 1 comes from all of the upper hemisphere, and the part transmitted is that seen from
below, since a homogeneous slab has no upper side. Its samples lie between 0 and 1, and no sun meets a peaked phase function."""
import csv
import math
import pathlib

tables = pathlib.Path(__file__).resolve().parent.parent / 'reference/tables'
HEMISPHERE = '{type: constant, radiance: %.17g, hemisphere: upper}'


def rows(name):
    with open(tables / f'{name}.csv', encoding='utf-8') as file:
        return list(csv.DictReader(line for line in file if not line.startswith('#')))


def scene(camera, extinction, albedo, phase, light, layer='[0, 1]'):
    return (f'nephos: 1\ncamera: {{{camera}, resolution: [64, 64], up: [0, 1, 0]}}\nmedia:\n  - {{layer: {layer}, extinction: '
            f'{extinction}, albedo: {albedo}, phase: {phase}}}\nlights:\n  - {light}\n')


def hg(g):
    return '{type: isotropic}' if float(g) == 0 else f'{{type: hg, g: {g}}}'


def sun(mu0, irradiance):
    """A beam that travels towards +x and down."""
    return (f'{{type: sun, direction: [{-math.sqrt(1 - mu0 * mu0):.17g}, 0, {mu0:.17g}], irradiance: {irradiance:.17g}}}')


def flux_camera(z, up):
    return f'type: flux, position: [0, 0, {z:.17g}], direction: [0, 0, {1 if up else -1}], extent: 1'


def view_camera(mu, phi_deg):
    """Sees the light that travels with cosine mu (up positive) and azimuth phi: looks against it, from outside the layer."""
    across, phi = math.sqrt(1 - mu * mu), math.radians(phi_deg)
    d = (-across * math.cos(phi), -across * math.sin(phi), -mu)
    z = 1.001 if mu > 0 else -0.001
    return (f'type: orthographic, position: [0, 0, {z}], direction: [{d[0]:.17g}, {d[1]:.17g}, {d[2]:.17g}], extent: 0.001')


def value(identity, yaml, published, error, largest, target, floor, **told):
    """One number to render. error: the table's own, absolute. largest: an upper bound of a sample, or None. target: relative
    standard error wanted, floor: absolute one that is always enough."""
    return dict(told, identity=identity, yaml=yaml, published=float(published), error=float(error), largest=largest,
                target=target, floor=floor)


def slab_fluxes(estimator):
    for number, row in enumerate(rows('slab_fluxes')):
        beam, mu0 = row['illum'] == 'beam', float(row['mu0'] or 0)
        error = max(float(row['conv_err']), float(row['peer_err']))
        for side, column in (('R', 'R'), ('T', 'T_total')):
            below = side == 'T'
            camera = flux_camera(-0.001 if below else 1.001, below)
            light, largest = HEMISPHERE % (1 / math.pi), 1
            if beam and estimator == 'view':
                camera, light = view_camera(-mu0 if below else mu0, 0), HEMISPHERE % 1
            elif beam:
                light, largest = sun(mu0, 1 / mu0), None
            elif estimator == 'flux':
                continue
            yield value(f'{number}{side}', scene(camera, row['tau'], row['ssa'], hg(row['g']), light), row[column], error,
                        largest, 5e-4, 2e-6, case=f"g {row['g']}, albedo {row['ssa']}, depth {row['tau']}, "
                        + (f"mu0 {row['mu0']}" if beam else 'isotropic'), quantity='T' if below else 'R')


def slab_radiances(_):
    for number, row in enumerate(rows('slab_radiances')):
        mu0 = float(row['mu0'])
        published = float(row['I_per_F0'])
        yield value(f'{number}', scene(view_camera(float(row['mu']), float(row['phi_deg'])), row['tau'], row['ssa'],
                                       hg(row['g']), sun(mu0, 1)), published, published * float(row['rel_err_est']), None,
                    5e-3, 0, case=f"g {row['g']}, albedo {row['ssa']}, depth {row['tau']}, mu0 {row['mu0']}",
                    quantity=f"I at mu {row['mu']}, phi {row['phi_deg']}")


PUBLISHED = {'isotropic': '{type: isotropic}', 'rayleigh_scalar': '{type: rayleigh}', 'HG_g0.75': '{type: hg, g: 0.75}'}


def published_light(row):
    mu0, beam = float(row['mu0']), float(row['F_beam_normal'])
    return sun(mu0, beam) if beam > 0 else HEMISPHERE % float(row['I_isotropic_top'])


def slab_published_fluxes(_):
    """F_down includes the direct beam, as a flux sensor does; incident light at the very top is left out. Haze L and Cloud C.1
    need phase functions from a file."""
    for number, row in enumerate(rows('slab_published_disotest_fluxes')):
        tau, level = float(row['tau_total']), float(row['tau_level'])
        if row['phase'] not in PUBLISHED:
            continue
        z = 1 - level / tau
        down = float(row['F_direct_down']) + float(row['F_diffuse_down_converged'])
        for side, published in (('up', float(row['F_up_converged'])), ('down', down)):
            if (side == 'up' and level == tau) or (side == 'down' and level == 0):
                continue
            camera = flux_camera(z + (0.001 if level == 0 else -0.001 if level == tau else 0), side == 'down')
            # the printed direct beam has 6 digits
            error = float(row['conv_err']) + (0 if side == 'up' else 5e-7 * float(row['F_direct_down']))
            yield value(f'{number}{side}', scene(camera, row['tau_total'], row['ssa'], PUBLISHED[row['phase']],
                                                 published_light(row)), published, error, None, 5e-4, 2e-6 * math.pi,
                        case=f"{row['case']}, {row['source']}", quantity=f"F {side} at depth {row['tau_level']}")


def slab_published_radiances(_):
    for number, row in enumerate(rows('slab_published_disotest_radiances')):
        tau, level, mu = float(row['tau_total']), float(row['tau_level']), float(row['mu'])
        inside = 0 < level < tau or (level == 0 and mu < 0) or (level == tau and mu > 0)
        if row['phase'] not in PUBLISHED or float(row['conv_err_rel'] or 1) > 1e-4 or inside:
            continue
        published = float(row['I_converged'])
        if published < 1e-12:
            continue  # at depth 32 with albedo 0.2 nothing arrives at all
        yield value(f'{number}', scene(view_camera(mu, float(row['phi_deg'] or 0)), row['tau_total'], row['ssa'],
                                       PUBLISHED[row['phase']], published_light(row)), published,
                    published * float(row['conv_err_rel']), None, 5e-3, 0, case=f"{row['case']}, {row['source']}",
                    quantity=f"I at depth {row['tau_level']}, mu {row['mu']}, phi {row['phi_deg']}")


# Half spaces as layers: light goes as exp(-depth / nu0), nu0 <= 1.91 for albedos up to 0.9 and 18.3 for 0.999, so a depth of 40 or
# 500 misses less than 1e-9; albedo 1, where it is 1 / depth, is left out.
def deep(omega):
    return '40' if float(omega) <= 0.9 else '500'


def semi_infinite_isotropic(_):
    for number, row in enumerate(rows('semi_infinite_isotropic')):
        if row['quantity'].startswith('alpha1') or float(row['omega']) == 1:
            continue
        published = float(row['value'])
        if row['quantity'].startswith('spherical'):
            camera, light, quantity = flux_camera(1.001, False), HEMISPHERE % (1 / math.pi), 'spherical albedo'
        else:
            camera, light = view_camera(float(row['mu']), 0), sun(float(row['mu0']), 1)
            quantity = f"I at mu {row['mu']}, mu0 {row['mu0']}"
        if 'mu0' in quantity and float(row['mu']) * float(row['mu0']) == 0:
            continue  # along the surface
        yield value(f'{number}', scene(camera, deep(row['omega']), row['omega'], '{type: isotropic}', light), published,
                    published * 1e-10, None, 1e-3, 2e-6, case=f"albedo {row['omega']}", quantity=quantity)


def chandrasekhar_H(_):
    """The plane albedo 1 - H sqrt(1 - omega)."""
    for number, row in enumerate(rows('chandrasekhar_H')):
        mu, published = float(row['mu']), float(row['plane_albedo_1-H*sqrt(1-omega)'])
        if mu == 0 or float(row['omega']) == 1:
            continue
        yield value(f'{number}', scene(view_camera(mu, 0), deep(row['omega']), row['omega'], '{type: isotropic}', HEMISPHERE % 1),
                    published, 1e-12, 1, 1e-3, 2e-6, case=f"albedo {row['omega']}", quantity=f"plane albedo at mu {row['mu']}")


TABLES = {'slab_fluxes': slab_fluxes, 'slab_radiances': slab_radiances, 'slab_published_fluxes': slab_published_fluxes,
          'slab_published_radiances': slab_published_radiances, 'semi_infinite_isotropic': semi_infinite_isotropic,
          'chandrasekhar_H': chandrasekhar_H}
ESTIMATORS = {'slab_fluxes': ('view', 'flux')}
