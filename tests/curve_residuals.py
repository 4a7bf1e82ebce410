"""Distances of measured points from projected curves, by dense sampling."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.camera.collinearity import project
from splinebba_cli.core.camera.distortion import corrected_photo_xy
from splinebba_cli.core.curves.registry import basis_of
from splinebba_cli.core.network import FloatArray, Network


def residuals_across(network: Network) -> FloatArray:
    """Signed distances (n,) mm of measured points from the projected approximate curves, corrected frame.

    Independent of the program's own foot points; for checking frames, not for adjusting.
    """
    seen, images = network.curve_observations, network.images
    out = np.full(len(seen), np.nan)
    for curve in range(len(network.curves)):
        basis = basis_of(network.curves[curve])
        coefficients = basis.coefficients_from_values(network.curves[curve].values)
        samples = np.linspace(basis.break_points[0], basis.break_points[-1], 4000)
        xyz = basis.evaluate(samples, coefficients)
        for image in range(len(images.ids)):
            rows = np.flatnonzero((seen.curve == curve) & (seen.image == image))
            camera = network.cameras[images.camera[image]]
            measured = corrected_photo_xy(camera, seen.photo_xy[rows])[0]
            rotation = np.broadcast_to(images.rotation[image], (len(xyz), 3, 3))
            c = np.full(len(xyz), camera.principal_distance_mm)
            projected = project(c, rotation, images.position[image][None], xyz)
            nearest = np.argmin(np.sum((measured[:, None] - projected) ** 2, axis=2), axis=1)
            nearest = np.clip(nearest, 1, len(xyz) - 2)
            tangent = projected[nearest + 1] - projected[nearest - 1]
            offset = measured - projected[nearest]
            out[rows] = tangent[:, 0] * offset[:, 1] - tangent[:, 1] * offset[:, 0]
            out[rows] /= np.linalg.norm(tangent, axis=1)
    return out
