"""The simulated blocks by name, written as projects with their truth beside them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from splinebba_cli.core.curves.registry import FAMILIES
from splinebba_cli.core.network import FloatArray, Network
from splinebba_cli.simulation.six_image_block import simulate_block
from splinebba_cli.simulation.truth import Truth

KINDS: dict[str, str] = {
    "six-image": "Lee's six images (table 5.3): control, partial control and tie splines of several segments",
    "six-image-mixed": "the same images: control, tie and check points with partial, tie and check splines",
    "six-image-singular": "the same images and one control segment (table 5.7): cannot be determined",
    "circle-three-ways": "one circle in four images, measured as a circle, a closed natural spline and a Fourier curve",
    "strip": "five images with observed orientations, control, ties; coordinates of millions of metres",
}
TRUTH_FORMAT = "splinebba-truth/1"


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
    text = json.dumps(truth_data(kind, seed, noise_um, network, truth), indent=1, allow_nan=False)
    (path.parent / "truth.json").write_text(text + "\n", encoding="utf-8")
    return path


def truth_data(kind: str, seed: int, noise_um: float, network: Network, truth: Truth) -> dict[str, Any]:
    """The truth as plain data in the layout of result.json: user's frame, metres and degrees."""
    eop = truth.eop.copy()
    eop[:, :3] = np.remainder(np.degrees(eop[:, :3]) + 180.0, 360.0) - 180.0  # as results are given
    eop[:, 3:] += network.origin
    names = ("omega", "phi", "kappa", "x", "y", "z")
    return {
        "format": TRUTH_FORMAT,
        "simulation": {"kind": kind, "seed": seed, "noise_um": noise_um},
        "images": [
            {"id": id, **dict(zip(names, row, strict=True))}
            for id, row in zip(network.images.ids, eop.tolist(), strict=True)
        ],
        "splines": [
            {
                "id": curve.id,
                "family": curve.family,
                "closed": curve.closed,
                "values": _user_values(curve.family, values, network.origin).tolist(),
            }
            for curve, values in zip(network.curves, truth.curves, strict=True)
        ],
        "points": [
            {"id": id, **dict(zip("xyz", row, strict=True))}
            for id, row in zip(network.points.ids, (truth.points + network.origin).tolist(), strict=True)
        ],
        "locations": [None if np.isnan(u) else u for u in truth.locations.tolist()],
    }


def _user_values(family: str, values: FloatArray, origin: FloatArray) -> FloatArray:
    """Values of a curve in the user's frame: vectors among them are not shifted."""
    return np.asarray(values + np.where(FAMILIES[family].positions(len(values))[:, None], origin, 0.0))
