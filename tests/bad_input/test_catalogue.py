"""Every broken project is refused at the place of its mistake, in words that were read, and nothing is written."""

from __future__ import annotations

import os
import re
from contextlib import chdir
from pathlib import Path

import pytest

from splinebba_cli.errors import ERROR_CODES
from splinebba_cli.project.file_content import in_words, memory_bytes
from tests.bad_input.cases import BASES, Case, all_cases, findings, fits

CASES = all_cases()

#: Codes of 1xx to 4xx that no project file can cause, with their reason.
ELSEWHERE = {
    "SBB320": "points of `fit`",
    "SBB321": "points of `fit`",
    "SBB322": "points of `fit`",
    "SBB323": "points of `fit`",
    "SBB324": "points of `fit`",
    "SBB332": "files of `chains`",
    "SBB333": "files of `chains`",
    "SBB334": "files of `chains`",
    "SBB335": "files of `chains`",
    "SBB336": "said by `match`, not by `check`",
    "SBB337": "said by `match`, not by `check`",
    "SBB406": "pyarrow is not installed",
    "SBB407": "points of `fit`",
}


def test_the_projects_that_are_broken_here_are_right(tmp_path: Path) -> None:
    for base in sorted(path.name for path in BASES.iterdir()):
        case = Case(base, {"base": base, "expected": []})
        folder = tmp_path / base
        case.written(folder)
        assert case.run(folder)[0] == 0, base


@pytest.mark.parametrize("case", CASES, ids=[case.name for case in CASES])
def test_message_and_place(case: Case, tmp_path: Path) -> None:
    if any("parquet" in str(name) for name in case.content.get("special", {})):
        pytest.importorskip("pyarrow", reason="needs the extra `parquet`")
    expected = case.written(tmp_path)
    before = listing(tmp_path)
    code, output = case.run(tmp_path)
    said = findings(output)
    assert code == case.exit_code
    assert len(said) == len(expected) and all(map(fits, said, expected)), (said, expected)
    assert comparable(f"{output.rstrip()}\nexit code {code}\n") == comparable(
        case.snapshot.read_text(encoding="utf-8")
    )
    if case.exit_code:
        assert listing(tmp_path) == before


def listing(folder: Path) -> list[tuple[str, int]]:
    """Everything in a folder, with its size."""
    with chdir(folder):
        return sorted(
            (os.path.join(root, name), os.lstat(os.path.join(root, name)).st_size)
            for root, folders, files in os.walk(".")
            for name in (*folders, *files)
        )


def comparable(text: str) -> str:
    """The text without what depends on the machine: the size of its memory, spellings of its libraries."""
    text = text.replace(in_words(memory_bytes()), "the memory")
    text = re.sub(r"more than [\d.,]+ GiB", "more than the memory", text)
    return re.sub(r"(no complete Parquet file:).*", r"\1", text)


def test_every_code_of_projects_and_tables_occurs() -> None:
    occurring = {one.split()[0] for case in CASES for one in case.content["expected"]}
    wanted = {code for code in ERROR_CODES if code[3] in "1234"}
    assert wanted - occurring == set(ELSEWHERE)
    assert not occurring & set(ELSEWHERE)
