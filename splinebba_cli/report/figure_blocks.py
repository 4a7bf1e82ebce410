"""Captions and descriptions of the figures: what is shown, in which unit, with its main number."""

from __future__ import annotations

from typing import Any

import numpy as np

from splinebba_cli.report.blocks import Block, FigureBlock, Note
from splinebba_cli.report.object_view import looks_down, side_view
from splinebba_cli.report.orientation_correlations import OrientationCorrelations
from splinebba_cli.report.rays_figure import longest_gap
from splinebba_cli.report.residual_figures import standardized
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.scale import length_scale

SPLINE_FIGURES = 20
_CORRELATED = 12  # images with a map of correlations


def plan_blocks(data: ResultData) -> list[Block]:
    """The block from above, and from the side where the images look aside."""
    counts = [_plural(len(data[f"{name}s"]), name) for name in ("image", "spline", "point")]
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
    if not looks_down(data):
        name = side_view(data).name[0]
        caption = f"The same from the side: {name} to the right, Z up, metres; ellipses of this view, enlarged as written."
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
        caption += f". Median of the largest |r| of an image {np.median(largest):.2f}; beyond 0.95 in {_plural(beyond, 'image')}"
    caption += ". Full colour is ±1; no colour is 0; grey is an unknown with itself."
    return [FigureBlock("correlations", caption, f"Correlations of orientation unknowns: {summary}")]


def spline_blocks(data: ResultData) -> list[Block]:
    """Plan, profile and measured parts of every spline, of many those with the largest σ across."""
    splines = drawn_splines(data)
    blocks: list[Block] = [block for spline in splines for block in _of_spline(data, spline)]
    if len(splines) < len(data["splines"]):
        text = f"Figures of the {len(splines)} splines with the largest σ across; {len(data['splines'])} are in the tables."
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
    alt = f"Plan and profile of spline {spline['id']}, σ across {scale.text(across['mean'])} in the mean, {scale.text(across['max'])} at most"
    blocks: list[Block] = [FigureBlock("spline", caption, alt, subject=spline["id"])]
    gap = longest_gap(data, spline)
    if gap is not None:
        caption = (
            f"Spline {spline['id']}: where every image has measured it; numbers of the knots above, of the points to the "
            f"right. The longest part without any measured point is {length_scale([gap]).text(gap)} long."
        )
        images = _plural(spline["images"], "image")
        alt = f"Measured points along spline {spline['id']}: {spline['observations']} in {images}, longest gap {length_scale([gap]).text(gap)}"
        blocks.append(FigureBlock("rays", caption, alt, subject=spline["id"]))
    return blocks


def check_point_blocks(checks: dict[str, Any]) -> list[Block]:
    """Differences of check points."""
    scale = length_scale(checks["points_rms"].values())
    values = ", ".join(f"{axis.upper()} {scale.text(checks['points_rms'][axis])}" for axis in "xyz")
    caption = (
        "Check points, adjusted − given: horizontal differences in the plan, enlarged as written (crosses: stations), and "
        f"height differences in {scale.unit} with ± 1.96 times their predicted σ. Red: the test of the point fails."
    )
    count = _plural(len(checks["points"]), "check point")
    return [FigureBlock("check_points", caption, f"Differences of {count}: root mean square {values}")]


def check_spline_blocks(splines: list[dict[str, Any]]) -> list[Block]:
    """Distances along check splines; of many those with the largest ones."""
    shown = sorted(splines, key=lambda each: -(each["max"] or 0.0))[:12]
    blocks: list[Block] = []
    for spline in shown:
        scale = length_scale([spline["rms"]])
        caption = (
            f"Check spline {spline['id']}: distance of the adjusted curve from the given points, across; the band holds "
            "95 % of good points. Red: the test of the point fails."
        )
        size = f"root mean square {scale.text(spline['rms'])}, largest {scale.text(spline['max'])}"
        alt = f"Distances along check spline {spline['id']}: {size}"
        blocks.append(FigureBlock("check_spline", caption, alt, subject=spline["id"]))
    if len(shown) < len(splines):
        blocks.append(Note(f"The {len(shown)} check splines with the largest distances of {len(splines)}."))
    return blocks


def histogram_blocks(data: ResultData) -> list[Block]:
    """Standardized residuals; none without a table of residuals."""
    if not data.residuals.rows:
        return []
    caption = (
        "Standardized residuals w = v / (σ₀ √q_vv) against the standard normal distribution: histogram, and the sorted "
        "values over the quantiles of N(0, 1), on the line where they are normal. Points give two values each (x and "
        "y), image points on splines one (across)."
    )
    found = [
        f"{name} {np.sqrt(np.mean(values**2)):.2f}"
        for name, values in standardized(data).items()
        if len(values)
    ]
    alt = f"Standardized residuals and the normal distribution, root mean square: {', '.join(found) or 'none tested'}"
    return [FigureBlock("histogram", caption, alt)]


