"""Estimated against declared σ of every group of observations, with the interval of the estimate."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from splinebba_cli.report.canvas import INK, MUTED, STATION, WARN, svg_of
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.svg_text import Tips, visible

if TYPE_CHECKING:
    from matplotlib.figure import Figure

GROUPS = 30
_INTERVAL = 1.96


def drawn_groups(data: ResultData) -> list[dict[str, Any]]:
    """Groups with redundancy, those that are farthest from what was declared first."""
    known = [each for each in data.content.get("variance_components", []) if each["sigma0"] is not None]
    return sorted(known, key=lambda each: -abs(_ratio(each)[0] - 1.0) / max(_ratio(each)[1], 1e-9))[:GROUPS]


def variance_figure(data: ResultData) -> str:
    """SVG: one row a group, estimated over declared σ; empty where no group has redundancy."""
    groups = drawn_groups(data)
    if not groups:
        return ""
    tips = Tips()
    ratio, sigma = np.array([_ratio(each) for each in groups]).T
    row = np.arange(len(groups))[::-1]
    failed = [not each["passed"] for each in groups]
    colours = [WARN if each else STATION for each in failed]
    says = [
        f"{each['group']} ({each['kind']})\nestimated / declared {a:.3f} ± {_INTERVAL * b:.3f}\n"
        f"{each['observations']} equations, redundancy {each['redundancy']:.1f}"
        for each, a, b in zip(groups, ratio, sigma, strict=True)
    ]

    def draw(figure: Figure) -> None:
        axes = figure.add_subplot()
        axes.axvline(1.0, color=INK, linewidth=1.0)
        axes.annotate(
            "declared", (1.0, 1.0), (3, 2), ("data", "axes fraction"), "offset points", fontsize=7.5
        )
        low = np.maximum(ratio - _INTERVAL * sigma, 0.0)
        axes.hlines(row, low, ratio + _INTERVAL * sigma, color=colours, linewidth=2.2)
        marks = axes.scatter(ratio, row, s=26, c=colours, linewidths=0, zorder=3)
        tips.on(marks, says)
        axes.set_yticks(row, [_name(each) for each in groups], color=MUTED)
        axes.set_ylim(-0.7, len(groups) - 0.3)
        axes.set_xlim(left=max(0.0, min(0.9, float(low.min()) - 0.05)))
        axes.grid(visible=False, axis="y")
        axes.set_xlabel("estimated / declared σ, bars: 95 % interval")

    return svg_of(draw, (7.6, 1.1 + 0.26 * len(groups)), "variance", tips=tips)


def _ratio(group: dict[str, Any]) -> tuple[float, float]:
    """Estimated over declared σ and its standard deviation: the factor stands for what was estimated already."""
    sigma = 0.0 if group["sigma0_sigma"] is None else group["sigma0_sigma"]
    return group["factor"] * group["sigma0"], group["factor"] * sigma


def _name(group: dict[str, Any]) -> str:
    """The group, with its kind where the name does not say it."""
    text = group["group"] if group["kind"] in group["group"] else f"{group['group']}, {group['kind']}"
    return visible(text, 36)
