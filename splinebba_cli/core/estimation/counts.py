"""Counts of equations and unknowns."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.estimation.normal_equations import Assembler, Linearization
from splinebba_cli.core.observations.coefficient_rows import GAUGE


def count_equations(assembler: Assembler, at: Linearization) -> int:
    """Equations of measurements, control, priors and shape conditions; locations not yet eliminated."""
    network = assembler.prepared.network
    priors = int(np.count_nonzero(at.orientation_priors.active))
    points = int(np.count_nonzero(assembler.point_inverse_sigma > 0.0))
    values = int(np.count_nonzero(assembler.coefficient_rows.component != GAUGE))
    return (
        2 * len(network.point_observations) + 2 * len(network.curve_observations)
        + len(network.arc_lengths) + len(network.tangents) + len(network.distances)
        + priors + points + values
    )  # fmt: skip
