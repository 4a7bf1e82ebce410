"""Arc lengths and tangents on curves of every family in random images, and their residuals for complex arguments.

Velocities are differences of eighth order of projected points: nothing of the package's derivatives is used.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache

import numpy as np

from splinebba_cli.core.curves.registry import FAMILIES, basis_of
from splinebba_cli.core.network import ArcLengths, CurveObservations, FloatArray, Tangents
from splinebba_cli.core.observations.arc_lengths import linearize_arc_lengths
from splinebba_cli.core.observations.tangents import linearize_tangents
from splinebba_cli.core.state import Prepared, State, prepare
from tests.core.observations import complex_step
from tests.core.observations.random_network import Case, curve_of, measured, random_case

IMAGES_EACH, PER_CHAIN = 4, 4
STENCIL = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}
GAUSS = np.polynomial.legendre.leggauss(10)


@cache
def linked_case() -> Case:
    """Chains of four points with three arc lengths and four tangents, for every family in four images."""
    base = random_case(seed=11)
    generator = np.random.default_rng(12)
    names = [
        *(name for name in FAMILIES if basis_of(curve_of(name, generator)).has_location),
        "closed",
        "corner",
    ]
    curves = tuple(curve_of(name, generator) for name in names)
    bases = [basis_of(curve) for curve in curves]
    chain_curve = np.repeat(np.arange(len(curves)), IMAGES_EACH)
    chain_image = (7 * np.arange(len(chain_curve))) % len(base.prepared.network.images.ids)
    location = np.concatenate([locations(bases[k].break_points, generator) for k in chain_curve])
    curve, image = np.repeat(chain_curve, PER_CHAIN), np.repeat(chain_image, PER_CHAIN)
    count = len(curve)
    first = np.flatnonzero(np.arange(count) % PER_CHAIN < PER_CHAIN - 1)
    arcs = ArcLengths(
        first, first + 1, generator.uniform(3.0, 9.0, len(first)), generator.uniform(0.005, 0.02, len(first)),
        np.arange(len(first)) % 3 == 2,
    )  # fmt: skip
    tangents = Tangents(
        np.arange(count), generator.uniform(-3.1, 3.1, count), generator.uniform(1e-3, 5e-3, count),
        np.arange(count) % 2 == 0,
    )  # fmt: skip
    network = replace(
        base.prepared.network,
        curves=curves,
        curve_observations=CurveObservations(
            image, curve, *measured(count, generator), location, np.full(count, -1)
        ),
        arc_lengths=arcs,
        tangents=tangents,
    )
    prepared = prepare(network)
    coefficients = np.vstack(
        [b.coefficients_from_values(c.values) for b, c in zip(bases, curves, strict=True)]
    )
    return Case(prepared, replace(base.state, coefficients=coefficients, location=location), generator)


def locations(breaks: FloatArray, generator: np.random.Generator) -> FloatArray:
    """Four ascending or descending locations, none near a joint: half a segment to two and a half apart."""
    segments = len(breaks) - 1
    if segments == 1:
        places = np.array([0.05, 0.3, 0.55, 0.9]) + generator.uniform(-0.04, 0.04, 4)
    else:
        steps = np.sort(generator.choice(2 * segments, 4, replace=False))
        places = 0.5 * steps + generator.uniform(0.12, 0.38, 4)
    segment = np.minimum(places.astype(int), segments - 1)
    u = breaks[segment] + (places - segment) * np.diff(breaks)[segment]
    return u[::-1] if generator.uniform() < 0.5 else u


def curve_xyz(curve: int, values: complex_step.Array, u: complex) -> complex_step.Array:
    """A point of a curve; smooth pieces between corners are splines of their own."""
    one, breaks = (
        linked_case().prepared.network.curves[curve],
        linked_case().prepared.curves.bases[curve].break_points,
    )
    if one.closed and one.family == "natural_cubic":
        u = breaks[0] + np.mod(np.real(u) - breaks[0], breaks[-1] - breaks[0]) + 1j * np.imag(u)
    if not one.breaks:
        return complex_step.curve_point(one, breaks, values, u)
    ends = [0, *one.breaks, len(values) - 1]
    piece = int(np.searchsorted(breaks[list(one.breaks)], np.real(u), side="right"))
    rows = slice(ends[piece], ends[piece + 1] + 1)
    return complex_step.curve_point(replace(one, breaks=()), breaks[rows], values[rows], u)


class Seen:
    """One curve as one image sees it, over x = (theta, X0, coefficients, locations)."""

    def __init__(self, prepared: Prepared, state: State, k: int) -> None:
        observed, curves = prepared.network.curve_observations, prepared.curves
        self.image, self.curve = int(observed.image[k]), int(observed.curve[k])
        self.camera = prepared.network.cameras[prepared.network.images.camera[self.image]]
        self.rotation, self.basis = state.rotation[self.image], curves.bases[self.curve]
        self.rows = slice(
            int(curves.coefficient_start[self.curve]), int(curves.coefficient_start[self.curve + 1])
        )
        own = state.coefficients[self.rows].ravel()
        self.start = np.concatenate([np.zeros(3), state.position[self.image], own])

    def velocity(self, x: complex_step.Array, u: complex) -> complex_step.Array:
        own = x[6 : 6 + 3 * (self.rows.stop - self.rows.start)].reshape(-1, 3)
        values = np.einsum("kw,kwd->kd", self.basis.value_weights, own[self.basis.value_columns])
        rotation = complex_step.turned(self.rotation, x[:3])

        def place(v: complex) -> complex_step.Array:
            return complex_step.photo_xy(self.camera, rotation, x[3:6], curve_xyz(self.curve, values, v))

        breaks = self.basis.break_points
        distance = np.abs(np.real(u) - breaks)
        h = min(float(distance.min()) / 5.0, 5e-3 * float(np.diff(breaks).min()))
        return np.asarray(sum(c * (place(u + k * h) - place(u - k * h)) for k, c in STENCIL.items()) / h)

    def speed(self, x: complex_step.Array, u: complex) -> complex:
        vx, vy = self.velocity(x, u)
        return complex(np.sqrt(vx * vx + vy * vy))


def arc(seen: Seen, x: complex_step.Array, simpson: bool) -> complex:
    """Length between the last two entries of x, by the rule that the package promises."""
    low, high = sorted(x[-2:], key=np.real)
    if simpson:
        middle = 0.5 * (low + high)
        return (high - low) / 6.0 * (seen.speed(x, low) + 4.0 * seen.speed(x, middle) + seen.speed(x, high))
    inner = [b for b in seen.basis.break_points if np.real(low) < b < np.real(high)]
    total = 0.0 + 0.0j
    for a, b in zip([low, *inner], [*inner, high], strict=True):
        nodes = 0.5 * (a + b) + 0.5 * (b - a) * GAUSS[0]
        total += 0.5 * (b - a) * sum(w * seen.speed(x, u) for w, u in zip(GAUSS[1], nodes, strict=True))
    return total


def arc_lengths() -> Iterator[tuple[FloatArray, FloatArray]]:
    """Every block of every arc length that does not wrap around a closed curve."""
    prepared, state = linked_case().prepared, linked_case().state
    arcs, rows = prepared.network.arc_lengths, linearize_arc_lengths(prepared, state)
    for q in range(len(arcs)):
        seen = Seen(prepared, state, int(arcs.first[q]))
        x = np.concatenate([seen.start, state.location[[arcs.first[q], arcs.second[q]]]])
        sigma = prepared.arc_lengths.sigma[q]

        def residual(
            x: complex_step.Array, seen: Seen = seen, q: int = q, s: float = sigma
        ) -> complex_step.Array:
            return np.array([(arc(seen, x, bool(arcs.simpson[q])) - prepared.arc_lengths.value[q]) / s])

        value = float(np.real(residual(x))[0])
        if prepared.curves.closed[seen.curve] and abs(value - rows.residual[q]) > 1.0:
            continue  # the other way round is nearer to the measured length
        full = complex_step.jacobian(residual, x)[0]
        own = np.zeros((prepared.curves.coefficient_count, 3))
        nodes = np.flatnonzero(rows.node_arc == q)
        np.add.at(own, prepared.curves.columns[rows.node_segment[nodes]], rows.node_coefficients[nodes])
        yield rows.orientation[q], full[:6]
        yield own[seen.rows].ravel(), full[6:-2]
        yield rows.slopes[q], full[-2:]
        yield rows.residual[q : q + 1], np.array([value])


def tangents() -> Iterator[tuple[FloatArray, FloatArray]]:
    """Every block of every tangent; residuals up to the quadrant, which a derivative does not see."""
    prepared, state = linked_case().prepared, linked_case().state
    rows, table = linearize_tangents(prepared, state), prepared.network.tangents
    for q in range(len(table)):
        k = int(table.point[q])
        seen, sigma = Seen(prepared, state, k), prepared.tangents.sigma[q]
        x = np.concatenate([seen.start, [state.location[k]]])

        def residual(x: complex_step.Array, seen: Seen = seen, s: float = sigma) -> complex_step.Array:
            vx, vy = seen.velocity(x, x[-1])
            return np.array([np.arctan(vy / vx) / s])

        full = complex_step.jacobian(residual, x)[0]
        own = np.zeros((prepared.curves.coefficient_count, 3))
        np.add.at(own, prepared.curves.columns[rows.segment[q]], rows.coefficients[q])
        yield own[seen.rows].ravel(), full[6:-1]
        with_slope = [*range(6), -1]  # together: the direction of a straight line has no slope of its own
        yield np.append(rows.orientation[q], rows.slope[q]), full[with_slope]
        off = (
            np.real(residual(x))[0] * sigma - prepared.tangents.value[q] - rows.residual[q] * sigma
        ) / np.pi
        yield np.array([off - round(off)]) + 1.0, np.ones(1)


LINKED: dict[str, Callable[[], Iterator[tuple[FloatArray, FloatArray]]]] = {
    "arc_lengths": arc_lengths,
    "tangents": tangents,
}
