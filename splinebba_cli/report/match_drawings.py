"""match_drawings.json: the lines of the drawings of match.html, so that `report` can make the page again.

Pixels of the page, one digit behind the point.  It is made for this program: other programs read match.json and the
tables.
"""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

from splinebba_cli.report.match_panels import Panel, Stroke

DRAWINGS_FILE = "match_drawings.json"


def write_drawings(folder: Path, panels: list[Panel]) -> None:
    """Write the drawings into a folder that is being made."""
    rows = [json.dumps(asdict(panel), ensure_ascii=False) for panel in panels]
    text = "[\n" + ",\n".join(rows) + "\n]\n"
    (folder / DRAWINGS_FILE).write_text(text, encoding="utf-8", newline="\n")


def read_drawings(folder: Path) -> list[Panel]:
    """The drawings of a folder.

    Raises
    ------
    OSError, ValueError, LookupError, TypeError
        If the file is missing or damaged.
    """
    content: list[dict[str, Any]] = json.loads((folder / DRAWINGS_FILE).read_text(encoding="utf-8"))
    return [
        Panel(
            image=int(each["image"]),
            height=float(each["height"]),
            frame=tuple(float(value) for value in each["frame"]),  # type: ignore[arg-type]
            strokes=tuple(Stroke(str(s["kind"]), str(s["path"]), str(s["says"])) for s in each["strokes"]),
        )
        for each in content
    ]
