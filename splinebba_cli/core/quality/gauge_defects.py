"""Defects of the measurements alone, as they are seen before an adjustment: some are filled by its conditions.

An adjustment adds gauge conditions along curves and, where the user wants that, datum conditions
(:mod:`~splinebba_cli.core.estimation.datum`).  What these fill is no error of the project.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from splinebba_cli.core.curves.registry import FAMILIES
from splinebba_cli.core.network import Network
from splinebba_cli.core.result import Problem


def before_conditions(
    problems: Iterable[Problem], network: Network, nulls: Mapping[str, int]
) -> tuple[Problem, ...]:
    """Problems with the severity that they have where gauge and datum conditions are still to come.

    Parameters
    ----------
    problems : iterable of Problem
        Null directions in words (:func:`~splinebba_cli.core.quality.null_problems.null_problems`).
    nulls : mapping
        Id of a spline -> directions that none of its measurements sees, orientations known; without those not counted.
    """
    phases = {
        f"spline `{curve.id}`"
        for curve in network.curves
        if FAMILIES[curve.family].rows == "harmonics" and nulls.get(curve.id) == 1
    }
    lines = {  # straight: both ends slide
        f"spline `{curve.id}`"
        for curve in network.curves
        if curve.family == "natural_cubic" and len(curve.values) == 2 and nulls.get(curve.id) == 2
    }
    filled = {"SBB520"} if network.settings.datum == "control" else {"SBB520", "SBB523"}
    seen = []
    for problem in problems:
        if problem.code == "SBB520" and problem.subject in phases:
            message = (
                f"{problem.subject}: no measurement sees where it begins (the phase of u); its shape is seen"
            )
            seen.append(
                Problem("SBB520", "info", message, problem.subject, "nothing to do: `adjust` holds the phase")
            )
        elif problem.code == "SBB520" and problem.subject in lines:
            message = f"{problem.subject}: no measurement sees where the straight line ends"
            help = "nothing to do: `adjust` holds its ends along the line"
            seen.append(Problem("SBB520", "info", message, problem.subject, help))
        elif problem.code in filled and problem.severity == "error":
            seen.append(replace(problem, severity="warning"))
        else:
            seen.append(problem)
    return tuple(seen)
