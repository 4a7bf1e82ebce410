"""Curves as an image sees them: polylines in its measured photo coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.camera.collinearity import project
from splinebba_cli.core.camera.distortion import corrected_photo_xy, measured_photo_xy
from splinebba_cli.core.matching.matches import BuiltCurve
from splinebba_cli.core.network import BoolArray, Camera, FloatArray, IntArray, Network
from splinebba_cli.core.state import initial_coefficients, prepare

SAMPLES = 12  # of a segment
BEYOND = 1.1  # times the reach of the corrected image: farther out distortion says nothing


@dataclass(frozen=True)
class ProjectedCurves:
    """Samples along all curves of a network, and how images see them."""

    network: Network
    curve: IntArray  # (n,) of the samples, one curve after another
    weak: BoolArray  # (n,) in a part that images do not hold
    xyz: FloatArray  # (n, 3) metres, local frame

    @classmethod
    def of(cls, network: Network, built: Sequence[BuiltCurve] = ()) -> ProjectedCurves:
        """The curves of a network by their approximate values; built ones have parts that are weak."""
        prepared = prepare(network)
        curves = prepared.curves
        owner = np.repeat(np.arange(len(network.curves)), np.diff(curves.segment_start))
        t = np.linspace(0.0, 1.0, SAMPLES + 1)
        u = (curves.left[:, None] + curves.length[:, None] * t).ravel()
        curve = np.repeat(owner, SAMPLES + 1)
        (xyz,) = curves.evaluate(initial_coefficients(prepared), curve, u, (0,))
        weak = np.zeros(len(u), dtype=bool)
        for each in built:
            for part in each.weak_parts:
                weak |= (curve == each.curve) & (u >= part.first) & (u <= part.last)
        return cls(network, curve, weak, xyz)

    def lines(self, image: int, half: FloatArray) -> list[tuple[int, bool, FloatArray]]:
        """Visible parts of the curves in an image: number of the curve, whether weak, (k, 2) mm as measured.

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
        same = (np.diff(self.curve) == 0) & seen[1:] & seen[:-1]
        out = []
        for weak in (False, True):
            # a step between two samples is weak where one of them is
            steps = np.flatnonzero(same & ((self.weak[1:] | self.weak[:-1]) == weak))
            for run in np.split(steps, np.flatnonzero(np.diff(steps) > 1) + 1) if len(steps) else []:
                rows = np.append(run, run[-1] + 1)
                out.append((int(self.curve[rows[0]]), weak, measured_photo_xy(camera, xy[rows])))
        return out


def _reach(camera: Camera, half: FloatArray) -> FloatArray:
    """Largest |x| and |y| of the corrected corners, (2,) mm."""
    corners = half * np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])
    return np.asarray(np.abs(corrected_photo_xy(camera, corners)[0]).max(axis=0))
