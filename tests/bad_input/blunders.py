"""A measurement with a gross error: what is reported must show it."""

from __future__ import annotations

import csv
import io
import random
from pathlib import Path

from splinebba_cli.errors import SplinebbaError
from tests.bad_input.fuzz import project_files, written
from tests.bad_input.oracles import OracleError, adjusted

SIGMA_MM = 0.004
UNCONTROLLED = 0.01  # redundancy number of a coordinate whose error nothing can show
SHOWING = {"SBB531", "SBB540", "SBB541", "SBB545", "SBB546", "SBB547", "SBB549", "SBB557"}
"""Global test, rejections, groups and chains with a common error, means and runs, largest residual."""


def case_of_blunders(seed: int, number: int, folder: Path) -> str:
    """One image coordinate is wrong by 50 to 2000 σ across the direction of what it measures."""
    chance = random.Random(f"blunders {seed} {number}")
    files = dict(project_files(chance.choice(("tables", "everything"))))
    rows = list(csv.reader(io.StringIO(files["image_points.csv"].decode())))
    row = chance.choice(rows[1:])
    column = rows[0].index(chance.choice("xy"))
    size = chance.choice((-1, 1)) * chance.choice((50, 200, 2000)) * SIGMA_MM
    row[column] = f"{float(row[column]) + size:.4f}"
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows(rows)
    files["image_points.csv"] = out.getvalue().encode()
    try:
        content = adjusted(written(files, folder), folder / "results")
    except SplinebbaError as error:
        return f"not adjusted {error.code}"
    found = SHOWING & {problem["code"] for problem in content["problems"]}
    if not found and redundancy(folder / "results", row, column) < UNCONTROLLED:
        return "not controlled: two rays, along the base"
    if not found:
        raise OracleError(f"{row} is wrong by {size:g} mm, and no problem says so")
    return f"shown by {min(found)}"


def redundancy(results: Path, row: list[str], column: int) -> float:
    """Redundancy number of a coordinate of an image point."""
    with (results / "residuals.csv").open(encoding="utf-8", newline="") as stream:
        for one in csv.DictReader(stream):
            if one["kind"] == "point" and [one["image"], one["feature"]] == row[:2]:
                return float(one["redundancy_x" if column == 2 else "redundancy_y"] or 0.0)
    raise OracleError(f"{row} is not in residuals.csv")
