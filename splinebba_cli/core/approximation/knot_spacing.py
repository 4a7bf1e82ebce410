"""Knots re-spaced to equal arc length over the measured part of a curve.

Knots that follow a digitised or wrong shape are replaced by equally spaced ones with chord-length parameters: on the
present curve (which keeps hairpins), or on the natural spline that fits it best in the sense of least squares (which
smooths away what is wrong).
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from splinebba_cli.core.curves.basis import CurveBasis, knot_parameters
from splinebba_cli.core.curves.natural_cubic import natural_cubic_basis
from splinebba_cli.core.curves.registry import lasting_parameters
from splinebba_cli.core.curves.support import supported_knots
from splinebba_cli.core.network import Curve, FloatArray, Network
from splinebba_cli.core.state import Prepared, State, initial_coefficients, prepare

SAMPLES_PER_SEGMENT = 40
FEWEST_LOCATED = 8  # measured points from which stretches without measurements can be told
WIDE_GAP = 1.5  # of the usual largest gap between measured points


def respaceable(curve: Curve) -> bool:
    """Whether the knots of a curve are the program's to choose."""
    return (
        curve.family == "natural_cubic"
        and curve.role in ("tie", "check")
        and bool(np.isinf(curve.sigma).all())
    )


def respaced_network(
    prepared: Prepared, state: State, spacing: FloatArray, *, smooth: bool
) -> tuple[Prepared, State]:
    """Network and state with other knots; locations are to be searched again.

    Parameters
    ----------
    spacing : (nc,) float, metres of arc length; NaN keeps the knots of a curve
    smooth : fit the present curve by least squares (else interpolate it)
    """
    network = prepared.network
    curves = []
    for k, curve in enumerate(network.curves):
        start, stop = prepared.curves.coefficient_start[k], prepared.curves.coefficient_start[k + 1]
        own = state.coefficients[start:stop]
        if np.isfinite(spacing[k]) and respaceable(curve):
            located = state.location[network.curve_observations.curve == k]
            curves.append(respaced(curve, prepared.curves.bases[k], own, located, float(spacing[k]), smooth))
        else:
            curves.append(present_curve(prepared, k, own))
    return restart(network, tuple(curves), state)


def restart(network: Network, curves: tuple[Curve, ...], state: State) -> tuple[Prepared, State]:
    """Prepared network and state with other curves at their values."""
    new = prepare(replace(network, curves=curves))
    unknown = np.full(len(network.curve_observations), np.nan)
    return new, replace(state, coefficients=initial_coefficients(new), location=unknown)


def present_curve(prepared: Prepared, k: int, own: FloatArray) -> Curve:
    """A curve with its present values; given (control) values and its parameters stay as they are."""
    curve, basis = prepared.network.curves[k], prepared.curves.bases[k]
    values = np.where(np.isinf(curve.sigma), basis.values_from_coefficients(own), curve.values)
    return replace(curve, values=values, knot_parameters=lasting_parameters(curve, basis))


def respaced(
    curve: Curve, basis: CurveBasis, own: FloatArray, located: FloatArray, spacing: float, smooth: bool
) -> Curve:
    """A curve with knots about `spacing` metres apart over its measured part.

    Parameters
    ----------
    own : (m, 3) present coefficients
    located : (n,) locations of its measured points, NaN where unknown
    """
    if curve.breaks:
        return _respaced_pieces(curve, basis, own, located, spacing, smooth)
    u, xyz = _samples(basis, own, located)
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(xyz, axis=0), axis=1))])
    count = max(3 if basis.closed else 1, round(length[-1] / spacing))
    even = _supported(np.linspace(0.0, length[-1], count + 1), u, length, located, basis.closed)
    if smooth:
        knots = _least_squares_knots(even, basis.closed, length, xyz)
    else:
        knots = basis.evaluate(np.interp(even[: len(even) - basis.closed], length, u), own)
    try:
        parameters = knot_parameters(knots, "chord_length", basis.closed)
    except ValueError:
        return replace(curve, values=basis.values_from_coefficients(own), knot_parameters=basis.break_points)
    if smooth:  # the same shape on chord lengths: fit again with the parameters that the curve will have
        knots = _least_squares_knots(parameters, basis.closed, np.interp(length, even, parameters), xyz)
    return replace(
        curve, values=knots, sigma=np.full_like(knots, np.inf), knot_parameters=parameters, reference=None
    )


