"""How wrong measurements, given values and starts of a simulated project are."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.network import FloatArray


@dataclass(frozen=True)
class Noise:
    """Sizes of all errors that a realization draws; lengths in mm (photo) and m (object).

    Starts are wrong by independent errors, equally likely up to ± the given size; None keeps the approximate
    values that the project has.
    """

    image_mm: float | None = None  # standard deviation of measured photo coordinates; None: their declared σ
    start_position_m: float | None = (
        None  # largest error of an approximate coordinate of a perspective centre
    )
    start_angle_rad: float | None = None  # largest error of an approximate angle
    start_knots_m: float | None = None  # largest error of an approximate coordinate of a knot
    blunder_share: float = 0.0  # of the measured image points
    blunder_size: float = 20.0  # of a blunder, in σ of the measurement
    missing_point_share: float = 0.0  # of the measured image points that are dropped
    missing_pair_share: float = 0.0  # of the pairs of image and feature that are dropped
    given_values: bool | None = None  # whether control and priors have errors; None: unless image_mm is 0

    @property
    def draws_given_values(self) -> bool:
        """Whether control and priors get errors of their σ."""
        return self.image_mm != 0.0 if self.given_values is None else self.given_values

    @property
    def perturbs_orientations(self) -> bool:
        """Whether approximate orientations are drawn anew."""
        return self.start_position_m is not None or self.start_angle_rad is not None

    def with_starts(self, factor: float) -> Noise:
        """The same with the errors of all starts multiplied by a factor."""
        position, angle, knots = (
            None if size is None else factor * size
            for size in (self.start_position_m, self.start_angle_rad, self.start_knots_m)
        )
        return replace(self, start_position_m=position, start_angle_rad=angle, start_knots_m=knots)


def perturbed(values: FloatArray, largest: float, generator: np.random.Generator) -> FloatArray:
    """Values with independent errors, equally likely up to ± `largest`."""
    return np.asarray(values + largest * generator.uniform(-1.0, 1.0, values.shape))


def observed(true: FloatArray, sigma: FloatArray, generator: np.random.Generator | None) -> FloatArray:
    """True values with errors of the given standard deviations (0, inf: none); exact without a generator."""
    if generator is None:
        return true.copy()
    size = np.where(np.isfinite(sigma), sigma, 0.0)
    return np.asarray(true + size * generator.standard_normal(true.shape))
