"""Every command and every Python snippet of the documentation does what its page says."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

import pytest

from splinebba_cli.commands.app import app
from tests.docs.page_blocks import RUN, Block, blocks_of, pages
from tests.docs.page_runner import ROOT, Reader, follow_page, run_in_process

PAGES = pages(ROOT)
BLOCKS = {name: blocks_of(name, text) for name, text in PAGES.items()}
WITH_COMMANDS = [name for name, blocks in BLOCKS.items() if any(block.concerned for block in blocks)]

# blocks that no test runs; each says why in its page
NOT_RUN = {
    "README.md": 3,
    "docs/batch.md": 1,
    "docs/fitting.md": 1,
    "docs/how-to/large-blocks.md": 1,
    "docs/how-to/roads-from-a-gis.md": 1,
    "docs/performance.md": 1,
    "docs/tutorial.md": 1,
}
COMMANDS = {command.name for command in app.registered_commands}


def called(blocks: list[Block]) -> set[str]:
    """Commands of the program that blocks run."""
    return set(re.findall(r"\bsplinebba ([a-z]+)", "\n".join(block.text for block in blocks if block.runs)))


@pytest.mark.parametrize("page", WITH_COMMANDS)
def test_page(page: str, tmp_path: Path) -> None:
    missing = called(BLOCKS[page]) - COMMANDS
    if missing and missing <= {"init", "batch"}:
        pytest.skip(f"this version has no command {sorted(missing)}")
    follow_page(BLOCKS[page], Reader(tmp_path, run_in_process))


def test_blocks_that_do_not_run_are_few_and_say_why() -> None:
    left_out = [
        block
        for blocks in BLOCKS.values()
        for block in blocks
        if block.language in RUN and block.mark("not run") is not None
    ]
    for block in left_out:
        print(f"{block.page}:{block.line}: {block.mark('not run')}")
    assert Counter(block.page for block in left_out) == NOT_RUN
    assert all(len(block.mark("not run") or "") > 10 for block in left_out)


def test_every_command_of_the_program_is_run_somewhere() -> None:
    assert COMMANDS - called([block for blocks in BLOCKS.values() for block in blocks]) == set()
