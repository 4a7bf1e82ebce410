"""From a matplotlib figure to SVG inside of the page: colours follow the page, same drawing, same bytes."""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from splinebba_cli.report.svg_text import Tips

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Colours that matplotlib writes; the page replaces them by its own, for light and dark.
INK, MUTED, GRID = "#101112", "#505152", "#d0d1d2"
STATION, WARN, PAPER = "#c00005", "#c00006", "#fcfdfe"
CLASS_COLOURS = tuple(
    f"#c0001{number}" for number in range(6)
)  # light for low to dark for high, in a light page
ROLE_COLOURS = {"control": "#c00001", "partial": "#c00002", "tie": "#c00003", "check": "#c00004"}
_VARIABLES = {
    INK: "var(--ink)",
    MUTED: "var(--muted)",
    GRID: "var(--rule)",
    STATION: "var(--station)",
    WARN: "var(--bad)",
    PAPER: "var(--card)",
    **{colour: f"var(--class-{number})" for number, colour in enumerate(CLASS_COLOURS)},
    **{colour: f"var(--role-{role})" for role, colour in ROLE_COLOURS.items()},
}
SCALE_BAR = "scale-bar-"  # id of the group of a scale bar, ends with its length in metres
Margins = tuple[float, float, float, float, float]
_STYLE: Any = {
    "svg.fonttype": "none",
    "font.family": "sans-serif",
    "font.size": 8.5,
    "axes.edgecolor": MUTED,
    "axes.labelcolor": INK,
    "axes.titlesize": 9.5,
    "axes.titleweight": "bold",
    "axes.titlecolor": INK,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-5, 9),  # coordinates of millions of metres as they are
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "text.color": INK,
    "text.parse_math": False,  # ids of the user may hold a dollar sign
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "legend.frameon": False,
    "lines.linewidth": 1.4,
    "path.simplify": True,
    "path.simplify_threshold": 0.3,
    "figure.facecolor": "none",
    "axes.facecolor": "none",
    "savefig.facecolor": "none",
}


def svg_of(
    draw: Callable[[Figure], None],
    size_inch: tuple[float, float],
    salt: str,
    *,
    margins: Margins | None = None,
    tips: Tips | None = None,
    kind: str = "drawing",
) -> str:
    """Draw a figure and give its SVG element.

    Parameters
    ----------
    draw : callable
        Draws into the empty figure that it gets.
    size_inch : (width, height)
    salt : str
        Makes the ids of clip paths in this figure different from those of other figures on the page.
    margins : tuple, optional
        Left, bottom, right, top of the axes and the gap between them, as fractions; by default they are
        computed, which takes longer than the drawing.
    tips : Tips, optional
        What the elements say when they are pointed at; `draw` fills it.
    kind : str
        Class of the element: ``map`` can be enlarged, a ``drawing`` cannot.

    Returns
    -------
    str
        ``<svg …>…</svg>`` without width and height; the same drawing gives the same text.
    """
    import matplotlib as mpl
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    with mpl.rc_context(), warnings.catch_warnings():
        mpl.rcdefaults()
        mpl.rcParams.update(_STYLE)
        mpl.rcParams["svg.hashsalt"] = salt
        figure = Figure(figsize=size_inch, layout="constrained" if margins is None else None)
        if margins is not None:
            figure.subplots_adjust(*margins[:4], wspace=margins[4])
        canvas = FigureCanvasSVG(figure)
        draw(figure)
        stream = io.StringIO()
        warnings.filterwarnings(
            "ignore", "Glyph .* missing", UserWarning
        )  # text stays text: the page has fonts
        canvas.print_svg(stream, metadata={"Date": None, "Creator": None, "Format": None, "Type": None})  # type: ignore[no-untyped-call]
    return _clean(stream.getvalue(), tips or Tips(), kind)


def write_figure(draw: Callable[[Figure], None], size_inch: tuple[float, float], path: Path) -> Path:
    """Draw a figure into a file of its own; the same drawing gives the same bytes.

    Parameters
    ----------
    draw : callable
        Draws into the empty figure that it gets.
    size_inch : (width, height)
    path : Path
        ``.svg`` or ``.png``.

    Returns
    -------
    Path
        The file written.
    """
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_STYLE)
        mpl.rcParams["svg.hashsalt"] = path.stem
        mpl.rcParams["savefig.facecolor"] = "white"
        figure = Figure(figsize=size_inch, layout="constrained")
        FigureCanvasAgg(figure)
        draw(figure)
        plain = {"Date": None, "Creator": None} if path.suffix == ".svg" else {"Software": None}
        figure.savefig(path, dpi=160, metadata=plain)
    return path


def _clean(svg: str, tips: Tips, kind: str) -> str:
    """Only the element, small and without what a page must not have twice."""
    svg = svg[svg.index("<svg ") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = re.sub(r"<!--.*?-->", "", svg, flags=re.DOTALL)
    head, rest = svg.split(">", 1)
    head = re.sub(r' (width|height|version|xmlns:xlink)="[^"]*"', "", head)
    rest = re.sub(r"\n\s*", "\n", re.sub(r"<[^/>][^>]*>", _clean_tag, rest))
    rest = tips.into(rest)
    used = set(re.findall(r"(?:url\(#|href=\"#)([^\")]+)", rest))
    rest = re.sub(r'(<\w+) id="([^"]*)"', lambda m: m.group(0 if m.group(2) in used else 1), rest)
    return f'{head} class="{kind}">{rest}'.strip()


def _clean_tag(match: re.Match[str]) -> str:
    """One tag: colours of the page, two decimals; texts between the tags stay as they are."""
    tag = match.group(0).replace("xlink:href", "href")
    tag = re.sub(r' (?:d|transform|x|y)="[^"]*"', lambda m: _rounded(m.group(0)), tag)
    tag = re.sub(r"font: (?:(bold) )?([\d.]+px) [^;\"]*", _font, tag)  # as matplotlib up to 3.9 writes it
    tag = tag.replace(f'id="{SCALE_BAR}', 'data-metres="')
    tag = re.sub(r"font-family: [^;\"]*;? ?", "", tag)
    tag = re.sub(r"font-size: ([\d.]+px)", r"font-size: calc(\1 * var(--shrink, 1))", tag)
    return re.sub(r"#[0-9a-f]{6}\b", lambda m: _VARIABLES.get(m.group(0), m.group(0)), tag)


def _rounded(attribute: str) -> str:
    return re.sub(r"(\.\d\d)\d+", r"\1", attribute)


def _font(match: re.Match[str]) -> str:
    weight = "font-weight: 600; " if match.group(1) else ""
    return f"{weight}font-size: {match.group(2)}"
