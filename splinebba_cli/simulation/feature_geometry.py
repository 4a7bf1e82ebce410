"""What lies on the simulated ground: rolling terrain, roads, shores and points.

A road or shore *is* the natural cubic spline through its knots (uniform parameters, knots about equally far
apart), so that a noise-free adjustment can give it back exactly.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from splinebba_cli.core.curves.basis import CurveBasis
from splinebba_cli.core.curves.registry import basis_of
from splinebba_cli.core.network import Curve, FloatArray, Role

SplineRole = Literal["control", "partial", "tie", "check"]


@dataclass(frozen=True)
class Feature:
    """A true curve and what is known about it."""

    id: str
    role: SplineRole
    values: FloatArray  # (k, 3) true values, metres
    sigma: FloatArray  # (k, 3) of the given values: 0 held, inf unknown
    family: str = "natural_cubic"
    closed: bool = False
    continuity: int = -1  # of polynomial segments
    natural_ends: bool = False
    tension: float = 0.0  # of a cardinal spline
    knot_parameters: FloatArray | None = None  # None: uniform
    really: Feature | None = None  # the true curve, where the family only approximates it

    def curve(self, values: FloatArray) -> Curve:
        """The curve of some values; uniform parameters do not depend on where the knots start."""
        return Curve(
            id=self.id,
            role=self.role,
            family=self.family,
            values=values,
            sigma=self.sigma,
            closed=self.closed,
            knot_parameters=self.knot_parameters,
            parameterization="uniform",
            continuity=self.continuity,
            natural_ends=self.natural_ends,
            tension=self.tension,
        )

    def shape(self) -> tuple[CurveBasis, FloatArray]:
        """Basis and coefficients of the true curve."""
        if self.really is not None:
            return self.really.shape()
        basis = basis_of(self.curve(self.values))
        return basis, basis.coefficients_from_values(self.values)


@dataclass(frozen=True)
class PointFeatures:
    """True points and what is known about them."""

    ids: tuple[str, ...] = ()
    role: tuple[Role, ...] = ()
    xyz: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))  # (n, 3)
    sigma: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))  # (n, 3) of given coordinates


def terrain_height(x: FloatArray, y: FloatArray) -> FloatArray:
    """Height of rolling terrain between about 10 and 60 m."""
    return np.asarray(35.0 + 16.0 * np.sin(x / 140.0) * np.cos(y / 170.0) + 9.0 * np.sin(x / 67.0 + y / 91.0))


def road(start: tuple[float, float], end: tuple[float, float], knots: int, swing_m: float) -> FloatArray:
    """Knots (k, 3) of a winding road on the terrain.

    Parameters
    ----------
    start, end : X and Y of the ends, metres
    knots : number of knots
    swing_m : how far the road leaves the straight line
    """
    share = np.linspace(0.0, 1.0, knots)
    first, last = np.asarray(start), np.asarray(end)
    along = last - first
    across = np.array([-along[1], along[0]]) / np.hypot(*along)
    offset = swing_m * (np.sin(2.0 * np.pi * share + 0.4) + 0.4 * np.sin(5.0 * np.pi * share + 1.0))
    xy = first + share[:, None] * along + offset[:, None] * across
    return np.column_stack([xy, terrain_height(xy[:, 0], xy[:, 1])])


def shore(centre: tuple[float, float], radius_m: float, knots: int) -> FloatArray:
    """Knots (k, 3) of a closed, irregular line on the terrain, counter-clockwise."""
    angle = 2.0 * np.pi * np.arange(knots) / knots
    radius = radius_m * (1.0 + 0.22 * np.sin(2.0 * angle + 0.5) + 0.12 * np.cos(3.0 * angle))
    xy = np.asarray(centre) + radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    return np.column_stack([xy, terrain_height(xy[:, 0], xy[:, 1])])


def circle_rows(
    centre: tuple[float, float, float], radius_m: float, normal: tuple[float, float, float]
) -> FloatArray:
    """Centre and two radius vectors (3, 3) of a circle, the first one in the X-Z plane."""
    up = np.asarray(normal) / np.linalg.norm(normal)
    first = np.array([up[2], 0.0, -up[0]]) / np.hypot(up[0], up[2])
    return np.vstack([centre, radius_m * first, radius_m * np.cross(up, first)])


def control_spline(id: str, values: FloatArray) -> Feature:
    """A spline whose knots are all known and held."""
    return Feature(id, "control", values, np.zeros_like(values))


def tie_spline(id: str, values: FloatArray, closed: bool = False, family: str = "natural_cubic") -> Feature:
    """A spline of which nothing is known."""
    return Feature(id, "tie", values, np.full_like(values, np.inf), family=family, closed=closed)


def check_spline(id: str, values: FloatArray) -> Feature:
    """A spline that takes part like a tie spline and is compared with its known shape afterwards."""
    return Feature(id, "check", values, np.full_like(values, np.inf))


def partial_control_spline(id: str, values: FloatArray, height_sigma_m: float = 0.05) -> Feature:
    """A spline whose first knot is held, and every third height is known with a standard deviation."""
    sigma = np.full_like(values, np.inf)
    sigma[2::3, 2] = height_sigma_m
    sigma[0] = 0.0
    return Feature(id, "partial", values, sigma)


def samples(feature: Feature, count: int) -> FloatArray:
    """Points (count, 3) along the true curve, for check splines."""
    basis, coefficients = feature.shape()
    return basis.evaluate(np.linspace(basis.break_points[0], basis.break_points[-1], count), coefficients)


def scattered_points(
    area: tuple[float, float, float, float], control: FloatArray, ties: int, checks: int, sigma_m: float
) -> PointFeatures:
    """Control points at given places, tie and check points scattered over an area.

    Parameters
    ----------
    area : X and Y of the lower left, X and Y of the upper right corner, metres
    control : (k, 2) X and Y
    ties, checks : numbers of points
    sigma_m : of the given coordinates of control and check points
    """
    generator = np.random.default_rng(71)
    scattered = generator.uniform(area[:2], area[2:], (ties + checks, 2))
    xy = np.vstack([control, scattered])
    xyz = np.column_stack([xy, terrain_height(xy[:, 0], xy[:, 1])])
    counts: tuple[tuple[Role, str, int], ...] = (
        ("control", "gcp", len(control)),
        ("tie", "tie", ties),
        ("check", "check", checks),
    )
    role = [name for name, _, count in counts for _ in range(count)]
    ids = [f"{prefix}-{i + 1}" for _, prefix, count in counts for i in range(count)]
    sigma = np.where(np.array(role)[:, None] == "tie", np.inf, sigma_m) * np.ones(3)
    return PointFeatures(tuple(ids), tuple(role), xyz, sigma)
