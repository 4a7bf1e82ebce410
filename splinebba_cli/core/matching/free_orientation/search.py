"""The orientation of one image from unlabelled chains and known curves: hypotheses, score, refinement, verdict.

Ends of chains are taken for ends of curves, two at a time and with their tangents (P2PT); where chains do not end as
curves do, points of chains are taken for places anywhere along the curves.  Every pair of image places is tried with
all pairs of curve places.  Thousands of the best by the coarse score are refined roughly, all at once; the best of
these exactly, one by one; the best by the exact score is the answer if it explains enough and no other comes near.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.approximation.point_tangent import orient_from_point_tangents
from splinebba_cli.core.matching.free_orientation.chain_raster import ALONGSIDE, ChainRaster
from splinebba_cli.core.matching.free_orientation.chains import ChainEnds, ImageChains
from splinebba_cli.core.matching.free_orientation.places import KnownCurves, Places
from splinebba_cli.core.matching.free_orientation.prior import PriorFilter
from splinebba_cli.core.matching.free_orientation.refinement import SMALLEST_GATE, FittedOrientation, Refiner
from splinebba_cli.core.matching.free_orientation.rough_refinement import roughly_refined
from splinebba_cli.core.matching.free_orientation.score import CoarseScore
from splinebba_cli.core.matching.free_orientation.seen import apart, see
from splinebba_cli.core.network import FloatArray, IntArray

GATE_SHARE = 0.012  # of the diagonal of what the chains cover: how far a hypothesis may be off in the picture
COARSE_SAMPLES, ROUGH_SAMPLES, FINE_SAMPLES, REFINING_SAMPLES = 100, 250, 500, 2500
REFINED_POINTS = 400
KEPT = 3000  # hypotheses of a batch after the coarse score, which are refined roughly, ...
REFINED = 20  # ... and after that
TURNED = 0.05  # rad, by which orientations differ that see nearly the same
HOPELESS = 0.5  # of the best score: what is below after rough refinement is not refined
PAIRS_IN_BATCH, BATCHES = 6, 10
PROBES = 100  # places by which two orientations are told apart
LEAST_SCORE, SURE_SCORE = 0.25, 0.5
LARGEST_RMS = (
    1.7  # sigma of a point, of an orientation that explains less than is sure; wrong ones leave 2 and more
)
SURE_RMS = 2.4  # likewise, of others: reversed before a distant object, they leave 2.7
CLEAR_SCORE, CLEAR_MARGIN = 0.3, 0.7  # the search ends when the best stands out so
CONFIRMED = 2  # after so many batches in a row
EQUAL_MARGIN, GIVEN_UP = 0.9, 3  # and when a second one is as good after so many
MARGIN = 0.8  # of the best score, that no other orientation may reach
PLACES = 160  # anywhere along the curves
SEPARATION = 0.15  # of the diagonal, of the two places of a hypothesis


@dataclass(frozen=True)
class SearchResult:
    """What a search has found: the best orientation, and how near the second one comes."""

    best: FittedOrientation | None
    second: float  # F of the best other one
    sigma: float  # of a measured point, mm

    @property
    def score(self) -> float:
        """F of the best one."""
        return 0.0 if self.best is None else self.best.score

    @property
    def explains(self) -> bool:
        """Whether the best one explains enough, and well."""
        if self.best is None or self.score < LEAST_SCORE:
            return False
        most = SURE_RMS if self.score > SURE_SCORE else LARGEST_RMS
        return self.best.rms_mm < most * self.sigma

    @property
    def stands_out(self) -> bool:
        """Whether there is no need to look farther."""
        return self.explains and self.score > CLEAR_SCORE and self.second < CLEAR_MARGIN * self.score

    @property
    def is_shared(self) -> bool:
        """Whether it is of no use to look farther."""
        return self.score > SURE_SCORE and self.second > EQUAL_MARGIN * self.score

    @property
    def unique(self) -> bool:
        """Whether no other comes near."""
        return self.best is not None and self.second < MARGIN * self.score


class ImageSearch:
    """The search in one image."""

    def __init__(
        self,
        chains: ImageChains,
        known: KnownCurves,
        ends: Places,
        prior: PriorFilter,
        tolerance: float,
        seed: int,
    ) -> None:
        self.chains, self.known, self.prior = chains, known, prior
        self._ends = ends
        self._rng = np.random.default_rng(seed)
        self._diagonal = float(np.linalg.norm(np.ptp(chains.xy, axis=0)))
        self.gate = max(GATE_SHARE * self._diagonal, 6.0 * chains.sigma)
        self._raster = ChainRaster(chains, ALONGSIDE * self.gate, tolerance)
        self._narrow = min(self.gate, max(self._raster.cell, SMALLEST_GATE * chains.sigma))
        self._coarse = CoarseScore(chains, known.samples(COARSE_SAMPLES), self._raster, self.gate)
        self._close = CoarseScore(chains, known.samples(FINE_SAMPLES), self._raster, self._narrow)
        self._samples = known.samples(ROUGH_SAMPLES)
        self._probes = known.samples(PROBES)
        self._refiner = Refiner(chains, known.samples(REFINING_SAMPLES), tolerance, REFINED_POINTS)
        self._found: list[FittedOrientation] = []

    def run(self) -> SearchResult:
        """Hypotheses from ends first, then from places anywhere, until one stands out."""
        confirmed = equal = 0
        for batch in self._batches():
            self._try(*batch)
            result = self.result()
            confirmed = confirmed + 1 if result.stands_out else 0
            equal = equal + 1 if result.is_shared else 0
            if confirmed == CONFIRMED or equal == GIVEN_UP:
                break
        return self.result()

    def result(self) -> SearchResult:
        """The best so far."""
        self._found.sort(key=lambda fitted: -fitted.score)
        best = self._found[0] if self._found else None
        others = [fitted.score for fitted in self._found[1:] if not self._same(fitted, self._found[0])]
        return SearchResult(best, max(others, default=0.0), self.chains.sigma)

    def _batches(self) -> Iterator[tuple[FloatArray, FloatArray]]:
        chains = self.chains
        points = self._points_of_chains()
        yield self._orientations(chains.ends, self._ends, _pairs_of_one_chain(chains.ends), directed=True)
        for _ in range(BATCHES):
            yield self._orientations(chains.ends, self._ends, self._image_pairs(chains.ends), directed=True)
            anywhere = self.known.samples(PLACES, self._rng.random())
            places = Places(anywhere.xyz, anywhere.tangent, anywhere.curve)
            yield self._orientations(points, places, self._image_pairs(points), directed=False)

    def _points_of_chains(self) -> ChainEnds:
        chains = self.chains
        rows = np.flatnonzero(np.isfinite(chains.direction).all(axis=1))
        weight = chains.length[rows] / chains.length[rows].sum()
        rows = self._rng.choice(rows, min(200, len(rows)), replace=False, p=weight)
        return ChainEnds(chains.xy[rows], chains.direction[rows], chains.chain[rows])

    def _orientations(
        self, at: ChainEnds, places: Places, pairs: list[tuple[int, int]], *, directed: bool
    ) -> tuple[FloatArray, FloatArray]:
        """Orientations of some pairs of image places with all pairs of curve places."""
        rays = at.rays(self.chains.principal_distance)
        first, second = (index.ravel() for index in np.indices((len(places), len(places))))
        apart = np.linalg.norm(places.xyz[first] - places.xyz[second], axis=1)
        distinct = apart > 1e-3 * apart.max(initial=0.0)
        first, second = first[distinct], second[distinct]
        image = [np.zeros((0, 2), dtype=np.int64)]
        object_ = [np.zeros((0, 2), dtype=np.int64)]
        for pair in pairs:
            of_one = (places.curve[first] == places.curve[second]) | (at.chain[pair[0]] != at.chain[pair[1]])
            object_.append(np.column_stack([first[of_one], second[of_one]]))
            image.append(np.broadcast_to(np.array(pair), object_[-1].shape))
        seen, shown = np.concatenate(image), np.concatenate(object_)
        solved = orient_from_point_tangents(
            rays[seen], at.direction[seen], places.xyz[shown], places.tangent[shown]
        )
        good = self.prior(solved.rotation, solved.position)
        if directed:
            good &= solved.same_sense.all(axis=1)
        return solved.rotation[good], solved.position[good]

    def _image_pairs(self, at: ChainEnds) -> list[tuple[int, int]]:
        """Random pairs of image places that lie apart."""
        pairs: list[tuple[int, int]] = []
        if len(at.xy) < 2:
            return pairs
        for _ in range(20 * PAIRS_IN_BATCH):
            a, b = self._rng.choice(len(at.xy), 2, replace=False)
            if np.linalg.norm(at.xy[a] - at.xy[b]) > SEPARATION * self._diagonal:
                pairs.append((int(a), int(b)))
            if len(pairs) == PAIRS_IN_BATCH:
                break
        return pairs

    def _try(self, rotation: FloatArray, position: FloatArray) -> None:
        """Score orientations, refine the best and keep those."""
        if not len(rotation):
            return
        rows = _largest(self._coarse(rotation, position), KEPT)
        rotation, position = roughly_refined(
            self.chains, self._samples, self._raster, rotation[rows], position[rows], self.gate, self._narrow
        )
        score = self._close(rotation, position)
        order = _largest(score, KEPT)
        order = order[score[order] > 0.0]
        gate = self._narrow
        for k in order[self._distinct(rotation[order], position[order], 0.5 * gate, REFINED)]:
            best = max((each.score for each in self._found), default=0.0)
            if score[k] <= HOPELESS * best:
                break
            fitted = self._refiner.refine(rotation[k], position[k], gate)
            if fitted is not None and self.prior(fitted.rotation[None], fitted.position[None])[0]:
                near = fitted.score > max(MARGIN * best, LEAST_SCORE)
                self._found.append(self._refiner.polish(fitted) if near else fitted)

    def _distinct(self, rotation: FloatArray, position: FloatArray, away: float, most: int) -> IntArray:
        """The first orientations that differ from those before, so many at most.

        They see the probes at other places (mm), or are turned: before distant objects the reversed orientation sees
        nearly the same.
        """
        seen = see(self.chains, self._probes, rotation, position)
        left = np.ones(len(position), dtype=bool)
        chosen: list[int] = []
        while left.any() and len(chosen) < most:
            chosen.append(int(np.argmax(left)))
            turn = np.linalg.norm(rotation - rotation[chosen[-1]], axis=(1, 2)) / np.sqrt(2.0)
            left &= (apart(seen, chosen[-1]) > away) | (turn > TURNED)
        return np.array(chosen, dtype=np.int64)

    def _same(self, a: FittedOrientation, b: FittedOrientation) -> bool:
        rotation, position = np.stack([a.rotation, b.rotation]), np.stack([a.position, b.position])
        return bool(apart(see(self.chains, self._probes, rotation, position), 0)[1] < 0.5 * self.gate)


def _pairs_of_one_chain(at: ChainEnds) -> list[tuple[int, int]]:
    """Both ends of every chain that has two."""
    rows = np.argsort(at.chain, kind="stable")
    same = np.flatnonzero(np.diff(at.chain[rows]) == 0)
    return [(int(rows[k]), int(rows[k + 1])) for k in same]


def _largest(values: FloatArray, count: int) -> IntArray:
    return np.argsort(-values, kind="stable")[:count]
