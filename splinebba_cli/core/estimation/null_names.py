"""Names for directions: which image, curve or point moves, and how, in the user's words."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.estimation.parameters import ParameterLayout
from splinebba_cli.core.network import FloatArray, Network
from splinebba_cli.core.result import Problem

ORIENTATION = ("ω", "φ", "κ", "X₀", "Y₀", "Z₀")
MUCH = 0.25  # share of the largest entry that is worth a name


@dataclass(frozen=True)
class Mover:
    """One feature that takes part in an undetermined direction."""

    kind: str  # image, spline, point
    id: str
    share: float  # of the squared length of the direction
    parts: tuple[str, ...]  # images: names of the unknowns


def movers(direction: FloatArray, layout: ParameterLayout, network: Network) -> list[Mover]:
    """Who moves in a direction over the reduced unknowns and the points, most first."""
    square = direction**2 / max(float(np.sum(direction**2)), 1e-300)
    found: list[Mover] = []
    images = layout.image_count
    by_image = square[: 6 * images].reshape(images, 6)
    for image in np.flatnonzero(by_image.sum(axis=1) > 1e-3):
        part = by_image[image]
        names = tuple(ORIENTATION[k] for k in range(6) if part[k] > MUCH**2 * part.max())
        found.append(Mover("image", network.images.ids[image], float(part.sum()), names))
    reduced = int(layout.node_starts[-1])
    node = np.repeat(np.arange(len(layout.node_sizes)), layout.node_sizes)
    curve = layout.node_curve[node]
    by_curve = np.bincount(curve[curve >= 0], square[:reduced][curve >= 0], minlength=len(network.curves))
    found += [
        Mover("spline", network.curves[k].id, float(by_curve[k]), ()) for k in np.flatnonzero(by_curve > 1e-3)
    ]
    by_point = square[layout.unknown_of_point].sum(axis=1)
    found += [
        Mover("point", network.points.ids[k], float(by_point[k]), ()) for k in np.flatnonzero(by_point > 1e-3)
    ]
    return sorted(found, key=lambda mover: -mover.share)


def describe(direction: FloatArray, layout: ParameterLayout, network: Network) -> Problem:
    """An undetermined direction as a problem with its cure."""
    who = movers(direction, layout, network)
    kinds = {mover.kind for mover in who}
    if kinds == {"spline"} and len(who) == 1:
        name = who[0].id
        return Problem(
            "SBB520",
            "error",
            f"spline `{name}` is not determined: it slides or bends without changing any measurement",
            f"spline `{name}`",
            "measure it in more images or from other directions, hold some of its knots, or use fewer knots",
        )
    if kinds == {"point"}:
        names = ", ".join(f"`{m.id}`" for m in who[:5])
        return Problem(
            "SBB521", "error", f"point {names} is not determined by its rays", f"point `{who[0].id}`",
            "measure it in a second image, or give its coordinates as control",
        )  # fmt: skip
    images = [mover for mover in who if mover.kind == "image"]
    if len(images) == 1:
        mover = images[0]
        return Problem(
            "SBB522", "error",
            f"image `{mover.id}`: {' and '.join(mover.parts)} are not separable by its measurements",
            f"image `{mover.id}`",
            "measure more control or tie features in it, spread over the format, "
            "or give a prior orientation (GNSS/INS)",
        )  # fmt: skip
    if images:
        names = ", ".join(f"`{m.id}`" for m in images[:6]) + (
            f" and {len(images) - 6} more" if len(images) > 6 else ""
        )
        return Problem(
            "SBB523", "error", f"images {names} can move together: nothing fixes this part of the datum",
            "datum",
            "add control points or control splines (not all on one line), prior orientations, or "
            "`adjustment: {datum: minimal}` for a network without control",
        )  # fmt: skip
    names = ", ".join(f"{m.kind} `{m.id}`" for m in who[:5])
    return Problem("SBB524", "error", f"{names} are not determined", "network", "measure them in more images")
