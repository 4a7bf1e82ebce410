"""Results of all curves in columns, cut into the result of one curve when it is asked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
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

    @classmethod
    def of(cls, curves: Sequence[CurveResult]) -> CurveColumns:
        """The columns of results of curves; those that are columns already are not copied."""
        if isinstance(curves, cls):
            return curves
        segments = [curve.segments for curve in curves]
        return cls(
            value_bounds=_bounds([curve.values for curve in curves]),
            values=_stacked([curve.values for curve in curves], 3),
            values_dispersion=_stacked([curve.values_dispersion for curve in curves], 3, 3),
            reference=_stacked([curve.reference for curve in curves], 3),
            knot_bounds=_bounds([curve.knots for curve in curves]),
            knots=_stacked([curve.knots for curve in curves], 3),
            knot_parameters=_stacked([curve.knot_parameters for curve in curves]),
            knot_sigma=_stacked([curve.knot_sigma for curve in curves], 3),
            along_sigma=_stacked([curve.along_sigma for curve in curves]),
            segment_bounds=_bounds([each.interval for each in segments]),
            segments=SegmentCoefficients(
                _stacked([each.interval for each in segments], 2),
                _stacked([each.coefficients for each in segments], 4, 3),
                _stacked([each.sigma for each in segments], 4, 3),
            ),
            without_segments=frozenset(k for k, each in enumerate(segments) if not len(each.interval)),
            sample_bounds=_bounds([curve.sample_u for curve in curves]),
            sample_u=_stacked([curve.sample_u for curve in curves]),
            sample_xyz=_stacked([curve.sample_xyz for curve in curves], 3),
            sample_across=_stacked([curve.sample_across for curve in curves], 2),
            sample_across_direction=_stacked([curve.sample_across_direction for curve in curves], 3),
            sigma_across_max=np.array([curve.sigma_across_max for curve in curves], dtype=np.float64),
            sigma_across_mean=np.array([curve.sigma_across_mean for curve in curves], dtype=np.float64),
            rms_across_mm=np.array([curve.rms_across_mm for curve in curves], dtype=np.float64),
            n_observations=np.array([curve.n_observations for curve in curves], dtype=np.int64),
            n_images=np.array([curve.n_images for curve in curves], dtype=np.int64),
            conics={k: curve.conic for k, curve in enumerate(curves) if curve.conic is not None},
            ellipses={k: curve.ellipse for k, curve in enumerate(curves) if curve.ellipse is not None},
        )

    @cached_property
    def segment_counts(self) -> IntArray:
        """Number of segments with powers of every curve, (nc,)."""
        counts = np.diff(self.segment_bounds)
        counts[list(self.without_segments)] = 0
        return counts

    @cached_property
    def power_segments(self) -> SegmentCoefficients:
        """Segments of all curves that have powers, one curve after another."""
        every, counts = self.segments, np.diff(self.segment_bounds)
        if (self.segment_counts == counts).all():
            return every
        kept = np.repeat(self.segment_counts > 0, counts)
        return SegmentCoefficients(every.interval[kept], every.coefficients[kept], every.sigma[kept])

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


def _bounds(parts: list[FloatArray]) -> IntArray:
    return np.cumsum([0, *map(len, parts)], dtype=np.int64)


def _stacked(parts: list[FloatArray], *shape: int) -> FloatArray:
    return np.concatenate([np.zeros((0, *shape)), *parts])
