"""What does not change while labels and adjustments alternate, and the two steps that alternate."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.estimation.gauss_markov import Observer
from splinebba_cli.core.matching.known_curves.chain_directions import Traced
from splinebba_cli.core.matching.known_curves.label_round import LabelRound, label_points
from splinebba_cli.core.matching.known_curves.loop_network import Start, loop_start
from splinebba_cli.core.matching.known_curves.orientation_prior import orientation_prior
from splinebba_cli.core.matching.known_curves.round_adjustment import Round, adjust_round
from splinebba_cli.core.matching.known_curves.round_network import Labels, RoundNetwork
from splinebba_cli.core.matching.known_curves.uncertainty import Uncertainty
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray, Network
from splinebba_cli.core.state import Prepared, State, prepare

LARGEST_NOISE = 3.0  # times the stated sigma of points, to which residuals may widen the gate


@dataclass(frozen=True)
class Progress:
    """State, dispersions and labels at a moment."""

    state: State
    uncertainty: Uncertainty
    labels: Labels

    def after(self, solved: Round, caution: float) -> Progress:
        """With a solution; its variances times `caution`."""
        noise = solved.fit.noise
        uncertainty = replace(
            solved.uncertainty, noise_factor=min(noise, LARGEST_NOISE), inflation=noise**2 * caution
        )
        return Progress(solved.state, uncertainty, self.labels)


@dataclass(frozen=True)
class LoopContext:
    """Network, settings and start of the loop."""

    network: Network
    prepared: Prepared
    start: Start
    settings: MatchSettings
    oriented: BoolArray  # (n,) points that are not taken out, in images with an orientation
    blocked: BoolArray  # (m,) images whose orientation is too rough to match single points
    excluded: BoolArray  # (n,) points that the user has taken out
    first_scene: Scene  # curves and points at the start
    traced: Traced  # chains and directions of points in images with an orientation
    observer: Observer | None

    @classmethod
    def of(cls, network: Network, settings: MatchSettings, observer: Observer | None) -> LoopContext:
        """For a network."""
        prepared = prepare(network)
        distance = _object_distance(network)
        start = loop_start(network, prepared, orientation_prior(network, settings, distance))
        points = network.unlabelled
        excluded = np.zeros(len(points), dtype=bool) if points.excluded is None else points.excluded
        oriented = ~excluded & start.prior.known[points.image]
        blocked = np.zeros(len(network.images.ids), dtype=bool)
        scene = Scene.of(network, start.state, prepared)
        traced = Traced.of(scene, oriented)
        return cls(network, prepared, start, settings, oriented, blocked, excluded, scene, traced, observer)

    @property
    def usable(self) -> BoolArray:
        """Points that may get a label, (n,)."""
        return self.oriented & ~self.blocked[self.network.unlabelled.image]

    def begin(self) -> Progress:
        """Before anything is matched."""
        count = len(self.network.unlabelled)
        labels = Labels(np.full(count, -1), np.full(count, np.nan))
        uncertainty = Uncertainty(self.start.prior.dispersion, self.start.shape_sigma)
        return Progress(self.start.state, uncertainty, labels)

    def scene(self, state: State) -> Scene:
        """Curves and points at a state."""
        return self.first_scene.at(state)

    def label(self, progress: Progress, curves: BoolArray) -> LabelRound:
        """Labels at a state."""
        scene = self.scene(progress.state)
        return label_points(scene, self.traced, progress.uncertainty, self.settings, self.usable, curves)

    def taken(self, curve: IntArray, location: FloatArray, curves: BoolArray) -> tuple[Labels, BoolArray]:
        """Labels of curves that an adjustment can take, and these curves: known ones, others in two images.

        Parameters
        ----------
        curve, location : (n,) labels, -1: none
        curves : (nc,) of the stage
        """
        rows = np.flatnonzero(curve >= 0)
        given, images = self.start.network.curve_observations, len(self.network.images.ids)
        all_curves: IntArray = np.concatenate([given.curve, curve[rows]])
        all_images: IntArray = np.concatenate([given.image, self.network.unlabelled.image[rows]])
        seen = np.bincount(np.unique(all_curves * images + all_images) // images, minlength=len(curves))
        has_given = np.bincount(given.curve, minlength=len(curves)) > 0
        kept = (curves | has_given) & self.start.shaped & (self.start.known | (seen >= 2))
        stays = (curve >= 0) & np.append(kept, False)[curve]
        return Labels(np.where(stays, curve, -1), location), np.asarray(kept)

    def thinned(self, labels: Labels, most: int) -> Labels:
        """Labels with evenly chosen points of held curves, about so many of an image."""
        rows = labels.rows
        rows = rows[self.start.held[labels.curve[rows]]]
        image = self.network.unlabelled.image[rows]
        order = np.argsort(image, kind="stable")
        count = np.bincount(image, minlength=len(self.network.images.ids))
        number = np.arange(len(rows)) - np.repeat(np.cumsum(count) - count, count)
        every = np.maximum(-(-count // most), 1)
        dropped = rows[order][number % np.repeat(every, count) != 0]
        curve = labels.curve.copy()
        curve[dropped] = -1
        return Labels(curve, labels.location)

    def adjust(
        self, progress: Progress, kept: BoolArray, network: Network, iterations: int, *, robust: bool
    ) -> Round | None:
        """The adjustment with the labels of a moment; None where it has no solution."""
        problem = RoundNetwork(network, self.scene(progress.state), kept, iterations, self.observer)
        return adjust_round(problem, progress.state, progress.labels, progress.uncertainty, robust=robust)


def _object_distance(network: Network) -> FloatArray:
    """Distance of every image from the middle of what is known in the object, (m,) metres."""
    values = [curve.values[np.isfinite(curve.values).all(axis=1)][:1] for curve in network.curves]
    values.append(network.points.xyz[np.isfinite(network.points.xyz).all(axis=1)])
    known = np.vstack(values)
    if not len(known):
        return np.ones(len(network.images.ids))
    away = np.linalg.norm(network.images.position - np.median(known, axis=0), axis=1)
    return np.asarray(np.nan_to_num(away, nan=1.0))
