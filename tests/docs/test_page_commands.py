"""Every command and every Python snippet of the documentation does what its page says."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

import pytest

from splinebba_cli.commands.app import app
from tests.docs.page_blocks import RUN, blocks_of, pages
from tests.docs.page_runner import ROOT, Reader, copy_folder

PAGES = pages(ROOT)
BLOCKS = {name: blocks_of(name, text) for name, text in PAGES.items()}
WITH_COMMANDS = [name for name, blocks in BLOCKS.items() if any(block.concerned for block in blocks)]

# blocks that no test runs; each says why in the page
NOT_RUN: dict[str, int] = {}


@pytest.mark.parametrize("page", WITH_COMMANDS)
def test_page(page: str, tmp_path: Path) -> None:
    copy_folder(ROOT / "sample_projects", tmp_path / "sample_projects")
    reader = Reader(tmp_path)
    for block in BLOCKS[page]:
        try:
            reader.follow(block)
        except ValueError as error:
            raise AssertionError(f"{page}:{block.line}: {error}") from error


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
    run = "\n".join(block.text for blocks in BLOCKS.values() for block in blocks if block.runs)
    called = set(re.findall(r"\bsplinebba ([a-z]+)", run))
    assert {command.name for command in app.registered_commands} - called == set()
