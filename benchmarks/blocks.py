"""Blocks of the generator: archive, text for the peer, project of this program; made once in a folder and kept.

The generator (``gen_block.py``) and the peer's source are no part of the project.  They are looked for under
``$SPLINEBBA_BENCH`` and at ``../shared/bench`` beside the repository.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from benchmarks.measured_process import PYTHON, REPOSITORY, run_measured

GENERATOR = "gen_block.py"


class NotAvailableError(RuntimeError):
    """Something that is no part of the project is missing; says what and what would cure it."""


@dataclass(frozen=True)
class Block:
    """One block in a folder."""

    images: int
    folder: Path

    @property
    def archive(self) -> Path:
        """The archive of the generator."""
        return self.folder / f"b{self.images}.npz"

    @property
    def text(self) -> Path:
        """The same for the peer."""
        return self.archive.with_suffix(".txt")

    @property
    def project(self) -> Path:
        """The folder of the project."""
        return self.folder / f"p{self.images}"


def bench_folder(given: Path | None = None) -> Path:
    """The folder of the generator.

    Raises
    ------
    NotAvailableError
        If it is not there.
    """
    beside = REPOSITORY.parent / "shared" / "bench"
    folder = given or Path(os.environ.get("SPLINEBBA_BENCH", beside))
    if not (folder / GENERATOR).is_file():
        raise NotAvailableError(
            f"block generator not found: {folder / GENERATOR} (set SPLINEBBA_BENCH or give --generator)"
        )
    return folder


def make_archive(block: Block, generator: Path, *, text: bool) -> None:
    """Generate the block unless it is there, with the peer's text where that is wanted."""
    if block.archive.exists() and (block.text.exists() or not text):
        return
    command = [PYTHON, generator / GENERATOR, str(block.images), block.archive.with_suffix("")]
    run_measured([*command, "--text"] if text else command)


def make_project(block: Block) -> None:
    """Write the block as a project unless it is there."""
    if not (block.project / "project.yaml").exists():
        run_measured([PYTHON, "-m", "benchmarks.bench_project", block.archive, block.project])
