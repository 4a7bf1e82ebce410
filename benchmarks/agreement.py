"""Whether two programs have found the same: v'Pv, exterior orientations in units of sigma, sigma of one image.

Rotations are compared as rotations: theta of R' R_other, in the frame in which sigma is that of (theta, X0).
The programs treat points next to a joint differently (:mod:`benchmarks.peer_rule`): v'Pv differs by 1e-7 of itself
as it is, and only by what the peer's termination leaves where it is computed by the peer's rule.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from splinebba_cli.core.camera.rotation import rotation_object_from_photo
from splinebba_cli.core.network import FloatArray


@dataclass(frozen=True)
class Agreement:
    """Differences between this program and the peer."""

    cost: float  # relative, each by its own rule
    cost_peer_rule: float  # relative, both by the peer's rule
    largest_difference: float  # of an orientation element, in sigma
    rms_difference: float  # of all orientation elements, in sigma
    sigma_x: float | None  # relative, of the image in the middle; None without the peer's dispersion
    sigma_z: float | None


def orientation_differences(ours: FloatArray, other: FloatArray, sigma: FloatArray) -> FloatArray:
    """(other - ours) / sigma of (theta, X0) of every image, (m, 6).

    Parameters
    ----------
    ours, other : (m, 6) omega, phi, kappa (rad), X0, Y0, Z0 (m)
    sigma : (m, 6) of (theta, X0): rad, m
    """
    turned = np.matmul(
        rotation_object_from_photo(ours[:, :3]).transpose(0, 2, 1), rotation_object_from_photo(other[:, :3])
    )
    skew = 0.5 * (turned - turned.transpose(0, 2, 1))
    theta = np.column_stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]])  # sin of a small angle
    return np.asarray(np.column_stack([theta, other[:, 3:] - ours[:, 3:]]) / sigma)


def agreement(figures: dict[str, Any], estimates: Path, peer: dict[str, Any], dump: Path) -> dict[str, Any]:
    """Differences of one run of each.

    Parameters
    ----------
    figures, estimates : what ``benchmarks.solve_block`` printed and wrote
    peer, dump : what the peer printed (with its dispersion or without) and wrote
    """
    with np.load(estimates) as archive:
        difference = orientation_differences(archive["eop"], np.loadtxt(dump, ndmin=2), archive["sigma"])

    def relative(ours: str, theirs: str) -> float | None:
        return figures[ours] / peer[theirs] - 1.0 if theirs in peer else None

    return asdict(
        Agreement(
            cost=figures["cost"] / peer["final_cost"] - 1.0,
            cost_peer_rule=figures["cost_peer_rule"] / peer["final_cost"] - 1.0,
            largest_difference=float(np.abs(difference).max()),
            rms_difference=float(np.sqrt(np.mean(difference**2))),
            sigma_x=relative("sigma_x", "sX"),
            sigma_z=relative("sigma_z", "sZ"),
        )
    )
