"""What a person should know about the search for outliers: rejections never vanish."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.evidence import Revision
from splinebba_cli.core.result import AdjustmentResult, Problem
from splinebba_cli.core.revision.observation_weights import lost_points
from splinebba_cli.core.revision.revise import Revised

MANY = 0.1  # share of rejections beyond which the model is in doubt
STOPPED = {
    "share": (
        "SBB541",
        "it stopped at the largest share of rejections while observations were still beyond the critical value",
        "look for systematic errors or wrong σ first; then raise `max_share`, or use `start: high_breakdown`",
    ),
    "rounds": (
        "SBB541",
        "it stopped at the largest number of rounds while observations were still beyond the critical value",
        "raise `adjustment.outliers.max_rounds`, or let it reject several observations `at_once`",
    ),
    "unsettled": (
        "SBB542",
        "the weights did not settle: the result belongs to those of the last round",
        "raise `adjustment.outliers.max_rounds`; `huber` always settles, the other weight functions need a good start",
    ),
    "unsolved": (
        "SBB543",
        "the network could not be solved with the outliers out: all observations take part again",
        "take out the worst observations by hand (column `use` of their table), a few at a time",
    ),
}


def revision_problems(revision: Revision, revised: Revised, result: AdjustmentResult) -> tuple[Problem, ...]:
    """Problems of the search."""
    found = []
    if revision.rejected:
        found.append(_rejected(revision, revised))
    if revised.stopped:
        code, message, help = STOPPED[revised.stopped]
        found.append(Problem(code, "warning", f"search for outliers: {message}", "outliers", help))
    out = int((revised.search.excluded == 0.0).sum())
    if out:
        verb = "takes" if out == 1 else "take"
        message = f"{out} of {len(revised.factor)} observations {verb} no part: excluded by the project"
        help = "listed in residuals.csv with predicted residuals"
        found.append(Problem("SBB544", "info", message, "observations", help))
    return (*found, *_lost(revised, result))


def _rejected(revision: Revision, revised: Revised) -> Problem:
    standing = [each for each in revision.rejections if not each.returned]
    worst = max(standing, key=lambda each: float(np.nan_to_num(abs(each.predicted))))
    total = int((revised.search.excluded > 0.0).sum())
    share = len(standing) / total
    verb = "was" if len(standing) == 1 else "were"
    message = (
        f"{len(standing)} of {total} observations {verb} rejected ({100 * share:.2g} %); worst: {worst.name}, "
        f"predicted w = {worst.predicted:.1f}"
    )
    help = "rejections.csv lists them; remeasure them, or mend what they have in common"
    if share > MANY:
        help = "so many rejections may mean wrong σ, systematic errors or a wrong model; " + help
    return Problem("SBB540", "warning", message, "outliers", help)


def _lost(revised: Revised, result: AdjustmentResult) -> list[Problem]:
    lost = lost_points(revised.search.listed, revised.factor)
    ids = result.network.points.ids
    return [
        Problem(
            "SBB540",
            "warning",
            f"point `{ids[k]}` has lost its rays and is not adjusted",
            f"point `{ids[k]}`",
            "measure it in a further image: with two rays nothing tells which of them is wrong",
        )
        for k in lost.tolist()
    ]
