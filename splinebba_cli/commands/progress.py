"""Progress of a long command on stderr: which stage is going on, and every iteration.

On a terminal it is one line that changes and goes away; elsewhere it is plain lines that are the same whenever the
same is computed.  The parts of the program say what they are at through :mod:`logging`: INFO is the beginning of a
stage, DEBUG is for those who want to know more (-vv).
"""

from __future__ import annotations

import logging
import math
import sys
from typing import TYPE_CHECKING, Any

from splinebba_cli.commands.streams import is_terminal, live_console, rich_console
from splinebba_cli.interruption import uninterrupted

if TYPE_CHECKING:
    from types import TracebackType

    from rich.console import Console as RichConsole

    from splinebba_cli.core.result import Iteration

PACKAGE = "splinebba_cli"


def iteration_text(step: Iteration, *, damping: bool = False) -> str:
    """An iteration as a line of fixed width."""
    moved = f"   step {step.step:9.3g} σ" if math.isfinite(step.step) else ""
    damped = f"   damping {step.damping:9.3g}" if damping else ""
    return f"{step.stage:>8} {step.number:3d}   vᵀPv {step.cost:14.6g}{moved}{damped}"


class PlainProgress:
    """Lines on stderr."""

    def line(self, text: str) -> None:
        """A line that stays."""
        print(text, file=sys.stderr, flush=True)

    def stage(self, text: str) -> None:
        """What begins now."""
        self.line(text)

    def iteration(self, step: Iteration, verbose: int) -> None:
        """An iteration is finished."""
        self.line(iteration_text(step, damping=verbose > 1))

    def console(self) -> RichConsole:
        """For what is more than a line."""
        return rich_console(to_stdout=False)

    def start(self) -> None:
        """Nothing to show yet."""

    def close(self) -> None:
        """Nothing to take away."""


class LiveProgress(PlainProgress):
    """One line on a terminal, with the time since the command began; lines that stay go above it."""

    def __init__(self) -> None:
        from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

        columns = (SpinnerColumn(), TextColumn("{task.description}", markup=False), TimeElapsedColumn())
        self._bar = Progress(
            *columns, console=live_console(), transient=True, redirect_stdout=False, redirect_stderr=False
        )
        self._task = self._bar.add_task("starting", total=None)

    def start(self) -> None:
        """Show the line."""
        with uninterrupted():  # else the cursor stays away
            self._bar.start()

    def line(self, text: str) -> None:
        """A line that stays, above the one that changes."""
        self._bar.console.print(text, markup=False, soft_wrap=True)

    def stage(self, text: str) -> None:
        """What begins now."""
        self._bar.update(self._task, description=text, refresh=True)

    def iteration(self, step: Iteration, verbose: int) -> None:
        """An iteration is finished; it stays for those who want to know more."""
        self._bar.update(self._task, description=iteration_text(step).strip())
        if verbose:
            self.line(iteration_text(step, damping=verbose > 1))

    def console(self) -> RichConsole:
        """For what is more than a line."""
        return self._bar.console

    def close(self) -> None:
        """Take the line away; the time that it showed is no result."""
        with uninterrupted():
            self._bar.stop()


class SilentProgress(PlainProgress):
    """Nothing (-q)."""

    def line(self, text: str) -> None:
        """Nothing."""

    def stage(self, text: str) -> None:
        """Nothing."""

    def iteration(self, step: Iteration, verbose: int) -> None:
        """Nothing."""


class StageListener(logging.Handler):
    """Hands on what the parts of the program say, as long as it is open."""

    def __init__(self, progress: PlainProgress, level: int) -> None:
        super().__init__(level)
        self._progress = progress
        self._logger = logging.getLogger(PACKAGE)
        self._before: tuple[int, bool] = (self._logger.level, self._logger.propagate)

    def __enter__(self) -> StageListener:
        self._before = (self._logger.level, self._logger.propagate)
        self._logger.setLevel(self.level)
        self._logger.propagate = False
        self._logger.addHandler(self)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._logger.removeHandler(self)
        level, propagate = self._before
        self._logger.setLevel(level)
        self._logger.propagate = propagate

    def emit(self, record: Any) -> None:
        """A stage, or a line of detail."""
        if record.levelno >= logging.INFO:
            self._progress.stage(record.getMessage())
        else:
            self._progress.line(f"    {record.getMessage()}")


def progress_for(quiet: bool) -> PlainProgress:
    """What fits to stderr."""
    if quiet:
        return SilentProgress()
    return LiveProgress() if is_terminal(sys.stderr) else PlainProgress()
