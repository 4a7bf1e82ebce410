"""Measured runs as plain records, kept in one JSON file per benchmark.

{"benchmark": name, "machine": {...}, "runs": [{"size", "repetition", "task", "mode", "wall_s", ...}]}
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from benchmarks.measured_process import Measured

PLAIN, SPEED = "plain", "speed"
SPEED_VARIABLE = {PLAIN: "never", SPEED: "always"}  # values of SPLINEBBA_SPEED


@dataclass(frozen=True)
class Run:
    """One measured process."""

    size: int  # images of a block, knots of a coast
    repetition: int
    task: str
    mode: str  # plain or speed; empty for the peer
    wall_s: float
    cpu_s: float
    peak_bytes: int
    figures: dict[str, Any] = field(default_factory=dict)  # what it printed about itself

    @classmethod
    def of(
        cls, measured: Measured, size: int, repetition: int, task: str, mode: str, figures: dict[str, Any]
    ) -> Run:
        """A measured process with its name."""
        return cls(
            size, repetition, task, mode, measured.wall_s, measured.cpu_s, measured.peak_bytes, figures
        )


def select(runs: Iterable[Run], size: int, task: str, mode: str = "") -> list[Run]:
    """The runs of one kind, in the order of repetitions."""
    wanted = (size, task, mode)
    return sorted(
        (run for run in runs if (run.size, run.task, run.mode) == wanted), key=lambda run: run.repetition
    )


def write_measurements(
    path: Path, benchmark: str, machine: dict[str, Any], runs: Iterable[Run], **more: Any
) -> None:
    """Write the JSON file of a benchmark."""
    content = {"benchmark": benchmark, "machine": machine, **more, "runs": [asdict(run) for run in runs]}
    path.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def runs_of(content: dict[str, Any]) -> list[Run]:
    """The runs of a loaded JSON file."""
    return [Run(**run) for run in content["runs"]]
