"""Tie curves whose location parameters leave exact nulls: lines and free segments, in the six-image block."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.network import FloatArray, Network
from splinebba_cli.simulation.assembly import assemble
from splinebba_cli.simulation.block_geometry import six_image_block
from splinebba_cli.simulation.feature_geometry import Feature, PointFeatures, scattered_points
from splinebba_cli.simulation.noise import Noise
from splinebba_cli.simulation.truth import Truth, at_truth

LINE = np.array([[3150.0, 4520.0, 40.0], [3470.0, 4130.0, 62.0]])
CUBIC = np.array([[3120.0, 4110.0, 30.0], [380.0, 310.0, 20.0], [-90.0, 180.0, 35.0], [40.0, -120.0, -18.0]])
PARABOLA = np.array([[3180.0, 4250.0, 35.0], [250.0, 160.0, -15.0], [-60.0, 120.0, 25.0]])
STRAIGHT = np.linspace([3080.0, 4290.0, 38.0], [3520.0, 4370.0, 52.0], 5)
WINDING = np.array(
    [
        [3050.0, 4200.0, 30.0],
        [3150.0, 4330.0, 52.0],
        [3290.0, 4290.0, 31.0],
        [3400.0, 4420.0, 56.0],
        [3530.0, 4350.0, 35.0],
    ]
)
CONTROL_XY = np.array([[2990, 3800], [3620, 3790], [3615, 4810], [2985, 4820], [3300, 4300], [3305, 3990]])


def tie(id: str, family: str, values: FloatArray) -> Feature:
    """A curve of which nothing is known."""
    return Feature(id, "tie", values, np.full_like(values, np.inf), family=family)


def block_with(
    *features: Feature,
    fixed: bool = False,
    noise_um: float = 5.0,
    per_curve: int = 12,
    at_the_truth: bool = False,
) -> tuple[Network, Truth]:
    """The six images with control points and curves.

    Parameters
    ----------
    fixed : exterior orientations fixed at the truth
    at_the_truth : true values as approximate values
    """
    points = scattered_points((2960.0, 3700.0, 3640.0, 4910.0), CONTROL_XY.astype(float), 20, 0, 0.02)
    noise = Noise(1e-3 * noise_um, 0.5, 1e-3, 0.3)
    made = assemble(
        six_image_block(), features, PointFeatures() if fixed else points, per_curve, None, noise, seed=4
    )
    network, truth = made
    if at_the_truth:
        network = at_truth(network, truth)
    if fixed:
        images = replace(network.images, prior=truth.eop.copy(), prior_sigma=np.zeros_like(truth.eop))
        images = replace(images, rotation=truth.rotation, position=truth.eop[:, 3:].copy())
        network = replace(network, images=images)
    return network, truth
