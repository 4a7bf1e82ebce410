"""One image above control curves, and chains traced in it; truth is known."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from splinebba_cli.core.camera.rotation import rotation_object_from_photo
from splinebba_cli.core.curves.registry import basis_of
from splinebba_cli.core.matching.known_curves.label_round import LabelRound
from splinebba_cli.core.matching.known_curves.loop_context import LoopContext
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.network import Camera, Curve, FloatArray, Images, Network, UnlabelledPoints
from splinebba_cli.simulation.block_geometry import six_image_block
from tests.reference_data import no_curve_observations, no_points, omega_phi_kappa

SIGMA_MM = 0.005
MIDDLE = np.array([3000.0, 4000.0, 0.0])  # below the image; 1 m is 0.3 mm in it
BLOCK = six_image_block()
GOOD = MatchSettings(position_sigma_m=1e-4, angle_sigma_rad=1e-7)

ROADS = (
    [(-150, -100, 10), (-50, 30, 22), (50, -40, 5), (150, 120, 12)],
    [(-100, 120, 30), (-20, 30, 2), (50, -140, 15)],
)


def control(values: Sequence[tuple[float, float, float]], name: str) -> Curve:
    """A held natural spline by knots about the middle."""
    xyz = np.array(values, dtype=float) + MIDDLE
    return Curve(name, "control", "natural_cubic", xyz, np.zeros_like(xyz))


def seen(curve: Curve, count: int, first: float = 0.0, last: float = 1.0) -> FloatArray:
    """Exact image points (count, 2) along a part of a curve."""
    basis = basis_of(curve)
    low, high = basis.break_points[[0, -1]]
    u = low + (high - low) * np.linspace(first, last, count)
    return BLOCK.photo_xy(0, basis.evaluate(u, basis.coefficients_from_values(curve.values)))


def network(
    curves: Sequence[Curve], chains: Sequence[FloatArray], single: FloatArray | None = None
) -> Network:
    """The image with its true orientation, chains, and single points behind them."""
    parts = [*chains, np.zeros((0, 2)) if single is None else single]
    number = [np.full(len(xy), k if k < len(chains) else -1) for k, xy in enumerate(parts)]
    xy = np.vstack(parts)
    points, none = no_points()
    return Network(
        origin=np.zeros(3),
        cameras=(Camera("c", 150.0, np.zeros(2), np.zeros(3), np.zeros(2), np.zeros(2), None, (230.0, 230.0)),),
        images=Images(
            ("a",), np.zeros(1, dtype=np.int64), rotation_object_from_photo(BLOCK.eop[:1, :3]), BLOCK.eop[:1, 3:],
            omega_phi_kappa(1), np.full((1, 6), np.nan), np.full((1, 6), np.inf),
        ),
        points=points,
        curves=tuple(curves),
        point_observations=none,
        curve_observations=no_curve_observations(),
        unlabelled=UnlabelledPoints(
            np.zeros(len(xy), dtype=np.int64), xy, np.full((len(xy), 2), SIGMA_MM), np.concatenate(number),
            np.full(len(xy), np.nan), tuple(f"t{k}" for k in range(len(chains))),
        ),
    )  # fmt: skip


def labelled(given: Network, settings: MatchSettings = GOOD) -> LabelRound:
    """One round of labels at the given orientation."""
    context = LoopContext.of(given, settings, None)
    return context.label(context.begin(), context.start.known)
