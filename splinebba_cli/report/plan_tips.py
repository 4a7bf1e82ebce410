"""What stations, splines and points of a plan say when they are pointed at."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.scale import angle_scale, length_scale


def station_tip(image: dict[str, Any]) -> str:
    """Image with position, its σ and those of the angles."""
    return (
        f"image {image['id']} ({image['camera']})\n{_position(image)}\n{_sigmas(image['sigma'])}\n"
        + _angles(image["sigma"])
    )


def point_tip(point: dict[str, Any]) -> str:
    """Point with role, position, σ and number of rays."""
    return f"point {point['id']}: {point['role']}, {point['rays']} rays\n{_position(point)}\n{_sigmas(point['sigma'])}"


def spline_tip(data: ResultData, spline: dict[str, Any]) -> str:
    """Spline with role, RMS of its residuals and σ across."""
    across = spline["sigma_across"]
    scale = length_scale([across["mean"]])
    lines = [
        f"spline {spline['id']}: {spline['role']}",
        f"{spline['observations']} image points in {spline['images']} images, {len(spline['knots'])} knots",
        f"RMS across {_rms(data, spline)}",
        f"σ across {scale.text(across['mean'])} (mean), {scale.text(across['max'])} (largest)",
    ]
    return "\n".join(lines)


def _rms(data: ResultData, spline: dict[str, Any]) -> str:
    rms = spline["rms_across_mm"]
    if rms is None:
        return "–"
    summary = data.spline_residuals.get(spline["id"])
    pixels = "" if summary is None or summary["rms_px"] is None else f" ({summary['rms_px']:.3f} px)"
    return f"{1e3 * rms:.2f} µm{pixels}"


def _position(item: dict[str, Any]) -> str:
    return ", ".join(f"{axis.upper()} {item[axis]:.3f}" for axis in "xyz" if item[axis] is not None) + " m"


def _sigmas(sigma: dict[str, Any]) -> str:
    values: Sequence[float | None] = [sigma[axis] for axis in "xyz"]
    scale = length_scale(values)
    return ", ".join(f"σ {axis} {scale.text(v)}" for axis, v in zip("XYZ", values, strict=True))


def _angles(sigma: dict[str, Any]) -> str:
    values: Sequence[float | None] = [sigma[name] for name in ("omega", "phi", "kappa")]
    scale = angle_scale(values)
    return ", ".join(f"σ {name} {scale.text(v)}" for name, v in zip("ωφκ", values, strict=True))
