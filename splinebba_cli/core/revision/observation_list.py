"""All measurements of a network as one list, so that the search for outliers treats them alike.

Points come first, then points on curves, arc lengths, tangents, distances; a vector over the list is cut into kinds by
:meth:`ObservationList.part`.  An image point is one entry with both of its coordinates.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from splinebba_cli.core.evidence import ObservationKind
from splinebba_cli.core.network import BoolArray, IntArray, Network
from splinebba_cli.core.quality.observation_names import distance_name

KINDS: tuple[tuple[ObservationKind, str], ...] = (
    ("point", "point_observations"),
    ("spline", "curve_observations"),
    ("arc length", "arc_lengths"),
    ("tangent", "tangents"),
    ("distance", "distances"),
)  # and the attribute of Network that holds them
POINTS, CURVES, ARCS, TANGENTS, DISTANCES = range(5)
NONE = -1


@dataclass(frozen=True)
class ObservationList:
    """One entry a measurement."""

    network: Network
    starts: IntArray  # (kinds + 1,) first entry of every kind

    @classmethod
    def of(cls, network: Network) -> ObservationList:
        """The list of a network."""
        counts = [len(getattr(network, name)) for _, name in KINDS]
        return cls(network, np.concatenate([[0], np.cumsum(counts)]).astype(np.int64))

    @cached_property
    def kind(self) -> IntArray:
        """Number in KINDS of every entry, (N,)."""
        return np.repeat(np.arange(len(KINDS)), np.diff(self.starts))

    @cached_property
    def row(self) -> IntArray:
        """Numbers among the observations of the same kind, (N,)."""
        return np.arange(len(self)) - self.starts[self.kind]

    @cached_property
    def image(self) -> IntArray:
        """Images, (N,); distances have a negative number of their own."""
        network, curves = self.network, self.network.curve_observations
        return np.concatenate(
            [
                network.point_observations.image, curves.image, curves.image[network.arc_lengths.first],
                curves.image[network.tangents.point], -1 - np.arange(len(network.distances)),
            ]
        )  # fmt: skip

    @cached_property
    def feature(self) -> IntArray:
        """Points, then curves, (N,); of distances as for `image`."""
        network = self.network
        of_curve = len(network.points.ids) + network.curve_observations.curve
        return np.concatenate(
            [
                network.point_observations.point, of_curve, of_curve[network.arc_lengths.first],
                of_curve[network.tangents.point], -1 - np.arange(len(network.distances)),
            ]
        )  # fmt: skip

    @cached_property
    def owners(self) -> IntArray:
        """Entries of the measured curve points at which an arc or tangent ends, (N, 2), NONE for none."""
        arcs, tangents, starts = self.network.arc_lengths, self.network.tangents, self.starts
        owners = np.full((len(self), 2), NONE)
        owners[starts[ARCS] : starts[ARCS + 1]] = starts[CURVES] + np.stack([arcs.first, arcs.second], axis=1)
        owners[starts[TANGENTS] : starts[DISTANCES], 0] = starts[CURVES] + tangents.point
        return owners

    def __len__(self) -> int:
        return int(self.starts[-1])

    def part(self, values: Any, kind: int) -> Any:
        """The entries of one kind of an array over the list."""
        return values[self.starts[kind] : self.starts[kind + 1]]

    def excluded(self) -> BoolArray:
        """What the user has taken out, with the arcs and tangents that end at it, (N,)."""
        found = np.zeros(len(self), dtype=bool)
        for kind, (_, name) in enumerate(KINDS):
            given = getattr(self.network, name).excluded
            if given is not None:
                self.part(found, kind)[:] = given
        return found | self.orphans(found)

    def with_excluded(self, out: BoolArray) -> Network:
        """The network with observations (N,) marked as taken out."""
        changes: dict[str, Any] = {
            name: replace(getattr(self.network, name), excluded=self.part(out, kind))
            for kind, (_, name) in enumerate(KINDS)
            if self.part(out, kind).any()
        }
        return replace(self.network, **changes)

    def orphans(self, gone: BoolArray) -> BoolArray:
        """Arcs and tangents that end at a measured point that is gone, (N,)."""
        if not gone.any():
            return np.zeros(len(self), dtype=bool)
        has = self.owners >= 0
        return np.asarray((has & gone[np.where(has, self.owners, 0)]).any(axis=1) & ~gone)

    def unlocated(self, used: BoolArray) -> BoolArray:
        """Used image points of points that the used ones cannot locate: fewer than two rays, coordinates free."""
        points = self.network.points
        needs = np.isinf(points.sigma).any(axis=1)
        seen = self.network.point_observations.point
        of_point = used[: len(seen)]
        rays = np.bincount(seen, of_point, minlength=len(points.ids))
        found = np.zeros(len(self), dtype=bool)
        found[: len(seen)] = of_point & (needs & (rays < 2))[seen]
        return found

    def name(self, entry: int) -> str:
        """What people call an entry: ``image `3`, spline `road` ``."""
        network, kind = self.network, int(self.kind[entry])
        if kind == DISTANCES:
            return distance_name(network, int(self.row[entry]))
        count = len(network.points.ids)
        feature = int(self.feature[entry])
        if feature < count:
            what = f"point `{network.points.ids[feature]}`"
        else:
            what = f"spline `{network.curves[feature - count].id}`"
        own = f", {KINDS[kind][0]}" if kind >= ARCS else ""
        return f"image `{network.images.ids[self.image[entry]]}`, {what}{own}"
