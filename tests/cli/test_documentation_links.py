"""Links and modules that the documents name exist."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("sample_projects/*/README.md")]


def missing_links(page: Path, text: str) -> list[str]:
    """Relative links that lead nowhere."""
    links = re.findall(r"\]\(([^)#]+?)(?:#[^)]*)?\)", text)
    return [link for link in links if "://" not in link and not (page.parent / link).exists()]


def missing_modules(text: str) -> list[str]:
    """Modules named like `core/estimation/datum.py` that the package does not have."""
    named = re.findall(r"`((?:core|project|output|report|simulation|commands)/[\w/]+\.py)`", text)
    return [name for name in named if not (ROOT / "splinebba_cli" / name).exists()]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_and_modules_exist(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert missing_links(page, text) == []
    assert missing_modules(text) == []


def test_what_is_missing_is_found() -> None:
    assert missing_links(ROOT / "README.md", "[a](docs) [b](nowhere.md#x) [c](https://x.org)") == [
        "nowhere.md"
    ]
    assert missing_modules("`core/network.py` `core/nothing.py`") == ["core/nothing.py"]
