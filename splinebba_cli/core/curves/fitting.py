"""A natural cubic spline through digitised points, with few knots (Lee 2008, 2.3.1).

A knot is inserted where the fit is worst until the largest distance of the points from the curve is below a threshold;
then knots are removed, merged and moved as long as it stays there.  See :mod:`.knot_search` and :mod:`.knot_fit`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from splinebba_cli.core.curves.basis import CurveBasis
from splinebba_cli.core.curves.knot_fit import KnotFit, basis_on
from splinebba_cli.core.curves.knot_search import few_knots
from splinebba_cli.core.curves.natural_cubic import natural_cubic_basis
from splinebba_cli.core.curves.polyline import Polyline, polyline_of
from splinebba_cli.core.network import Curve, FloatArray, IntArray, Role
from splinebba_cli.errors import FitError

KNOTS_PER_POINT = 0.3  # more than this is no smooth curve


@dataclass(frozen=True)
class FittedSpline:
    """A natural cubic spline fitted to points."""

    knots: FloatArray  # (k, 3) metres, in the frame of the points
    knot_parameters: FloatArray  # (k,), closed: (k + 1,) with the end of the last segment
    closed: bool
    breaks: tuple[int, ...]  # knots at corners
    threshold_m: float
    points: FloatArray  # (n, 3) metres, the distinct points
    point_numbers: IntArray  # (n,) their numbers in the input, from 0
    location: FloatArray  # (n,) their foot points u
    distance: FloatArray  # (n,) metres, orthogonal to the curve
    repeated_points: int  # points of the input left out because they repeat the one before (or the first)

    @property
    def largest_distance(self) -> float:
        """Largest distance of a point from the curve, metres."""
        return float(self.distance.max())

    @property
    def rms_distance(self) -> float:
        """Root mean square distance of the points from the curve, metres."""
        return float(np.sqrt(np.mean(self.distance**2)))

    @property
    def knots_follow_noise(self) -> bool:
        """Whether there are so many knots that they follow the noise of the points rather than a curve."""
        return len(self.points) >= 12 and len(self.knots) > KNOTS_PER_POINT * len(self.points)

    @property
    def ends_meet(self) -> bool:
        """Whether an open curve has points that end where they begin."""
        return not self.closed and float(np.linalg.norm(self.points[-1] - self.points[0])) == 0.0

    @property
    def basis(self) -> CurveBasis:
        """The basis of the curve."""
        return natural_cubic_basis(self.knot_parameters, self.closed, self.breaks)

    def evaluate(self, u: ArrayLike) -> FloatArray:
        """Points of the curve at locations u, (m, 3) metres."""
        basis, origin = self.basis, self.knots[0]
        return np.asarray(basis.evaluate(u, basis.coefficients_from_values(self.knots - origin)) + origin)

    def curve(self, id: str, role: Role = "tie", sigma_m: float | None = None) -> Curve:
        """The spline as a curve of a network.

        Parameters
        ----------
        sigma_m : float or None
            σ of the knots, metres; 0 is fixed, None is free.
        """
        sigma = np.full(self.knots.shape, np.inf if sigma_m is None else sigma_m)
        return Curve(
            id=id,
            role=role,
            family="natural_cubic",
            values=self.knots,
            sigma=sigma,
            closed=self.closed,
            knot_parameters=self.knot_parameters,
            breaks=self.breaks,
        )


def fit_spline(
    points: ArrayLike,
    threshold_m: float = 0.05,
    *,
    closed: bool = False,
    parameterization: Literal["chord_length", "uniform"] = "chord_length",
    corner_angle_deg: float | None = None,
) -> FittedSpline:
    """Fit a natural cubic spline to the points of a digitised curve.

    Parameters
    ----------
    points : (n, 3) float, metres
        In their order along the curve, Cartesian. Points that repeat the one before are left out.
    threshold_m : float
        No point is farther from the curve than this.
    closed : bool
        Whether the curve is closed; the first point may be repeated at the end.
    parameterization : {"chord_length", "uniform"}
        Locations with which the fit begins: the cumulated distance of the points, metres, or one unit from
        point to point (for points at equal distances).
    corner_angle_deg : float, optional
        Where the polyline turns by more than this, the spline has a corner (C⁰) in that point. A closed curve
        with corners becomes an open one that begins and ends in the first of them.

    Returns
    -------
    FittedSpline
        Give its knots together with its knot parameters: other parameters make another curve.

    Raises
    ------
    FitError
        SBB320 for too few distinct points, SBB403 for coordinates that are not finite, SBB900 for a
        threshold or an angle that is none.

    References
    ----------
    Lee (2008), 2.3.1.
    """
    if not (np.isfinite(threshold_m) and threshold_m > 0.0):
        raise FitError("SBB900", f"the threshold {threshold_m} m is not a positive number")
    if corner_angle_deg is not None and not 0.0 < corner_angle_deg < 180.0:
        raise FitError(
            "SBB900", f"{corner_angle_deg}° is no angle of corners", "choose one between 0 and 180"
        )
    array = np.asarray(points, dtype=float)
    polyline = polyline_of(
        array, closed=closed, parameterization=parameterization, corner_angle_deg=corner_angle_deg
    )
    return _result(polyline, few_knots(polyline, threshold_m), threshold_m, len(array))


def _result(polyline: Polyline, fit: KnotFit, threshold_m: float, given: int) -> FittedSpline:
    basis = basis_on(polyline, fit.knots)
    knots = basis.values_from_coefficients(fit.coefficients) + polyline.origin
    if polyline.meets_itself:
        knots[[0, -1]] = polyline.points[0] + polyline.origin
    return FittedSpline(
        knots=knots,
        knot_parameters=fit.knots,
        closed=polyline.closed,
        breaks=tuple(int(i) for i in np.searchsorted(fit.knots, polyline.corners)),
        threshold_m=threshold_m,
        points=polyline.points + polyline.origin,
        point_numbers=polyline.given,
        location=fit.location,
        distance=fit.distance,
        repeated_points=given - len(np.unique(polyline.given)),
    )