def image_residual_blocks(data: ResultData) -> list[Block]:
    """Root mean square and vectors of the residuals of every image."""
    images = data["residuals"]["images"]
    sizes = [
        (image[kind]["rms_mm"], image["id"], kind)
        for image in images
        for kind in ("points", "splines")
        if image[kind]["rms_mm"] is not None
    ]
    largest = max(sizes, default=None)
    summary = (
        "" if largest is None else f"; largest {1e3 * largest[0]:.2f} µm, {largest[2]} in image {largest[1]}"
    )
    caption = (
        "Root mean square of the residuals of every image: points per coordinate, splines across the curve."
    )
    blocks: list[Block] = [
        FigureBlock(
            "image_residuals",
            caption,
            f"Root mean square residual of {_plural(len(images), 'image')}{summary}",
        )
    ]
    if data.image_points.rows:
        caption = (
            "Residual vectors (adjusted − measured) in the photo, the images with the largest root mean square first; one "
            "enlargement for all images, written under each. Vectors longer than a quarter of the image are cut; of an "
            "image with very many points those with the largest w are drawn, of very many images the worst. Point at a "
            "vector for its feature, v and w."
        )
        alt = f"Residual vectors of the images with the largest residuals{summary}"
        blocks.append(FigureBlock("image_vectors", caption, alt))
    return blocks


def reliability_blocks(data: ResultData) -> list[Block]:
    """Redundancy numbers and minimal detectable biases over the block and over the image formats."""
    if not data.residuals.rows:
        return []
    kinds = {kind["kind"]: kind for kind in data["tests"]["kinds"]}
    image_kinds = [kinds[name] for name in ("points, per coordinate", "splines, across") if name in kinds]
    if not image_kinds:
        return []
    mean = ", ".join(f"{kind['kind'].split(',')[0]} {kind['redundancy']['mean']:.2f}" for kind in image_kinds)
    caption = (
        "Mean redundancy number of the measurements of every point and of every part of a spline, at its place in the "
        "object (metres). Dark blue (light in a dark page): errors of these measurements hardly show in residuals."
    )
    blocks: list[Block] = [
        FigureBlock("redundancy_map", caption, f"Redundancy numbers in the block, mean: {mean}")
    ]
    for camera in data["cameras"]:
        caption = (
            f"Camera {camera['id']}, over the image format in mm: mean redundancy number r, and median minimal detectable "
            "bias (MDB) in µm, of all images together; points with x and y, splines across. Empty: nothing measured."
        )
        bias = [kind["minimal_detectable_bias"]["median"] for kind in image_kinds]
        known = [1e3 * value for value in bias if value is not None]
        size = f"; median MDB {', '.join(f'{value:.3g}' for value in known)} µm" if known else ""
        alt = f"Redundancy numbers and minimal detectable biases over the format of camera {camera['id']}, mean r: {mean}{size}"
        blocks.append(FigureBlock("format_map", caption, alt, subject=camera["id"]))
    return blocks


def variance_blocks(components: list[dict[str, Any]]) -> list[Block]:
    """Estimated against declared σ of every group."""
    known = [each for each in components if each["sigma0"] is not None]
    if not known:
        return []
    ratios = [each["factor"] * each["sigma0"] for each in known]
    caption = (
        "Estimated over declared σ of every group of observations with the 95 % interval of the estimate; 1: as declared. "
        "Red: the test of the group fails. Of many groups those that are farthest from 1, in units of their σ."
    )
    alt = (
        f"Estimated over declared σ of {_plural(len(known), 'group')}, {min(ratios):.2f} to {max(ratios):.2f}"
    )
    return [FigureBlock("variance", caption, alt)]


def convergence_blocks(log: list[dict[str, Any]]) -> list[Block]:
    """Cost and largest step of every iteration."""
    caption = (
        "v′Pv and the largest step, in units of the predicted σ, of every iteration; logarithmic scales."
    )
    last = log[-1]
    alt = (
        f"Cost and largest step of {_plural(len(log), 'iteration')}, at the end {last['cost']:.4g} and "
        f"{last['step']:.2g} σ"
    )
    return [FigureBlock("convergence", caption, alt)]


def residual_grid_blocks(grids: list[dict[str, Any]]) -> list[Block]:
    """Mean residuals over the format of every camera."""
    blocks: list[Block] = []
    for grid in grids:
        mean = np.array(grid["mean_mm"], dtype=float)
        size = np.hypot(mean[..., 0], mean[..., 1])
        largest = f"{1e3 * np.nanmax(size):.2g} µm" if np.isfinite(size).any() else "unknown"
        caption = (
            f"Mean residuals (adjusted − measured) of all images of camera {grid['camera']}, cell by cell of the image "
            "format, enlarged; the ellipse is three σ of a mean, red arrows leave it. Empty: too few residuals."
        )
        alt = f"Mean residual vectors over the image format of camera {grid['camera']}, longest {largest}"
        blocks.append(FigureBlock("residual_grid", caption, alt, grid["camera"]))
    return blocks


def _plural(count: int, noun: str) -> str:
    return f"{count} {noun}{'' if count == 1 else 's'}"
