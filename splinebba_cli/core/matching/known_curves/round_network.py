"""What a round adjusts: labels, the network with its priors, and which of its curves take part."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from splinebba_cli.core.approximation.control_network import known_curves
from splinebba_cli.core.estimation.gauss_markov import Observer
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray, Network


@dataclass(frozen=True)
class Labels:
    """Points that take part as measured points of curves; all arrays (n,)."""

    curve: IntArray  # -1: none
    location: FloatArray

    @property
    def rows(self) -> IntArray:
        """The points that have a label."""
        return np.flatnonzero(self.curve >= 0)


@dataclass(frozen=True)
class RoundNetwork:
    """A network with all its curves, of which a round adjusts some."""

    network: Network  # with priors (orientation_prior.py)
    scene: Scene  # of all curves at the state with which the round begins
    kept: BoolArray  # (nc,) curves that take part
    iterations: int
    observer: Observer | None = None

    @cached_property
    def held(self) -> BoolArray:
        """Curves (nc,) that are held and have no measurements but labels: their points are fixed points."""
        given = np.bincount(self.network.curve_observations.curve, minlength=len(self.kept)) > 0
        return known_curves(self.network) & ~given

    @cached_property
    def adjusted(self) -> BoolArray:
        """Curves (nc,) that take part as such."""
        return self.kept & ~self.held

    @property
    def coefficients(self) -> BoolArray:
        """Coefficients (C,) of adjusted curves."""
        return np.repeat(self.adjusted, np.diff(self.scene.curves.coefficient_start))
