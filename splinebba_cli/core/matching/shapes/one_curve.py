"""New curves that chains prove to be one: joined, smoothly or with a corner (C0), where the measurements allow it.

The curves of a joint are fitted as one, with the points between, and stay one if their own points allow it,

    v'Pv(one) - v'Pv(two) < chi square of the three coordinates that are gone,

residuals cut off at LARGEST, and if most of the points between fit.  A joint is smooth only where a corner costs
clearly more, the price of knots included.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2

from splinebba_cli.core.matching.shapes.curve_joints import CurveJoint, possible_joints, turned
from splinebba_cli.core.matching.shapes.draft import Draft, draft_of
from splinebba_cli.core.matching.shapes.joining import links_between, path_from
from splinebba_cli.core.matching.shapes.knot_need import PRICE, with_needed_knots
from splinebba_cli.core.matching.shapes.soundness import distorted
from splinebba_cli.core.network import BoolArray, Curve, FloatArray, IntArray, Network

CHANCE = float(chi2.ppf(0.999, 3))
LARGEST = 5.0  # sigma: a residual counts as at most this
MOST_OFF = 0.4  # of the points between that do not fit
SHORTEST = 1e-3  # segments, of the length of the curve


@dataclass(frozen=True)
class _Whole:
    """Several curves as one, and where their locations are on it: sign u + shift."""

    curve: Curve
    parts: tuple[tuple[int, float, float], ...]  # curve, sign, shift
    row: IntArray  # points between


def joined_smoothly(network: Network, draft: Draft, tolerance: float) -> Draft:
    """Curves that run on into each other as one; the points between are not linked yet.

    Parameters
    ----------
    tolerance : for knots, in sigma of the mean of neighbouring residuals
    """
    smooth = _tried(network, draft, possible_joints(network, draft, corners=False), tolerance)
    corner = _tried(network, draft, possible_joints(network, draft, corners=True), tolerance)
    cheapest = {frozenset((j.first, j.second)): price for j, price in corner}
    kept = [j for j, price in smooth if price + PRICE < cheapest.get(frozenset((j.first, j.second)), np.inf)]
    return _draft_of_wholes(network, draft, _wholes(draft, kept)) if kept else draft


def joined_at_corners(network: Network, draft: Draft, width: float, tolerance: float) -> Draft:
    """Curves that go on around corners as one, with the points there that fit.

    Parameters
    ----------
    width : sigma within which points around corners are linked
    tolerance : for knots, in sigma of the mean of neighbouring residuals
    """
    kept = [j for j, _ in _tried(network, draft, possible_joints(network, draft, corners=True), tolerance)]
    if not kept:
        return draft
    wholes = _wholes(draft, kept)
    more = _draft_of_wholes(network, draft, wholes, between=True)
    square = _squares_of_points(more)
    return more.with_links((square <= width**2) | np.isin(more.row, draft.row)).solved()


def _tried(
    network: Network, draft: Draft, joints: list[CurveJoint], tolerance: float
) -> list[tuple[CurveJoint, float]]:
    """Joints whose curves fit as one, each by itself, and what the one costs with its knots."""
    wholes = [
        _end_to_end(
            draft.present_curves(),
            [(joint.first[0], joint.first[1] == 1), (joint.second[0], joint.second[1] == 0)],
            {joint.first: joint, joint.second: joint},
        )
        for joint in joints
    ]
    sound = np.array([_ascends(whole.curve) for whole in wholes], dtype=bool)
    joints = [joint for joint, good in zip(joints, sound, strict=True) if good]
    wholes = [whole for whole, good in zip(wholes, sound, strict=True) if good]
    if not wholes:
        return []
    trial = with_needed_knots(_draft_of_wholes(network, draft, wholes, between=True), tolerance)
    price = _costs(trial) + PRICE * np.diff(trial.prepared.curves.coefficient_start)
    fits = _fits(draft, trial, wholes)
    return [(joint, float(price[k])) for k, joint in enumerate(joints) if fits[k]]


def _fits(draft: Draft, trial: Draft, wholes: list[_Whole]) -> BoolArray:
    """Whether each whole fits the points of its parts as well as these do, and most of the points between."""
    before = _costs(draft)
    apart = np.array([sum(before[k] for k, _, _ in whole.parts) for whole in wholes])
    between = ~np.isin(trial.row, draft.row)
    variance = max(1.0, float(before.sum()) / max(len(draft.row), 1))
    off = between & (_squares_of_points(trial) > LARGEST**2)
    count, count_off = (
        np.bincount(trial.links.curve[rows], minlength=len(wholes)) for rows in (between, off)
    )
    worse = _costs(trial, ~between) - apart
    return np.asarray((worse < CHANCE * variance) & ~distorted(trial) & (count_off <= MOST_OFF * count))


def _ascends(curve: Curve) -> bool:
    """Whether knot parameters ascend with segments of some length."""
    parameters = np.asarray(curve.knot_parameters)
    return bool((np.diff(parameters) > SHORTEST * (parameters[-1] - parameters[0])).all())


def _squares_of_points(draft: Draft) -> FloatArray:
    """Squared residuals of the links, of both equations where there are two, (n,)."""
    rows = draft.equations()
    return np.asarray(np.bincount(rows.point, rows.residual**2, minlength=len(draft.row)), dtype=np.float64)


def _costs(draft: Draft, chosen: BoolArray | None = None) -> FloatArray:
    """v'Pv of all or chosen links of every curve, (nc,)."""
    square = np.minimum(_squares_of_points(draft), LARGEST**2)
    if chosen is not None:
        square = np.where(chosen, square, 0.0)
    return np.asarray(np.bincount(draft.links.curve, square, minlength=len(draft.curves)), dtype=np.float64)


