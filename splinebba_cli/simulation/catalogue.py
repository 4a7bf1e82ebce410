"""The simulated blocks by name, written as projects with their truth beside them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from splinebba_cli.core.network import Network
from splinebba_cli.simulation.six_image_block import simulate_block
from splinebba_cli.simulation.truth import Truth
from splinebba_cli.simulation.truth_file import TRUTH_FILE, truth_content, truth_text

KINDS: dict[str, str] = {
    "six-image": "Lee's six images (table 5.3): control, partial control and tie splines of several segments",
    "six-image-mixed": "the same images: control, tie and check points with partial, tie and check splines",
    "six-image-singular": "the same images and one control segment (table 5.7): cannot be determined",
    "strip": "five images with observed orientations, control, ties; coordinates of millions of metres",
}


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
    from splinebba_cli.project.writer import write_project

    network, truth = simulate_block(kind, seed, noise_um)
    path = write_project(
        network,
        folder,
        name=kind,
        description=KINDS[kind],
        simulation={"block": kind, "seed": seed, "image_sigma_um": noise_um},
    )
    text = truth_text(truth_data(kind, seed, noise_um, network, truth))
    (path.parent / TRUTH_FILE).write_text(text, encoding="utf-8")
    return path


def truth_data(kind: str, seed: int, noise_um: float, network: Network, truth: Truth) -> dict[str, Any]:
    """The truth of a simulated block as plain data (:func:`.truth_file.truth_content`)."""
    return truth_content(network, truth, {"kind": kind, "seed": seed, "noise_um": noise_um})
