"""Verdicts, their order and their exit codes."""

from __future__ import annotations

import json

import pytest

from splinebba_cli.batch.outcome import Outcome, Verdict, counted, exit_code, worst_first
from splinebba_cli.project.diagnostics import Diagnostic

CODES = {
    Verdict.crashed: 70, Verdict.timed_out: 3, Verdict.killed: 3, Verdict.not_solvable: 3, Verdict.not_written: 2,
    Verdict.invalid: 2, Verdict.not_accepted: 1, Verdict.not_run: 0, Verdict.accepted: 0,
}  # fmt: skip


def outcomes(*verdicts: Verdict) -> list[Outcome]:
    return [Outcome(f"{number}.yaml", verdict) for number, verdict in enumerate(verdicts)]


def test_exit_codes_of_verdicts() -> None:
    assert {verdict: verdict.exit_code for verdict in Verdict} == CODES


@pytest.mark.parametrize("worst", Verdict)
def test_the_worst_code_wins(worst: Verdict) -> None:
    others = [verdict for verdict in Verdict if CODES[verdict] <= CODES[worst]]
    assert exit_code(outcomes(*others)) == exit_code(outcomes(*reversed(others))) == CODES[worst]


def test_worst_first_and_else_in_their_order() -> None:
    mixed = outcomes(
        Verdict.accepted,
        Verdict.invalid,
        Verdict.accepted,
        Verdict.crashed,
        Verdict.not_accepted,
        Verdict.not_solvable,
    )
    assert [outcome.project for outcome in worst_first(mixed)] == [
        "3.yaml", "5.yaml", "1.yaml", "4.yaml", "0.yaml", "2.yaml",
    ]  # fmt: skip
    assert counted(mixed) == (
        "6 projects: 2 accepted, 1 not accepted, 1 invalid, 1 not solvable, 1 program error"
    )
    assert counted(mixed[:1]) == "1 project: 1 accepted"


def test_an_outcome_survives_json() -> None:
    problem = Diagnostic(
        "SBB510", "error", "σ̂₀ too large", "help", "a/project.yaml", 3, 5, 4, "  max_sigma0: 1"
    )
    outcome = Outcome(
        "a/project.yaml", Verdict.not_accepted, "a", "a/project.results", False, 1.25, {"sigma0": 1.5},
        [{"criterion": "max_sigma0"}], (problem,),
    )  # fmt: skip
    data = json.loads(json.dumps(outcome.data()))
    assert Outcome.of_data(data) == outcome
    assert (data["exit_code"], data["counts"]) == (1, {"error": 1, "warning": 0, "info": 0})
