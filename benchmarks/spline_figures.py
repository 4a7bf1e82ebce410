"""How good tie splines built from chains are, held against the labelled solution and a scan."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.curves.nearest import nearest_on_curve
from splinebba_cli.core.curves.registry import basis_of
from splinebba_cli.core.matching.fragments.fragment import Fragment
from splinebba_cli.core.matching.match import with_labels
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.matching.shapes.build import NewCurves, build_curves
from splinebba_cli.core.network import FloatArray, IntArray, KnotPolicy, Network
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.core.state import State

BESIDE = 2.0  # knot distances up to which a labelled curve counts as rebuilt


@dataclass(frozen=True)
class SplineFigures:
    """Of new curves that were adjusted as the labelled ones were."""

    curves: int
    linked: float  # share of all points
    right: float  # share of links whose label is that of most links of their curve
    rms_px: float  # residuals across
    rebuilt: float  # share of the labelled curves that have a new curve beside them
    two_sigma: float  # share of it that is within two sigma of the labelled solution, across
    median_sigma: float


def splines_of(network: Network, fragments: Sequence[Fragment]) -> NewCurves:
    """Tie splines of a network at its given orientations."""
    images = network.images
    nothing = np.zeros(0)
    state = State(images.rotation, images.position, np.zeros((0, 3)), network.points.xyz, nothing)
    return build_curves(network, state, fragments, MatchSettings(new_curves=True))


def adjusted_splines(network: Network, new: NewCurves, spacing_m: float) -> AdjustmentResult:
    """The labelled network adjusted with knots as dense as those of the labelled solution."""
    labelled = with_labels(replace(network, curves=new.curves), new.curve, new.location)
    knots = KnotPolicy(spacing_m=spacing_m, drop=True)
    return adjust(replace(labelled, settings=replace(labelled.settings, knots=knots)))


def spline_figures(
    new: NewCurves, result: AdjustmentResult, labelled: AdjustmentResult, truth: IntArray, spacing_m: float
) -> SplineFigures:
    """Figures of new curves after their adjustment.

    Parameters
    ----------
    truth : (n,) label of every unlabelled point, -1: a wrong chain
    labelled : the solution with labels, all of whose samples count
    """
    network = result.network
    main = [_most(truth[new.curve == k]) for k in range(len(new.curves))]
    linked = new.curve >= 0
    right = truth[linked] == np.array(main)[new.curve[linked]]
    closest = [np.full(len(c.sample_u), np.inf) for c in labelled.curves]
    for k, curve in enumerate(result.curves):
        if main[k] < 0:
            continue
        values = curve.values - network.origin
        basis = basis_of(replace(network.curves[k], values=values))
        own = basis.coefficients_from_values(values)
        given = labelled.curves[main[k]]
        xyz = given.sample_xyz - labelled.network.origin
        u, distance = nearest_on_curve(basis, own, xyz)
        edge = 1e-9 * (basis.break_points[-1] - basis.break_points[0])
        inside = (u > basis.break_points[0] + edge) & (u < basis.break_points[-1] - edge) | basis.closed
        sigmas = _sigmas(basis.evaluate(u, own) - xyz, given.sample_across, given.sample_across_direction)
        sigmas = np.where(inside & (distance < BESIDE * spacing_m), sigmas, np.inf)
        closest[main[k]] = np.minimum(closest[main[k]], sigmas)
    every = np.concatenate(closest)
    reached = every[np.isfinite(every)]
    pixel = network.cameras[0].pixel_size_mm or 1.0
    return SplineFigures(
        curves=len(new.curves),
        linked=float(linked.mean()),
        right=float(right.mean()),
        rms_px=float(np.sqrt(np.mean(result.curve_residuals.across**2))) / pixel,
        rebuilt=len(reached) / len(every),
        two_sigma=float(np.mean(reached <= 2.0)),
        median_sigma=float(np.median(reached)),
    )


def false_curves(new: NewCurves, truth: IntArray) -> int:
    """New curves most of whose links have no label."""
    return sum(_most(truth[new.curve == k]) < 0 for k in range(len(new.curves)))


def distance_to(scan: FloatArray, result: AdjustmentResult, well_determined_m: float) -> float:
    """Median distance of samples that are precise across from a scan, metres."""
    xyz = np.vstack([c.sample_xyz[c.sample_across[:, 0] < well_determined_m] for c in result.curves])
    return float(np.median(cKDTree(scan).query(xyz)[0]))


def _most(labels: IntArray) -> int:
    """The label of most links; -1 where most have none."""
    known = labels[labels >= 0]
    return int(np.bincount(known).argmax()) if 2 * len(known) > len(labels) else -1


def _sigmas(offset: FloatArray, across: FloatArray, direction: FloatArray) -> FloatArray:
    """Lateral offsets in the standard ellipse of the labelled curve, (p,)."""
    major = np.abs(np.sum(offset * direction, axis=1))
    minor = np.sqrt(np.maximum(np.sum(offset**2, axis=1) - major**2, 0.0))
    return np.asarray(np.hypot(major / across[:, 0], minor / across[:, 1]))
