"""Where an image may look inside the range of its prior: votes for the shift between points and projected curves.

Errors of an orientation move all curves of an image together.  With J = d xy / d(theta, X0) of the samples and the
prior dispersion S, the mean shift has the dispersion J_m S J_m', J_m the mean of J.  Every pair of a point and a
sample that run the same way votes for the shift between them; where curves of several directions agree, votes pile up.
What remains when the shift is known,

    S_r = S - S J_m' (J_m S J_m')^-1 J_m S,

turns and scales the image; its largest directions (those that move samples by more than a cell) are tried on a grid.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.ndimage import gaussian_filter, maximum_filter

from splinebba_cli.core.matching.known_curves.curve_samples import SeenSamples
from splinebba_cli.core.matching.known_curves.image_view import ImageView
from splinebba_cli.core.matching.known_curves.search_effort import Effort
from splinebba_cli.core.network import FloatArray

FINEST = 4.0  # sigma of a point: the smallest cell
CELLS = 100  # of the window, across
SHIFTS = 8  # places of a grid of one shape
COARSER = 1.2
PAIRS = 300_000
FEWEST_SAMPLES = 4


@dataclass(frozen=True)
class ShiftWindow:
    """Range of the shift of an image, and the cells of its search."""

    dispersion: FloatArray  # (6, 6) prior
    mean_jacobian: FloatArray  # (2, 6)
    half: FloatArray  # (2,) mm
    cell: float  # mm
    root: FloatArray  # (6, 6) of what remains when the shift is known
    size: FloatArray  # (6,) mm, of its modes at one standard deviation, root mean square over the samples
    modes: FloatArray  # (6, 6) one a row
    reach: float  # standard deviations of a mode that are tried

    @classmethod
    def of(
        cls, seen: SeenSamples, dispersion: FloatArray, sigma: float, effort: Effort
    ) -> ShiftWindow | None:
        """Around the present projections; None where nothing is seen."""
        jacobian = seen.orientation[np.isfinite(seen.xy).all(axis=1)]
        if len(jacobian) < FEWEST_SAMPLES:
            return None
        mean = jacobian.mean(axis=0)
        half = effort.shift_reach * np.sqrt(np.maximum(np.diag(mean @ dispersion @ mean.T), 0.0))
        cell = max(FINEST * sigma, 2.0 * float(half.max()) / CELLS)
        root, size, modes = _shape_modes(jacobian, mean, dispersion)
        while _number(size, cell, effort.shape_reach) > effort.shapes:
            cell *= COARSER
        return cls(dispersion, mean, half, cell, root, size, modes, effort.shape_reach)

    def step_for(self, shift: FloatArray) -> FloatArray:
        """Most probable step (6,) of an orientation that moves all curves by a shift (2,)."""
        cross = self.dispersion @ self.mean_jacobian.T
        return np.asarray(cross @ np.linalg.lstsq(self.mean_jacobian @ cross, shift, rcond=1e-9)[0])

    def shapes(self) -> Iterator[FloatArray]:
        """Steps (6,) that turn and scale the image, on a grid inside the prior; the first one is none."""
        for amounts in product(*(_grid(float(s), self.cell, self.reach) for s in self.size)):
            yield self.root @ (np.array(amounts) @ self.modes)


def _shape_modes(
    jacobian: FloatArray, mean: FloatArray, dispersion: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Root of S_r, and the modes in which it moves samples: their sizes (6,) mm and directions (6, 6)."""
    cross = dispersion @ mean.T
    rest = dispersion - cross @ np.linalg.pinv(mean @ cross, rcond=1e-9) @ cross.T
    value, vector = np.linalg.eigh(0.5 * (rest + rest.T))
    root = vector * np.sqrt(np.maximum(value, 0.0))
    moves = np.einsum("nij,jk->nik", jacobian, root).reshape(-1, 6)
    _, size, modes = np.linalg.svd(moves / np.sqrt(len(jacobian)), full_matrices=False)
    return root, size, modes


def _number(size: FloatArray, cell: float, reach: float) -> int:
    return int(np.prod([len(_grid(float(s), cell, reach)) for s in size]))


def _grid(size: float, cell: float, reach: float) -> FloatArray:
    """Amounts of a mode that moves samples by `size` at one standard deviation, 0 first."""
    count = int(np.ceil(reach * size / (2.0 * cell) - 0.5))
    steps = np.linspace(-reach, reach, 2 * count + 1) if count > 0 else np.zeros(1)
    return steps[np.argsort(np.abs(steps), kind="stable")]


def likely_shifts(
    view: ImageView, seen: SeenSamples, window: ShiftWindow, generator: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Shifts (k, 2) of the projected curves with the most votes, mm, and their votes (k,)."""
    visible = np.flatnonzero(np.isfinite(seen.xy).all(axis=1))
    low, high = view.xy.min(axis=0) - window.half, view.xy.max(axis=0) + window.half
    visible = visible[((seen.xy[visible] >= low) & (seen.xy[visible] <= high)).all(axis=1)]
    share = np.sqrt(min(1.0, PAIRS / max(len(visible) * len(view.xy), 1)))
    points = _thinned(len(view.xy), share, generator)
    visible = visible[_thinned(len(visible), share, generator)]
    size = np.ceil(window.half / window.cell).astype(np.int64)
    shape = 2 * size + 1
    # one coordinate after the other: arrays of pairs are large, and a last axis of two is slow
    column, row = (
        np.rint(np.subtract.outer(view.xy[points, k], seen.xy[visible, k]) / window.cell).astype(np.int32)
        + size[k]
        for k in (0, 1)
    )
    inside = (column >= 0) & (column < shape[0]) & (row >= 0) & (row < shape[1])
    angle = view.angle[points]
    if np.isfinite(angle).any():
        along = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        sine = np.abs(along[:, :1] * seen.direction[visible, 1] - along[:, 1:] * seen.direction[visible, 0])
        inside &= np.isnan(angle)[:, None] | (sine <= np.sin(view.direction_tolerance))
    flat = column[inside] * shape[1] + row[inside]
    votes = np.bincount(flat, minlength=int(shape.prod())).astype(float).reshape(shape)
    votes = gaussian_filter(votes, 1.0, mode="constant")
    peaks = np.flatnonzero(((votes == maximum_filter(votes, 5)) & (votes > 0.0)).ravel())
    best = peaks[np.argsort(-votes.ravel()[peaks], kind="stable")[:SHIFTS]]
    cells = np.column_stack(np.unravel_index(best, tuple(shape))) - size
    return np.asarray(cells * window.cell), np.asarray(votes.ravel()[best] / max(share, 1e-9) ** 2)


def _thinned(count: int, share: float, generator: np.random.Generator) -> np.ndarray:
    """A share of the numbers below `count`, ascending."""
    if share >= 1.0:
        return np.arange(count)
    return np.sort(generator.choice(count, max(1, int(share * count)), replace=False))
