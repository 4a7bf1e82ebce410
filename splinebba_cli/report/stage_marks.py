"""The stages of a log along the axis of its steps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from splinebba_cli.report.canvas import MUTED

_MANY = 25  # steps beyond which the names stand upright


def mark_stages(axes: Any, stages: Sequence[str]) -> None:
    """Lay out axes over steps 1, 2, 3 …: a dashed line and the name where a stage begins.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    stages : the stage of every step
    """
    axes.xaxis.get_major_locator().set_params(integer=True)
    axes.grid(visible=False, axis="x")
    axes.set_xlim(0.5, len(stages) + 0.5)
    for start in [k for k in range(len(stages)) if k == 0 or stages[k] != stages[k - 1]]:
        if start:
            axes.axvline(start + 0.5, color=MUTED, linewidth=0.7, linestyle=(0, (3, 3)))
        axes.annotate(
            stages[start],
            (start + 0.55, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(1, -2),
            textcoords="offset points",
            va="top",
            fontsize=7,
            color=MUTED,
            rotation=90 if len(stages) > _MANY else 0,
        )
