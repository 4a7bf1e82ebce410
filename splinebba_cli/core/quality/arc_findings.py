"""Whether one Simpson step was enough for the arc lengths that ask for it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.observations.arc_lengths import arc_lengths_at
from splinebba_cli.core.result import Problem
from splinebba_cli.core.state import Prepared, State

WORTH_A_WORD = 0.3  # of sigma


def arc_findings(prepared: Prepared, state: State) -> tuple[Problem, ...]:
    """A warning where Simpson's rule differs from the length of the adjusted curve by much of sigma."""
    arcs = prepared.network.arc_lengths
    rows = np.flatnonzero(arcs.simpson)
    if not len(rows):
        return ()
    exact = replace(arcs, simpson=np.zeros(len(arcs), dtype=bool))
    other = replace(prepared, network=replace(prepared.network, arc_lengths=exact))
    bias = np.abs(arc_lengths_at(prepared, state, rows) - arc_lengths_at(other, state, rows))
    much = np.flatnonzero(bias > WORTH_A_WORD * prepared.arc_lengths.sigma[rows])
    if not len(much):
        return ()
    worst = rows[much[np.argmax(bias[much])]]
    observed, network = prepared.network.curve_observations, prepared.network
    curve = network.curves[observed.curve[arcs.first[worst]]].id
    image = network.images.ids[observed.image[arcs.first[worst]]]
    message = (
        f"{len(much)} of {len(rows)} arc lengths are too long for one Simpson step, in error by more than "
        f"{WORTH_A_WORD} σ: largest {1e3 * float(bias.max()):.3g} µm on spline `{curve}` in image `{image}`"
    )
    help = "use `method: gauss-legendre`, or measure points closer to each other"
    return (Problem("SBB537", "warning", message, "arc lengths", help),)
