"""An orientation moved so that projected curves run along the chains: nearest curve, step, smaller gate, again."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from splinebba_cli.core.camera.rotation import rotation_from_vector
from splinebba_cli.core.matching.free_orientation.chains import ImageChains
from splinebba_cli.core.matching.free_orientation.places import CurveSamples
from splinebba_cli.core.matching.free_orientation.seen import across_design, see
from splinebba_cli.core.network import FloatArray, IntArray

SHRINK = 0.75  # of the gate from step to step
LAST_STEPS = 4  # with the smallest gate
SMALLEST_GATE = 4.0  # sigma of a point, or of the residuals where these are larger
JUDGING_GATE = 6.0  # sigma of a point: the same for all orientations, so that their scores compare
FEWEST = 12  # matched points
POLISHING_STEPS, SETTLED = 40, 0.05  # a step that is small, in standard deviations
POLISH_RMS = 4.0  # sigma of a point; larger residuals do not widen the gate
NEIGHBOURS = 4  # samples among which one of the right direction is looked for


@dataclass(frozen=True)
class FittedOrientation:
    """An orientation of one image, and how well known curves explain its chains under it."""

    rotation: FloatArray  # (3, 3) object from photo
    position: FloatArray  # (3,) metres
    score: float  # F, see score.py
    explained: float  # share of the length of all chains that follows a known curve
    rms_mm: float  # of the distances across
    points: int  # matched points
    dispersion: FloatArray  # (6, 6) of theta (photo frame, rad) and X0 (m), for the stated sigma of points

    @property
    def sigma(self) -> FloatArray:
        """Standard deviations of theta and X0, (6,)."""
        return np.asarray(np.sqrt(np.maximum(np.diag(self.dispersion), 0.0)))


@dataclass(frozen=True)
class _Matched:
    """Points of chains with the curve sample that each lies beside."""

    point: IntArray
    sample: IntArray
    normal: FloatArray  # (k, 2) across the projected curve
    distance: FloatArray  # (k,) across, projected minus measured, mm
    design: FloatArray  # (k, 6) of the distance


class Refiner:
    """Refinement of orientations of one image."""

    def __init__(
        self, chains: ImageChains, samples: CurveSamples, tolerance: float, most_points: int
    ) -> None:
        self.chains, self.samples = chains, samples
        self._cosine = np.cos(tolerance)
        usable = np.flatnonzero(np.isfinite(chains.direction).all(axis=1))
        stride = max(1, len(usable) // most_points)
        self._few = usable[::stride]
        self._all = usable

    def refine(self, rotation: FloatArray, position: FloatArray, gate: float) -> FittedOrientation | None:
        """From a rough orientation (3, 3), (3,) with a gate in mm; None where it leads nowhere."""
        smallest = SMALLEST_GATE * self.chains.sigma
        count = max(int(np.ceil(np.log(smallest / gate) / np.log(SHRINK))), 0) + LAST_STEPS
        for _ in range(count):
            moved = self._moved(rotation, position, gate, self._few)
            if moved is None:
                return None
            rotation, position, _, rms = moved
            gate = max(SHRINK * gate, smallest, min(gate, SMALLEST_GATE * rms))
        return self._judged(rotation, position)

    def polish(self, fitted: FittedOrientation) -> FittedOrientation:
        """Steps with all points and the smallest gate, until they are small against the standard deviations."""
        rotation, position = fitted.rotation, fitted.position
        gate = SMALLEST_GATE * max(self.chains.sigma, min(fitted.rms_mm, POLISH_RMS * self.chains.sigma))
        for _ in range(POLISHING_STEPS):
            moved = self._moved(rotation, position, gate, self._all)
            if moved is None:
                return fitted
            rotation, position, step, _ = moved
            if (np.abs(step) < SETTLED * fitted.sigma).all():
                break
        return self._judged(rotation, position) or fitted

    def _match(
        self, rotation: FloatArray, position: FloatArray, gate: float, points: IntArray
    ) -> _Matched | None:
        chains, samples = self.chains, self.samples
        seen = see(chains, samples, rotation[None], position[None])
        shown = np.flatnonzero(seen.inside[0])
        if len(shown) < FEWEST:
            return None
        xy, flow = seen.one(shown)
        half = 0.5 * np.linalg.norm(flow, axis=1) * samples.length[shown]
        unit = flow / np.linalg.norm(flow, axis=1, keepdims=True)
        reach = gate + float(np.quantile(half, 0.95))
        neighbours = min(NEIGHBOURS, len(shown))
        away, near = cKDTree(xy).query(
            chains.xy[points], k=np.arange(1, neighbours + 1), distance_upper_bound=reach
        )
        near = np.minimum(near, len(shown) - 1)
        offset = xy[near] - chains.xy[points, None]
        across = np.stack([-unit[:, 1], unit[:, 0]], axis=1)[near]
        distance = np.sum(offset * across, axis=2)
        along = np.abs(np.sum(offset * unit[near], axis=2))
        parallel = np.abs(np.sum(unit[near] * chains.direction[points, None], axis=2)) > self._cosine
        fits = (
            np.isfinite(away) & (np.abs(distance) < gate) & (along < 1.5 * half[near] + 0.5 * gate) & parallel
        )
        row = np.flatnonzero(fits.any(axis=1))
        if len(row) < FEWEST:
            return None
        first = np.argmax(fits[row], axis=1)
        chosen = near[row, first]
        normal = across[row, first]
        sample = shown[chosen]
        p = (samples.xyz[sample] - position) @ rotation
        design = across_design(chains.principal_distance, p, normal, rotation)
        return _Matched(points[row], sample, normal, distance[row, first], design)

    def _moved(
        self, rotation: FloatArray, position: FloatArray, gate: float, points: IntArray
    ) -> tuple[FloatArray, FloatArray, FloatArray, float] | None:
        """An orientation after one Gauss-Newton step, distances weighted down towards the gate (Tukey).

        With the step of theta and X0 and the spread of the distances; None where few points are matched.
        """
        matched = self._match(rotation, position, gate, points)
        if matched is None:
            return None
        weight = (1.0 - (matched.distance / gate) ** 2) ** 2
        scale = np.linalg.norm(matched.design, axis=0)
        scale = np.where(scale > 0.0, scale, 1.0)
        design = matched.design / scale * np.sqrt(weight)[:, None]
        step = np.linalg.lstsq(design, -np.sqrt(weight) * matched.distance, rcond=1e-6)[0] / scale
        spread = 1.4826 * float(np.median(np.abs(matched.distance)))
        return rotation @ rotation_from_vector(step[:3]), position + step[3:], step, spread

    def _judged(self, rotation: FloatArray, position: FloatArray) -> FittedOrientation | None:
        gate = JUDGING_GATE * self.chains.sigma
        matched = self._match(rotation, position, gate, self._all)
        if matched is None:
            return None
        chains, samples = self.chains, self.samples
        nearness = 1.0 - (matched.distance / gate) ** 2  # a point at the gate explains nothing
        seen = see(chains, samples, rotation[None], position[None])
        visible = float(
            np.sum(np.hypot(seen.along_x[0], seen.along_y[0]) * samples.length, where=seen.inside[0])
        )
        explained = min(float(chains.length[matched.point] @ nearness), visible)
        total = float(chains.length.sum())
        normal = matched.design.T @ matched.design / chains.sigma**2
        scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), 1e-300))
        cofactor = np.linalg.pinv(normal * scale * scale[:, None], rcond=1e-13) * scale * scale[:, None]
        return FittedOrientation(
            rotation=rotation,
            position=position,
            score=2.0 * explained / (visible + total),
            explained=float(chains.length[matched.point].sum()) / total,
            rms_mm=float(np.sqrt(np.mean(matched.distance**2))),
            points=len(matched.point),
            dispersion=cofactor,
        )
