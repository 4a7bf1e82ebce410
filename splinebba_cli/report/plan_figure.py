"""The block from above: stations, footprints, splines by role, points, scale."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from splinebba_cli.core.camera.rotation import rotation_object_from_photo
from splinebba_cli.core.network import FloatArray
from splinebba_cli.report.canvas import INK, MUTED, ROLE_COLOURS, STATION, svg_of
from splinebba_cli.report.plan_ellipses import draw_ellipses
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.scale import round_length

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LABELLED_IMAGES, _LABELLED_SPLINES, _DRAWN_POINTS = 60, 40, 3000
_MARKERS = {"control": "^", "partial": "v", "tie": "o", "check": "s"}


def block_plan(data: ResultData) -> str:
    """SVG of the plan; X to the right, Y up, metres."""
    stations = np.array([[image[axis] for axis in "xyz"] for image in data["images"]], dtype=float).reshape(
        -1, 3
    )
    footprints = _footprints(data, stations)
    extent = _extent(data, stations, footprints)
    width, height = extent[1] - extent[0]
    size = (7.6, float(np.clip(6.6 * height / max(width, 1e-9) + 0.9, 3.2, 6.0)))

    def draw(figure: Figure) -> None:
        axes = figure.add_subplot()
        axes.set_aspect("equal", adjustable="datalim")
        _draw_footprints(axes, footprints)
        _draw_splines(axes, data)
        _draw_points(axes, data)
        _draw_stations(axes, data, stations)
        draw_ellipses(axes, data, extent)
        _finish(axes, extent)

    return svg_of(draw, size, "block_plan")


def _ground_height(data: ResultData, stations: FloatArray) -> float:
    heights = [point["z"] for point in data["points"]]
    heights += [knot[2] for spline in data["splines"] for knot in spline["knots"]]
    finite = [height for height in heights if height is not None]
    return float(np.median(finite)) if finite else float(np.min(stations[:, 2], initial=0.0))


def _footprints(data: ResultData, stations: FloatArray) -> list[FloatArray]:
    """Corners of the image formats on the mean height of the object; images that look aside have none."""
    cameras = {camera["id"]: camera for camera in data["cameras"]}
    ground = _ground_height(data, stations)
    out = []
    for image, station in zip(data["images"], stations, strict=True):
        camera = cameras[image["camera"]]
        if camera["format_mm"] is None:
            continue
        half = 0.5 * np.array(camera["format_mm"])
        xy = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half - camera["principal_point_mm"]
        rays = np.column_stack([xy, np.full(4, -camera["principal_distance_mm"])]) @ _rotation(image).T
        if np.all(rays[:, 2] < -0.2 * np.linalg.norm(rays, axis=1)) and station[2] > ground:
            out.append(station[:2] + rays[:, :2] * ((ground - station[2]) / rays[:, 2])[:, None])
    return out


def _rotation(image: dict[str, Any]) -> FloatArray:
    angles = np.radians([image[key] for key in ("omega", "phi", "kappa")])
    return rotation_object_from_photo(angles, image["rotation_sequence"])


def _extent(data: ResultData, stations: FloatArray, footprints: list[FloatArray]) -> FloatArray:
    """Lower left and upper right corner of everything, (2, 2)."""
    parts = [stations[:, :2], *footprints]
    parts.append(_xy([[point["x"], point["y"]] for point in data["points"]]))
    parts += [_xy([knot[:2] for knot in spline["knots"]]) for spline in data["splines"]]
    every = np.concatenate([part for part in parts if len(part)] or [np.zeros((1, 2))])
    every = every[np.isfinite(every).all(axis=1)]
    if not len(every):
        every = np.zeros((1, 2))
    return np.array([every.min(axis=0), np.maximum(every.max(axis=0), every.min(axis=0) + 1e-6)])


def _xy(rows: list[list[float | None]]) -> FloatArray:
    return np.array(rows, dtype=float).reshape(-1, 2)


def _draw_footprints(axes: Axes, footprints: list[FloatArray]) -> None:
    from matplotlib.collections import PolyCollection

    fill = max(0.06 * min(1.0, 30 / max(len(footprints), 1)), 0.008)  # many lie on top of each other
    axes.add_collection(PolyCollection(footprints, facecolors=STATION, alpha=fill, linewidths=0))
    axes.add_collection(
        PolyCollection(footprints, facecolors="none", edgecolors=STATION, alpha=0.45, linewidths=0.6)
    )


def _draw_splines(axes: Axes, data: ResultData) -> None:
    from matplotlib.collections import LineCollection

    samples = data.samples_by_spline
    for role, colour in ROLE_COLOURS.items():
        splines = [spline for spline in data["splines"] if spline["role"] == role]
        lines = [
            samples[s["id"]].xyz[:, :2] if s["id"] in samples else _xy([knot[:2] for knot in s["knots"]])
            for s in splines
        ]
        lines = [line for line in lines if len(line)]
        if lines:
            axes.add_collection(LineCollection(lines, colors=colour, linewidths=1.8, label=f"{role} spline"))
    if len(data["splines"]) <= _LABELLED_SPLINES:
        for spline in data["splines"]:
            if spline["knots"]:
                x, y = spline["knots"][len(spline["knots"]) // 2][:2]
                _label(axes, spline["id"], x, y, ROLE_COLOURS[spline["role"]])


def _label(axes: Axes, text: str, x: float, y: float, colour: str) -> None:
    axes.annotate(
        text,
        (x, y),
        xytext=(4, 4),
        textcoords="offset points",
        fontsize=7,
        color=colour,
        clip_on=True,
    )


def _draw_points(axes: Axes, data: ResultData) -> None:
    step = 1 + len(data["points"]) // _DRAWN_POINTS
    for role, marker in _MARKERS.items():
        points = [point for point in data["points"] if point["role"] == role]
        drawn = points[::step] if role == "tie" else points
        if drawn:
            xy = _xy([[point["x"], point["y"]] for point in drawn])
            name = f"{role} point" + (f" (1 of {step})" if step > 1 and role == "tie" else "")
            size = (3.0 if role == "tie" else 5.0) * max(0.4, min(1.0, (200 / len(drawn)) ** 0.5))
            axes.plot(
                xy[:, 0], xy[:, 1], marker, color=ROLE_COLOURS[role], markersize=size, label=name, mew=0
            )


def _draw_stations(axes: Axes, data: ResultData, stations: FloatArray) -> None:
    axes.plot(
        stations[:, 0], stations[:, 1], "+", color=STATION, markersize=7, mew=1.4, label="camera station"
    )
    if len(stations) <= _LABELLED_IMAGES:
        for image, station in zip(data["images"], stations, strict=True):
            _label(axes, image["id"], station[0], station[1], STATION)


def _finish(axes: Axes, extent: FloatArray) -> None:
    span = extent[1] - extent[0]
    margin = 0.05 * float(span.max())
    axes.update_datalim([extent[0] - [margin, 2 * margin], extent[1] + margin])
    axes.autoscale_view()
    axes.set_xlabel("X [m]")
    axes.set_ylabel("Y [m]")
    axes.locator_params(nbins=6)
    if span.max() > 20:
        axes.xaxis.set_major_formatter("{x:.0f}")
        axes.yaxis.set_major_formatter("{x:.0f}")
    length = round_length(0.2 * float(span.max()))
    x, y = extent[0, 0] - 0.4 * margin, extent[0, 1] - 1.2 * margin
    axes.plot([x, x + length], [y, y], color=INK, linewidth=2.2, solid_capstyle="butt")
    axes.annotate(
        f"{length:g} m", (x + 0.5 * length, y), xytext=(0, 4), textcoords="offset points", ha="center"
    )
    axes.annotate(
        "Y",
        xy=(0.985, 0.99),
        xytext=(0.985, 0.88),
        xycoords="axes fraction",
        ha="center",
        va="top",
        arrowprops={"arrowstyle": "-|>", "color": MUTED, "lw": 1.2},
    )
    axes.figure.legend(loc="outside lower center", ncols=4, fontsize=8)
