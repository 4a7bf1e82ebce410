"""One image with its measured points and their enlarged residual vectors, as SVG."""

from __future__ import annotations

from typing import Any

import numpy as np

from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.report.measured_image import MeasuredPoints
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.scale import grouped, round_length
from splinebba_cli.report.svg_text import escaped_line, number, titled

_WIDTH, _TOP, _BOTTOM = 400.0, 1.0, 24.0
_CUT = 0.25  # of the width: longer vectors are cut


class Panel:
    """Draws images of one result with one enlargement."""

    DRAWN = 800  # vectors an image, those with the largest w

    def __init__(self, data: ResultData, points: MeasuredPoints, factor: float) -> None:
        table = data.image_points
        self._points, self._factor = points, factor
        self._features, self._status = table["feature"], table.get("status")
        names = ("x", "y", "across")
        self._v = {name: table.numbers(f"residual_{name}_mm") for name in names}
        self._w = {name: table.numbers(f"standardized_{name}") for name in names}
        self._images = {image["id"]: image for image in data["images"]}
        self._number = {image: number for number, image in enumerate(self._images)}
        self._cameras = {camera["id"]: camera for camera in data["cameras"]}
        tests = data.content.get("tests") or {}
        self._critical = float(tests.get("critical", np.inf))
        if tests.get("statistic") == "tau":
            self._critical *= data["statistics"]["sigma0"] / data["statistics"]["sigma0_prior"]

    def svg(self, image: str) -> str:
        """The drawing of one image."""
        rows, camera = self._points.rows[image], self._cameras[self._images[image]["camera"]]
        half = self._half(rows, camera)
        scale = 0.5 * (_WIDTH - 2.0) / half[0]
        height = 2.0 * half[1] * scale
        drawn = self._drawn(rows)
        parts = [self._frame(height, half, scale, camera)]
        middle = np.array([0.5 * _WIDTH, _TOP + 0.5 * height])
        places = middle + scale * self._points.xy[drawn] * [1.0, -1.0]
        vectors = self._factor * scale * self._points.vector[drawn] * [1.0, -1.0]
        pixel = camera["pixel_size_mm"]
        parts += [self._vector(*each, pixel) for each in zip(drawn.tolist(), places, vectors, strict=True)]
        parts += [self._dots(drawn, places, on_spline) for on_spline in (False, True)]
        parts += self._crosses(drawn, places, pixel)
        parts.append(self._key(height, scale))
        view = f"0 0 {number(_WIDTH)} {number(_TOP + height + _BOTTOM)}"
        return (
            f'<div class="panel">{self._title(image, rows, len(drawn))}'
            f'<div class="scroll" tabindex="0" role="img" aria-labelledby="{self._name(image)}">'
            f'<svg class="map" viewBox="{view}">{"".join(parts)}</svg></div></div>'
        )

    def _name(self, image: str) -> str:
        """Id of the title of an image, which is the name of its drawing."""
        return f"vectors-{self._number[image]}"

    def _half(self, rows: IntArray, camera: dict[str, Any]) -> FloatArray:
        """Half of what is shown, (2,) mm: the image format, and all measured points."""
        reach: FloatArray = np.nanmax(np.abs(self._points.xy[rows]), axis=0)
        if camera["format_mm"] is None:
            return np.maximum(1.08 * reach, 1e-6)
        half = 0.5 * np.array(camera["format_mm"], dtype=float)
        return np.where(reach > half, 1.04 * reach, half)

    def _drawn(self, rows: IntArray) -> IntArray:
        if len(rows) <= self.DRAWN:
            return rows
        size = np.where(self._points.out[rows], np.inf, np.nan_to_num(self._points.w[rows]))
        return np.sort(rows[np.argsort(-size, kind="stable")[: self.DRAWN]])

    def _title(self, image: str, rows: IntArray, drawn: int) -> str:
        count = f"{len(rows)} points" if drawn == len(rows) else f"{drawn} of {len(rows)} points"
        out = int(self._points.out[rows].sum())
        text = f"{count}, rms {1e3 * self._points.rms_mm(image):.2f} µm" + (f", {out} out" if out else "")
        return f'<p id="{self._name(image)}">Image <strong>{escaped_line(image, 40)}</strong> {text}</p>'

    def _frame(self, height: float, half: FloatArray, scale: float, camera: dict[str, Any]) -> str:
        x0, y0 = camera["principal_point_mm"]
        x, y = 0.5 * _WIDTH + scale * x0, _TOP + 0.5 * height - scale * y0
        size = half if camera["format_mm"] is None else 0.5 * np.array(camera["format_mm"], dtype=float)
        left, top = 0.5 * _WIDTH - scale * size[0], _TOP + 0.5 * height - scale * size[1]
        frame = (
            f'<rect class="frame" x="{number(left)}" y="{number(top)}" width="{number(2 * scale * size[0])}" '
            f'height="{number(2 * scale * size[1])}"/>'
        )
        cross = f"M{number(x - 5)} {number(y)}h10M{number(x)} {number(y - 5)}v10"
        return frame + titled("path", f'class="ink" d="{cross}"', f"principal point {x0:g}, {y0:g} mm")

    def _vector(self, row: int, place: FloatArray, vector: FloatArray, pixel: float | None) -> str:
        length = float(np.hypot(*vector))
        if not np.isfinite(length):
            return ""
        if length > _CUT * _WIDTH:
            vector = vector * (_CUT * _WIDTH / length)
        bad = self._points.out[row] or self._points.w[row] > self._critical
        kind = "bad" if bad else "spline" if self._points.on_spline[row] else "point"
        d = f"M{number(place[0], 1)} {number(place[1], 1)}l{number(vector[0], 1)} {number(vector[1], 1)}"
        return titled("path", f'class="v-{kind}" d="{d}"', self._tip(row, pixel))

    def _tip(self, row: int, pixel: float | None) -> str:
        names = ("across",) if self._points.on_spline[row] else ("x", "y")
        microns = ", ".join(f"{1e3 * self._v[name][row]:+.2f}" for name in names)
        w = ", ".join(f"{self._w[name][row]:+.2f}" for name in names if np.isfinite(self._w[name][row]))
        lines = [
            self._features[row],
            f"v {'across ' if self._points.on_spline[row] else ''}{microns} µm",
        ]
        if pixel is not None:
            lines[-1] += f" ({', '.join(f'{self._v[name][row] / pixel:+.2f}' for name in names)} px)"
        lines.append(f"w {w}" if w else "not tested")
        if self._points.out[row] and self._status is not None:
            lines.append(self._status[row])
        return "\n".join(lines)

    def _dots(self, drawn: IntArray, places: FloatArray, on_spline: bool) -> str:
        chosen = places[(self._points.on_spline[drawn] == on_spline) & ~self._points.out[drawn]]
        if not len(chosen):
            return ""
        d = "".join(f"M{number(x, 1)} {number(y, 1)}h0" for x, y in chosen)
        return f'<path class="dots dots-{"spline" if on_spline else "point"}" d="{d}"/>'

    def _crosses(self, drawn: IntArray, places: FloatArray, pixel: float | None) -> list[str]:
        found = zip(drawn.tolist(), places, strict=True)
        return [
            titled(
                "path",
                f'class="out" d="M{number(x - 4, 1)} {number(y - 4, 1)}l8 8m-8 0l8-8"',
                self._tip(row, pixel),
            )
            for row, (x, y) in found
            if self._points.out[row]
        ]

    def _key(self, height: float, scale: float) -> str:
        """How long a vector of a round size is."""
        microns = round_length(1e3 * 0.18 * _WIDTH / (scale * self._factor))
        length = 1e-3 * microns * scale * self._factor
        y = _TOP + height + 12
        return (
            f'<path class="ink" d="M1 {number(y)}h{number(length)}"/><text class="soft" '
            f'x="{number(length + 7)}" y="{number(y + 4)}">'
            f"{microns:g} µm, "
            f"enlarged {grouped(self._factor)} times</text>"
        )
