"""Names of chains: those of the files where they have some, else numbers; no two of an image are the same."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import count

from splinebba_cli.exchange.traced_chains import TracedChain
from splinebba_cli.project.diagnostics import Collector
from splinebba_cli.project.plain_text import id_problem

NUMBERS_HELP = "`--renumber` gives all chains numbers instead of names"
SINGLE = "-"  # for the project: a point that is in no chain


def named_chains(chains: Sequence[TracedChain], collector: Collector) -> list[TracedChain]:
    """Chains of which each has a name of its own in its image; errors go to the collector.

    SBB210 says which names cannot be ids, SBB334 which stand twice.
    """
    taken: dict[str, dict[str, TracedChain]] = {}
    for chain in chains:
        _check_image(chain, collector)
        if not chain.id:
            continue
        _check_id(chain, collector)
        first = taken.setdefault(chain.image, {}).setdefault(chain.id, chain)
        if first is not chain:
            where = first.place.file + ("" if first.place.line is None else f":{first.place.line}")
            message = (
                f"two chains of image `{chain.image}` have the name `{chain.id}`; the first one is in {where}"
            )
            collector.error("SBB334", message, chain.place, NUMBERS_HELP, kind="chains of one name")
    numbers = {image: _free_numbers(taken.get(image, {})) for image in {chain.image for chain in chains}}
    return [chain if chain.id else replace(chain, id=next(numbers[chain.image])) for chain in chains]


def renumbered(chains: Sequence[TracedChain]) -> list[TracedChain]:
    """Chains without their names."""
    return [replace(chain, id="") for chain in chains]


def _free_numbers(taken: Mapping[str, TracedChain]) -> Iterator[str]:
    return (str(number) for number in count(1) if str(number) not in taken)


def _check_image(chain: TracedChain, collector: Collector) -> None:
    if problem := id_problem(chain.image):
        message = f"the name of image `{chain.image}` {problem}"
        help = "give the file, or its property, column or `imagePath`, the name of the image in the project"
        collector.error("SBB210", message, chain.place, help, kind="names of images")


def _check_id(chain: TracedChain, collector: Collector) -> None:
    if chain.id == SINGLE:
        message = f"a chain cannot have the name `{SINGLE}`: it is for points that are in no chain"
        collector.error("SBB210", message, chain.place, NUMBERS_HELP, kind="names of chains")
    elif problem := id_problem(chain.id):
        message = f"the name of chain `{chain.id}` {problem}"
        collector.error("SBB210", message, chain.place, NUMBERS_HELP, kind="names of chains")
