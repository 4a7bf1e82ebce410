"""One close-range network in several datums: what stays, and whose trace is smallest.

    python -m benchmarks.free_network

The sample `free_network` in a minimal datum and in inner ones over points, images and splines.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.network import DatumFeatures, Network
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.project.loading import load_project

SAMPLE = Path(__file__).parents[1] / "sample_projects" / "free_network" / "project.yaml"
INNER = {
    "inner, points": DatumFeatures(),
    "inner, images": DatumFeatures(points=(), images=None),
    "inner, splines": DatumFeatures(points=(), curves=None),
    "inner, all": DatumFeatures(images=None, curves=None),
}


def in_datum(network: Network, features: DatumFeatures | None) -> AdjustmentResult:
    """The network adjusted in an inner datum, or in a minimal one."""
    datum = "minimal" if features is None else "inner"
    return adjust(replace(network, settings=replace(network.settings, datum=datum, datum_features=features)))


def root_trace(blocks: np.ndarray) -> float:
    """Root of the trace of the dispersion of many positions, mm."""
    return 1e3 * float(np.sqrt(np.einsum("nii->", blocks)))


def main() -> None:
    network = load_project(SAMPLE).network
    minimal = in_datum(network, None)
    print("datum            sigma0      largest dw   largest dr   trace^1/2: points  stations [mm]")
    for name, features in {"minimal": None, **INNER}.items():
        result = minimal if features is None else in_datum(network, features)
        pairs = [
            (result.point_residuals, minimal.point_residuals),
            (result.curve_residuals, minimal.curve_residuals),
        ]
        w = max(float(np.nanmax(np.abs(a.standardized - b.standardized))) for a, b in pairs)
        r = max(float(np.abs(a.redundancy - b.redundancy).max()) for a, b in pairs)
        points, stations = (
            root_trace(result.points.dispersion),
            root_trace(result.images.dispersion[:, 3:, 3:]),
        )
        print(
            f"{name:16s} {result.statistics.sigma0:.7f}  {w:10.1e}  {r:10.1e}  {points:16.3f} {stations:14.3f}"
        )


if __name__ == "__main__":
    main()
