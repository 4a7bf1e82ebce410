"""The pages that explain the error codes: one Markdown file a code, with the same headings.

# SBBnnn: title      ## Cause      ## Example      ## Cure      [## See also]
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

FOLDER = Path(__file__).parent
HEADINGS = ("Cause", "Example", "Cure")
OPTIONAL = "See also"


@dataclass(frozen=True)
class Explanation:
    """The page of one code."""

    code: str
    title: str
    text: str  # the whole page, Markdown
    sections: dict[str, str]  # heading -> Markdown


def page_of(code: str) -> Path:
    """Where the page of a code lies."""
    return FOLDER / f"{code}.md"


def explanation_of(code: str) -> Explanation:
    """The page of a registered code.

    Raises
    ------
    FileNotFoundError
        If there is none.
    """
    text = page_of(code).read_text(encoding="utf-8")
    head, *parts = re.split(r"^## ", text, flags=re.MULTILINE)
    title = head.strip().removeprefix(f"# {code}: ")
    sections = {name.strip(): body.strip() for name, _, body in (part.partition("\n") for part in parts)}
    return Explanation(code, title, text, sections)
