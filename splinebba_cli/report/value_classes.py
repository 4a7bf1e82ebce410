"""Six classes of a value for maps: limits, colours, and a legend that says them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.report.canvas import CLASS_COLOURS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COUNT = len(CLASS_COLOURS)
_APART = 1.15  # least ratio of neighbouring limits


@dataclass(frozen=True)
class ValueClasses:
    """Classes from good to bad; the last one stands out most.

    Attributes
    ----------
    limits : five limits between the classes, from the good side
    title : what the values are
    """

    limits: tuple[float, ...]
    title: str

    @property
    def falling(self) -> bool:
        """Whether small values are the bad ones."""
        return self.limits[0] > self.limits[-1]

    def of(self, values: FloatArray) -> IntArray:
        """Number of the class of every value, 0 the best."""
        sign = -1.0 if self.falling else 1.0
        return np.searchsorted(sign * np.array(self.limits), sign * values, side="left")

    def names(self) -> list[str]:
        """Every class in words."""
        first, last = ("≥", "<") if self.falling else ("≤", ">")
        inner = [f"{a:g} – {b:g}" for a, b in zip(self.limits, self.limits[1:], strict=False)]
        return [f"{first} {self.limits[0]:g}", *inner, f"{last} {self.limits[-1]:g}"]

    def legend(self, figure: Figure) -> None:
        """Patches under the figure, the good class first."""
        from matplotlib.patches import Patch

        patches = [Patch(color=c, label=n) for c, n in zip(CLASS_COLOURS, self.names(), strict=True)]
        figure.legend(
            handles=patches,
            loc="outside lower center",
            ncols=_COUNT,
            fontsize=7.5,
            title=self.title,
            title_fontsize=8,
            handlelength=1.2,
            columnspacing=1.0,
        )


def redundancy_classes() -> ValueClasses:
    """Redundancy numbers; below 0.1 an observation is hardly controlled."""
    return ValueClasses((0.8, 0.65, 0.5, 0.3, 0.1), "mean redundancy number")


def quantile_classes(values: FloatArray, title: str) -> ValueClasses:
    """Limits at two digits that divide the values into classes of like size; small values are good.

    Limits differ by 15 % at least, so that noise does not look like a pattern.
    """
    found = np.quantile(values[np.isfinite(values)], np.arange(1, _COUNT) / _COUNT)
    limits = np.array([float(f"{value:.2g}") for value in found])
    for k in range(1, len(limits)):
        limits[k] = max(limits[k], float(f"{_APART * limits[k - 1]:.2g}"))
    return ValueClasses(tuple(limits.tolist()), title)
