"""One spline: plan and profile with knots and the band of its lateral standard deviation.

The standard ellipse across the tangent t has the semi-axes a (along d) and b (along e = t × d):

    Q = a² d dᵀ + b² e eᵀ

The band in the plan is ± k √(hᵀ Q h) along the horizontal normal h of the curve, the band in the profile
± k √(vᵀ Q v) along v = t × h; k is written in the figure.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.report.canvas import INK, ROLE_COLOURS, svg_of
from splinebba_cli.report.result_data import ResultData, SplineSamples
from splinebba_cli.report.scale import round_length

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def spline_figure(data: ResultData, spline_id: str) -> str:
    """SVG of plan and profile of one spline; empty if there are no samples along it."""
    samples = data.samples_by_spline.get(spline_id)
    if samples is None or len(samples.u) < 2:
        return ""
    spline = next(spline for spline in data["splines"] if spline["id"] == spline_id)
    if spline["closed"]:
        samples = ring(samples)
    horizontal, sigma_plan, sigma_profile = lateral_sigma(samples)

    def draw(figure: Figure) -> None:
        plan, profile = figure.subplots(1, 2, width_ratios=(1.0, 1.25))
        _draw_plan(plan, samples, spline, horizontal, sigma_plan)
        _draw_profile(profile, samples, spline, sigma_profile)

    return svg_of(draw, (7.6, 2.9), f"spline {spline_id}", margins=(0.085, 0.16, 0.98, 0.91, 0.24))


def ring(samples: SplineSamples) -> SplineSamples:
    """Samples of a closed spline with the first one again at the end, one step further."""
    first = [
        np.concatenate([values, values[:1]]) for values in (samples.xyz, samples.across, samples.direction)
    ]
    return SplineSamples(np.append(samples.u, 2.0 * samples.u[-1] - samples.u[-2]), *first)


def lateral_sigma(samples: SplineSamples) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Horizontal normals (n, 2) and the standard deviations along them and along v (n,), in metres."""
    tangent = np.gradient(samples.xyz, axis=0)
    tangent /= np.maximum(np.linalg.norm(tangent, axis=1), 1e-12)[:, None]
    normal = np.column_stack([-tangent[:, 1], tangent[:, 0], np.zeros(len(tangent))])
    length = np.linalg.norm(normal, axis=1)
    normal = np.where(length[:, None] > 1e-9, normal / np.maximum(length, 1e-9)[:, None], [1.0, 0.0, 0.0])
    vertical = np.cross(tangent, normal)
    minor_direction = np.cross(tangent, samples.direction)
    sigmas = []
    for direction in (normal, vertical):
        major = samples.across[:, 0] * np.sum(samples.direction * direction, axis=1)
        minor = samples.across[:, 1] * np.sum(minor_direction * direction, axis=1)
        sigmas.append(np.nan_to_num(np.hypot(major, minor)))
    return normal[:, :2], sigmas[0], sigmas[1]


def _enlargement(sigma: FloatArray, span: float) -> float:
    """A round factor that makes the widest band a twelfth of the plot."""
    largest = float(sigma.max(initial=0.0))
    return max(1.0, round_length(span / 12.0 / largest)) if largest > 0.0 else 1.0


def _draw_plan(
    axes: Axes, samples: SplineSamples, spline: dict[str, Any], normal: FloatArray, sigma: FloatArray
) -> None:
    origin = np.floor(samples.xyz[0, :2])
    xy = samples.xyz[:, :2] - origin
    factor = _enlargement(sigma, float(np.ptp(xy, axis=0).max()))
    offset = factor * sigma[:, None] * normal
    band = np.concatenate([xy + offset, (xy - offset)[::-1]])
    colour = ROLE_COLOURS[spline["role"]]
    axes.set_aspect("equal", adjustable="datalim")
    axes.fill(band[:, 0], band[:, 1], color=colour, alpha=0.22, linewidth=0)
    axes.plot(xy[:, 0], xy[:, 1], color=colour)
    knots = np.array(spline["knots"], dtype=float).reshape(-1, 3)[:, :2] - origin
    axes.plot(knots[:, 0], knots[:, 1], "o", color=INK, markersize=2.6)
    axes.set_title(f"Plan, band σ × {factor:g}")
    axes.set_xlabel(_less("X", origin[0]))
    axes.set_ylabel(_less("Y", origin[1]))
    axes.locator_params(nbins=5)


def _less(name: str, origin: float) -> str:
    """Label of an axis whose values are coordinates less an origin."""
    shift = f" {'−' if origin > 0 else '+'} {abs(origin):.0f}" if origin else ""
    return f"{name}{shift} [m]"


def _draw_profile(axes: Axes, samples: SplineSamples, spline: dict[str, Any], sigma: FloatArray) -> None:
    steps = np.linalg.norm(np.diff(samples.xyz[:, :2], axis=0), axis=1)
    distance = np.concatenate([[0.0], np.cumsum(steps)])
    height = samples.xyz[:, 2]
    factor = _enlargement(sigma, max(float(np.ptp(height)), 0.05 * float(distance[-1])))
    colour = ROLE_COLOURS[spline["role"]]
    axes.fill_between(
        distance, height - factor * sigma, height + factor * sigma, color=colour, alpha=0.22, lw=0
    )
    axes.plot(distance, height, color=colour)
    parameters = np.array(spline["knot_parameters"], dtype=float)
    axes.plot(
        np.interp(parameters, samples.u, distance),
        np.interp(parameters, samples.u, height),
        "o",
        color=INK,
        markersize=2.6,
    )
    axes.set_title(f"Profile, band σ × {factor:g}")
    axes.set_xlabel("horizontal distance along the spline [m]")
    axes.set_ylabel("Z [m]")
    axes.locator_params(nbins=6)
