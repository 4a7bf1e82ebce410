"""Curves as an image sees them: polylines in its measured photo coordinates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.camera.collinearity import project
from splinebba_cli.core.camera.distortion import corrected_photo_xy, measured_photo_xy
from splinebba_cli.core.network import Camera, FloatArray, IntArray, Network
from splinebba_cli.core.state import initial_coefficients, prepare

SAMPLES = 12  # of a segment
BEYOND = 1.1  # times the reach of the corrected image: farther out distortion says nothing


@dataclass(frozen=True)
class ProjectedCurves:
    """Samples along all curves of a network, and how images see them."""

    network: Network
    curve: IntArray  # (n,) of the samples, one curve after another
    xyz: FloatArray  # (n, 3) metres, local frame

    @classmethod
    def of(cls, network: Network) -> ProjectedCurves:
        """The curves of a network by their approximate values."""
        prepared = prepare(network)
        curves = prepared.curves
        owner = np.repeat(np.arange(len(network.curves)), np.diff(curves.segment_start))
        t = np.linspace(0.0, 1.0, SAMPLES + 1)
        u = (curves.left[:, None] + curves.length[:, None] * t).ravel()
        curve = np.repeat(owner, SAMPLES + 1)
        (xyz,) = curves.evaluate(initial_coefficients(prepared), curve, u, (0,))
        return cls(network, curve, xyz)

    def lines(self, image: int, half: FloatArray) -> list[tuple[int, FloatArray]]:
        """Visible parts of the curves in an image: number of the curve, (k, 2) mm as measured.

        Parameters
        ----------
        half : (2,) mm, half of the width and height that are of interest
        """
        images = self.network.images
        if not images.has_orientation[image]:
            return []
        camera = self.network.cameras[int(images.camera[image])]
        rotation = np.broadcast_to(images.rotation[image], (len(self.xyz), 3, 3))
        distance = np.full(len(self.xyz), camera.principal_distance_mm)
        with np.errstate(invalid="ignore"):
            xy = project(distance, rotation, images.position[image : image + 1], self.xyz)
            seen = np.asarray((np.abs(xy) <= BEYOND * _reach(camera, half)).all(axis=1))
        breaks = np.flatnonzero(np.diff(self.curve) | ~seen[1:] | ~seen[:-1]) + 1
        parts = [part for part in np.split(np.arange(len(seen)), breaks) if len(part) > 1]
        return [(int(self.curve[part[0]]), measured_photo_xy(camera, xy[part])) for part in parts]


def _reach(camera: Camera, half: FloatArray) -> FloatArray:
    """Largest |x| and |y| of the corrected corners, (2,) mm."""
    corners = half * np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])
    return np.asarray(np.abs(corrected_photo_xy(camera, corners)[0]).max(axis=0))
