"""Captions and descriptions of the figures of residuals, reliability and convergence, with their main numbers."""

from __future__ import annotations

from typing import Any

import numpy as np

from splinebba_cli.report.blocks import Block, FigureBlock, Note
from splinebba_cli.report.residual_figures import standardized
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.scale import plural

CAMERAS = 3  # with maps of their format


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
            f"Root mean square residual of {plural(len(images), 'image')}{summary}",
        )
    ]
    if data.image_points.rows:
        caption = (
            "Residual vectors (adjusted − measured) in the photo, the images with the largest root mean square first; "
            "one enlargement for all images, written under each. Vectors longer than a quarter of the image are cut; "
            "of an image with very many points those with the largest w are drawn, of very many images the worst. "
            "Point at a vector for its feature, v and w."
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
    for camera in _busiest(data):
        caption = (
            f"Camera {camera['id']}, over the image format in mm: mean redundancy number r, and median minimal "
            "detectable bias (MDB) in µm, of all images together; points with x and y, splines across. "
            "Empty: nothing measured."
        )
        bias = [kind["minimal_detectable_bias"]["median"] for kind in image_kinds]
        known = [1e3 * value for value in bias if value is not None]
        size = f"; median MDB {', '.join(f'{value:.3g}' for value in known)} µm" if known else ""
        alt = f"Redundancy numbers and MDB over the format of camera {camera['id']}, mean r: {mean}{size}"
        blocks.append(FigureBlock("format_map", caption, alt, subject=camera["id"]))
    if len(data["cameras"]) > CAMERAS:
        blocks.append(Note(f"The {CAMERAS} cameras with the most image points of {len(data['cameras'])}."))
    return blocks


def _busiest(data: ResultData) -> list[dict[str, Any]]:
    """Cameras with a map of their format: of many those with the most image points."""
    count: dict[str, int] = {}
    points = {
        image["id"]: image["points"]["n"] + image["splines"]["n"] for image in data["residuals"]["images"]
    }
    for image in data["images"]:
        count[image["camera"]] = count.get(image["camera"], 0) + points.get(image["id"], 0)
    chosen = sorted(count, key=lambda camera: -count[camera])[:CAMERAS]
    return [camera for camera in data["cameras"] if camera["id"] in chosen]


def variance_blocks(components: list[dict[str, Any]]) -> list[Block]:
    """Estimated against declared σ of every group."""
    known = [each for each in components if each["sigma0"] is not None]
    if not known:
        return []
    ratios = [each["factor"] * each["sigma0"] for each in known]
    caption = (
        "Estimated over declared σ of every group of observations with the 95 % interval of the estimate; 1: as "
        "declared. Red: the test of the group fails. Of many groups those that are farthest from 1, in units "
        "of their σ."
    )
    alt = (
        f"Estimated over declared σ of {plural(len(known), 'group')}, {min(ratios):.2f} to {max(ratios):.2f}"
    )
    return [FigureBlock("variance", caption, alt)]


def convergence_blocks(log: list[dict[str, Any]]) -> list[Block]:
    """Cost and largest step of every iteration."""
    caption = (
        "v′Pv and the largest step, in units of the predicted σ, of every iteration; logarithmic scales."
    )
    last = log[-1]
    alt = (
        f"Cost and largest step of {plural(len(log), 'iteration')}, at the end {last['cost']:.4g} and "
        f"{last['step']:.2g} σ"
    )
    return [FigureBlock("convergence", caption, alt)]


def residual_grid_blocks(grids: list[dict[str, Any]]) -> list[Block]:
    """Mean residuals over the format of every camera."""
    blocks: list[Block] = []
    sizes = {grid["camera"]: _largest_mean(grid) for grid in grids}
    for grid in sorted(grids, key=lambda grid: -sizes[grid["camera"]])[:CAMERAS]:
        largest = f"{1e3 * sizes[grid['camera']]:.2g} µm"
        caption = (
            f"Mean residuals (adjusted − measured) of all images of camera {grid['camera']}, cell by cell of the image "
            "format, enlarged; the ellipse is three σ of a mean, red arrows leave it: each cell by itself, where the "
            "table above has one α for all cells together. Empty: too few residuals."
        )
        alt = f"Mean residual vectors over the image format of camera {grid['camera']}, longest {largest}"
        blocks.append(FigureBlock("residual_grid", caption, alt, grid["camera"]))
    if len(grids) > CAMERAS:
        blocks.append(Note(f"The {CAMERAS} cameras with the longest mean residuals of {len(grids)}."))
    return blocks


def _largest_mean(grid: dict[str, Any]) -> float:
    """The longest mean residual of a grid, mm."""
    mean = np.array(grid["mean_mm"], dtype=float)
    return float(np.nan_to_num(np.hypot(mean[..., 0], mean[..., 1])).max(initial=0.0))
