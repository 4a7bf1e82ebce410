"""Results of all curves in columns, cut into the result of one curve when it is asked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import overload

import numpy as np

from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.result import ConicElements, CurveResult, Ellipse, SegmentCoefficients

NO_SEGMENTS = SegmentCoefficients(np.zeros((0, 2)), np.zeros((0, 4, 3)), np.zeros((0, 4, 3)))


@dataclass(frozen=True, eq=False)
class CurveColumns(Sequence[CurveResult]):
    """Columns as those of :class:`CurveResult`; bounds (nc + 1,) say which rows belong to a curve."""

    value_bounds: IntArray
    values: FloatArray
    values_dispersion: FloatArray
    reference: FloatArray
    knot_bounds: IntArray
    knots: FloatArray
    knot_parameters: FloatArray
    knot_sigma: FloatArray
    along_sigma: FloatArray
    segment_bounds: IntArray
    segments: SegmentCoefficients
    without_segments: frozenset[int]  # curves whose segments are not powers
    sample_bounds: IntArray
    sample_u: FloatArray
    sample_xyz: FloatArray
    sample_across: FloatArray
    sample_across_direction: FloatArray
    sigma_across_max: FloatArray  # (nc,)
    sigma_across_mean: FloatArray  # (nc,)
    rms_across_mm: FloatArray  # (nc,)
    n_observations: IntArray  # (nc,)
    n_images: IntArray  # (nc,)
    conics: Mapping[int, ConicElements]
    ellipses: Mapping[int, Ellipse]

    def __len__(self) -> int:
        return len(self.n_images)

    @overload
    def __getitem__(self, number: int) -> CurveResult: ...

    @overload
    def __getitem__(self, number: slice) -> tuple[CurveResult, ...]: ...

    def __getitem__(self, number: int | slice) -> CurveResult | tuple[CurveResult, ...]:
        if isinstance(number, slice):
            return tuple(self._one(k) for k in range(*number.indices(len(self))))
        if not -len(self) <= number < len(self):
            raise IndexError(f"curve {number} of {len(self)}")
        return self._one(int(number) % len(self))

    def _one(self, k: int) -> CurveResult:
        values, knots, samples = (
            slice(int(bounds[k]), int(bounds[k + 1]))
            for bounds in (self.value_bounds, self.knot_bounds, self.sample_bounds)
        )
        return CurveResult(
            values=self.values[values],
            values_dispersion=self.values_dispersion[values],
            knots=self.knots[knots],
            knot_parameters=self.knot_parameters[knots],
            knot_sigma=self.knot_sigma[knots],
            reference=self.reference[values],
            segments=self._segments(k),
            sample_u=self.sample_u[samples],
            sample_xyz=self.sample_xyz[samples],
            sample_across=self.sample_across[samples],
            sample_across_direction=self.sample_across_direction[samples],
            sigma_across_max=float(self.sigma_across_max[k]),
            sigma_across_mean=float(self.sigma_across_mean[k]),
            rms_across_mm=float(self.rms_across_mm[k]),
            n_observations=int(self.n_observations[k]),
            n_images=int(self.n_images[k]),
            along_sigma=self.along_sigma[knots],
            conic=self.conics.get(k),
            ellipse=self.ellipses.get(k),
        )

    def _segments(self, k: int) -> SegmentCoefficients:
        if k in self.without_segments:
            return NO_SEGMENTS
        rows = slice(int(self.segment_bounds[k]), int(self.segment_bounds[k + 1]))
        every = self.segments
        return SegmentCoefficients(every.interval[rows], every.coefficients[rows], every.sigma[rows])


def samples_across(curves: Sequence[CurveResult]) -> tuple[FloatArray, IntArray]:
    """Lateral semi-axes (p, 2) at the samples of all curves, one after another, and their bounds (nc + 1,)."""
    if isinstance(curves, CurveColumns):
        return curves.sample_across, curves.sample_bounds
    bounds = np.cumsum([0, *(len(curve.sample_across) for curve in curves)], dtype=np.int64)
    return np.concatenate([np.zeros((0, 2)), *(curve.sample_across for curve in curves)]), bounds
