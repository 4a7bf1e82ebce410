"""What a simulated network was made from, in the local frame of the network."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.camera.rotation import rotation_object_from_photo
from splinebba_cli.core.curves.basis import CurveBasis
from splinebba_cli.core.curves.registry import basis_of, lasting_parameters
from splinebba_cli.core.network import Curve, FloatArray, Network, RotationSequence
from splinebba_cli.core.state import Prepared, State

Shape = tuple[CurveBasis, FloatArray]  # basis and coefficients (k, 3) of a curve, local frame


@dataclass(frozen=True)
class Truth:
    """True values of everything that an adjustment estimates; indices as in the network."""

    eop: FloatArray  # (m, 6) omega, phi, kappa (rad), X0, Y0, Z0 (m, local frame)
    curves: tuple[FloatArray, ...]  # values of each curve: (k, 3) knots of a spline, metres
    points: FloatArray  # (n, 3) metres
    locations: FloatArray  # (q,) u of every measured point; NaN where the family only approximates it
    sequence: tuple[RotationSequence, ...] = ()  # (m,) of the angles; empty: omega-phi-kappa

    @property
    def rotation(self) -> FloatArray:
        """R (object from photo) of every image, (m, 3, 3)."""
        return rotations_of(self.eop[:, :3], self.sequence)


def rotations_of(angles: FloatArray, sequence: tuple[RotationSequence, ...]) -> FloatArray:
    """R (object from photo) of angles (m, 3), each row in its own sequence; empty: omega-phi-kappa."""
    rotation = rotation_object_from_photo(angles)
    other = np.array([s == "phi-omega-kappa" for s in sequence], dtype=bool)
    if other.any():
        rotation[other] = rotation_object_from_photo(angles[other], "phi-omega-kappa")
    return rotation


def at_truth(network: Network, truth: Truth) -> Network:
    """The network with its true values as approximate values; observations and priors stay."""
    return replace(
        network,
        images=replace(network.images, rotation=truth.rotation, position=truth.eop[:, 3:].copy()),
        points=replace(network.points, xyz=truth.points.copy()),
        curves=tuple(
            replace(curve, values=values.copy())
            for curve, values in zip(network.curves, truth.curves, strict=True)
        ),
        curve_observations=replace(network.curve_observations, location=truth.locations.copy()),
    )


def true_state(prepared: Prepared, truth: Truth) -> State:
    """The state of the core at the truth; `prepared` gives the curves' bases."""
    parts = [
        basis.coefficients_from_values(values)
        for basis, values in zip(prepared.curves.bases, truth.curves, strict=True)
    ]
    return State(
        rotation=truth.rotation,
        position=truth.eop[:, 3:].copy(),
        coefficients=np.vstack(parts) if parts else np.zeros((0, 3)),
        xyz=truth.points.copy(),
        location=truth.locations.copy(),
    )


def shape_of(curve: Curve, values: FloatArray) -> Shape:
    """Basis and coefficients of a curve with the given values."""
    basis = basis_of(replace(curve, values=values))
    return basis, basis.coefficients_from_values(values)


def with_fixed_parameters(curve: Curve, values: FloatArray) -> Curve:
    """The curve with the knot parameters of `values` written out: wrong starts do not change the family of curves."""
    if curve.knot_parameters is not None or curve.parameterization == "uniform":
        return curve
    return replace(curve, knot_parameters=lasting_parameters(curve, shape_of(curve, values)[0]))