def _wholes(draft: Draft, joints: list[CurveJoint]) -> list[_Whole]:
    """All curves, those of the joints together; one that is joined to itself in a ring stays open."""
    links = links_between([(joint.first, joint.second) for joint in joints])
    at = {end: joint for joint in joints for end in (joint.first, joint.second)}
    curves = draft.present_curves()
    found, done = [], set[int]()
    for k in range(len(curves)):
        if k not in done:
            path, _ = path_from(k, links)
            done.update(number for number, _ in path)
            found.append(_end_to_end(curves, path, at))
    return found


def _end_to_end(
    curves: tuple[Curve, ...], path: list[tuple[int, bool]], at: dict[tuple[int, int], CurveJoint]
) -> _Whole:
    """Curves one after another as one.

    Parameters
    ----------
    path : curves with their sense, True: as they are
    at : joints of ends
    """
    number, forward = path[0]
    whole, parts = _in_sense(curves[number], number, forward)
    row = [np.zeros(0, dtype=np.int64)]
    for number, forward in path[1:]:
        own, ((_, sign, shift),) = _in_sense(curves[number], number, forward)
        end = (number, 0 if forward else 1)
        joint = at[end]
        reach = joint.reach if joint.second == end else joint.reach[::-1]
        before, after = np.asarray(whole.knot_parameters), np.asarray(own.knot_parameters)
        moved = float(before[-1] + sum(reach) - after[0])
        values = np.vstack([whole.values[:-1], joint.place, own.values[1:]])
        last = len(before) - 1
        corner = (last,) if joint.corner else ()
        whole = replace(
            whole, values=values, sigma=np.full_like(values, np.inf), reference=None,
            knot_parameters=np.concatenate([before[:-1], [before[-1] + reach[0]], after[1:] + moved]),
            breaks=(*whole.breaks, *corner, *(last + k for k in own.breaks)),
        )  # fmt: skip
        parts = (*parts, (number, sign, shift + moved))
        row.append(joint.row)
    longest = max(path, key=lambda part: float(np.ptp(np.asarray(curves[part[0]].knot_parameters))))[0]
    return _Whole(replace(whole, id=curves[longest].id), parts, np.unique(np.concatenate(row)))


def _in_sense(curve: Curve, number: int, forward: bool) -> tuple[Curve, tuple[tuple[int, float, float], ...]]:
    """A curve in the wanted sense, and where its locations are."""
    if forward:
        return curve, ((number, 1.0, 0.0),)
    parameters = np.asarray(curve.knot_parameters)
    return turned(curve), ((number, -1.0, float(parameters[0] + parameters[-1])),)


def _draft_of_wholes(network: Network, draft: Draft, wholes: list[_Whole], *, between: bool = False) -> Draft:
    """The links of the parts on the wholes, adjusted; a part may be in several wholes.

    Parameters
    ----------
    between : whether the points between are linked as well
    """
    row, label, location = [], [], []
    for number, whole in enumerate(wholes):
        for k, sign, shift in whole.parts:
            own = draft.links_by_curve[k]
            row.append(draft.row[own])
            label.append(np.full(len(own), number))
            location.append(sign * draft.state.location[own] + shift)
        if between:
            row.append(whole.row)
            label.append(np.full(len(whole.row), number))
            location.append(np.full(len(whole.row), np.nan))
    curves = tuple(whole.curve for whole in wholes)
    return draft_of(
        network, draft.state, curves, np.concatenate(row), np.concatenate(label), np.concatenate(location)
    ).solved()
