"""Fragments -> tie splines: merged, joined, given knots, adjusted with the orientations held, points linked anew."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.matching.fragments.fragment import Fragment
from splinebba_cli.core.matching.matches import BuiltCurve
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.matching.shapes.built import built_curves
from splinebba_cli.core.matching.shapes.corners import corner_points, cut_at_corners
from splinebba_cli.core.matching.shapes.draft import Draft, curve_of_fit, draft_of
from splinebba_cli.core.matching.shapes.duplicates import SameAsGiven, same_as_given, without_duplicates
from splinebba_cli.core.matching.shapes.extent import cut_back, extended
from splinebba_cli.core.matching.shapes.grouping import groups_of
from splinebba_cli.core.matching.shapes.joining import joined_strands
from splinebba_cli.core.matching.shapes.knot_need import with_needed_knots
from splinebba_cli.core.matching.shapes.knot_pruning import without_idle_knots
from splinebba_cli.core.matching.shapes.linking import Gate, relinked
from splinebba_cli.core.matching.shapes.merging import merged
from splinebba_cli.core.matching.shapes.names import new_ids
from splinebba_cli.core.matching.shapes.new_curve_problems import (
    cut_problems,
    duplicate_problems,
    second_edge_problems,
    weak_problems,
)
from splinebba_cli.core.matching.shapes.one_curve import joined_at_corners, joined_smoothly
from splinebba_cli.core.matching.shapes.overlaps import ImagePoints, overlaps_of
from splinebba_cli.core.matching.shapes.place_fit import fit_places
from splinebba_cli.core.matching.shapes.second_edges import split
from splinebba_cli.core.matching.shapes.settling import settled_curves
from splinebba_cli.core.matching.shapes.soundness import with_supported_knots
from splinebba_cli.core.matching.shapes.strand import Strand, strand_of
from splinebba_cli.core.matching.shapes.undetermined import cut_undetermined, real_curves, usual_sigma
from splinebba_cli.core.network import Curve, FloatArray, IntArray, Network
from splinebba_cli.core.result import Problem
from splinebba_cli.core.state import State, image_rays, prepare

_log = logging.getLogger(__name__)

GATES = (8.0, 5.0, 4.0)  # sigma within which points are linked, round after round
JOININGS = 3
FIRST_TOLERANCE = 2.0  # sigma of places, before the image points decide over knots


@dataclass(frozen=True)
class NewCurves:
    """Tie curves made from fragments, and which unlabelled points belong to them."""

    curves: tuple[Curve, ...]
    curve: IntArray  # (n,) of every unlabelled point: index into `curves`, -1 none
    location: FloatArray  # (n,) u on the new or the given curve, NaN where none
    on_given: IntArray  # (n,) curve of the network whose edge the point shows after all, -1 none
    built: tuple[BuiltCurve, ...]
    problems: tuple[Problem, ...]


def build_curves(
    network: Network, state: State, fragments: Sequence[Fragment], settings: MatchSettings,
    rows: IntArray | None = None,
) -> NewCurves:  # fmt: skip
    """Tie splines with knots, and the unlabelled points linked to them.

    Parameters
    ----------
    network : with unlabelled points
    state : whose orientations are held, and whose coefficients are those of the curves of the network
    fragments : their links are rows of the unlabelled points
    rows : unlabelled points that may be linked, default all

    Returns
    -------
    NewCurves
        Indices of curves begin at 0: those of the network are not counted.
    """
    rows = np.arange(len(network.unlabelled)) if rows is None else rows
    rows = rows[np.lexsort((rows, network.unlabelled.chain[rows]))]
    draft = _first_draft(network, state, strands_of(network, fragments))
    gate = Gate(GATES[0], settings.direction_tolerance_rad)
    for width in GATES:
        draft = _settled(network, draft, rows, replace(gate, width=width), settings)
    if not draft.curves:
        return _result(network, draft, [], (), ())
    draft = _run_on(network, draft, rows, gate, settings)
    draft, merged_pairs = without_duplicates(network, draft, _image_points(network))
    draft, second = split(
        network, with_needed_knots(draft, settings.knot_tolerance), network.unlabelled.chain
    )
    refused = frozenset((int(row), one.curve) for edge in second for one in edge.off for row in one.row)
    draft = _settled(network, draft, rows, replace(gate, width=GATES[-1], refused=refused), settings)
    draft = real_curves(network, with_needed_knots(draft, settings.knot_tolerance))
    if not draft.curves:
        return _result(network, draft, [], (), ())
    draft = joined_at_corners(network, draft, GATES[-1], settings.knot_tolerance)
    draft = without_idle_knots(with_supported_knots(draft).solved())
    usual = usual_sigma(draft)
    draft, cuts = cut_undetermined(network, draft, usual)
    draft = settled_curves(draft)
    same = _same_as_given(network, state, draft)
    built = built_curves(network, draft, usual)
    ids = [curve.id for curve in draft.curves]
    problems = (
        *weak_problems(built, ids, usual),
        *cut_problems(cuts),
        *duplicate_problems(merged_pairs, [_given_ids(network, one) for one in same]),
        *second_edge_problems(network, second),
    )
    return _result(network, draft, same, built, problems)


def _settled(network: Network, draft: Draft, rows: IntArray, gate: Gate, settings: MatchSettings) -> Draft:
    """Knots where they are needed, ends carried on, points linked anew, ends cut back."""
    if not draft.curves:
        return draft
    draft = extended(with_needed_knots(draft, settings.knot_tolerance))
    return cut_back(real_curves(network, relinked(network, draft, rows, gate)))


def _run_on(network: Network, draft: Draft, rows: IntArray, gate: Gate, settings: MatchSettings) -> Draft:
    """Curves that run on into each other as one, as often as linking finds more of them."""
    gate = replace(gate, width=GATES[-1])
    for _ in range(JOININGS):
        joined = joined_smoothly(network, draft, settings.knot_tolerance)
        if joined is draft:
            break
        draft = _settled(network, joined, rows, gate, settings)
    return draft


def strands_of(network: Network, fragments: Sequence[Fragment]) -> list[Strand]:
    """Whole edges from fragments: those of one edge merged, then joined across gaps."""
    points = _image_points(network)
    corner = corner_points(points, network.unlabelled.chain)
    parts = [part for f in fragments for part in cut_at_corners(f, corner, points.image)]
    single = [s for part in parts if (s := strand_of(part)) is not None]
    overlaps = overlaps_of(single, points)
    groups = groups_of(len(single), overlaps)
    whole = [merged([single[k] for k in group]) for group in groups]
    joined = joined_strands(whole, network.unlabelled.chain, points.image)
    _log.info("%d fragments: %d edges, %d after joining", len(fragments), len(groups), len(joined))
    return joined


def _image_points(network: Network) -> ImagePoints:
    points = network.unlabelled
    rays = image_rays(network, points.image, points.photo_xy, points.sigma)
    return ImagePoints(points.image, rays.xy, points.sigma.max(axis=1))


def _first_draft(network: Network, state: State, strands: list[Strand]) -> Draft:
    ids = new_ids(len(strands), (curve.id for curve in network.curves))
    fits = [fit_places(strand.places, FIRST_TOLERANCE) for strand in strands]
    curves = tuple(curve_of_fit(fit, id) for fit, id in zip(fits, ids, strict=True))
    none = np.zeros(0, dtype=np.int64)
    row = np.concatenate([none, *(s.link_row for s in strands)])
    curve = np.repeat(np.arange(len(strands)), [len(s.link_row) for s in strands])
    kept = np.unique(row, return_index=True)[1]
    return draft_of(network, state, curves, row[kept], curve[kept], np.full(len(kept), np.nan))


def _same_as_given(network: Network, state: State, draft: Draft) -> list[SameAsGiven]:
    if not network.curves:
        return []
    free, labelled = _image_points(network), network.curve_observations
    rays = image_rays(network, labelled.image, labelled.photo_xy, labelled.sigma)
    points = ImagePoints(
        np.concatenate([free.image, labelled.image]),
        np.vstack([free.xy, rays.xy]),
        np.concatenate([free.sigma, labelled.sigma.max(axis=1, initial=0.0)]),
    )
    return same_as_given(network, prepare(network), state, draft, points)


def _given_ids(network: Network, one: SameAsGiven) -> tuple[str, ...]:
    """The curve of the project that a new one is, and the other one that it is as well."""
    return tuple(network.curves[k].id for k in (one.given, one.also) if k >= 0)


def _result(
    network: Network, draft: Draft, same: list[SameAsGiven], built: tuple[BuiltCurve, ...],
    problems: tuple[Problem, ...],
) -> NewCurves:  # fmt: skip
    count = len(network.unlabelled)
    curve, location, on_given = np.full(count, -1), np.full(count, np.nan), np.full(count, -1)
    curve[draft.row], location[draft.row] = draft.links.curve, draft.state.location
    for one in same:
        curve[one.row], on_given[one.row], location[one.row] = -1, one.given, one.location
    gone = {one.curve for one in same}
    kept = [k for k in range(len(draft.curves)) if k not in gone]
    number = np.full(len(draft.curves) + 1, -1)
    number[kept] = np.arange(len(kept))
    curves = draft.present_curves()
    return NewCurves(
        tuple(curves[k] for k in kept),
        number[curve],
        location,
        on_given,
        tuple(replace(one, curve=int(number[one.curve])) for one in built if one.curve not in gone),
        problems,
    )
