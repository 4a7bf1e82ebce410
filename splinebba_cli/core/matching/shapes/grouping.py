"""Strands that show the same edge brought together, those of different edges kept apart.

The strongest evidence comes first: pairs with most image points in common, then those that lie closest.  Two groups are
not joined where an image proves that a strand of the one and a strand of the other are two edges, unless most
pairs between them say otherwise.
"""

from __future__ import annotations

from splinebba_cli.core.matching.shapes.overlaps import Overlap


def groups_of(count: int, overlaps: list[Overlap]) -> list[list[int]]:
    """Groups of strands of one edge, each ascending, in the order of their first members.

    Parameters
    ----------
    count : number of strands
    """
    groups = {k: [k] for k in range(count)}
    owner = list(range(count))
    known = {(o.first, o.second): o for o in overlaps}
    same = sorted(
        (o for o in overlaps if o.one_edge), key=lambda o: (-o.shared, o.statistic, o.first, o.second)
    )
    for overlap in same:
        a, b = owner[overlap.first], owner[overlap.second]
        if a == b or _contradicted(groups[a], groups[b], known):
            continue
        groups[a] = sorted(groups[a] + groups[b])
        for k in groups.pop(b):
            owner[k] = a
    return sorted(groups.values())


def _contradicted(a: list[int], b: list[int], known: dict[tuple[int, int], Overlap]) -> bool:
    """Whether more pairs between two groups are two edges than one."""
    between = [known[key] for i in a for j in b if (key := (min(i, j), max(i, j))) in known]
    against = sum(o.two_edges for o in between)
    return against > sum(o.one_edge for o in between)
