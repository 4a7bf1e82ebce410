"""What is known of an orientation beforehand: single coordinates or angles with their standard deviations."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.camera.rotation import angles_from_rotation
from splinebba_cli.core.network import BoolArray, FloatArray, Network, RotationSequence

WIDTH = 5.0  # standard deviations


class PriorFilter:
    """Which orientations agree with the prior of an image, in those elements that it has."""

    def __init__(self, prior: FloatArray, sigma: FloatArray, sequence: RotationSequence) -> None:
        known = np.isfinite(prior) & np.isfinite(sigma)
        self._angles, self._coordinates = np.flatnonzero(known[:3]), np.flatnonzero(known[3:])
        self._prior, self._sigma, self._sequence = prior, np.maximum(sigma, 1e-12), sequence

    @classmethod
    def of(cls, network: Network, image: int) -> PriorFilter:
        """Of an image of a network."""
        images = network.images
        return cls(images.prior[image], images.prior_sigma[image], images.sequence[image])

    def __call__(self, rotation: FloatArray, position: FloatArray) -> BoolArray:
        """(s, 3, 3), (s, 3) -> (s,)."""
        good = np.ones(len(rotation), dtype=bool)
        if len(self._coordinates):
            place = 3 + self._coordinates
            away = np.abs(position[:, self._coordinates] - self._prior[place]) / self._sigma[place]
            good &= (away < WIDTH).all(axis=1)
        if len(self._angles) and len(rotation):
            angle = angles_from_rotation(rotation, self._sequence)[:, self._angles]
            away = np.abs(np.angle(np.exp(1j * (angle - self._prior[self._angles]))))
            good &= (away / self._sigma[self._angles] < WIDTH).all(axis=1)
        return good
