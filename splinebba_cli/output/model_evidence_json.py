"""The parts of result.json about the model: variance components, tests of groups, systematic effects."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from splinebba_cli.core.evidence import Evidence


def model_evidence(evidence: Evidence) -> dict[str, Any]:
    """``variance_components``, ``group_tests`` and ``systematic``; mm in the photo, metres, NaN is null later."""
    return {
        "variance_components": [asdict(component) for component in evidence.variance_components],
        "group_tests": {
            "possible": evidence.possible_groups,
            "tested": len(evidence.groups),
            "tests": [dict(vars(test)) for test in evidence.groups],
        },
        "systematic": {
            "effects": [dict(vars(effect)) for effect in evidence.systematic],
            "grids": [
                {
                    "camera": grid.camera,
                    "x_edges_mm": grid.x_edges,
                    "y_edges_mm": grid.y_edges,
                    "mean_mm": grid.mean,
                    "sigma_mm": grid.sigma,
                    "count": grid.count.astype(int),
                }
                for grid in evidence.grids
            ],
        },
    }
