"""Frame of a view of the block: axes, scale bar, direction of the upper axis, legend, labels."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.report.canvas import INK, MUTED, SCALE_BAR
from splinebba_cli.report.scale import round_length
from splinebba_cli.report.svg_text import visible

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.text import Annotation
    from matplotlib.transforms import Bbox

_LABEL = 24  # characters of an id that are shown


class Labels:
    """Ids beside their places; those that would cover earlier ones are left out and stay in the tips.

    Parameters
    ----------
    axes : where they are written
    """

    def __init__(self, axes: Axes) -> None:
        self._axes = axes
        self._written: list[Annotation] = []

    def add(self, text: str, x: float | None, y: float | None, colour: str) -> None:
        """An id at the upper right of its place."""
        if x is None or y is None:
            return
        shown = f"\u00a0\u00a0{visible(text, _LABEL)}"
        label = self._axes.annotate(shown, (x, y), fontsize=7, color=colour, clip_on=True, va="bottom")
        self._written.append(label)

    def thin_out(self) -> None:
        """Take out what covers others, once the limits of the axes and all parts of the figure are there."""
        if not self._written:
            return
        self._axes.figure.draw_without_rendering()  # type: ignore[union-attr]
        kept: list[Bbox] = []
        for label in self._written:
            box = label.get_window_extent()
            if box.count_overlaps(kept):
                label.remove()
            else:
                kept.append(box)


def finish(axes: Axes, plane: str, extent: FloatArray, upwards: str) -> None:
    """Limits, names of the axes, scale bar, arrow with the name of what is up."""
    span = extent[1] - extent[0]
    margin = 0.05 * float(span.max())
    axes.update_datalim(np.array([extent[0] - [margin, 2.6 * margin], extent[1] + margin]))
    axes.autoscale_view()
    axes.set_xlabel(f"{plane[0]} [m]")
    axes.set_ylabel(f"{plane[1]} [m]")
    axes.locator_params(nbins=6)
    if span.max() > 20:
        axes.xaxis.set_major_formatter("{x:.0f}")
        axes.yaxis.set_major_formatter("{x:.0f}")
    _scale_bar(axes, extent, margin)
    _arrow(axes, upwards)


def _scale_bar(axes: Axes, extent: FloatArray, margin: float) -> None:
    length = round_length(0.2 * float((extent[1] - extent[0]).max()))
    x, y = extent[0, 0] - 0.4 * margin, extent[0, 1] - 1.8 * margin
    (bar,) = axes.plot([x, x + length], [y, y], color=INK, linewidth=2.2, solid_capstyle="butt")
    bar.set_gid(f"{SCALE_BAR}{length:g}")
    text = f"{length:g} m" if length >= 1.0 else f"{1e3 * length:g} mm"
    axes.annotate(text, (x + 0.5 * length, y), xytext=(0, 4), textcoords="offset points", ha="center")


def _arrow(axes: Axes, name: str) -> None:
    axes.annotate(
        name,
        xy=(0.985, 0.99),
        xytext=(0.985, 0.87),
        xycoords="axes fraction",
        ha="center",
        va="top",
        arrowprops={"arrowstyle": "-|>", "color": MUTED, "lw": 1.2},
    )
