"""What became of one project of a batch: plain data, the same in the log, in JSON and between processes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from enum import StrEnum
from typing import Any

from splinebba_cli.errors import ExitCode
from splinebba_cli.project.diagnostics import Diagnostic

SEVERITIES = ("error", "warning", "info")


class Verdict(StrEnum):
    """How the adjustment of a project ended, the worst first."""

    crashed = "program error"
    timed_out = "timed out"
    killed = "killed"
    not_solvable = "not solvable"
    not_written = "not written"
    invalid = "invalid"
    not_accepted = "not accepted"
    not_run = "not run"
    accepted = "accepted"

    @property
    def exit_code(self) -> int:
        """That of ``splinebba adjust``; a project without a solution for want of time or memory is not solvable."""
        return _EXIT_CODES[self]


_EXIT_CODES = {
    Verdict.crashed: ExitCode.BUG,
    Verdict.timed_out: ExitCode.NOT_SOLVABLE,
    Verdict.killed: ExitCode.NOT_SOLVABLE,
    Verdict.not_solvable: ExitCode.NOT_SOLVABLE,
    Verdict.not_written: ExitCode.INVALID,
    Verdict.invalid: ExitCode.INVALID,
    Verdict.not_accepted: ExitCode.NOT_ACCEPTED,
    Verdict.not_run: ExitCode.DONE,
    Verdict.accepted: ExitCode.DONE,
}


@dataclass(frozen=True)
class Outcome:
    """What became of one project.

    Attributes
    ----------
    project : str
        The project file as the user sees it: relative to the working directory where it lies inside.
    verdict : Verdict
    name : str
        Name that the project gives itself; empty where it is not known.
    results : str
        The result folder that was written or found up to date; empty where there is none.
    up_to_date : bool
        Whether these are results of an earlier run.
    seconds : float
        From the reading of the project to its results; 0 for those of an earlier run.
    statistics : dict
        That of result.json; empty without results.
    acceptance : list of dict
        That of result.json: every criterion of the project with what was found.
    problems : tuple of Diagnostic
        Problems of the result, warnings of the project file, or what prevented results.
    details : str
        For the developers: the traceback of a program error.
    """

    project: str
    verdict: Verdict
    name: str = ""
    results: str = ""
    up_to_date: bool = False
    seconds: float = 0.0
    statistics: dict[str, Any] = field(default_factory=dict)
    acceptance: list[dict[str, Any]] = field(default_factory=list)
    problems: tuple[Diagnostic, ...] = ()
    details: str = ""

    def count(self, severity: str) -> int:
        """Number of problems of a severity."""
        return sum(problem.severity == severity for problem in self.problems)

    def data(self) -> dict[str, Any]:
        """JSON types only, with the exit code and the number of problems of each severity."""
        counts = {severity: self.count(severity) for severity in SEVERITIES}
        fields = {**asdict(self), "problems": [asdict(problem) for problem in self.problems]}
        head = {
            "project": self.project,
            "verdict": self.verdict.value,
            "exit_code": int(self.verdict.exit_code),
        }
        return {**head, **fields, "verdict": self.verdict.value, "counts": counts}

    @classmethod
    def of_data(cls, data: dict[str, Any]) -> Outcome:
        """The outcome that :meth:`data` describes."""
        fields = {key: value for key, value in data.items() if key in cls.__dataclass_fields__}
        problems = tuple(Diagnostic(**problem) for problem in data["problems"])
        return cls(**{**fields, "verdict": Verdict(data["verdict"]), "problems": problems})


def worst_first(outcomes: Iterable[Outcome]) -> list[Outcome]:
    """Outcomes by verdict, the worst first, in their order where the verdict is the same."""
    order = list(Verdict)
    return sorted(outcomes, key=lambda outcome: order.index(outcome.verdict))


def exit_code(outcomes: Iterable[Outcome]) -> int:
    """The worst exit code: 70 before 3 before 2 before 1 before 0."""
    return max((int(outcome.verdict.exit_code) for outcome in outcomes), default=int(ExitCode.DONE))


def counted(outcomes: Iterable[Outcome]) -> str:
    """``40 projects: 37 accepted, 2 not accepted, 1 invalid``, the worst last."""
    all_of_them = list(outcomes)
    counts = Counter(outcome.verdict for outcome in all_of_them)
    parts = [f"{counts[verdict]} {verdict.value}" for verdict in reversed(Verdict) if counts[verdict]]
    return f"{len(all_of_them)} project{'s' if len(all_of_them) != 1 else ''}: {', '.join(parts)}"
