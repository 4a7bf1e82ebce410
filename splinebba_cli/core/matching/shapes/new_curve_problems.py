"""What a person should know about new curves: weak parts, cuts, duplicates, double edges."""

from __future__ import annotations

from collections.abc import Sequence

from splinebba_cli.core.matching.matches import BuiltCurve, WeakPart
from splinebba_cli.core.matching.shapes.double_edges import TwoClusters
from splinebba_cli.core.matching.shapes.second_edges import SecondEdge
from splinebba_cli.core.matching.shapes.undetermined import Cut
from splinebba_cli.core.network import Network
from splinebba_cli.core.result import Problem

NAMED = 5  # images or chains in a message
WEAK_TOLD = 3  # splines with weak parts that have a message of their own


def weak_problems(built: Sequence[BuiltCurve], ids: Sequence[str], usual: float) -> list[Problem]:
    """SBB594: new curves with parts that their images hold weakly, or not."""
    found: list[Problem] = []
    more: list[str] = []
    for one, weak in _weakest_first(built):
        if len(found) == WEAK_TOLD:
            more.append(ids[one.curve])
            continue
        bridged = sum(part.kind == "bridged" for part in weak)
        what = []
        if len(weak) - bridged:
            what.append(f"{_count(len(weak) - bridged, 'part')} along the epipolar lines of the images")
        if bridged:
            what.append(f"{_count(bridged, 'part')} bridged where fewer than two images see it")
        largest = max(part.sigma_m for part in weak)
        found.append(
            Problem(
                "SBB594",
                "info",
                f"new spline `{ids[one.curve]}` is weak across in {' and '.join(what)} "
                f"(σ up to {_metres(largest)}, usual for new splines {_metres(usual)})",
                f"spline `{ids[one.curve]}`",
                "an image from another direction, or a chain there in another image, would hold it",
            )
        )
    if more:
        noun = "new spline" if len(more) == 1 else "new splines"
        message = f"{len(more)} more {noun} with weak parts: {', '.join(f'`{id}`' for id in more[:NAMED])}"
        found.append(
            Problem("SBB594", "info", message, "new splines", "the table of new splines lists these parts")
        )
    return found


def _weakest_first(built: Sequence[BuiltCurve]) -> list[tuple[BuiltCurve, list[WeakPart]]]:
    """New curves with weak parts, those with the largest sigma first."""
    weak = [(one, [part for part in one.weak_parts if part.kind != "two_images"]) for one in built]
    found = [(one, parts) for one, parts in weak if parts]
    return sorted(found, key=lambda each: -max(part.sigma_m for part in each[1]))


def cut_problems(cuts: Sequence[Cut]) -> list[Problem]:
    """SBB595: new curves of which parts are left out, because nothing determines them."""
    found = []
    for cut in cuts:
        left = (
            "nothing of it is left" if not cut.parts else f"left: {', '.join(f'`{id}`' for id in cut.parts)}"
        )
        found.append(
            Problem(
                "SBB595",
                "warning",
                f"new spline `{cut.curve}` is cut where no images determine it (σ {_metres(cut.sigma_m)}); {left}",
                f"spline `{cut.curve}`",
                "measure it there in an image from another direction",
            )
        )
    return found


def duplicate_problems(merged: Sequence[tuple[str, str]], given: Sequence[tuple[str, ...]]) -> list[Problem]:
    """SBB596: curves that turned out to be one edge.

    Parameters
    ----------
    merged : pairs of new ids, the kept one first
    given : ids of the project for every new curve that has one, or has two
    """
    found = [
        Problem(
            "SBB596",
            "info",
            f"new spline `{gone}` is the same edge as `{kept}`: they are one",
            f"spline `{kept}`",
        )
        for kept, gone in merged
    ]
    return found + [_edge_of_given(*ids) for ids in given]


def _edge_of_given(kept: str, other: str | None = None) -> Problem:
    if other is not None:
        return Problem(
            "SBB596",
            "warning",
            f"chains show one edge where the project has splines `{kept}` and `{other}`: they stay without a spline",
            f"spline `{kept}`",
            "take one of the two splines out, or trace both edges in one image",
        )
    return Problem(
        "SBB596",
        "warning",
        f"the chains of a new spline show the edge of spline `{kept}`: their points belong to it now",
        f"spline `{kept}`",
        "look at the residuals of its points; an image that shows two edges side by side would tell them apart",
    )


def second_edge_problems(network: Network, split: Sequence[SecondEdge]) -> list[Problem]:
    """SBB597: curves to whose points those of a second edge beside them had been added."""
    found = []
    for one in split:
        images = sorted({network.images.ids[off.image] for off in one.off})
        shift = max(abs(off.shift) for off in one.off)
        points = sum(len(off.row) for off in one.off)
        where = f"they make spline `{one.other}`" if one.other else "they have no spline now"
        found.append(
            Problem(
                "SBB597",
                "info",
                f"beside new spline `{one.curve}` runs a second edge: {_count(points, 'point')} of "
                f"{_names(images, 'image')} lie {shift:.1f} σ across it; {where}",
                f"spline `{one.curve}`",
                "nothing to do where there are two edges; else look at these chains",
            )
        )
    return found


def two_edges_problem(network: Network, curve: int, clusters: TwoClusters) -> Problem:
    """SBB598: the points of a curve of known shape lie on two sides of it."""
    id = network.curves[curve].id
    return Problem(
        "SBB598",
        "warning",
        f"the points of spline `{id}` show two edges: {_count(len(clusters.minority), 'chain')} of them on one side, "
        f"{clusters.apart:.1f} σ from the others",
        f"spline `{id}`",
        "decide which edge the spline is, and take the other chains out (column `use`)",
    )


def _names(ids: Sequence[str], noun: str) -> str:
    shown = ", ".join(f"`{id}`" for id in ids[:NAMED])
    more = f" and {len(ids) - NAMED} more" if len(ids) > NAMED else ""
    return f"{noun}{'s' if len(ids) > 1 else ''} {shown}{more}"


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"


def _metres(value: float) -> str:
    return f"{1000.0 * value:.3g} mm" if value < 1.0 else f"{value:.3g} m"
