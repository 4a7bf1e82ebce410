"""Pixel coordinates outside of their image: where they stand, and which other frame would explain many of them."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.project.build_context import Building
from splinebba_cli.project.diagnostics import SHOWN_PER_KIND
from splinebba_cli.project.table import Table

BESIDE = 1.0  # pixels that a measurement may lie outside
NEARLY_ALL = 0.98  # of the measurements that another frame has to bring into the image


def outside_of_image(xy: FloatArray, size: FloatArray) -> IntArray:
    """Rows of pixel coordinates, (n, 2), that lie outside of an image, (2,) width and height."""
    return np.flatnonzero(((xy < -BESIDE) | (xy > size + BESIDE)).any(axis=1))


def warn_of_outside(
    rows: IntArray, xy: FloatArray, size: FloatArray, table: Table, building: Building
) -> None:
    """SBB313: each of a few measurements, or all of many in one.

    Parameters
    ----------
    rows : (m,) int
        Of the table, measured with one camera.
    xy : (m, 2) float
    """
    outside = outside_of_image(xy, size)
    text = f"outside of the image ({size[0]:g} × {size[1]:g} px)"
    if len(outside) <= SHOWN_PER_KIND:
        for row in rows[outside].tolist():
            place = table.place_of(row, "x")
            building.collector.warning(
                "SBB313", f"measured {text}", place, kind="measurements outside of the image"
            )
        return
    message = f"{len(outside)} of {len(rows)} measurements lie {text}, the first of them here"
    place = table.place_of(int(rows[outside[0]]), "x")
    building.collector.warning("SBB313", message, place, likely_frame(xy, size))


def likely_frame(xy: FloatArray, size: FloatArray) -> str:
    """What would bring pixel coordinates into their image, as a help line.

    Parameters
    ----------
    xy : (n, 2) float, pixels as they were given
    size : (2,) float, width and height of the image
    """
    down = np.array([1.0, -1.0])
    frames = (
        (xy[:, ::-1], "x and y seem to be swapped: x is the column, y the row"),
        (xy * down, "y seems to point up from the upper edge: it counts down from there"),
        (
            xy + 0.5 * size,
            "they seem to count from the middle of the image: pixels count from its upper left corner",
        ),
    )
    for inside, help in frames:
        if len(outside_of_image(inside, size)) <= (1.0 - NEARLY_ALL) * len(xy):
            return help
    return (
        "look at `image_size_px` (width first) and `image_coordinates`; were they measured in a smaller or larger "
        "image?"
    )