def _respaced_pieces(
    curve: Curve, basis: CurveBasis, own: FloatArray, located: FloatArray, spacing: float, smooth: bool
) -> Curve:
    """A curve with corners, every smooth piece re-spaced by itself; the corners stay about where they are."""
    bounds = [0, *curve.breaks, basis.segment_count]
    knots, parameters, breaks = np.zeros((0, 3)), np.zeros(0), []
    for number, (first, last) in enumerate(pairwise(bounds)):
        piece = natural_cubic_basis(basis.break_points[first : last + 1])
        low, high = piece.break_points[[0, -1]]
        inside = located[(located >= low) & (located <= high)]
        ends = [end for end, outer in ((low, number == 0), (high, last == bounds[-1])) if not outer]
        new = respaced(
            replace(curve, breaks=()), piece, own[first : last + 1], np.append(inside, ends), spacing, smooth
        )
        own_parameters = np.asarray(new.knot_parameters)
        if number:
            breaks.append(len(knots) - 1)
            knots[-1] = 0.5 * (knots[-1] + new.values[0])
            parameters = np.append(parameters, parameters[-1] - own_parameters[0] + own_parameters[1:])
            knots = np.vstack([knots, new.values[1:]])
        else:
            knots, parameters = new.values.copy(), own_parameters
    return replace(
        curve, values=knots, sigma=np.full_like(knots, np.inf), knot_parameters=parameters, reference=None,
        breaks=tuple(breaks),
    )  # fmt: skip


def _supported(
    even: FloatArray, u: FloatArray, length: FloatArray, located: FloatArray, closed: bool
) -> FloatArray:
    """Places of knots without those that would bound a stretch with hardly a measured point."""
    known = located[np.isfinite(located)]
    if len(known) < FEWEST_LOCATED or closed:
        return even
    number, _ = np.histogram(np.interp(known, u, length), bins=even)
    return even[supported_knots(number, closed, cut_ends=False)]


def _samples(basis: CurveBasis, own: FloatArray, located: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Samples of the measured stretches of a curve; loops and ends without measurements are left out."""
    low, high = basis.break_points[0], basis.break_points[-1]
    known = np.sort(located[np.isfinite(located)])
    measured = len(known) >= FEWEST_LOCATED and known[-1] > known[0]
    if not basis.closed and measured:
        low, high = float(known[0]), float(known[-1])
    u = np.linspace(low, high, SAMPLES_PER_SEGMENT * basis.segment_count + 1)
    if measured:
        far = WIDE_GAP * float(np.quantile(np.diff(known), 0.95))
        after = np.clip(np.searchsorted(known, u), 1, len(known) - 1)
        distance = np.minimum(np.abs(u - known[after - 1]), np.abs(u - known[after]))
        near = distance <= far
        near[[0, -1]] = True
        u = u[near]
    return u, basis.evaluate(u if not basis.closed else np.append(u[:-1], low), own)


def _least_squares_knots(
    parameters: FloatArray, closed: bool, places: FloatArray, xyz: FloatArray
) -> FloatArray:
    """Knots of the natural spline on `parameters` that fits samples (n, 3) at `places` best."""
    basis = natural_cubic_basis(parameters, closed)
    segment, t = basis.locate(np.clip(places, parameters[0], parameters[-1] - 1e-12 * parameters[-1]))
    weights = np.einsum("nk,nkw->nw", t[:, None] ** np.arange(4), basis.power[segment])
    design = np.zeros((len(places), basis.coefficient_count))
    np.add.at(design, (np.arange(len(places))[:, None], basis.columns[segment]), weights)
    coefficients: FloatArray = np.asarray(np.linalg.lstsq(design, xyz, rcond=None)[0], dtype=np.float64)
    return basis.values_from_coefficients(coefficients)
