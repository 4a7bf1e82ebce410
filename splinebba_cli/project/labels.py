"""Names by number: a column of ids that repeats few of them many times."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain
from typing import overload

import numpy as np

from splinebba_cli.core.network import IntArray


class Labels(Sequence[str]):
    """The texts ``names[number]`` without a copy of each.

    Parameters
    ----------
    names : sequence of str
    number : (n,) int, numbers of the names
    """

    def __init__(self, names: Sequence[str], number: IntArray) -> None:
        self.names = names
        self.number = number

    @classmethod
    def joined(cls, *parts: Labels) -> Labels:
        """Several columns under each other."""
        starts = np.cumsum([0, *(len(part.names) for part in parts)])
        names = tuple(chain.from_iterable(part.names for part in parts))
        numbers = [part.number + start for part, start in zip(parts, starts, strict=False)]
        return cls(names, np.concatenate(numbers))

    @overload
    def __getitem__(self, row: int) -> str: ...
    @overload
    def __getitem__(self, row: slice) -> Labels: ...
    def __getitem__(self, row: int | slice) -> str | Labels:
        if isinstance(row, slice):
            return Labels(self.names, self.number[row])
        return self.names[int(self.number[row])]

    def __len__(self) -> int:
        return len(self.number)

    def __iter__(self) -> Iterator[str]:
        return map(self.names.__getitem__, self.number.tolist())
