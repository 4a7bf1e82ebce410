"""Captions and descriptions of the figures of the block and its features: what is shown, in which unit, main number."""

from __future__ import annotations

from typing import Any

import numpy as np

from splinebba_cli.report.blocks import Block, FigureBlock, Note
from splinebba_cli.report.object_view import needs_side_view, side_view
from splinebba_cli.report.orientation_correlations import OrientationCorrelations
from splinebba_cli.report.rays_figure import longest_gap
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.scale import length_scale, plural

SPLINE_FIGURES = 20
_CORRELATED = 12  # images with a map of correlations


def plan_blocks(data: ResultData) -> list[Block]:
    """The block from above, and from the side where the images look aside."""
    counts = [plural(len(data[f"{name}s"]), name) for name in ("image", "spline", "point")]
    sigma = [s for image in data["images"] for s in image["sigma"].values() if s is not None]
    positions = [image["sigma"][a] for image in data["images"] for a in "xyz"]
    largest = max((s for s in positions if s is not None), default=None)
    precision = f"; largest σ of a station {length_scale([largest]).text(largest)}" if sigma else ""
    caption = (
        "Block seen along the Z axis, in metres: camera stations, footprints at the median height of the object where "
        "the image format is known, else viewing directions; splines by role, points, standard ellipses enlarged as "
        "written. The arrow is +Y (grid north in a map frame). Point at anything for its name and figures."
    )
    alt = f"Plan of {counts[0]}, {counts[1]} and {counts[2]}{precision}"
    blocks: list[Block] = [FigureBlock("block_plan", caption, alt)]
    if needs_side_view(data):
        name = side_view(data).name[0]
        caption = (
            f"The same from the side: {name} to the right, Z up, metres; its ellipses enlarged as written."
        )
        alt = f"Elevation of {counts[0]}, {counts[1]} and {counts[2]}, {name} and Z"
        blocks.append(FigureBlock("block_elevation", caption, alt))
    return blocks


def correlation_blocks(data: ResultData) -> list[Block]:
    """Correlations of orientation unknowns as heat map; none where the dispersion was not written."""
    found = OrientationCorrelations.of(data)
    if found is None or not found.largest().any():
        return []
    largest = found.largest()
    image = int(largest.argmax())
    pair = found.strongest_pair(image)
    if pair is None:
        return []
    summary = f"largest |r| {abs(pair[2]):.3f}, {pair[0]} with {pair[1]} of image {found.images[image]}"
    if found.whole is not None and len(found.images) <= _CORRELATED:
        caption = "Correlations r of the orientation unknowns of all images, from dispersion.npz"
    else:
        shown = min(_CORRELATED, len(largest))
        many = f"; the {shown} images with the largest |r| of {len(largest)}" if shown < len(largest) else ""
        caption = f"Correlations r of the six orientation unknowns inside each image{many}"
        beyond = int((largest > 0.95).sum())
        caption += f". Median of the largest |r| of an image {np.median(largest):.2f}"
        caption += f"; beyond 0.95 in {plural(beyond, 'image')}"
    caption += ". Full colour is ±1; no colour is 0; grey is an unknown with itself."
    return [FigureBlock("correlations", caption, f"Correlations of orientation unknowns: {summary}")]


def spline_blocks(data: ResultData) -> list[Block]:
    """Plan, profile and measured parts of every spline, of many those with the largest σ across."""
    splines = drawn_splines(data)
    blocks: list[Block] = [block for spline in splines for block in _of_spline(data, spline)]
    if len(splines) < len(data["splines"]):
        text = f"Figures of the {len(splines)} splines with the largest σ across of {len(data['splines'])}."
        blocks.insert(0, Note(text))
    return blocks


def drawn_splines(data: ResultData) -> list[dict[str, Any]]:
    """Splines with a figure, in the order of the project; of many the least precise ones."""
    splines: list[dict[str, Any]] = data["splines"]
    if len(splines) <= SPLINE_FIGURES:
        return splines
    size = [-(spline["sigma_across"]["max"] or 0.0) for spline in splines]
    return [splines[k] for k in sorted(np.argsort(size, kind="stable")[:SPLINE_FIGURES].tolist())]


def _of_spline(data: ResultData, spline: dict[str, Any]) -> list[Block]:
    name, across = f"{spline['id']} ({spline['role']})", spline["sigma_across"]
    scale = length_scale([across["mean"]])
    caption = (
        f"Spline {name}: plan and profile with knots, metres; the band is ± σ across, enlarged as written."
    )
    sizes = f"σ across {scale.text(across['mean'])} in the mean, {scale.text(across['max'])} at most"
    alt = f"Plan and profile of spline {spline['id']}, {sizes}"
    blocks: list[Block] = [FigureBlock("spline", caption, alt, subject=spline["id"])]
    gap = longest_gap(data, spline)
    if gap is not None:
        caption = (
            f"Spline {spline['id']}: where every image has measured it; numbers of the knots above, of the points to "
            f"the right. The longest part without any measured point is {length_scale([gap]).text(gap)} long."
        )
        images = plural(spline["images"], "image")
        count = f"{spline['observations']} in {images}, longest gap {length_scale([gap]).text(gap)}"
        alt = f"Measured points along spline {spline['id']}: {count}"
        blocks.append(FigureBlock("rays", caption, alt, subject=spline["id"]))
    return blocks


def check_point_blocks(checks: dict[str, Any]) -> list[Block]:
    """Differences of check points."""
    scale = length_scale(checks["points_rms"].values())
    values = ", ".join(f"{axis.upper()} {scale.text(checks['points_rms'][axis])}" for axis in "xyz")
    caption = (
        "Check points, adjusted − given: horizontal differences in the plan, enlarged as written (crosses: stations), "
        f"and height differences in {scale.unit} with ± 1.96 times their predicted σ. Red: the test of the point fails."
    )
    count = plural(len(checks["points"]), "check point")
    return [FigureBlock("check_points", caption, f"Differences of {count}: root mean square {values}")]


def check_spline_blocks(splines: list[dict[str, Any]]) -> list[Block]:
    """Distances along check splines; of many those with the largest ones."""
    shown = sorted(splines, key=lambda each: -(each["max"] or 0.0))[:12]
    blocks: list[Block] = []
    for spline in shown:
        scale = length_scale([spline["rms"]])
        caption = (
            f"Check spline {spline['id']}: distance of the adjusted curve from the given points, across; the band "
            "holds 95 % of good points. Red: the test of the point fails."
        )
        size = f"root mean square {scale.text(spline['rms'])}, largest {scale.text(spline['max'])}"
        alt = f"Distances along check spline {spline['id']}: {size}"
        blocks.append(FigureBlock("check_spline", caption, alt, subject=spline["id"]))
    if len(shown) < len(splines):
        blocks.append(Note(f"The {len(shown)} check splines with the largest distances of {len(splines)}."))
    return blocks
