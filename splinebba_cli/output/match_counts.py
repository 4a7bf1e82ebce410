"""What matching has found, counted: by reason, image, spline and chain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from splinebba_cli.core.matching.matches import MatchResult, Reason
from splinebba_cli.core.network import BoolArray, IntArray
from splinebba_cli.output.columns import Column, Table
from splinebba_cli.project.matched_tables import reason_word

BINS = 10  # of the histogram of distances over those of the second-best splines
CLEAR = 0.5  # of that ratio, beyond which a match is called close


@dataclass(frozen=True)
class MatchCounts:
    """Sums over the unlabelled points of a result; those that the user has taken out do not count."""

    result: MatchResult

    @cached_property
    def counted(self) -> BoolArray:
        """Points that count, (n,)."""
        excluded = self.result.given.unlabelled.excluded
        count = len(self.result.given.unlabelled)
        return np.ones(count, dtype=bool) if excluded is None else ~excluded

    @cached_property
    def matched(self) -> BoolArray:
        """Points with a curve, (n,)."""
        return np.asarray(self.result.matches.curve >= 0)

    @property
    def share(self) -> float:
        """Matched share of the points that count; 0 where there is none."""
        total = int(self.counted.sum())
        return float(self.matched[self.counted].sum()) / total if total else 0.0

    @property
    def labelled_before(self) -> int:
        """Points on curves that had a label before."""
        return len(self.result.given.curve_observations)

    @property
    def labelled_share(self) -> float:
        """Share of all points with a label, of this matching or from before: matching again does not lower it."""
        total = int(self.counted.sum()) + self.labelled_before
        labelled = int(self.matched[self.counted].sum()) + self.labelled_before
        return labelled / total if total else 0.0

    def by_reason(self, rows: BoolArray | None = None) -> dict[Reason, int]:
        """Number of unmatched points of every reason that occurs."""
        chosen = ~self.matched if rows is None else rows & ~self.matched
        counts = np.bincount(self.result.matches.reason[chosen], minlength=len(Reason))
        return {reason: int(counts[reason]) for reason in Reason if counts[reason] and reason}

    @cached_property
    def ratio(self) -> np.ndarray:
        """Distance over that of the next curve, in [0, 1]; 0 where no other is near, NaN where unmatched, (n,)."""
        found = self.result.matches
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.where(np.isfinite(found.runner_up), found.distance / found.runner_up, 0.0)
        return np.asarray(np.where(self.matched, np.clip(np.nan_to_num(ratio), 0.0, 1.0), np.nan))

    def per_image(self) -> tuple[IntArray, IntArray]:
        """Points and matched points of every image, (m,)."""
        image, count = self.result.given.unlabelled.image, len(self.result.given.images.ids)
        return (
            np.bincount(image[self.counted], minlength=count),
            np.bincount(image[self.counted & self.matched], minlength=count),
        )

    def per_curve(self) -> tuple[IntArray, IntArray, IntArray]:
        """Matched points, images and chains of every curve of the result's network, (k,)."""
        points, count = self.result.given.unlabelled, len(self.result.network.curves)
        rows = np.flatnonzero(self.matched)
        curve, chain = self.result.matches.curve[rows], points.chain[rows]
        images = len(self.result.given.images.ids)
        seen = np.unique(curve * images + points.image[rows]) // max(images, 1)
        chained = chain >= 0
        linked = np.unique(curve[chained] * max(len(points.chain_ids), 1) + chain[chained])
        return (
            np.bincount(curve, minlength=count),
            np.bincount(seen, minlength=count),
            np.bincount(linked // max(len(points.chain_ids), 1), minlength=count),
        )

    @cached_property
    def chain_sizes(self) -> tuple[IntArray, IntArray]:
        """Points and matched points of every chain, without those taken out."""
        chain, count = self.result.given.unlabelled.chain, len(self.result.given.unlabelled.chain_ids)
        rows = self.counted & (chain >= 0)
        return (
            np.bincount(chain[rows], minlength=count),
            np.bincount(chain[rows & self.matched], minlength=count),
        )


def chains_table(counts: MatchCounts) -> Table:
    """One row a chain: image, points, matched points, the spline with most of them, why the rest has none."""
    result = counts.result
    points, found = result.given.unlabelled, result.matches
    size, matched = counts.chain_sizes
    order = np.argsort(points.chain, kind="stable")
    starts = np.searchsorted(points.chain[order], np.arange(len(points.chain_ids) + 1))
    names = [curve.id for curve in result.network.curves]
    splines, others, reasons, images = [], [], [], []
    for chain in range(len(points.chain_ids)):
        rows = order[starts[chain] : starts[chain + 1]]
        curve = found.curve[rows]
        numbers, count = np.unique(curve[curve >= 0], return_counts=True)
        splines.append(names[numbers[count.argmax()]] if len(numbers) else "")
        others.append(max(len(numbers) - 1, 0))
        why = np.bincount(found.reason[rows[curve < 0]]) if (curve < 0).any() else np.zeros(0, dtype=int)
        reasons.append(reason_word(int(why.argmax())) if len(why) else "")
        images.append(points.image[rows[0]])
    ids = _of_chains(points.chain_ids, [result.given.images.ids[k] for k in images])
    return Table(
        "chains",
        (
            Column("image", [result.given.images.ids[k] for k in images]),
            Column("chain", ids),
            Column("points", size),
            Column("matched", matched),
            Column("spline", splines),
            Column("other_splines", np.array(others, dtype=np.int64)),
            Column("reason", reasons),
        ),
    )


def _of_chains(chain_ids: Sequence[str], images: Sequence[str]) -> list[str]:
    """Names of chains as the user has them, without the image in front."""
    return [id.removeprefix(f"{image}/") for id, image in zip(chain_ids, images, strict=True)]
