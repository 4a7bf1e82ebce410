"""Anchors that pages write as HTML, ``<a id="table-5-4"></a>``, are targets of links on the site as well."""

from __future__ import annotations

import re
from typing import Any

_ANCHOR = re.compile(r'^<a id="([\w-]+)"></a>\n', re.MULTILINE)


def _replace(app: Any, docname: str, source: list[str]) -> None:
    source[0] = _ANCHOR.sub(r"(\1)=\n", source[0])


def setup(app: Any) -> dict[str, Any]:
    """Register with Sphinx."""
    app.connect("source-read", _replace)
    return {"parallel_read_safe": True}
