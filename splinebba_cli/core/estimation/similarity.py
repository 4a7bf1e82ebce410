"""Similarity transformations of a network: the directions of its datum, and moving it along them.

    X -> c + t + e^s exp(w) (X - c)

turns every measurement in the images into itself.  As directions of the unknowns, seven columns G (shift, rotation,
scale): points and perspective centres dX = t + w x (X - c) + s (X - c); attitudes theta = R'w (photo frame);
coefficients of a curve sum_j N_j P_j with sum_j N_j tau_j = 1: dP_j = (t - w x c - s c) tau_j + w x P_j + s P_j.
Rotation and scale are taken about the mean c of the stations and in units of their extent, so that all columns
displace the network by about one metre.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.camera.rotation import rotation_from_vector
from splinebba_cli.core.curves.registry import FAMILIES
from splinebba_cli.core.estimation.parameters import ParameterLayout
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.state import Prepared, State

PARAMETERS = 7


@dataclass(frozen=True)
class SimilarityDirections:
    """Columns G over all unknowns, removed ones too."""

    orientation: FloatArray  # (m, 6, 7) of (theta, X0)
    coefficients: FloatArray  # (C, 3, 7)
    point: FloatArray  # (n, 3, 7)
    centre: FloatArray  # (3,)
    extent: float  # metres

    @property
    def count(self) -> int:
        """Number of directions d."""
        return int(self.orientation.shape[2])

    def combined(self, weights: FloatArray) -> SimilarityDirections:
        """Other columns G V, V (7, d)."""
        return replace(
            self,
            orientation=self.orientation @ weights,
            coefficients=self.coefficients @ weights,
            point=self.point @ weights,
        )

    def reduced(self, layout: ParameterLayout) -> FloatArray:
        """Rows of the reduced unknowns, (N, d)."""
        return reduced_rows(layout, self.orientation, self.coefficients, self.point)


def reduced_rows(
    layout: ParameterLayout, orientation: FloatArray, coefficients: FloatArray, point: FloatArray
) -> FloatArray:
    """Columns over all unknowns (m, 6, d), (C, 3, d), (n, 3, d) as rows of the reduced ones, (N, d)."""
    count = orientation.shape[2]
    out = np.zeros((int(layout.node_starts[-1]), count))
    out[: layout.image_mask.size] = orientation.reshape(-1, count)
    out[layout.unknown_of_coefficient[:, None] + np.arange(3)] = coefficients
    kept = layout.kept_points
    out[layout.unknown_of_point[kept]] = point[kept]
    return out


def similarity_directions(prepared: Prepared, state: State) -> SimilarityDirections:
    """The seven directions at a state."""
    centre = state.position.mean(axis=0)
    extent = float(np.sqrt(np.mean(np.sum((state.position - centre) ** 2, axis=1))))
    extent = extent if extent > 0.0 else 1.0
    m = len(state.position)
    orientation = np.zeros((m, 6, PARAMETERS))
    orientation[:, 3:] = _of_positions(state.position, centre, extent)
    orientation[:, :3, 3:6] = state.rotation.transpose(0, 2, 1) / extent
    unit = unit_coefficients(prepared)
    coefficients = np.zeros((len(unit), 3, PARAMETERS))
    coefficients[:, :, :3] = unit[:, None, None] * np.eye(3)
    offset = state.coefficients - unit[:, None] * centre
    coefficients[:, :, 3:] = _turned_and_scaled(offset, extent)
    return SimilarityDirections(
        orientation, coefficients, _of_positions(state.xyz, centre, extent), centre, extent
    )


def moved_by(
    prepared: Prepared, state: State, directions: SimilarityDirections, parameters: FloatArray
) -> State:
    """The state after the similarity of seven parameters in the units of the directions."""
    shift, turn = parameters[:3], rotation_from_vector(parameters[None, 3:6] / directions.extent)[0]
    scale, centre = float(np.exp(parameters[6] / directions.extent)), directions.centre

    def moved(xyz: FloatArray) -> FloatArray:
        return np.asarray(centre + shift + scale * (xyz - centre) @ turn.T)

    unit = unit_coefficients(prepared)[:, None]
    coefficients = unit * (centre + shift) + scale * (state.coefficients - unit * centre) @ turn.T
    return replace(
        state,
        rotation=turn @ state.rotation,
        position=moved(state.position),
        coefficients=coefficients,
        xyz=moved(state.xyz),
    )


def unit_coefficients(prepared: Prepared) -> FloatArray:
    """tau: the coefficients of all curves for which sum_j N_j tau_j = 1 everywhere, (C,)."""
    parts = [np.zeros(0)]
    for curve, basis in zip(prepared.network.curves, prepared.curves.bases, strict=True):
        ones = FAMILIES[curve.family].positions(len(curve.values)).astype(np.float64)
        parts.append(basis.coefficients_from_values(np.repeat(ones[:, None], 3, axis=1))[:, 0])
    return np.concatenate(parts)


def _of_positions(xyz: FloatArray, centre: FloatArray, extent: float) -> FloatArray:
    out = np.zeros((len(xyz), 3, PARAMETERS))
    out[:, :, :3] = np.eye(3)
    out[:, :, 3:] = _turned_and_scaled(xyz - centre, extent)
    return out


def _turned_and_scaled(offset: FloatArray, extent: float) -> FloatArray:
    """e_k x offset for the three axes, and the offset itself, over the extent, (n, 3, 4)."""
    turned = np.cross(np.eye(3)[None], offset[:, None, :])  # (n, axis, coordinate)
    return np.concatenate([turned.transpose(0, 2, 1), offset[:, :, None]], axis=2) / extent
