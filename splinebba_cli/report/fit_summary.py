"""What ``fit`` says about the splines that it has fitted, and their section of a project file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from splinebba_cli.core.curves.fitting import FittedSpline
from splinebba_cli.core.network import Role
from splinebba_cli.project.diagnostics import Diagnostic
from splinebba_cli.project.writer import inline_spline_entry
from splinebba_cli.project.yaml_writing import sections_yaml

if TYPE_CHECKING:
    from rich.table import Table as RichTable


@dataclass(frozen=True)
class Fitted:
    """A spline with its id, and how long the fit took."""

    id: str
    spline: FittedSpline
    seconds: float


def fit_warnings(fits: Sequence[Fitted], file: str) -> list[Diagnostic]:
    """What a fit says about the points."""
    out = []
    for fitted in fits:
        if fitted.spline.knots_follow_noise:
            message = (
                f"line `{fitted.id}`: {len(fitted.spline.knots)} knots for {len(fitted.spline.points)} points"
            )
            help = "the threshold may be smaller than the noise of the points: try a larger --threshold-m"
            out.append(Diagnostic("SBB323", "warning", message, help, file))
        if fitted.spline.ends_meet and not fitted.spline.breaks:
            message = f"line `{fitted.id}` ends in its first point, but is fitted as an open one"
            out.append(Diagnostic("SBB324", "warning", message, "--closed, if it is smooth there", file))
    return out


def splines_yaml(
    fits: Sequence[Fitted], role: Role, sigma_m: float | None, source: str, threshold_m: float
) -> str:
    """The section `splines` of a project file.

    Parameters
    ----------
    sigma_m : float or None
        σ of the knots, metres; 0 is fixed, None is free.
    source : str
        Name of the file of points, for the comment.
    """
    curves = [fitted.spline.curve(fitted.id, role, sigma_m) for fitted in fits]
    comment = (
        f"Fitted to {source}, no point farther than {threshold_m:g} m; for the section `splines` of a project.\n"
        "Knots belong to their knot_parameters: with others they make another curve."
    )
    return sections_yaml({"splines": [inline_spline_entry(curve) for curve in curves]}, comment)


def fit_data(fitted: Fitted) -> dict[str, Any]:
    """A fitted spline as plain data; lengths in metres."""
    spline = fitted.spline
    return {
        "id": fitted.id,
        "closed": spline.closed,
        "points": len(spline.points),
        "repeated_points": spline.repeated_points,
        "knot_count": len(spline.knots),
        "breaks": list(spline.breaks),
        "threshold_m": spline.threshold_m,
        "largest_distance_m": spline.largest_distance,
        "rms_distance_m": spline.rms_distance,
        "seconds": fitted.seconds,
        "knot_parameters": spline.knot_parameters.tolist(),
        "knots": spline.knots.tolist(),
    }


def fit_table(fits: Sequence[Fitted]) -> RichTable:
    """Points, knots and distances of every spline."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("Spline")
    for title in ("Points", "Knots", "Corners", "Largest distance\n[mm]", "RMS\n[mm]", "Time\n[s]"):
        table.add_column(Text(title), justify="right", no_wrap=True)
    for fitted in fits:
        spline = fitted.spline
        table.add_row(
            Text(fitted.id + (", closed" if spline.closed else "")),
            str(len(spline.points)),
            str(len(spline.knots)),
            str(len(spline.breaks)),
            f"{1000.0 * spline.largest_distance:.2f}",
            f"{1000.0 * spline.rms_distance:.2f}",
            f"{fitted.seconds:.2f}",
        )
    return table
