"""Cubic segments and measured points of the difficult kinds, and what dense sampling finds.

Loops, segments with a cusp or nearly one, straight ones that run back, tiny ones, and any of these partly behind the
camera or from a tenth of a metre to a kilometre away; points on the curve, at its end, near it and far from it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import FloatArray

C = 150.0
POWERS_OF_BEZIER = np.array([[1.0, 0, 0, 0], [-3, 3, 0, 0], [3, -6, 3, 0], [-1, 3, -3, 1]])


@dataclass(frozen=True)
class FootPointCases:
    """Segments in the photo frame, powers of t of (u, v, -w), metres, and points."""

    powers: FloatArray  # (k, 4, 3)
    xy: FloatArray  # (k, 2) mm
    whitening: FloatArray  # (k, 2, 2)

    @property
    def seen(self) -> FloatArray:
        """(c u, c v, -w), (k, 4, 3)."""
        return self.powers * np.array([C, C, 1.0])

    @property
    def direction(self) -> FloatArray:
        """Of the rays of the points, in this frame, (k, 3)."""
        return np.column_stack([self.xy, np.full(len(self.xy), C)])


def random_cases(generator: np.random.Generator, count: int) -> FootPointCases:
    """Cases of all kinds."""
    g, kind = generator, generator.integers(0, 8, count)
    b = (
        g.normal(size=(count, 4, 3))
        * np.array([60.0, 60.0, 20.0])
        * 10.0 ** g.uniform(-3.0, 0.5, (count, 1, 1))
    )
    own = kind == 1  # tiny
    b[own] = b[own][:, :1] + (b[own] - b[own][:, :1]) * 10.0 ** g.uniform(-6.0, -1.0, (own.sum(), 1, 1))
    own = kind == 2  # straight, also running back
    part = g.uniform(-0.5, 1.5, (own.sum(), 4, 1))
    part[:, 0], part[:, 3] = 0.0, 1.0
    b[own] = b[own][:, :1] + part * (b[own][:, 3:] - b[own][:, :1])
    own = kind == 3  # nearly a cusp: the polygon crosses itself
    b[own, 1] = b[own, 3] + g.normal(size=(own.sum(), 3)) * 1e-3
    b[own, 2] = b[own, 0] + g.normal(size=(own.sum(), 3)) * 1e-3
    own = kind == 4  # a cusp: control points at corners of a parallelogram, crosswise
    first, second = b[own, 1] - b[own, 0], b[own, 2] - b[own, 0]
    b[own, 1:] = b[own][:, :1] + np.stack([first + second, second, first], axis=1)
    b[:, :, 2] += 10.0 ** g.uniform(-1.0, 3.0, count)[:, None]
    powers = np.einsum("ij,kjc->kic", POWERS_OF_BEZIER, b)
    at = np.einsum("ki,kic->kc", g.uniform(0.0, 1.0, count)[:, None] ** np.arange(4), powers)
    xy = C * at[:, :2] / np.abs(at[:, 2:]) + g.normal(size=(count, 2)) * 10.0 ** g.uniform(
        -6.0, 2.0, (count, 1)
    )
    own = kind == 5  # the end itself
    xy[own] = C * b[own, 0, :2] / b[own, 0, 2:]
    return FootPointCases(powers, xy, g.normal(size=(count, 2, 2)) + 2.0 * np.eye(2))


def sampled_in_photo(cases: FootPointCases, samples: int, whitened: str) -> FloatArray:
    """Least distance of samples in front of the camera, (k,) mm or sigma; inf where there are none."""
    table, out = _table(samples), np.empty(len(cases.xy))
    for k, (a, xy) in enumerate(zip(cases.seen, cases.xy, strict=True)):
        x, y, depth = a.T @ table
        with np.errstate(all="ignore"):
            x, y = x / depth - xy[0], y / depth - xy[1]
            if whitened == "sigma":
                w = cases.whitening[k]
                x, y = w[0, 0] * x + w[0, 1] * y, w[1, 0] * x + w[1, 1] * y
            out[k] = np.sqrt(np.min(np.where(depth > 0.0, x * x + y * y, np.inf)))
    return out


def sampled_from_rays(cases: FootPointCases, samples: int) -> FloatArray:
    """Least distance of samples from rays that begin at the origin, (k,) metres."""
    table, out = _table(samples), np.empty(len(cases.xy))
    unit = cases.direction / np.linalg.norm(cases.direction, axis=1)[:, None]
    for k, (a, d) in enumerate(zip(cases.powers, unit, strict=True)):
        places = a.T @ table
        places -= d[:, None] * np.maximum(d @ places, 0.0)
        out[k] = np.sqrt(np.min(np.sum(places * places, axis=0)))
    return out


def _table(samples: int) -> FloatArray:
    """Powers of t of samples, (4, samples)."""
    return np.linspace(0.0, 1.0, samples) ** np.arange(4)[:, None]
