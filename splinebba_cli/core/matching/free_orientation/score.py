"""How well orientations explain the chains of an image by the known curves: cheaply, for many at once.

    F = 2 h / (v + l)

h is the length in the image of projected curves that run along a chain, v that of all projected curves inside the
picture, l that of all chains.  A camera so far away that everything shrinks onto one chain has a small h; one that sees
a single curve of many has a small h against l; one that covers the picture with curves has a large v.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.matching.free_orientation.chain_raster import ChainRaster
from splinebba_cli.core.matching.free_orientation.chains import ImageChains
from splinebba_cli.core.matching.free_orientation.places import CurveSamples
from splinebba_cli.core.matching.free_orientation.seen import see
from splinebba_cli.core.network import FloatArray

TOGETHER = 15_000  # samples that are judged together: arrays that stay in the cache


class CoarseScore:
    """F by a raster of the picture."""

    def __init__(self, chains: ImageChains, samples: CurveSamples, raster: ChainRaster, gate: float) -> None:
        self._chains, self._samples, self._raster, self._gate = chains, samples, raster, gate
        self._total = float(chains.length.sum())

    def __call__(self, rotation: FloatArray, position: FloatArray) -> FloatArray:
        """F of orientations (s, 3, 3), (s, 3): (s,)."""
        step = max(TOGETHER // max(len(self._samples.length), 1), 1)
        parts = [
            self._score(rotation[k : k + step], position[k : k + step]) for k in range(0, len(rotation), step)
        ]
        return np.concatenate([np.zeros(0), *parts])

    def _score(self, rotation: FloatArray, position: FloatArray) -> FloatArray:
        beside = self._raster.beside(
            see(self._chains, self._samples, rotation, position), np.full(len(rotation), self._gate)
        )
        length = beside.speed * self._samples.length[beside.sample]
        explained = np.bincount(beside.pose, length * beside.hit, minlength=len(rotation))
        visible = np.bincount(beside.pose, length, minlength=len(rotation))
        return np.asarray(2.0 * np.minimum(explained, self._total) / (visible + self._total))
