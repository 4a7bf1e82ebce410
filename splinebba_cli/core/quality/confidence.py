"""Factors that turn standard deviations, ellipses and ellipsoids into regions with a confidence.

For a vector x of k components with dispersion sigma0^2 Q, x'Q^-1 x / sigma0^2 is chi-square of k degrees of freedom;
with sigma0^2 estimated from the redundancy r, x'Q^-1 x / (k s0^2) is F of (k, r).  A standard region is enlarged by

    sqrt(chi2_k(p))   sigma0 known,      sqrt(k F_k,r(p))   sigma0 estimated

The circle of radius R holds a horizontal position with the standard ellipse (a, b) with the probability

    P(R) = 1 - 1/(2 pi) int S(R / s(phi)) dphi,   s^2 = a^2 cos^2 phi + b^2 sin^2 phi,
    S(t) = exp(-t^2 / 2)   or   (1 + t^2 / r)^(-r / 2)

as x = rho (a cos phi, b sin phi) has phi uniform and rho with P(rho > t) = S(t): normal, or t of r degrees of freedom.
The integrand is periodic and smooth, so the rule of equal steps converges faster than any power of the step.
(probability of circles: Hoover 1984, NOAA Technical Report NOS 107; Harter 1960, Biometrika 47)
"""

from __future__ import annotations

import numpy as np
from scipy.special import chdtri, fdtri

from splinebba_cli.core.network import FloatArray

NODES = 48  # of a quarter turn: P is exact to 1e-12 for every ratio of the axes, b = 0 included
STEPS = 60  # of bisection and Newton together; 6 are enough
RATIOS = 1001


def confidence_factor(dimensions: int, confidence: float, degrees: float | None) -> float:
    """Factor by which the standard region of `dimensions` is enlarged to hold `confidence`.

    Parameters
    ----------
    degrees : float or None
        Redundancy from which the variance of unit weight is estimated; None: it is known.
    """
    if degrees is None:
        return float(np.sqrt(chdtri(dimensions, 1.0 - confidence)))
    return float(np.sqrt(dimensions * fdtri(dimensions, degrees, confidence)))


def circular_probability(radius: FloatArray, semi_axes: FloatArray, degrees: float | None) -> FloatArray:
    """Probability that circles hold positions with standard ellipses of the given semi-axes, (n,).

    Parameters
    ----------
    radius : (n,) float, metres
    semi_axes : (n, 2) float, metres, in any order; one of them may be 0
    """
    outside, _ = _survival(radius, semi_axes, degrees)
    return np.asarray(1.0 - outside)


def circular_radius(semi_axes: FloatArray, confidence: float, degrees: float | None) -> FloatArray:
    """Radius of the circles that hold horizontal positions with `confidence`, (n,) metres.

    Parameters
    ----------
    semi_axes : (n, 2) float, metres, of the standard ellipses

    Notes
    -----
    R / a is a smooth function of b / a: of many ellipses it is solved at equal steps of the ratio, between them by a
    cubic spline, which is within 3e-9 of the solution.
    """
    larger, smaller = np.max(semi_axes, axis=1, initial=0.0), np.min(semi_axes, axis=1)
    share = np.where(larger > 0.0, smaller / np.where(larger > 0.0, larger, 1.0), 0.0)
    if len(share) <= RATIOS:
        return np.asarray(larger * _radius_of_ratios(share, confidence, degrees))
    from scipy.interpolate import CubicSpline  # a fifth of a second that small networks need not wait for

    ratio = np.linspace(0.0, 1.0, RATIOS)
    table = _radius_of_ratios(ratio, confidence, degrees)
    return np.asarray(larger * CubicSpline(ratio, table)(share))


def _radius_of_ratios(ratio: FloatArray, confidence: float, degrees: float | None) -> FloatArray:
    """Radius over the larger semi-axis for ratios b / a, (n,)."""
    return _unit_radius(np.stack([np.ones(len(ratio)), ratio], axis=1), confidence, degrees)


def _unit_radius(unit: FloatArray, confidence: float, degrees: float | None) -> FloatArray:
    """Radius for ellipses of semi-axes (1, ratio): Newton's method, halving where it leaves the bracket."""
    low = np.full(len(unit), confidence_factor(1, confidence, degrees)) * (1.0 - 1e-9)
    high = np.full(len(unit), confidence_factor(2, confidence, degrees)) * (1.0 + 1e-9)
    radius = low + (high - low) * unit[:, 1] ** 2
    for _ in range(STEPS):
        outside, density = _survival(radius, unit, degrees)
        excess = outside - (1.0 - confidence)
        low, high = np.where(excess > 0.0, radius, low), np.where(excess > 0.0, high, radius)
        step = radius + excess / density
        new = np.where((step > low) & (step < high), step, 0.5 * (low + high))
        settled = bool(np.all(np.abs(new - radius) <= 1e-12 * radius))
        radius = new
        if settled:
            break
    return radius


def _survival(
    radius: FloatArray, semi_axes: FloatArray, degrees: float | None
) -> tuple[FloatArray, FloatArray]:
    """Probability outside of the circle and the density of the radius, (n,) each."""
    phi = (np.arange(NODES) + 0.5) * (0.5 * np.pi / NODES)
    square = semi_axes[:, :1] ** 2 * np.cos(phi) ** 2 + semi_axes[:, 1:] ** 2 * np.sin(phi) ** 2
    with np.errstate(divide="ignore", over="ignore"):
        t2 = radius[:, None] ** 2 / square
        if degrees is None:
            outside = np.exp(-0.5 * t2)
            density = radius[:, None] / square * outside
        else:
            outside = (1.0 + t2 / degrees) ** (-0.5 * degrees)
            density = radius[:, None] / square * outside / (1.0 + t2 / degrees)
    return np.asarray(outside.mean(axis=1)), np.asarray(np.maximum(density.mean(axis=1), 1e-300))
