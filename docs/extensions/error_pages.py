"""A page for every error code that has an explanation.

Explanations belong to the package, where ``splinebba explain`` reads them.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from docs.extensions.repository_links import ROOT

EXPLANATIONS = ROOT / "splinebba_cli" / "explanations"
FOLDER = "errors"


def copy_explanations(docs: Path) -> list[str]:
    """Put the explanations where Sphinx finds them; their codes."""
    folder = docs / FOLDER
    pages = sorted(EXPLANATIONS.glob("SBB*.md"))
    wanted = {page.name: page.read_text(encoding="utf-8") for page in pages}
    for old in folder.glob("*.md"):
        if old.name not in wanted:
            old.unlink()
    for name, text in wanted.items():
        folder.mkdir(exist_ok=True)
        target = folder / name
        if not target.exists() or target.read_text(encoding="utf-8") != text:
            target.write_text(text, encoding="utf-8", newline="\n")
    return [page.stem for page in pages]


def _copy(app: Any) -> None:
    app.config.explained_codes = copy_explanations(Path(app.srcdir))


def _list(app: Any, docname: str, source: list[str]) -> None:
    if docname == "error-codes" and app.config.explained_codes:
        pages = "\n".join(f"{FOLDER}/{code}" for code in app.config.explained_codes)
        source[0] += f"\n\n```{{toctree}}\n:hidden:\n\n{pages}\n```\n"


def setup(app: Any) -> dict[str, Any]:
    """Register with Sphinx."""
    app.add_config_value("explained_codes", [], "")
    app.connect("builder-inited", _copy)
    app.connect("source-read", _list)
    return {"parallel_read_safe": True}
