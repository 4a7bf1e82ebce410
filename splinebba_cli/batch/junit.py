"""JUnit XML of a batch."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from splinebba_cli.batch.outcome import Outcome, Verdict
from splinebba_cli.core.evidence import Criterion
from splinebba_cli.output.junit import Suite, Trouble, junit_text
from splinebba_cli.project.diagnostics import render_text

_FIGURES = ("sigma0", "redundancy", "observations", "unknowns")


def junit_of_batch(outcomes: Sequence[Outcome]) -> str:
    """One test suite a project, in the given order."""
    return junit_text([suite_of(outcome) for outcome in outcomes])


def suite_of(outcome: Outcome) -> Suite:
    """The test suite of a project: verdict, key figures and result folder are its properties."""
    properties = {"verdict": outcome.verdict.value, "up_to_date": str(outcome.up_to_date).lower()}
    figures = {key: outcome.statistics.get(key) for key in _FIGURES}
    properties |= {key: f"{figure:.6g}" for key, figure in figures.items() if figure is not None}
    if outcome.results:
        properties["results"] = outcome.results
    return Suite(
        outcome.project,
        [_criterion(each) for each in outcome.acceptance],
        _trouble(outcome),
        "not run: the batch ended before" if outcome.verdict is Verdict.not_run else "",
        properties,
        outcome.seconds,
    )


def _criterion(data: dict[str, Any]) -> Criterion:
    return Criterion(key=data["criterion"], **{key: data[key] for key in data if key != "criterion"})


def _trouble(outcome: Outcome) -> Trouble | None:
    """The errors of a project that has no results."""
    if outcome.results or outcome.verdict is Verdict.not_run:
        return None
    errors = [problem for problem in outcome.problems if problem.severity == "error"]
    more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
    text = render_text(errors) + (f"\n\n{outcome.details}" if outcome.details else "")
    return Trouble(errors[0].code, errors[0].message + more, text)
