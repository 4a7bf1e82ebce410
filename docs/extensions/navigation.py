"""The table of contents is the list of links that a reader sees: pages need no directives for it.

In a page named ``index.md`` every section with a list of links becomes a part of the navigation, under its heading.
"""

from __future__ import annotations

import re
from typing import Any

_SECTION = re.compile(r"^## (.+)$", re.MULTILINE)
_LINK = re.compile(r"^- \[[^\]]+\]\(([^):#]+)\.md\)", re.MULTILINE)


def navigation(text: str) -> str:
    """Hidden tables of contents for the sections of a page that list other pages."""
    parts = _SECTION.split(text)
    found = []
    for caption, body in zip(parts[1::2], parts[2::2], strict=True):
        pages = [page for page in _LINK.findall(body) if not page.startswith("..")]
        if pages:
            found.append("\n".join(["```{toctree}", ":hidden:", f":caption: {caption}", "", *pages, "```"]))
    return "\n\n".join(found)


def _append(app: Any, docname: str, source: list[str]) -> None:
    if docname.rpartition("/")[2] == "index":
        source[0] += f"\n\n{navigation(source[0])}\n"


def setup(app: Any) -> dict[str, Any]:
    """Register with Sphinx."""
    app.connect("source-read", _append)
    return {"parallel_read_safe": True}
