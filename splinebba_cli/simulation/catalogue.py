"""The simulated blocks by name, written as projects with their truth beside them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from splinebba_cli.core.network import Network
from splinebba_cli.simulation.six_image_block import KINDS
from splinebba_cli.simulation.targets import block_target, write_target
from splinebba_cli.simulation.truth import Truth
from splinebba_cli.simulation.truth_file import truth_content

__all__ = ["KINDS", "truth_data", "write"]


def write(kind: str, folder: Path, seed: int = 1, noise_um: float = 5.0) -> Path:
    """Write a simulated block as a project.

    Parameters
    ----------
    kind : a key of :data:`KINDS`
    folder : created where it does not exist
    seed : of noise and wrong starts
    noise_um : standard deviation of measured photo coordinates, micrometres

    Returns
    -------
    Path of the project file; ``truth.json`` lies beside it, in the user's frame, metres and degrees.
    """
    return write_target(block_target(kind, {"image_mm": 1e-3 * noise_um}), folder, seed)


def truth_data(kind: str, seed: int, noise_um: float, network: Network, truth: Truth) -> dict[str, Any]:
    """The truth of a simulated block as plain data (:func:`.truth_file.truth_content`)."""
    return truth_content(network, truth, {"kind": kind, "seed": seed, "noise_um": noise_um})
