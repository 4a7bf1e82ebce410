"""What every image shows of the chains: the rectangle of its measurements, a little larger."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.matching.fragments.traced_chains import TracedChains
from splinebba_cli.core.matching.fragments.views import Views
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

MARGIN = 0.02  # of the longer side of measurements


@dataclass(frozen=True)
class Frames:
    """Rectangles in the corrected photo frames that hold all chain points, (m, 2) mm each."""

    low: FloatArray
    high: FloatArray

    @classmethod
    def of(cls, views: Views, chains: TracedChains) -> Frames:
        """The rectangles of the chains; images without chains show nothing."""
        low = np.full((len(views.position), 2), np.inf)
        high = np.full((len(views.position), 2), -np.inf)
        np.minimum.at(low, chains.image, chains.xy)
        np.maximum.at(high, chains.image, chains.xy)
        margin = MARGIN * np.where(high > low, high - low, 0.0).max(axis=1, keepdims=True)
        return cls(low - margin, high + margin)

    def shows(self, views: Views, image: IntArray, xyz: FloatArray) -> BoolArray:
        """Whether images show object points, (n,)."""
        xy = views.project(image, xyz)
        with np.errstate(invalid="ignore"):
            return np.asarray(((xy >= self.low[image]) & (xy <= self.high[image])).all(axis=1))
