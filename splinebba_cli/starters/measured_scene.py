"""A scene measured with a digital camera: the network of a starter, with noise and rough approximate values."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.network import Distances, FloatArray, Network
from splinebba_cli.simulation.assembly import scene_design
from splinebba_cli.simulation.block_geometry import BlockGeometry
from splinebba_cli.simulation.feature_geometry import Feature, PointFeatures
from splinebba_cli.simulation.noise import Noise
from splinebba_cli.simulation.realization import Design, exact_network, realize
from splinebba_cli.starters.digital_camera import DigitalCamera


@dataclass(frozen=True)
class MeasuredScene:
    """What is there, and how it is measured."""

    block: BlockGeometry
    image_ids: tuple[str, ...]
    camera: DigitalCamera
    features: tuple[Feature, ...]
    points: PointFeatures
    points_per_curve: int  # measured points for every curve and image that sees it
    sigma_px: float  # of measured coordinates
    eop_sigma: FloatArray | None = None  # (6,) of observed exterior orientations (rad, m)

    def design(self, bars: tuple[tuple[str, str], ...] = (), bar_sigma_m: float = 0.0) -> Design:
        """Noise-free measurements; `bars` are points at the ends of scale bars."""
        made = scene_design(
            self.block,
            self.features,
            self.points,
            self.points_per_curve,
            self.eop_sigma,
            self.sigma_px * self.camera.pixel_size_mm,
        )
        network = replace(
            made.network,
            cameras=(self.camera.camera(),),
            images=replace(made.network.images, ids=self.image_ids),
            distances=_scale_bars(made.network, bars, bar_sigma_m),
        )
        return Design(exact_network(network, made.truth), made.truth)


def measured(design: Design, seed: int, start_m: float, start_angle_rad: float) -> Network:
    """The network of a seed; approximate positions and knots are wrong by up to `start_m`."""
    return realize(design, Noise(None, start_m, start_angle_rad, start_m), seed).network


def _scale_bars(network: Network, bars: tuple[tuple[str, str], ...], sigma_m: float) -> Distances:
    """Bars between points; their lengths are measured later."""
    if not bars:
        return Distances.none()
    number = {name: k for k, name in enumerate(network.points.ids)}
    station = np.array([[number[a], number[b]] for a, b in bars])
    not_yet, sigma = np.zeros(len(bars)), np.full(len(bars), sigma_m)
    return Distances(station, np.zeros(station.shape, dtype=bool), not_yet, sigma)
