"""Every error code that the package uses is registered, and every registered one can be explained."""

from __future__ import annotations

import re
from pathlib import Path

import splinebba_cli
from splinebba_cli.core.result import Problem
from splinebba_cli.errors import (
    ERROR_CODES,
    ExitCode,
    NotConvergedError,
    NotSolvableError,
    OutputError,
    SingularNetworkError,
    UsageError,
)

PACKAGE = Path(splinebba_cli.__file__).parent


def test_codes_are_registered() -> None:
    used = {
        code
        for path in PACKAGE.rglob("*.py")
        if path.name != "errors.py"
        for code in re.findall(r"\"(SBB\d{3})\"", path.read_text(encoding="utf-8"))
    }
    assert used - set(ERROR_CODES) == set()


def test_exit_codes() -> None:
    assert [int(code) for code in ExitCode] == [0, 1, 2, 3, 70]
    assert UsageError("SBB900", "x").exit_code == OutputError("SBB601", "x").exit_code == 2
    assert SingularNetworkError([]).exit_code == NotConvergedError([]).exit_code == 3


def test_unsolvable_networks_speak_through_their_problems() -> None:
    problem = Problem("SBB521", "error", "point `a` is not determined", "point `a`", "measure it again")
    error = SingularNetworkError([problem])
    assert isinstance(error, NotSolvableError)
    assert (error.code, error.message, error.help) == (problem.code, problem.message, problem.help)
    assert NotConvergedError([]).code == "SBB502"
