"""Every code has a page, every page a code; pages have one form; their examples give their codes."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import splinebba_cli
from splinebba_cli.errors import ERROR_CODES
from splinebba_cli.explanations import FOLDER, HEADINGS, OPTIONAL, explanation_of
from tests.explanations.examples import PAGES, example_of, printed

RUN = [path.stem for path in sorted(PAGES.glob("SBB*.md")) if example_of(path) is not None]
PROJECT_CODES = [code for code in ERROR_CODES if code[3] in "1234"]
NOT_AS_TEXT = {
    "SBB103",
    "SBB109",
    "SBB336",
    "SBB337",
    "SBB406",
    "SBB409",
    "SBB411",
    "SBB412",
}  # blocks of chains (tests/core/matching/test_doubts.py), bytes, sizes, a package that is missing (tests/bad_input)


def test_a_page_for_every_code_and_a_code_for_every_page() -> None:
    assert {path.stem for path in FOLDER.glob("*.md")} == set(ERROR_CODES)


@pytest.mark.parametrize("code", ERROR_CODES)
def test_form(code: str) -> None:
    page = explanation_of(code)
    assert page.text.startswith(f"# {code}: {ERROR_CODES[code]}\n")
    assert len(re.findall(r"^# (?!\w+\.\w+$)", outside_of_code(page.text), re.MULTILINE)) == 1
    assert [name for name in page.sections if name != OPTIONAL] == list(HEADINGS)
    assert all(len(text) > 20 for text in page.sections.values())
    assert page.text.count("```") % 2 == 0


def outside_of_code(text: str) -> str:
    return re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("code", ERROR_CODES)
def test_what_it_refers_to_exists(code: str) -> None:
    text = explanation_of(code).text
    links = re.findall(r"\]\(([^)]+)\)", outside_of_code(text))
    assert [link for link in links if not (FOLDER / link).exists()] == []
    named = re.findall(r"`(docs/[\w./-]+\.md)`", text)
    assert [name for name in named if not (FOLDER.parents[1] / name).exists()] == []


def test_examples_of_project_files_are_run() -> None:
    assert set(PROJECT_CODES) - set(RUN) == NOT_AS_TEXT


@pytest.mark.parametrize("code", RUN)
def test_example(code: str, tmp_path: Path) -> None:
    """To renew: python -m tests.regenerate_explanations."""
    example = example_of(PAGES / f"{code}.md")
    assert example is not None
    assert f"[{code}]" in example.output
    assert printed(example, tmp_path) == example.output


def test_every_code_is_used() -> None:
    package = Path(splinebba_cli.__file__).parent
    texts = [p.read_text(encoding="utf-8") for p in package.rglob("*.py")]
    registered_only = [code for code in ERROR_CODES if sum(t.count(f'"{code}"') for t in texts) == 1]
    assert registered_only == []
