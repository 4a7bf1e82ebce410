"""Curves that are the same edge: new ones among themselves, and new ones against those that the project has.

Every curve becomes a strand: places along it with the dispersion of the adjusted curve, and its links.  Then the same
tests decide as for fragments (:mod:`.overlaps`): an image that shows two lines proves two edges.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.curves.nearest import nearest_on_curve
from splinebba_cli.core.matching.shapes.curve_normals import curve_normals
from splinebba_cli.core.matching.shapes.draft import Draft, curve_of_fit, draft_of
from splinebba_cli.core.matching.shapes.extent import point_spacing
from splinebba_cli.core.matching.shapes.grouping import groups_of
from splinebba_cli.core.matching.shapes.merging import merged
from splinebba_cli.core.matching.shapes.overlaps import ImagePoints, overlap_of, overlaps_of
from splinebba_cli.core.matching.shapes.place_fit import fit_places
from splinebba_cli.core.matching.shapes.polyline_feet import cumulated_length, feet_on_polyline
from splinebba_cli.core.matching.shapes.strand import Strand
from splinebba_cli.core.network import FloatArray, IntArray, Network
from splinebba_cli.core.state import Prepared, State

TOLERANCE = 2.0  # sigma of places, for the curve through merged ones
MOST = 0.7  # of a new curve beside a given one: the same edge
LEAST_PLACES = 8


def strands_of_curves(draft: Draft) -> list[Strand]:
    """The new curves as strands."""
    spacing = point_spacing(draft)
    spacing = np.where(
        np.isfinite(spacing), spacing, np.nanmedian(spacing) if np.isfinite(spacing).any() else 1.0
    )
    found = []
    for k, own in enumerate(curve_normals(draft)):
        breaks = own.basis.break_points
        extent = float(breaks[-1] - breaks[0])
        count = max(LEAST_PLACES, int(np.ceil(extent / spacing[k])))
        u = np.linspace(breaks[0], breaks[-1], count + 1)[: count + (not own.basis.closed)]
        xyz = own.basis.evaluate(u, own.coefficients)
        found.append(_strand(xyz, u, own.dispersion(u), own.basis.closed, draft.row[own.link], own.location))
    return found


def _strand(
    xyz: FloatArray, u: FloatArray, dispersion: FloatArray, closed: bool, row: IntArray, at: FloatArray
) -> Strand:
    along = cumulated_length(xyz, closed=closed)
    table = np.append(u, u[-1] + (u[1] - u[0])) if closed else u
    spacing = float(np.median(np.diff(along)))
    loose = dispersion + np.eye(3) * (1e-3 * spacing) ** 2
    many = np.full(len(xyz), 2)
    return Strand(
        xyz, xyz, loose, many, np.zeros(len(xyz), dtype=bool), along[: len(xyz)], row,
        np.interp(at, table, along), float(along[-1]) if closed else 0.0, spacing,
    )  # fmt: skip


def without_duplicates(
    network: Network, draft: Draft, points: ImagePoints
) -> tuple[Draft, list[tuple[str, str]]]:
    """New curves of which no two are the same edge; and pairs of ids, the kept one and the one that went into it."""
    strands = strands_of_curves(draft)
    groups = groups_of(len(strands), overlaps_of(strands, points))
    if len(groups) == len(strands):
        return draft, []
    given, curves, pairs = draft.present_curves(), [], []
    new_of = np.empty(len(strands), dtype=np.int64)
    for number, group in enumerate(groups):
        new_of[group] = number
        longest = max(group, key=lambda k: strands[k].length)
        pairs += [(given[longest].id, given[k].id) for k in group if k != longest]
        if len(group) == 1:
            curves.append(given[longest])
        else:
            fit = fit_places(merged([strands[k] for k in group]).places, TOLERANCE)
            curves.append(curve_of_fit(fit, given[longest].id))
    unknown = np.full(len(draft.row), np.nan)
    kept = draft_of(network, draft.state, tuple(curves), draft.row, new_of[draft.links.curve], unknown)
    return kept.solved(), pairs


@dataclass(frozen=True)
class SameAsGiven:
    """A new curve that is an edge which the project has."""

    curve: int  # of the draft
    given: int  # of the project
    row: IntArray
    location: FloatArray  # on the given curve
    share: float  # of the new curve that runs beside the given one
    also: int = -1  # another curve of the project that is the same edge: points belong to neither, -1: none


def same_as_given(
    network: Network, prepared: Prepared, state: State, draft: Draft, points: ImagePoints
) -> list[SameAsGiven]:
    """New curves that are edges of the project.

    Parameters
    ----------
    prepared, state : of the network, with its own curves
    points : of the unlabelled points, followed by the labelled ones
    """
    if not network.curves or not draft.curves:
        return []
    new = strands_of_curves(draft)
    found = []
    for g in range(len(network.curves)):
        given = _given_strand(network, prepared, state, g)
        for k, strand in enumerate(new):
            if given is None or not _boxes_meet(given, strand):
                continue
            share = float(feet_on_polyline(given.line, strand.line, closed=given.closed).beside.mean())
            pair = overlap_of([given, strand], 0, 1, points) if share >= MOST else None
            if pair is not None and pair.one_edge:
                found.append(_on_given(prepared, state, draft, k, g, share))
    best: dict[int, SameAsGiven] = {}
    for one in sorted(found, key=lambda each: -each.share):
        first = best.setdefault(one.curve, one)
        if first is not one and first.also < 0:
            best[one.curve] = replace(first, row=first.row[:0], location=first.location[:0], also=one.given)
    return list(best.values())


def _on_given(prepared: Prepared, state: State, draft: Draft, k: int, g: int, share: float) -> SameAsGiven:
    links = draft.links_by_curve[k]
    xyz = draft.prepared.curves.bases[k].evaluate(draft.state.location[links], draft.coefficients_of(k))
    start = prepared.curves.coefficient_start
    own = state.coefficients[int(start[g]) : int(start[g + 1])]
    return SameAsGiven(k, g, draft.row[links], nearest_on_curve(prepared.curves.bases[g], own, xyz)[0], share)


def _given_strand(network: Network, prepared: Prepared, state: State, g: int) -> Strand | None:
    """A curve of the project as a strand; its labelled points are rows behind the unlabelled ones."""
    basis, curve = prepared.curves.bases[g], network.curves[g]
    if not basis.has_location:
        return None
    start = prepared.curves.coefficient_start
    own = state.coefficients[int(start[g]) : int(start[g + 1])]
    breaks = basis.break_points
    u = np.linspace(breaks[0], breaks[-1], 16 * basis.segment_count + 1)[: None if not basis.closed else -1]
    known = curve.sigma[np.isfinite(curve.sigma)]
    sigma = float(np.median(known)) if len(known) else 0.0
    labelled = np.flatnonzero(network.curve_observations.curve == g)
    at = state.location[labelled] if len(state.location) == len(network.curve_observations) else np.zeros(0)
    labelled = labelled[np.isfinite(at)] if len(at) == len(labelled) else labelled[:0]
    at = at[np.isfinite(at)]
    dispersion = np.broadcast_to(sigma**2 * np.eye(3), (len(u), 3, 3))
    return _strand(
        basis.evaluate(u, own), u, dispersion, basis.closed, len(network.unlabelled) + labelled, at
    )


def _boxes_meet(a: Strand, b: Strand) -> bool:
    reach = max(a.spacing, b.spacing)
    return bool((a.line.min(axis=0) - reach <= b.line.max(axis=0)).all() and (
        b.line.min(axis=0) - reach <= a.line.max(axis=0)).all())  # fmt: skip
