"""Whether given orientations, given points and measurements belong together, before anything is adjusted.

A wrong unit of angles, another rotation sequence, a y axis that points the other way or swapped columns leave a network
that has no solution, or one far away; what then fails first says nothing about the cause.  Points with given
coordinates, projected with the given orientations, do: they come to lie where nobody has measured them.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from splinebba_cli.core.camera.collinearity import project
from splinebba_cli.core.camera.distortion import corrected_photo_xy
from splinebba_cli.core.network import Camera, FloatArray, IntArray, Network
from splinebba_cli.core.result import Problem
from splinebba_cli.errors import NotSolvableError

CONSPICUOUS = 0.05  # of the diagonal of the format; 2 degrees at normal angles give 0.04
SUSPICIOUS = 0.03  # where there is no solution
FEWEST = 3  # measurements that tell something
HELP = (
    "usual for rough orientations; else look at the order of the columns, `angle_unit`, `rotation_sequence`, signs of "
    "the angles, `image_coordinates` (does y point up or down?), `pixel_size_mm` and the principal distance"
)


@contextmanager
def told_of_misfit(network: Network) -> Iterator[None]:
    """A network without a solution: its problems are followed by the misfit of what is given, if there is one."""
    try:
        yield
    except NotSolvableError as error:
        found = misfit_of_given(network, SUSPICIOUS)
        if not found:
            raise
        raise type(error)((*error.problems, *found)) from error


def misfit_of_given(network: Network, limit: float = CONSPICUOUS) -> tuple[Problem, ...]:
    """A warning naming images from which given points are typically seen far from where they are measured.

    Parameters
    ----------
    limit : of the distance, a share of the diagonal of the format
    """
    observed, images = network.point_observations, network.images
    given = np.isfinite(network.points.xyz).all(axis=1) & (
        np.array(network.points.role, dtype=object) != "tie"
    )
    rows = np.flatnonzero(images.has_orientation[observed.image] & given[observed.point])
    if len(rows) < FEWEST:
        return ()
    distance, diagonal = _distances(network, rows)
    image = observed.image[rows]
    far = {
        images.ids[k]: float(np.median(distance[image == k]))
        for k in np.unique(image)
        if np.median((distance / diagonal)[image == k]) > limit
    }
    if not far:
        return ()
    names = ", ".join(f"`{id}`" for id in list(far)[:6]) + (
        f" and {len(far) - 6} more" if len(far) > 6 else ""
    )
    largest = max(far.values())
    where = "behind the image" if np.isinf(largest) else f"up to {_length(network, largest)} away"
    message = (
        f"image{'s' if len(far) > 1 else ''} {names}: with the orientation as given, control and check points are "
        f"typically seen far from where they are measured ({where})"
    )
    return (Problem("SBB506", "warning", message, "approximate values", HELP),)


def _distances(network: Network, rows: IntArray) -> tuple[FloatArray, FloatArray]:
    """Of measured points from their projections, and diagonals of their formats: (k,) mm, inf behind the image."""
    observed, images = network.point_observations, network.images
    image = observed.image[rows]
    camera = images.camera[image]
    distances = np.array([each.principal_distance_mm for each in network.cameras])
    xyz = network.points.xyz[observed.point[rows]]
    measured = np.empty((len(rows), 2))
    diagonal = np.empty(len(rows))
    for number, each in enumerate(network.cameras):
        own = camera == number
        if own.any():
            measured[own] = corrected_photo_xy(each, observed.photo_xy[rows][own])[0]
            diagonal[own] = _diagonal(each, measured[own])
    expected = project(distances[camera], images.rotation[image], images.position[image], xyz)
    away = np.linalg.norm(expected - measured, axis=1)
    return np.where(np.isfinite(away), away, np.inf), diagonal


def _diagonal(camera: Camera, measured: FloatArray) -> float:
    """Of the format, mm; of a camera without one, what its measurements reach."""
    if camera.format_mm is not None:
        return float(np.hypot(*camera.format_mm))
    return 2.0 * float(np.linalg.norm(measured, axis=1).max())


def _length(network: Network, millimetres: float) -> str:
    sizes = {camera.pixel_size_mm for camera in network.cameras}
    size = sizes.pop() if len(sizes) == 1 else None
    return f"{millimetres:.3g} mm" if size is None else f"{millimetres / size:.0f} px"
