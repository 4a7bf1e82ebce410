"""Orientation of one image by the curves that it sees, from a rough one: several starts, a shrinking scale, a verdict.

From every start the robust cost

    sum rho(d_i / s_i) + (x - x0)' S^-1 (x - x0)

is made least, d_i the distance of a point across the nearest sample that runs the same way, s_i its standard deviation
(of the point and of the shape), rho the function of Geman and McClure (1987), whose scale shrinks from the size of the
cells of the search down to the noise.  Poses are compared by the sum of

    max(0, ln(range / (s_i sqrt(2 pi))) - (d_i / s_i)^2 / 2),

the gain of likelihood against a point that lies anywhere inside the range.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.matching.known_curves.image_view import ImageView, Nearest, Pose, nearest_samples
from splinebba_cli.core.matching.known_curves.search_effort import Effort
from splinebba_cli.core.matching.known_curves.shift_search import ShiftWindow, likely_shifts
from splinebba_cli.core.network import FloatArray

STEPS = 40
SHRINKING = 0.7
LAST_SCALE = 2.5  # sigma
SAME = 3.0  # sigma of a point and the shape: mean distance of the projections of two poses that are one
CLEAR_GAIN = 10.0
CLEAR_SHARE = 0.1  # of the gain of the best, by which the next one must be worse
FEWEST, LEAST_SHARE = 12, 0.3  # points that must follow curves, and share of those that should
SETTLED = 0.02  # sigma, of a step in the photo


@dataclass(frozen=True)
class Alignment:
    """Where an image looks."""

    pose: Pose
    dispersion: FloatArray  # (6, 6) of theta, X0, with the prior
    gain: float
    runner_up: float  # gain of the best other pose, 0 where there is none
    inliers: int
    points: int  # that took part
    needed: float  # points that must follow curves
    scale: float  # robust standard deviation of whitened distances

    @property
    def enough(self) -> bool:
        """Whether enough points follow curves."""
        return self.inliers >= self.needed

    @property
    def clear(self) -> bool:
        """Whether enough points follow curves, and no other pose is nearly as good."""
        return self.enough and self.gain - self.runner_up > max(CLEAR_GAIN, CLEAR_SHARE * self.gain)


def align_image(
    view: ImageView, dispersion: FloatArray, generator: np.random.Generator, effort: Effort,
    found: tuple[Pose, ...] = (),
) -> Alignment | None:  # fmt: skip
    """The best pose inside a prior; None where nothing is seen.

    Parameters
    ----------
    dispersion : (6, 6) of theta, X0, about the start of the view
    found : good poses, that the best one is compared with in any case
    """
    start = view.start
    seen = view.seen(start)
    sigma = float(np.median(view.sigma)) if len(view.sigma) else 0.0
    window = ShiftWindow.of(seen, dispersion, sigma, effort)
    if window is None or not len(view.xy):
        return None
    poses = _starts(view, start, window, generator, effort.starts)
    span = max(float(np.linalg.norm(window.half)), 10.0 * sigma)
    gains = [_gain(view, pose, span, window.cell) for pose in poses]
    best = np.argsort(-np.array(gains), kind="stable")
    chosen = list(found)
    for number in best.tolist():
        if len(chosen) >= effort.refined:
            break
        if all(_apart(view, poses[number], other) > window.cell for other in chosen):
            chosen.append(poses[number])
    begin = [0.0] * len(found) + [2.0 * window.cell] * (len(chosen) - len(found))
    refined = [_refined(view, *each, start, dispersion) for each in zip(chosen, begin, strict=True)]
    return _decided(view, refined, span, dispersion)


def _starts(
    view: ImageView, start: Pose, window: ShiftWindow, generator: np.random.Generator, count: int
) -> list[Pose]:
    """The prior itself and the poses with most votes."""
    found: list[tuple[float, Pose]] = []
    for shape in window.shapes():
        turned = start.moved(shape)
        shifts, votes = likely_shifts(view, view.seen(turned), window, generator)
        found += [
            (float(vote), turned.moved(window.step_for(shift)))
            for shift, vote in zip(shifts, votes, strict=True)
        ]
    found.sort(key=lambda each: -each[0])
    return [start, *(pose for _, pose in found[:count])]


def _scales(view: ImageView, pose: Pose, near: Nearest) -> FloatArray:
    """Standard deviation of distances across, (k,) mm."""
    depth = np.linalg.norm(view.samples.xyz[near.sample] - pose.position, axis=1)
    shape = view.shape_sigma[near.sample] * view.principal_distance / np.maximum(depth, 1e-12)
    return np.asarray(np.hypot(view.sigma[near.point], shape))


def _gain(view: ImageView, pose: Pose, span: float, blur: float) -> float:
    """Gain of likelihood of a pose that is known to about `blur` (mm)."""
    near = nearest_samples(view, view.seen(pose), 4.0 * blur + view.samples.spacing)
    scale = np.hypot(_scales(view, pose, near), 0.5 * blur)
    return _gain_of(near.across, scale, span)


def _gain_of(across: FloatArray, scale: FloatArray, span: float) -> float:
    floor = np.log(np.maximum(span / (scale * np.sqrt(2.0 * np.pi)), 1.0))
    return float(np.maximum(floor - 0.5 * (across / scale) ** 2, 0.0).sum())


def _apart(view: ImageView, first: Pose, second: Pose) -> float:
    """Root mean square distance of the samples as two poses see them, mm."""
    difference = view.seen(first).xy - view.seen(second).xy
    square = np.sum(difference**2, axis=1)
    square = square[np.isfinite(square)]
    return float(np.sqrt(square.mean())) if len(square) else np.inf


@dataclass(frozen=True)
class _Refined:
    pose: Pose
    normal: FloatArray  # (6, 6) of the measurements
    scale: float


def _refined(view: ImageView, pose: Pose, begin: float, prior: Pose, dispersion: FloatArray) -> _Refined:
    """A pose improved with a scale that shrinks from `begin` (mm)."""
    sigma = float(np.median(view.sigma))
    weight = np.linalg.pinv(dispersion, rcond=1e-12, hermitian=True)
    move = dispersion @ weight  # nothing moves where the prior is fixed
    scale = max(begin / sigma, LAST_SCALE)
    normal, spread = np.zeros((6, 6)), np.inf
    for _ in range(STEPS):
        seen = view.seen(pose)
        near = nearest_samples(view, seen, 3.0 * scale * sigma + 2.0 * _sample_step(view, pose))
        if len(near.point) < 2:
            break
        deviation = _scales(view, pose, near)
        r = near.across / deviation
        p = 1.0 / (1.0 + (r / scale) ** 2) ** 2
        g = np.einsum("ki,kij->kj", near.normal, seen.orientation[near.sample]) / deviation[:, None]
        normal = (g * p[:, None]).T @ g
        off = _difference(prior, pose)
        step = move @ np.linalg.lstsq(normal + weight, -(g.T @ (p * r)) - weight @ off, rcond=1e-12)[0]
        pose = pose.moved(step)
        moved = float(np.sqrt(np.mean((g @ step) ** 2)))
        spread = 1.4826 * float(np.median(np.abs(r)))
        last = max(LAST_SCALE, 1.5 * min(spread, scale / 3.0))
        if scale <= last * 1.01 and moved < SETTLED:
            break
        scale = max(last, SHRINKING * scale)
    return _Refined(pose, normal, spread)


def _sample_step(view: ImageView, pose: Pose) -> float:
    """Spacing of the samples in the photo, mm."""
    depth = np.median(np.linalg.norm(view.samples.xyz - pose.position, axis=1))
    return float(view.samples.spacing * view.principal_distance / max(float(depth), 1e-12))


def _difference(prior: Pose, pose: Pose) -> FloatArray:
    """Step (6,) that leads from the prior to a pose."""
    turn = prior.rotation.T @ pose.rotation
    vector = 0.5 * np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    return np.concatenate([vector, pose.position - prior.position])


def _decided(view: ImageView, refined: list[_Refined], span: float, dispersion: FloatArray) -> Alignment:
    """The best pose, its dispersion, and the best other one."""
    sigma = float(np.median(view.sigma))
    gains, usual = [], sigma
    for each in refined:
        near = nearest_samples(view, view.seen(each.pose), 4.0 * sigma + 2.0 * _sample_step(view, each.pose))
        scale = _scales(view, each.pose, near)
        usual = max(usual, float(np.median(scale))) if len(scale) else usual
        gains.append((_gain_of(near.across, scale, span), int((np.abs(near.across) < 3.0 * scale).sum())))
    order = sorted(range(len(refined)), key=lambda k: -gains[k][0])
    best = refined[order[0]]
    others = [gains[k][0] for k in order[1:] if _apart(view, best.pose, refined[k].pose) > SAME * usual]
    return Alignment(
        pose=best.pose,
        dispersion=_posterior(best, dispersion),
        gain=gains[order[0]][0],
        runner_up=max(others, default=0.0),
        inliers=gains[order[0]][1],
        points=len(view.xy),
        needed=max(FEWEST, LEAST_SHARE * (1.0 - view.wrong_share) * len(view.xy)),
        scale=best.scale,
    )


def _posterior(found: _Refined, prior: FloatArray) -> FloatArray:
    """Dispersion (6, 6) after the measurements: (N + S^-1)^-1, written so that S may be singular."""
    noise = max(1.0, found.scale) if np.isfinite(found.scale) else 1.0
    return np.asarray(prior @ np.linalg.inv(np.eye(6) + found.normal @ prior / noise**2))
