"""The drawings of images with their chains as SVG."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any

from splinebba_cli.report.match_panels import EDGE, SHOWN, UNMATCHED, WIDTH, Panel, Stroke
from splinebba_cli.report.svg_text import escaped_line, number, titled

CROWDED = 500  # unmatched chains of an image from which they are drawn thin
_CURVES = ("projected", "weak")
_MARKS = (
    ("d-matched", "━", "on a spline of the project"),
    ("d-unmatched", "━", "unmatched"),
    ("d-projected", "╌", "projected spline"),
)
_MARKS_OF_NEW = (("d-new", "━", "on a new spline"), ("d-weak", "╍", "weak part of a new spline"))


def match_images(panels: Sequence[Panel], images: list[dict[str, Any]], *, new: bool) -> str:
    """The first drawings side by side, further ones to choose from.

    Parameters
    ----------
    images : of match.json
    new : whether splines were built
    """
    first = "".join(_svg(panel, images[panel.image]) for panel in panels[:SHOWN])
    marks = (*_MARKS, *(_MARKS_OF_NEW if new else ()))
    legend = "".join(f'<span><i class="{kind}">{mark}</i> {text}</span>' for kind, mark, text in marks)
    text = f'<p class="legend">{legend}</p><div class="panels">{first}</div>'
    rest = sorted(panels[SHOWN:], key=lambda panel: panel.image)
    if rest:
        more = "".join(
            f"<details><summary>{escaped_line(images[panel.image]['id'])}</summary>"
            f"{_svg(panel, images[panel.image])}</details>"
            for panel in rest
        )
        text += f'<div class="choice" data-label="Another image">{more}</div>'
    return text


def _svg(panel: Panel, about: dict[str, Any]) -> str:
    """The drawing of one image under its name."""
    name, view = f"chains-{panel.image}", f"0 0 {number(WIDTH)} {number(panel.height + 2 * EDGE)}"
    left, top, width, height = map(number, panel.frame)
    frame = f'<rect class="frame" x="{left}" y="{top}" width="{width}" height="{height}"/>'
    title = (
        f'<p id="{name}">Image <strong>{escaped_line(about["id"], 40)}</strong> '
        f"{about['matched']} of {about['points']} points matched</p>"
    )
    drawing = f'<svg class="map{_density(panel)}" viewBox="{view}">{frame}{"".join(map(_path, panel.strokes))}</svg>'
    return (
        f'<div class="panel">{title}<div class="scroll" tabindex="0" role="img" aria-labelledby="{name}">'
        f"{drawing}</div></div>"
    )


def _density(panel: Panel) -> str:
    """A class for drawings in which unmatched chains would cover all else."""
    return " crowded" if sum(stroke.kind == UNMATCHED for stroke in panel.strokes) > CROWDED else ""


def _path(stroke: Stroke) -> str:
    kind = stroke.kind if stroke.kind in _CURVES else f"chain chain-{stroke.kind}"
    return titled("path", f'class="{escape(kind)}" d="{escape(stroke.path)}"', stroke.says)
