"""The observation with the largest standardised residual, where chance does not explain it.

    P(max |w| > k) <= 0.001,   k the critical value of one of n tests with this level for all together (Sidak)

Other tests show what an error of a single observation does elsewhere: the one with the largest |w| is named first.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from splinebba_cli.core.evidence import LocalTests
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.prior_residuals import PriorResidual
from splinebba_cli.core.quality.critical_values import critical_value
from splinebba_cli.core.quality.observation_names import curve_point_name, distance_name, image_point_name
from splinebba_cli.core.quality.reliability import tested_values
from splinebba_cli.core.result import AdjustmentResult, Problem

CERTAIN = 1e-3  # probability by chance of the largest of all, below which it is named


def local_findings(result: AdjustmentResult, tests: LocalTests) -> list[Problem]:
    """The worst observation, where nothing is done about outliers; none where all are as chance makes them."""
    settings, statistics = result.network.settings, result.statistics
    if settings.outliers.method != "none" or not tests.tests or statistics.redundancy <= 0:
        return []
    size, name, place = _worst(result)
    size = float(tested_values(settings.testing, np.array(size), statistics))
    together = replace(settings.testing, alpha=CERTAIN, multiplicity="sidak")
    if not size > critical_value(together, tests.tests, statistics.redundancy):
        return []
    symbol = "τ" if tests.statistic == "tau" else "w"
    message = (
        f"{name}{place}: |{symbol}| = {size:.1f} is the largest of {tests.tests} standardised residuals; "
        f"{tests.beyond} of them {'is' if tests.beyond == 1 else 'are'} beyond {tests.critical:.2f}, "
        f"{tests.alpha_single * tests.tests:.2g} expected by chance"
    )
    help = (
        "look at this one before all others, correct it or take it out (column `use`), adjust again; or let the "
        "program search: `adjust --outliers snooping`"
    )
    return [Problem("SBB557", "warning", message, name, help)]


def _worst(result: AdjustmentResult) -> tuple[float, str, str]:
    """Largest |w| of all kinds, whose it is, and which of the points of an image on a spline."""
    network = result.network

    def on_arc(row: int) -> str:
        return f"{curve_point_name(network, int(network.arc_lengths.first[row]))}, arc length"

    def of_tangent(row: int) -> str:
        return f"{curve_point_name(network, int(network.tangents.point[row]))}, tangent"

    def of_prior(row: int) -> str:
        return _prior(result.prior_residuals[row])

    kinds: list[tuple[FloatArray, Callable[[int], str]]] = [
        (result.point_residuals.standardized, partial(image_point_name, network)),
        (result.curve_residuals.standardized, partial(curve_point_name, network)),
        (result.arc_residuals.standardized[:, None], on_arc),
        (result.tangent_residuals.standardized[:, None], of_tangent),
        (result.distance_residuals.standardized[:, None], partial(distance_name, network)),
        (result.prior_residuals.standardized[:, None], of_prior),
    ]
    best, name, place = 0.0, "", ""
    for standardized, described in kinds:
        size = np.nan_to_num(np.abs(standardized), nan=0.0)
        if size.size and size.max() > best:
            row = int(size.max(axis=1).argmax())
            best, name = float(size.max()), described(row)
            on_curve = standardized is result.curve_residuals.standardized
            place = f", row {row + 1} of the points on splines" if on_curve else ""
    return best, name, place


def _prior(prior: PriorResidual) -> str:
    kind = "prior orientation of image" if prior.kind == "eop prior" else prior.kind
    return f"{kind} `{prior.subject}`, {prior.component}"
