"""Curves cut where nothing determines them, and curves that are none."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.matching.shapes.curve_normals import curve_normals
from splinebba_cli.core.matching.shapes.draft import Draft, draft_of
from splinebba_cli.core.matching.shapes.extent import on_domain, point_spacing
from splinebba_cli.core.matching.shapes.names import new_ids
from splinebba_cli.core.matching.shapes.weak_parts import determined_parts, seen_places
from splinebba_cli.core.network import Curve, Network

FEWEST = 8  # links of a curve
SHORTEST = 3.0  # spacings of points


@dataclass(frozen=True)
class Cut:
    """A curve of which only parts are determined."""

    curve: str  # id
    parts: tuple[str, ...]  # ids of what is left of it; none: nothing is
    sigma_m: float  # largest across in what was cut out


def usual_sigma(draft: Draft) -> float:
    """Median of sigma across the new curves, metres."""
    spacing = point_spacing(draft)
    known = [
        seen_places(draft, own, spacing[k]).sigma
        for k, own in enumerate(curve_normals(draft))
        if np.isfinite(spacing[k])
    ]
    return float(np.median(np.concatenate(known))) if known else float("nan")


def cut_undetermined(network: Network, draft: Draft, usual: float) -> tuple[Draft, list[Cut]]:
    """A draft of what is determined; curves that are cut in the middle become two.

    Parameters
    ----------
    usual : sigma across, metres
    """
    spacing, cuts = point_spacing(draft), []
    curves: list[Curve] = []
    label = np.full(len(draft.row), -1)
    taken = [curve.id for curve in (*network.curves, *draft.curves)]
    for k, (curve, own) in enumerate(zip(draft.present_curves(), curve_normals(draft), strict=True)):
        seen = seen_places(draft, own, spacing[k]) if np.isfinite(spacing[k]) else None
        parts = determined_parts(seen, usual) if seen is not None and not curve.closed else None
        if not parts:
            label[own.link] = len(curves)
            curves.append(curve)
            continue
        names: list[str] = []
        for low, high in parts:
            inside = (own.location >= low) & (own.location <= high)
            images = np.unique(draft.links.image[own.link[inside]])
            if high - low < SHORTEST * spacing[k] or inside.sum() < FEWEST or len(images) < 2:
                continue
            id = curve.id if not names else new_ids(1, taken)[0]
            taken.append(id)
            names.append(id)
            label[own.link[inside]] = len(curves)
            curves.append(replace(on_domain(curve, own.basis, own.coefficients, low, high), id=id))
        largest = float(seen.sigma.max()) if seen is not None else float("inf")
        cuts.append(Cut(curve.id, tuple(names), largest))
    if not cuts:
        return draft, []
    keep = label >= 0
    unknown = np.full(int(keep.sum()), np.nan)
    found = draft_of(network, draft.state, tuple(curves), draft.row[keep], label[keep], unknown)
    return found.solved(), cuts


def real_curves(network: Network, draft: Draft) -> Draft:
    """The curves that two images see with enough points."""
    kept = []
    spacing = point_spacing(draft)
    for k, curve in enumerate(draft.present_curves()):
        own = draft.links_by_curve[k]
        breaks = draft.prepared.curves.bases[k].break_points
        images = np.unique(draft.links.image[own])
        long = float(breaks[-1] - breaks[0]) >= SHORTEST * spacing[k]
        if len(own) >= FEWEST and len(images) >= 2 and long:
            kept.append((k, curve))
    if len(kept) == len(draft.curves):
        return draft
    new = np.full(len(draft.curves), -1)
    new[[k for k, _ in kept]] = np.arange(len(kept))
    label = new[draft.links.curve]
    keep = label >= 0
    return draft_of(
        network,
        draft.state,
        tuple(c for _, c in kept),
        draft.row[keep],
        label[keep],
        draft.state.location[keep],
    )
