# SPDX-License-Identifier: Apache-2.0
"""Absorption: the cube of Figure 12 with isotropic scattering, of several depths and albedos: what a cell absorbs must go with the fluence that it shows.

The paper has no such figure. A visit of isotropic light counts as the path that diffusion has (docs/principal_ordinates.md), c of a cell's edge, but the propagation absorbs along the edge, e^(-s_a d). Then light
falls by e within sqrt(d / 6 s_a) and not within 1 / sqrt(3 s_a s_tr). `absorbed by its path` is the same walk, done here in numpy, that absorbs e^(-s_a c d) in a visit, as pop.spread does: its length is that of
diffusion whatever the cells. Fluence of the slice over that of path: bias of the mean, and `deep`, that of the middle 4 x 4 cells; noise of that: the truth's standard error there, relative."""
import numpy

import make_slice as cut

CUBES = ((4.0, 1.0), (4.0, 0.7), (20.0, 1.0), (20.0, 0.9), (20.0, 0.7))
ITERATIONS = 1000
FRONT, SIDE = 0.5 * (1 - 0.5 ** 0.5), 0.25 * 0.5 ** 0.5  # of isotropic light, along and across the grid


def walk(sigma, albedo, by_path):
    """Fluence of the slice by the steps of pop.inject and pop.propagate at g = 0."""
    n, edge = cut.CELLS, 1 / cut.CELLS
    c = 0.5 * sigma * edge
    keep = numpy.exp(-sigma * (1 - albedo) * edge * (c if by_path else 1.0))
    light = numpy.zeros((n + 2,) * 3)  # [along][z][y], dark around
    light[1:-1, 1:-1, 1:-1] = (albedo * -numpy.expm1(-sigma * edge) * numpy.exp(-sigma * edge * numpy.arange(n))).reshape(-1, 1, 1)
    total = 0.5 * c * light
    for _ in range(ITERATIONS - 1):
        new = numpy.zeros_like(light)
        inner = (slice(1, -1),) * 3
        for axis, part in ((0, FRONT), (1, SIDE), (2, SIDE)):
            new[inner] += part * keep * (numpy.roll(light, 1, axis) + numpy.roll(light, -1, axis))[inner]
        light = new
        total = total + c * light
    return total[1:-1, 1 + cut.LAYER, 1:-1].T + cut.beam(sigma)


def run(lab):
    rows, deep = [], (slice(6, 10), slice(6, 10))
    for sigma, albedo in CUBES:
        cube = {'sigma': sigma, 'albedo': albedo}
        true, variance = cut.true_fluence(lab, 0.0, 4096, name=f'absorption_{sigma:g}_{albedo:g}', **cube)
        told = {way: cut.fluence_of(cut.solution(lab, 0.0, way, ITERATIONS, **cube)[0], way, sigma=sigma) for way in ('corrected', 'corrected, a visit is an edge')}
        told['absorbed by its path'] = walk(sigma, albedo, True)
        away = abs(walk(sigma, albedo, False) - told['corrected']).max() / true.max()
        if away > 1e-4:
            raise SystemExit(f'the walk is not that of the grid: {away}')
        for way, fluence in told.items():
            rows.append({'sigma_t': sigma, 'albedo': albedo, 'method': way, 'bias': float(fluence.mean() / true.mean() - 1), 'deep': float(fluence[deep].mean() / true[deep].mean() - 1),
                         'truth_deep': float(true[deep].mean()), 'noise': float(numpy.sqrt(variance[deep].sum()) / true[deep].sum())})
    lab.write(rows)
