"""What a simulated network was made from, in the local frame of the network."""

from __future__ import annotations

from dataclasses import dataclass, replace

from splinebba_cli.core.camera.rotation import rotation_object_from_photo
from splinebba_cli.core.network import FloatArray, Network


@dataclass(frozen=True)
class Truth:
    """True values of everything that an adjustment estimates; indices as in the network."""

    eop: FloatArray  # (m, 6) omega, phi, kappa (rad), X0, Y0, Z0 (m, local frame)
    curves: tuple[FloatArray, ...]  # values of each curve: (k, 3) knots of a spline, metres
    points: FloatArray  # (n, 3) metres
    locations: (
        FloatArray  # (q,) u of every point measured on a curve; NaN where the family only approximates it
    )

    @property
    def rotation(self) -> FloatArray:
        """R (object from photo) of every image, (m, 3, 3)."""
        return rotation_object_from_photo(self.eop[:, :3])


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
