"""What a person should know about the chains that tie curves were sought in."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from splinebba_cli.core.matching.fragments.fragment import Fragment
from splinebba_cli.core.matching.fragments.traced_chains import TracedChains
from splinebba_cli.core.matching.fragments.views import Views
from splinebba_cli.core.network import FloatArray, IntArray, Network
from splinebba_cli.core.result import Problem

NAMED = 3  # chains that a message names


def fragment_problems(
    network: Network,
    rotation: FloatArray,
    position: FloatArray,
    fragments: Sequence[Fragment],
    rows: IntArray | None = None,
) -> list[Problem]:
    """Findings about the search for fragments; arguments as those of :func:`.build.build_fragments`."""
    rows = np.arange(len(network.unlabelled)) if rows is None else np.asarray(rows)
    views = Views.of(network, rotation, position)
    chains = TracedChains.of(network, views, rows)
    images = np.unique(chains.image)
    if len(images) < 2:
        return [_too_few_images(len(images))]
    return [*_left_over(network, chains, fragments), *_jumps(network, chains)]


def _too_few_images(count: int) -> Problem:
    number = "no oriented image has chains" if not count else "only one oriented image has chains"
    return Problem(
        "SBB590",
        "warning",
        f"no tie curves can be built: {number} that no curve explains",
        "matching",
        "a tie curve needs chains of the same edge in two oriented images, better in three; give points of one traced"
        " edge the same chain, and approximate orientations to the images",
    )


def _left_over(network: Network, chains: TracedChains, fragments: Sequence[Fragment]) -> list[Problem]:
    linked = np.zeros(len(network.unlabelled), dtype=bool)
    for fragment in fragments:
        linked[fragment.link_row] = True
    chain = network.unlabelled.chain[chains.row]
    every = np.unique(chain)
    left = np.setdiff1d(every, chain[linked[chains.row]])
    if not len(left):
        return []
    return [
        Problem(
            "SBB591",
            "info",
            f"{len(left)} of {len(every)} chains belong to no tie curve: {_names(network, left)}",
            "matching",
            "no chains of two other images agree with them: edges that one or two images show, edges of things that"
            " moved, traced noise; nothing has to be done",
        )
    ]


def _jumps(network: Network, chains: TracedChains) -> list[Problem]:
    chain = network.unlabelled.chain[chains.row]
    first = chain[chains.start[:-1]]
    cut, pieces = np.unique(first, return_counts=True)
    cut = cut[pieces > 1]
    if not len(cut):
        return []
    return [
        Problem(
            "SBB592",
            "info",
            f"{_jumping(len(cut))} cut into {int(pieces[pieces > 1].sum())} pieces: {_names(network, cut)}",
            "matching",
            "points of a chain follow each other along one edge; nothing has to be done where the edge is hidden for a"
            " stretch, but look at chains whose points are not in the order of tracing",
        )
    ]


def _names(network: Network, chain: IntArray) -> str:
    ids = network.unlabelled.chain_ids
    named = ", ".join(f"`{ids[k]}`" for k in chain[:NAMED])
    return named + (f" (and {len(chain) - NAMED} more)" if len(chain) > NAMED else "")


def _jumping(count: int) -> str:
    return (
        "1 chain jumps or turns back and was" if count == 1 else f"{count} chains jump or turn back and were"
    )
