"""The chains of one image as a search for its orientation needs them: directions, weights, ends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import FloatArray, IntArray, Network
from splinebba_cli.core.state import image_rays

END_SHARE = 0.15  # of a chain, over which the direction at its end is taken
END_SIGMAS = 40.0  # of a point: length that is needed at least for a direction at an end
LOCAL_SIGMAS = 16.0  # of a point: length over which the direction at a point is taken
AT_BORDER = 0.01  # of the format: an end so near to it is where the picture ends, not the curve


@dataclass(frozen=True)
class ImageChains:
    """Unlabelled points of one image, corrected photo frame (mm)."""

    principal_distance: float
    format_mm: (
        FloatArray  # (2, 2) lower and upper corner of what the picture shows, corrected frame: all chains too
    )
    sigma: float  # of a point, mm
    xy: FloatArray  # (n, 2)
    direction: FloatArray  # (n, 2) unit, up to sense; NaN where unknown
    length: FloatArray  # (n,) mm of chain that a point stands for
    chain: IntArray  # (n,)
    ends: ChainEnds


@dataclass(frozen=True)
class ChainEnds:
    """Ends of chains inside the picture."""

    xy: FloatArray  # (e, 2) mm
    direction: FloatArray  # (e, 2) unit, into the chain
    chain: IntArray  # (e,)

    def rays(self, principal_distance: float) -> FloatArray:
        """Directions (x, y, -c), (e, 3)."""
        return np.column_stack([self.xy, np.full(len(self.xy), -principal_distance)])


def image_chains(network: Network, image: int) -> ImageChains | None:
    """The chains of an image; None where it has none of at least three points that lead somewhere."""
    points = network.unlabelled
    mine = (points.image == image) & (points.chain >= 0)
    if points.excluded is not None:
        mine &= ~points.excluded
    rows = np.flatnonzero(mine)
    rows = rows[np.argsort(points.chain[rows], kind="stable")]
    rays = image_rays(network, points.image[rows], points.photo_xy[rows], points.sigma[rows])
    parts_of = np.split(np.arange(len(rows)), _changes(points.chain[rows]))
    groups = [part for part in parts_of if len(part) >= 3 and np.ptp(rays.xy[part], axis=0).any()]
    if not groups:
        return None
    sigma = float(np.sqrt(np.mean(points.sigma[rows] ** 2)))
    camera = network.cameras[int(network.images.camera[image])]
    corners = _corners(rays.xy, camera.format_mm, camera.principal_point_mm)
    parts = [_directions(rays.xy[group], sigma) for group in groups]
    ends = [_ends(rays.xy[group], sigma) for group in groups]
    kept = np.concatenate(groups)
    xy = rays.xy[kept]
    numbers = points.chain[rows[[group[0] for group in groups]]]
    at = np.array([end[0] for pair in ends for end in pair])
    into = np.array([end[1] for pair in ends for end in pair])
    margin = AT_BORDER * np.abs(corners[1] - corners[0]).max()
    inside = ((at > corners[0] + margin) & (at < corners[1] - margin)).all(axis=1)
    if camera.format_mm is None:
        inside[:] = True
    inside &= np.isfinite(into).all(axis=1)
    return ImageChains(
        principal_distance=camera.principal_distance_mm,
        format_mm=np.stack([np.minimum(corners[0], xy.min(axis=0)), np.maximum(corners[1], xy.max(axis=0))]),
        sigma=sigma,
        xy=xy,
        direction=np.concatenate([part[0] for part in parts]),
        length=np.concatenate([part[1] for part in parts]),
        chain=points.chain[rows[kept]],
        ends=ChainEnds(at[inside], into[inside], np.repeat(numbers, 2)[inside]),
    )


def _changes(chain: IntArray) -> IntArray:
    return np.flatnonzero(np.diff(chain)) + 1


def _corners(
    xy: FloatArray, format_mm: tuple[float, float] | None, principal_point: FloatArray
) -> FloatArray:
    """What the picture shows: the format, else what the chains cover, (2, 2)."""
    if format_mm is None:
        return np.stack([xy.min(axis=0), xy.max(axis=0)])
    half = 0.5 * np.asarray(format_mm)
    return np.stack([-half, half]) - principal_point


def _directions(xy: FloatArray, sigma: float) -> tuple[FloatArray, FloatArray]:
    """Unit directions of a chain at its points, and the length that each stands for."""
    step = np.linalg.norm(np.diff(xy, axis=0), axis=1)
    place = np.concatenate([[0.0], np.cumsum(step)])
    half = max(0.5 * LOCAL_SIGMAS * sigma, 1.5 * place[-1] / (len(xy) - 1))
    low = np.searchsorted(place, place - half)
    high = np.searchsorted(place, place + half, side="right")
    sums = np.vstack([np.zeros(5), np.cumsum(_moments(xy - xy.mean(axis=0)), axis=0)])
    count = (high - low)[:, None]
    x, y, xx, xy_, yy = ((sums[high] - sums[low]) / count).T
    angle = 0.5 * np.arctan2(2.0 * (xy_ - x * y), (xx - x * x) - (yy - y * y))
    length = 0.5 * (np.concatenate([[0.0], step]) + np.concatenate([step, [0.0]]))
    direction = np.column_stack([np.cos(angle), np.sin(angle)])
    direction[count[:, 0] < 2] = np.nan
    return direction, length


def _moments(xy: FloatArray) -> FloatArray:
    x, y = xy.T
    return np.column_stack([x, y, x * x, x * y, y * y])


def _ends(xy: FloatArray, sigma: float) -> list[tuple[FloatArray, FloatArray]]:
    """Both ends of a chain: place, and unit direction into the chain (NaN where it is too short to tell)."""
    return [_end(xy, sigma), _end(xy[::-1], sigma)]


def _end(xy: FloatArray, sigma: float) -> tuple[FloatArray, FloatArray]:
    """A quadratic through the points next to the first one."""
    place = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(xy, axis=0), axis=1))])
    reach = max(END_SHARE * place[-1], END_SIGMAS * sigma)
    near = place <= reach
    if place[-1] < 0.5 * END_SIGMAS * sigma or np.count_nonzero(near) < 3:
        return xy[0], np.full(2, np.nan)
    # along the chord of these points: cumulated steps are lengthened by noise
    chord = xy[near][-1] - xy[0]
    along = (xy[near] - xy[0]) @ chord / np.linalg.norm(chord)
    degree = 2 if np.count_nonzero(near) >= 6 else 1
    fit = np.polynomial.polynomial.polyfit(along / reach, xy[near], degree)
    return fit[0], fit[1] / np.linalg.norm(fit[1])
