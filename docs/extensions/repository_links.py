"""Links out of the documentation, to modules and samples of the repository, lead to pages of the site.

``[datum.py](../splinebba_cli/core/estimation/datum.py)`` works in a clone as it stands; the site gets a page
``repository/...`` with the highlighted file, or the list of a folder.
"""

from __future__ import annotations

import html
import os
import posixpath
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
SCHEME = "repository:"
_LINK = re.compile(r"\]\((\.\./[^)#\s]*)(#[^)]*)?\)")
_REWRITTEN = re.compile(rf"\]\({SCHEME}([^)#]+)\)")
_LANGUAGES = {
    ".py": "python",
    ".yaml": "yaml",
    ".yml": "yaml",
    ".json": "json",
    ".md": "markdown",
    ".toml": "toml",
}
_SITE = (
    (re.compile(r"^docs/(?P<page>.+)\.md$"), "/{page}.md"),
    (re.compile(r"^splinebba_cli/explanations/(?P<page>SBB\d+)\.md$"), "/errors/{page}.md"),
    (re.compile(r"^README\.md$"), "/index.md"),
)


def rewritten(docname: str, text: str) -> str:
    """A page whose links out of docs/ carry the scheme of this module, or lead to the page that stands for the file."""
    folder = posixpath.join("docs", posixpath.dirname(docname))

    def target(match: re.Match[str]) -> str:
        path = posixpath.normpath(posixpath.join(folder, match[1]))
        for pattern, page in _SITE:
            found = pattern.match(path)
            if found:
                return f"]({page.format(**found.groupdict())}{match[2] or ''})"
        return f"]({SCHEME}{path})"

    return _LINK.sub(target, text)


def _rewrite(app: Any, docname: str, source: list[str]) -> None:
    source[0] = rewritten(docname, source[0])


def _resolve(app: Any, doctree: Any, docname: str) -> None:
    from docutils import nodes

    for reference in doctree.findall(nodes.reference):
        uri = reference.get("refuri", "")
        if uri.startswith(SCHEME):
            reference["refuri"] = app.builder.get_relative_uri(docname, _page(uri.removeprefix(SCHEME)))
            reference["internal"] = True


def _page(path: str) -> str:
    return f"repository/{path}" + ("/list" if (ROOT / path).is_dir() else "")


def _collect(app: Any) -> Iterator[tuple[str, dict[str, Any], str]]:
    """Pages of the files and folders that are linked."""
    wanted = linked_files(app.env)
    files = {path for path in wanted if (ROOT / path).is_file()}
    for path in wanted:
        if (ROOT / path).is_dir():
            names = sorted(_listed(ROOT / path))
            files |= {f"{path}/{name}" for name in names}
            targets = [app.builder.get_relative_uri(_page(path), _page(f"{path}/{name}")) for name in names]
            pairs = zip(targets, names, strict=True)
            items = "".join(f'<li><a href="{uri}">{html.escape(name)}</a></li>' for uri, name in pairs)
            yield _page(path), _context(path, f"<ul>{items}</ul>"), "page.html"
    for path in sorted(files):
        text = (ROOT / path).read_text(encoding="utf-8")
        language = _LANGUAGES.get(Path(path).suffix, "text")
        body = app.builder.highlighter.highlight_block(text, language, force=True)
        yield _page(path), _context(path, body), "page.html"


def linked_files(env: Any) -> list[str]:
    """Files and folders of the repository that pages link."""
    texts = (rewritten(name, Path(env.doc2path(name)).read_text(encoding="utf-8")) for name in env.found_docs)
    return sorted({path for text in texts for path in _REWRITTEN.findall(text)})


def _listed(folder: Path) -> list[str]:
    """Files of a folder that make a page."""
    return [
        entry.name
        for entry in os.scandir(folder)
        if entry.is_file()
        and Path(entry.name).suffix in (*_LANGUAGES, ".csv")
        and entry.name != "__init__.py"
    ]


def _context(path: str, body: str) -> dict[str, Any]:
    title = html.escape(path)
    return {"title": title, "body": f"<h1><code>{title}</code></h1>{body}", "hide_toc": True}


def setup(app: Any) -> dict[str, Any]:
    """Register with Sphinx."""
    app.connect("source-read", _rewrite, priority=900)
    app.connect("doctree-resolved", _resolve)
    app.connect("html-collect-pages", _collect)
    return {"parallel_read_safe": True, "parallel_write_safe": False}
