"""Errors of the elements of conics and circles over the σ that is reported for them.

The direction of the normal has a standard ellipse of which the larger semi-axis is reported; its error is taken along
that axis, which follows from the full dispersion D of (C, A, B) as the first eigenvector of J D Jᵀ.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.quality.conic_elements import conic_elements, conic_jacobian
from splinebba_cli.core.result import AdjustmentResult, ConicElements
from splinebba_cli.errors import NotSolvableError
from splinebba_cli.simulation.campaign import Campaign
from splinebba_cli.simulation.realization import realize
from splinebba_cli.simulation.run_errors import dispersion_factor
from splinebba_cli.simulation.run_record import Failure, RunRecord, failed_record

Elements = dict[tuple[str, str], tuple[FloatArray, FloatArray]]  # (curve, element): errors and σ


@dataclass(frozen=True)
class MeasuredRun:
    """One run with the errors of all conics; metres and radians, a-priori σ."""

    record: RunRecord
    conics: Elements


def measured_run(campaign: Campaign, run: int) -> MeasuredRun:
    """A run of a campaign; the full dispersion is computed where there are conics."""
    made = realize(campaign.design, campaign.noise, campaign.seed + run)
    has_conics = any(curve.family in ("conic", "circle") for curve in made.network.curves)
    solve = partial(adjust, full_dispersion=has_conics)
    try:
        result = solve(made.network)
    except NotSolvableError as error:
        return MeasuredRun(failed_record(run, Failure(error.code, error.message)), {})
    conics: Elements = {}
    for k, found in enumerate(result.curves):
        if found.conic is not None:
            own = conic_errors(result, k, made.truth.curves[k])
            conics |= {(made.network.curves[k].id, name): each for name, each in own.items()}
    return MeasuredRun(campaign.record(run, made, result), conics)


def conic_errors(
    result: AdjustmentResult, k: int, true: FloatArray
) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Errors (e,) and σ (e,) of every element of curve k; `true` are C, A, B in the local frame."""
    found = result.curves[k].conic
    assert found is not None
    factor = dispersion_factor(result)
    axes, _, normal, eccentricity = conic_elements(true)
    turn, turn_sigma = _normal_error(result, k, found, normal)
    elements = {
        "centre": (found.centre - result.network.origin - true[0], found.centre_sigma),
        "normal": (np.array([turn]), np.array([turn_sigma])),
    }
    if found.form == "circle":
        elements["radius"] = (found.semi_axes[:1] - axes[:1], found.semi_axes_sigma[:1])
    else:
        elements["semi-axes"] = (found.semi_axes - axes, found.semi_axes_sigma)
        elements["eccentricity"] = (
            np.array([found.eccentricity - eccentricity]),
            np.array([found.eccentricity_sigma]),
        )
    return {name: (error, sigma / factor) for name, (error, sigma) in elements.items()}


def _normal_error(
    result: AdjustmentResult, k: int, found: ConicElements, true: FloatArray
) -> tuple[float, float]:
    """Turn of the normal along the larger semi-axis of its standard ellipse, and the reported σ of that, rad."""
    assert result.dispersion is not None
    assert result.dispersion.matrix is not None
    id = result.network.curves[k].id
    names = [f"spline {id} value {row} {axis}" for row in range(3) for axis in "xyz"]
    rows = [result.dispersion.names.index(name) for name in names]
    jacobian = conic_jacobian(result.curves[k].values)[3:]
    spread = jacobian @ result.dispersion.matrix[np.ix_(rows, rows)] @ jacobian.T
    major = np.linalg.eigh(spread)[1][:, -1]
    return float(major @ (found.axes @ (found.normal - true))), found.normal_sigma_rad
