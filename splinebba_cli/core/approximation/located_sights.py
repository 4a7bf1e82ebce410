"""Measured points whose place in the object is known although they are no control points: on known curves, located."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.approximation.control_network import known_curves
from splinebba_cli.core.approximation.point_tangent_resection import PointsWithTangents
from splinebba_cli.core.network import FloatArray, IntArray, Network
from splinebba_cli.core.state import initial_coefficients, prepare


class LocatedSights:
    """Points measured on control curves with a given location, and their tangents, by image."""

    def __init__(self, network: Network) -> None:
        observed = network.curve_observations
        usable = known_curves(network)[observed.curve] & np.isfinite(observed.location)
        if observed.excluded is not None:
            usable &= ~observed.excluded
        self._rows = np.flatnonzero(usable)
        self.image = observed.image[self._rows]
        if not len(self._rows):
            return
        prepared = prepare(network)
        curve, u = observed.curve[self._rows], observed.location[self._rows]
        xyz, tangent = prepared.curves.evaluate(initial_coefficients(prepared), curve, u, (0, 1))
        with np.errstate(invalid="ignore", divide="ignore"):
            tangent = tangent / np.linalg.norm(tangent, axis=1, keepdims=True)
        direction, sigma = np.full((len(observed), 2), np.nan), np.full(len(observed), np.nan)
        measured, own = network.tangents, prepared.tangents
        kept = np.arange(len(measured)) if measured.excluded is None else np.flatnonzero(~measured.excluded)
        direction[measured.point[kept]] = np.column_stack([np.cos(own.value[kept]), np.sin(own.value[kept])])
        sigma[measured.point[kept]] = own.sigma[kept]
        directed = np.zeros(len(observed), dtype=bool)
        directed[measured.point[kept]] = measured.directed[kept]
        lever = np.sqrt(np.mean(observed.sigma[self._rows] ** 2, axis=1)) / sigma[self._rows]
        self._points = PointsWithTangents(
            prepared.curve_rays.xy[self._rows],
            xyz,
            direction[self._rows],
            tangent,
            lever,
            directed[self._rows],
        )

    def of_image(self, image: int, photo_xy: FloatArray, object_xyz: FloatArray) -> PointsWithTangents | None:
        """These of an image behind points of known place; None where there are none of them."""
        rows: IntArray = np.flatnonzero(self.image == image)
        if not len(rows):
            return None
        own, count = self._points, len(photo_xy)
        return PointsWithTangents(
            np.vstack([photo_xy, own.photo_xy[rows]]),
            np.vstack([object_xyz, own.object_xyz[rows]]),
            np.vstack([np.full((count, 2), np.nan), own.direction[rows]]),
            np.vstack([np.full((count, 3), np.nan), own.tangent[rows]]),
            np.concatenate([np.full(count, np.nan), own.lever[rows]]),
            np.concatenate([np.zeros(count, dtype=bool), own.directed[rows]]),
        )
