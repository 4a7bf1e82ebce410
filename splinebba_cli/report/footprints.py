"""Footprints: what the image formats cover of the ground."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.report.object_view import rotation, stations
from splinebba_cli.report.result_data import ResultData

_STEEP = 0.2  # of the length of a ray, its fall: flatter rays have no useful corner


def footprints(data: ResultData) -> dict[str, FloatArray]:
    """Corners (4, 2) of the image formats at the median height of the object, by image.

    Images that look aside, and those whose format is not known, have none.
    """
    cameras = {camera["id"]: camera for camera in data["cameras"]}
    centres = stations(data)
    ground = _ground_height(data, centres)
    found = {}
    for image, station in zip(data["images"], centres, strict=True):
        camera = cameras[image["camera"]]
        if camera["format_mm"] is None:
            continue
        half = 0.5 * np.array(camera["format_mm"])
        xy = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half - camera["principal_point_mm"]
        rays = np.column_stack([xy, np.full(4, -camera["principal_distance_mm"])]) @ rotation(image).T
        if np.all(rays[:, 2] < -_STEEP * np.linalg.norm(rays, axis=1)) and station[2] > ground:
            found[image["id"]] = station[:2] + rays[:, :2] * ((ground - station[2]) / rays[:, 2])[:, None]
    return found


def _ground_height(data: ResultData, centres: FloatArray) -> float:
    heights = [point["z"] for point in data["points"]]
    heights += [knot[2] for spline in data["splines"] for knot in spline["knots"]]
    finite = [height for height in heights if height is not None]
    return float(np.median(finite)) if finite else float(np.min(centres[:, 2], initial=0.0))
