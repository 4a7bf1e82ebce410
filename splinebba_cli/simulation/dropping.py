"""What is not measured in a realization: single points, whole pairs of image and feature; who is then left out."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from splinebba_cli.core.network import BoolArray, Distances, FloatArray, IntArray, Network
from splinebba_cli.simulation.observation_kinds import KINDS, select
from splinebba_cli.simulation.truth import Truth


@dataclass(frozen=True)
class Dropped:
    """A network with its truth, and where its features stand in the design."""

    network: Network
    truth: Truth
    points: IntArray  # (n,) numbers of the points in the design
    curves: IntArray  # (k,) numbers of the curves in the design
    measured: IntArray  # (q,) numbers of the measured curve points in the design
    left_out: tuple[str, ...] = ()  # "tie point `a`": features that too few images see


def drop_measurements(
    network: Network, truth: Truth, point_share: float, pair_share: float, generator: np.random.Generator
) -> Dropped:
    """Drop shares of the measured image points and of the pairs of image and feature.

    round(share n) of each kind are dropped, of the pairs first.  Tie features that fewer than two images still see
    are left out, and so is what no image sees, as a project would be refused otherwise.
    """
    if point_share <= 0.0 and pair_share <= 0.0:
        points, curves = np.arange(len(network.points.ids)), np.arange(len(network.curves))
        return Dropped(network, truth, points, curves, np.arange(len(network.curve_observations)))
    measured = np.arange(len(network.curve_observations))
    for field, feature in (("point_observations", "point"), ("curve_observations", "curve")):
        group = getattr(network, field)
        rows = np.arange(len(group))
        if pair_share > 0.0 and len(rows):
            _, pair = np.unique(
                np.column_stack([group.image, getattr(group, feature)]), axis=0, return_inverse=True
            )
            pair = pair.reshape(-1)
            rows = rows[np.isin(pair, _kept(int(pair.max()) + 1, pair_share, generator))]
        if point_share > 0.0:
            rows = rows[_kept(len(rows), point_share, generator)]
        if len(rows) < len(group):
            network, truth = keep_rows(network, truth, field, rows)
            measured = measured[rows] if field == "curve_observations" else measured
    left = leave_out_unseen(network, truth)
    return replace(left, measured=measured[left.measured])


def _kept(count: int, share: float, generator: np.random.Generator) -> IntArray:
    """The numbers that stay, ascending."""
    return np.sort(generator.permutation(count)[round(share * count) :]).astype(np.int64)


def keep_rows(network: Network, truth: Truth, field: str, rows: IntArray) -> tuple[Network, Truth]:
    """Network and truth with some observations of one group."""
    count = len(getattr(network, field))
    changes: dict[str, Any] = {field: select(getattr(network, field), rows)}
    if field == "curve_observations":
        truth = replace(truth, locations=truth.locations[rows])
        changes |= _following(network, rows, count)
    return replace(network, **changes), truth


def _following(network: Network, rows: IntArray, count: int) -> dict[str, Any]:
    """Groups that refer to measured curve points, with those whose points all stay."""
    number = np.full(count, -1, dtype=np.int64)
    number[rows] = np.arange(len(rows))
    changes: dict[str, Any] = {}
    for kind in KINDS:
        if kind.curve_points and len(kind.of(network)):
            referred = {name: number[getattr(kind.of(network), name)] for name in kind.curve_points}
            stay = np.flatnonzero(np.all([found >= 0 for found in referred.values()], axis=0))
            changes[kind.group] = replace(
                select(kind.of(network), stay), **{name: found[stay] for name, found in referred.items()}
            )
    return changes


def leave_out_unseen(network: Network, truth: Truth) -> Dropped:
    """Leave out the features that too few images see, by the rules of a project."""
    points, curves = network.points, network.curves
    on_points, on_curves = network.point_observations, network.curve_observations
    point_roles, curve_roles = points.role, tuple(curve.role for curve in curves)
    kept_points = _usable(point_roles, _images_of(on_points.point, on_points.image, len(points.ids)))
    kept_curves = _usable(curve_roles, _images_of(on_curves.curve, on_curves.image, len(curves)))
    out = [f"{points.role[k]} point `{points.ids[k]}`" for k in np.flatnonzero(~kept_points)]
    out += [f"{curves[k].role} spline `{curves[k].id}`" for k in np.flatnonzero(~kept_curves)]
    measured = np.flatnonzero(kept_curves[on_curves.curve])
    if out:
        network, truth = _without(network, truth, kept_points, kept_curves)
    kept = np.flatnonzero(kept_points), np.flatnonzero(kept_curves)
    return Dropped(network, truth, kept[0], kept[1], measured, tuple(out))


def _images_of(feature: IntArray, image: IntArray, count: int) -> IntArray:
    """Number of images that see each feature, (count,)."""
    pairs = np.unique(np.column_stack([feature, image]), axis=0)
    return np.bincount(pairs[:, 0], minlength=count).astype(np.int64)


def _usable(roles: tuple[str, ...], seen: IntArray) -> BoolArray:
    need = np.array([2 if role in ("tie", "check") else 1 for role in roles], dtype=np.int64)
    return np.asarray(seen >= need)


def _without(network: Network, truth: Truth, points: BoolArray, curves: BoolArray) -> tuple[Network, Truth]:
    """Network and truth without some features and their measurements."""
    on_points, on_curves = network.point_observations, network.curve_observations
    network, truth = keep_rows(network, truth, "point_observations", np.flatnonzero(points[on_points.point]))
    network, truth = keep_rows(network, truth, "curve_observations", np.flatnonzero(curves[on_curves.curve]))
    new_point, new_curve = np.cumsum(points) - 1, np.cumsum(curves) - 1
    network = replace(network, distances=_between_kept(network.distances, points, new_point))
    rows = network.points
    arrays: dict[str, FloatArray] = {
        name: getattr(rows, name)[points] for name in ("xyz", "sigma", "check_sigma")
    }
    network = replace(
        network,
        points=replace(
            rows,
            ids=tuple(np.array(rows.ids, dtype=object)[points]),
            role=tuple(np.array(rows.role, dtype=object)[points]),
            **arrays,
        ),
        curves=tuple(curve for curve, keep in zip(network.curves, curves, strict=True) if keep),
        point_observations=replace(
            network.point_observations, point=new_point[network.point_observations.point].astype(np.int64)
        ),
        curve_observations=replace(
            network.curve_observations, curve=new_curve[network.curve_observations.curve].astype(np.int64)
        ),
    )
    kept = tuple(values for values, keep in zip(truth.curves, curves, strict=True) if keep)
    return network, replace(truth, points=truth.points[points], curves=kept)


def _between_kept(distances: Distances, points: BoolArray, new_point: IntArray) -> Distances:
    """The distances whose points stay, with their new numbers."""
    on_points = ~distances.is_image
    stays = np.ones(distances.station.shape, dtype=bool)
    stays[on_points] = points[distances.station[on_points]]
    station = distances.station.copy()
    station[on_points] = new_point[station[on_points]]
    kept: Distances = select(replace(distances, station=station), np.flatnonzero(stays.all(axis=1)))
    return kept
