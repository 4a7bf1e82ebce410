"""New curves joined at corners: one spline that is only C0 there.

The pieces are built first, each for itself; the points around a corner are linked to the whole last, where they fit.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2

from splinebba_cli.core.matching.shapes.corner_joints import CornerJoint, corner_joints, turned
from splinebba_cli.core.matching.shapes.draft import Draft, draft_of
from splinebba_cli.core.matching.shapes.joining import links_between, path_from
from splinebba_cli.core.matching.shapes.soundness import distorted
from splinebba_cli.core.network import BoolArray, Curve, FloatArray, IntArray, Network

CHANCE = float(chi2.ppf(0.999, 3))
LARGEST = 5.0  # sigma: a residual counts as at most this


@dataclass(frozen=True)
class _Whole:
    """Several curves as one, and where their locations are on it: sign u + shift."""

    curve: Curve
    parts: tuple[tuple[int, float, float], ...]  # curve, sign, shift


def joined_at_corners(network: Network, draft: Draft, width: float) -> Draft:
    """Curves that go on around corners as one.

    Parameters
    ----------
    width : sigma within which points around corners are linked
    """
    joints = corner_joints(network, draft)
    joints = [joint for joint, fits in zip(joints, _fit(network, draft, joints), strict=True) if fits]
    if not joints:
        return draft
    links = links_between([(joint.first, joint.second) for joint in joints])
    at = {end: joint for joint in joints for end in (joint.first, joint.second)}
    curves = draft.present_curves()
    wholes, done = [], set[int]()
    for k in range(len(curves)):
        if k not in done:
            path, _ = path_from(k, links)
            done.update(number for number, _ in path)
            wholes.append(_end_to_end(curves, path, at))
    joined = _draft_of_wholes(network, draft, wholes)
    return _with_points_around(network, joined, wholes, joints, width)


def _fit(network: Network, draft: Draft, joints: list[CornerJoint]) -> BoolArray:
    """Whether the curves of each joint fit as one, each joint by itself."""
    curves = draft.present_curves()
    wholes = [
        _end_to_end(
            curves,
            [(joint.first[0], joint.first[1] == 1), (joint.second[0], joint.second[1] == 0)],
            {joint.first: joint, joint.second: joint},
        )
        for joint in joints
    ]
    if not wholes:
        return np.zeros(0, dtype=bool)
    trial = _draft_of_wholes(network, draft, wholes)
    apart = _squares(draft)
    together = _squares(trial)
    before = np.array([sum(apart[k] for k, _, _ in whole.parts) for whole in wholes])
    variance = max(1.0, float(apart.sum()) / max(len(draft.row), 1))
    return np.asarray((together - before < CHANCE * variance) & ~distorted(trial))


def _squares(draft: Draft) -> FloatArray:
    """v'Pv of the links of every curve, (nc,)."""
    rows = draft.equations()
    residual = np.clip(rows.residual, -LARGEST, LARGEST)
    return np.bincount(draft.links.curve[rows.point], residual**2, minlength=len(draft.curves))


def _end_to_end(
    curves: tuple[Curve, ...], path: list[tuple[int, bool]], at: dict[tuple[int, int], CornerJoint]
) -> _Whole:
    """Curves one after another, with a corner between each two.

    Parameters
    ----------
    path : curves with their sense, True: as they are
    """
    whole, parts = None, []
    for number, forward in path:
        own = curves[number] if forward else turned(curves[number])
        given = np.asarray(curves[number].knot_parameters)
        sign, shift = (1.0, 0.0) if forward else (-1.0, float(given[0] + given[-1]))
        if whole is None:
            whole = own
        else:
            end = (number, 0 if forward else 1)
            joint = at[end]
            reach = joint.reach if joint.second == end else joint.reach[::-1]
            before, after = np.asarray(whole.knot_parameters), np.asarray(own.knot_parameters)
            moved = before[-1] + reach[0] + reach[1] - after[0]
            values = np.vstack([whole.values[:-1], joint.corner, own.values[1:]])
            last = len(before) - 1
            whole = replace(
                whole, values=values, sigma=np.full_like(values, np.inf), reference=None,
                knot_parameters=np.concatenate([before[:-1], [before[-1] + reach[0]], after[1:] + moved]),
                breaks=(*whole.breaks, last, *(last + k for k in own.breaks)),
            )  # fmt: skip
            shift += moved
        parts.append((number, sign, shift))
    assert whole is not None
    longest = max(path, key=lambda part: float(np.ptp(np.asarray(curves[part[0]].knot_parameters))))[0]
    return _Whole(replace(whole, id=curves[longest].id), tuple(parts))


def _draft_of_wholes(network: Network, draft: Draft, wholes: list[_Whole]) -> Draft:
    """The links of the parts on the wholes, adjusted; a part may be in several wholes."""
    row, label, location = [], [], []
    for number, whole in enumerate(wholes):
        for k, sign, shift in whole.parts:
            own = np.flatnonzero(draft.links.curve == k)
            row.append(draft.row[own])
            label.append(np.full(len(own), number))
            location.append(sign * draft.state.location[own] + shift)
    curves = tuple(replace(whole.curve, id=f"{whole.curve.id}") for whole in wholes)
    return draft_of(
        network, draft.state, curves, np.concatenate(row), np.concatenate(label), np.concatenate(location)
    ).solved()


def _with_points_around(
    network: Network, draft: Draft, wholes: list[_Whole], joints: list[CornerJoint], width: float
) -> Draft:
    """The draft with the points around its corners that fit."""
    whole_of = {k: number for number, whole in enumerate(wholes) for k, _, _ in whole.parts}
    none = np.zeros(0, dtype=np.int64)
    row: IntArray = np.concatenate([none, *(joint.row for joint in joints)])
    label = np.concatenate(
        [none, *(np.full(len(joint.row), whole_of[joint.first[0]]) for joint in joints)]
    )
    new = ~np.isin(row, draft.row)
    more = draft_of(
        network, draft.state, draft.present_curves(),
        np.concatenate([draft.row, row[new]]), np.concatenate([draft.links.curve, label[new]]),
        np.concatenate([draft.state.location, np.full(int(new.sum()), np.nan)]),
    ).solved()  # fmt: skip
    rows = more.equations()
    square = np.bincount(rows.point, rows.residual**2, minlength=len(more.row))
    keep = (square <= width**2) | np.isin(more.row, draft.row)
    return more.with_links(keep).solved()
