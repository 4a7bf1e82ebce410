"""Ids of new curves: `new-1`, `new-2`, ..., never one that the project has."""

from __future__ import annotations

from collections.abc import Iterable


def new_ids(count: int, given: Iterable[str]) -> tuple[str, ...]:
    """Free ids in ascending order."""
    taken, number = set(given), 0
    found: list[str] = []
    while len(found) < count:
        number += 1
        if f"new-{number}" not in taken:
            found.append(f"new-{number}")
    return tuple(found)
