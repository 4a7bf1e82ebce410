"""Figures of a matching: how the gate closed, how clear the matches are."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from splinebba_cli.report.canvas import INK, ROLE_COLOURS, STATION, svg_of
from splinebba_cli.report.stage_marks import mark_stages
from splinebba_cli.report.svg_text import Tips

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_HEADROOM = 1.15  # for the names of the stages
_DECADE = 10.0  # beyond which ratio of the gates their axis is logarithmic
_MARGINS = (0.08, 0.17, 0.985, 0.88, 0.26)


def gate_history(content: dict[str, Any]) -> str:
    """SVG: half width of the gate and matched points of every round; empty without rounds."""
    log = content["history"]
    if not log:
        return ""
    rounds = np.arange(1, len(log) + 1)
    gate = np.array([step["gate_px"] for step in log], dtype=float)
    matched = np.array([step["matched"] for step in log], dtype=float)
    stages = [step["stage"] for step in log]

    def draw(figure: Figure) -> None:
        left, right = figure.subplots(1, 2)
        left.plot(rounds, np.where(gate > 0.0, gate, np.nan), "o-", color=STATION, markersize=3)
        if np.nanmax(gate) > _DECADE * np.nanmin(gate[gate > 0.0], initial=np.inf):
            left.set_yscale("log")
            left.yaxis.set_major_formatter("{x:g}")
            left.yaxis.set_minor_formatter("")
        else:
            left.set_ylim(0.0, _HEADROOM * float(np.nanmax(gate)))
        left.set_title("Half width of the gate [px]")
        right.plot(rounds, matched, "o-", color=ROLE_COLOURS["tie"], markersize=3)
        right.set_ylim(0.0, _HEADROOM * max(float(matched.max()), 1.0))
        right.set_title("Matched points")
        for axes in (left, right):
            axes.set_xlabel("round")
            mark_stages(axes, stages)

    return svg_of(draw, (7.6, 2.7), "gate_history", margins=_MARGINS)


def ambiguity(content: dict[str, Any]) -> str:
    """SVG: matched points by their distance over that of the second-best spline; empty where none has a second one."""
    found = content["ambiguity"]
    numbers, edges = np.array(found["points"]), np.array(found["edges"])
    if not numbers.sum():
        return ""
    tips = Tips()
    width = np.diff(edges)
    says = [
        f"ratio {a:.1f} to {b:.1f}: {count} points"
        for a, b, count in zip(edges[:-1], edges[1:], numbers.tolist(), strict=True)
    ]

    def draw(figure: Figure) -> None:
        from matplotlib.ticker import MaxNLocator

        axes = figure.add_subplot()
        middle = 0.5 * (edges[:-1] + edges[1:])
        bars = axes.vlines(middle, 0.0, numbers, color=ROLE_COLOURS["tie"], alpha=0.8)
        bars.set_linewidth(480.0 * float(width[0]) * 0.9)
        tips.on(bars, says)
        axes.axvline(found["close_from"], color=INK, linewidth=0.8, linestyle=(0, (4, 3)))
        axes.set_xlim(0.0, 1.0)
        axes.set_ylim(bottom=0.0)
        axes.yaxis.set_major_locator(MaxNLocator(integer=True))
        axes.grid(visible=False, axis="x")
        axes.set_xlabel("distance from the chosen spline / distance from the next one")
        axes.set_ylabel("points")

    return svg_of(draw, (7.6, 2.4), "ambiguity", tips=tips)
