"""report.html: one self-contained file, no network, light and dark, for the screen, the phone and paper."""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from splinebba_cli.report.blocks import (
    Block,
    Cell,
    Facts,
    FigureBlock,
    Note,
    ProblemList,
    Report,
    Table,
    cell_text,
)
from splinebba_cli.report.table_payload import table_payload

if TYPE_CHECKING:
    from jinja2 import Environment
    from markupsafe import Markup

_TEMPLATES = Path(__file__).parent / "templates"
_PLAIN = 100  # rows up to which all of a table stand in the page
_PAGE = 50  # rows of longer ones that do: the script makes those that are looked at
_LONG = 40  # characters of a cell from which on it is broken into lines
_KEPT = 60_000  # rows of a table that the page has as data: more would make it too large for a mail
_STYLES = ("style.css", "tables.css", "print.css", "figures.css")
_SCRIPTS = ("theme.js", "table_rows.js", "table_filter.js", "tables.js", "page.js", "figures.js")
_KINDS: dict[type, str] = {
    Facts: "facts",
    FigureBlock: "figure",
    Note: "note",
    ProblemList: "problems",
    Table: "table",
}


def render_page(report: Report, draw: Callable[[FigureBlock], str]) -> str:
    """The whole page of a report of any kind.

    Parameters
    ----------
    draw : callable
        Gives the markup of a figure, in which every text is escaped; empty where there is nothing to draw.
    """
    from markupsafe import Markup

    environment = _environment()
    environment.filters["figure"] = lambda block: Markup(draw(block))
    template = environment.get_template("report.html.j2")
    return template.render(report=report, plain_rows=_PLAIN, page_rows=_PAGE, kept_rows=_KEPT)


def _environment() -> Environment:
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from markupsafe import Markup

    environment = Environment(
        loader=FileSystemLoader(_TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters["kind"] = _kind
    environment.filters["code"] = _code
    environment.filters["cell"] = lambda cell, column: cell_text(column, cell)
    environment.filters["sort_key"] = _sort_key
    environment.tests["long"] = lambda cell: isinstance(cell, str) and len(cell) > _LONG
    environment.filters["payload"] = lambda table: Markup(table_payload(table, _KEPT))
    environment.filters["css_string"] = _css_string
    script = f"\n{_assets(*_SCRIPTS)}\n"
    environment.globals["style"] = Markup(_assets(*_STYLES))
    environment.globals["script"] = Markup(script)
    environment.globals["script_hash"] = _script_hash(script)
    return environment


def _assets(*names: str) -> str:
    return "\n".join((_TEMPLATES / name).read_text(encoding="utf-8") for name in names)


def _script_hash(script: str) -> str:
    """Names the script of the page, so that its policy lets no other one run."""
    return base64.b64encode(hashlib.sha256(script.encode("utf-8")).digest()).decode("ascii")


def _css_string(text: str) -> Markup:
    """A text as a string of a style sheet: every character but the plainest by its number."""
    from markupsafe import Markup

    plain = "".join(c if c.isascii() and c.isalnum() else f"\\{ord(c):06x}" for c in text)
    return Markup('"{}"').format(Markup(plain))


def _kind(block: Block) -> str:
    return _KINDS[type(block)]


def _code(text: str) -> Markup:
    """Text with `names` in backticks set as code; everything is escaped."""
    from markupsafe import Markup, escape

    return Markup("").join(
        Markup("<code>{}</code>").format(part) if number % 2 else escape(part)
        for number, part in enumerate(re.split(r"`([^`]*)`", text))
    )


def _sort_key(cell: Cell) -> str:
    """The value by which the page sorts and compares a numeric cell."""
    return "" if cell is None or isinstance(cell, str) else f"{cell:.9g}"
