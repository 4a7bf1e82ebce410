"""Curves of every family and option where the six images see them, as features of a simulated scene."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.curves.natural_cubic import natural_cubic_basis
from splinebba_cli.core.curves.registry import FAMILIES
from splinebba_cli.core.network import FloatArray
from splinebba_cli.simulation.feature_geometry import Feature
from tests.core.free_curves import CUBIC, LINE, PARABOLA, WINDING, tie

PLACE = np.array([3300.0, 4310.0, 40.0])
RING = np.array(
    [[70, 0, 10], [45, 62, -8], [-20, 75, 6], [-72, 30, -5], [-60, -45, 9], [0, -70, -7], [50, -52, 4]], float
)
ELLIPSE = np.array([PLACE, [90.0, 20.0, 8.0], [-25.0, 60.0, -12.0]])
HARMONICS = np.vstack([ELLIPSE, [[9.0, -6.0, 10.0], [4.0, 8.0, -5.0], [-5.0, 3.0, 3.0], [2.0, 6.0, 4.0]]])


def circle_rows(radius_m: float = 60.0) -> FloatArray:
    """Centre and two radius vectors of a tilted circle."""
    first, second = np.array([0.8, 0.6, 0.0]), np.array([-0.588, 0.784, 0.2])
    return np.array([PLACE, radius_m * first, radius_m * second / np.linalg.norm(second)])


def spline_rows(segments: int) -> FloatArray:
    """a_0 .. a_3 of every segment of a winding natural spline: it fulfils every continuity of cubics."""
    knots = WINDING[: segments + 1]
    basis = natural_cubic_basis(np.arange(segments + 1.0))
    own = basis.coefficients_from_values(knots)[basis.columns]
    return np.einsum("skw,swd->skd", basis.power, own).reshape(-1, 3)


def joined(segments: int, continuity: int, natural: bool = False) -> Feature:
    """Cubic segments of one smooth curve."""
    name = f"cubics-{segments}-{'natural' if natural else continuity}"
    feature = tie(name, "free_cubic", spline_rows(segments))
    return with_options(feature, continuity=continuity, natural_ends=natural)


def with_options(feature: Feature, **options: object) -> Feature:
    """The feature with options of its family."""
    return Feature(**{**feature.__dict__, **options})  # type: ignore[arg-type]


def parabolas() -> FloatArray:
    """Two parabolas with a common tangent and a jump of curvature at their joint."""
    first = PARABOLA.copy()
    second = np.array([first.sum(axis=0), first[1] + 2.0 * first[2], [40.0, 55.0, -30.0]])
    return np.vstack([first, second])


def of_family(name: str) -> Feature:
    """A tie curve of a family, without options."""
    family = FAMILIES[name]
    if name == "circle":
        return tie(name, name, circle_rows())
    if family.rows == "harmonics":
        return tie(name, name, HARMONICS if name == "fourier" else ELLIPSE)
    if family.rows == "powers":
        return tie(
            name,
            name,
            {1: LINE - [[0.0], [1.0]] * LINE[0], 2: PARABOLA}.get(family.degree, CUBIC[: family.degree + 1]),
        )
    return tie(name, name, LINE if family.most == 2 else WINDING)


WITH_OPTIONS = (
    with_options(tie("closed", "natural_cubic", PLACE + RING), closed=True),
    joined(3, -1),
    joined(3, 0),
    joined(3, 1),
    joined(3, 2),
    joined(3, 2, natural=True),
    with_options(tie("parabolas", "polynomial_2", parabolas()), continuity=1),
    with_options(tie("tense", "cardinal", WINDING), tension=0.3),
    with_options(tie("tense-closed", "cardinal", PLACE + RING), tension=-0.2, closed=True),
    *(with_options(tie(f"bspline_{d}-closed", f"bspline_{d}", PLACE + RING), closed=True) for d in (1, 2, 3)),
    with_options(tie("arc", "conic", ELLIPSE), knot_parameters=np.array([-0.5, 2.5])),
    with_options(tie("circular-arc", "circle", circle_rows()), knot_parameters=np.array([0.2, 2.4])),
)
ALL = (*(of_family(name) for name in FAMILIES), *WITH_OPTIONS)
