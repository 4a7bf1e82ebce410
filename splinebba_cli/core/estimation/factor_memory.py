"""Memory of the normal equations, predicted from their pattern before any of it is taken.

    index       places of the values and of the rows of all fronts
    assembly    three arrays of values: as assembled, with damping, and what a step adds
    factor      panels of all fronts
    update      updates that wait for their parents while the matrix is factored
    inverse     panels once more, Z₂₂ on the way down, inverses of the factors of the leaves

    peak = index + assembly + factor + max(update, inverse)

The equations themselves (measurements, their derivatives) are not among it.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass
from typing import TYPE_CHECKING

from splinebba_cli.core.estimation.compiled_fronts import factor_kernels
from splinebba_cli.core.memory import available_memory
from splinebba_cli.core.result import Problem
from splinebba_cli.errors import NotEnoughMemoryError

if TYPE_CHECKING:
    from splinebba_cli.core.estimation.block_cholesky import SymbolicFactor

_log = logging.getLogger(__name__)

NUMBER = 8
"""Bytes of a floating-point number and of an index."""
VALUE_ARRAYS = 3


@dataclass(frozen=True)
class FactorMemory:
    """Bytes by their use."""

    index: int
    assembly: int
    factor: int
    update: int
    inverse: int

    @property
    def peak(self) -> int:
        """The most at a time."""
        return self.index + self.assembly + self.factor + max(self.update, self.inverse)


def factor_memory(symbolic: SymbolicFactor) -> FactorMemory:
    """Memory that assembling, factoring and inverting a matrix of an analysed pattern takes."""
    layout, structure = symbolic.layout, symbolic.structure
    leaves, leaf_pairs = layout.tree.n_leaves, 0
    index = 5 * len(structure.rows) + 2 * len(symbolic.places.unknown) + 4 * structure.n_unknowns
    if factor_kernels(structure.n_unknowns) is None:
        index += structure.n_entries
        squares = layout.rows[:leaves] ** 2
        leaf_pairs = int(squares.sum())
        update = symbolic.order.update_size
        inverse = symbolic.order.outer_size + int((layout.pivots[:leaves] ** 2).sum())
    else:
        index += 5 * len(structure.rows)
        update, inverse = symbolic.compiled.schedule.update_size, symbolic.compiled.schedule.outer_size
    numbers = (
        index + leaf_pairs, VALUE_ARRAYS * structure.n_entries, symbolic.factor_entries,
        update + leaf_pairs, symbolic.factor_entries + inverse,
    )  # fmt: skip
    return FactorMemory(*(NUMBER * int(n) for n in numbers))


def require_memory(symbolic: SymbolicFactor, available: float | None = None) -> FactorMemory:
    """Make sure that the memory for a factor and its selected inverse is there.

    Parameters
    ----------
    available : float, optional
        Bytes; by default what this process may still take.

    Returns
    -------
    FactorMemory

    Raises
    ------
    NotEnoughMemoryError
        SBB570: how much is needed, how much is there, and what would help.
    """
    needed = factor_memory(symbolic)
    there = available_memory() if available is None else available
    _log.debug(
        "%d unknowns in %d fronts, factor %s (%.2f %% of full), %.3g operations, %s at the peak",
        symbolic.structure.n_unknowns, symbolic.n_fronts, _amount(needed.factor),
        100.0 * symbolic.factor_entries / max(1.0, 0.5 * symbolic.structure.n_unknowns**2), symbolic.flops,
        _amount(needed.peak),
    )  # fmt: skip
    if needed.peak <= there:
        return needed
    message = (
        f"the normal equations of {symbolic.structure.n_unknowns} unknowns need {_amount(needed.peak)} of memory, "
        f"{_amount(there)} are available (factor {_amount(needed.factor)}, its selected inverse "
        f"{_amount(needed.inverse)}, assembly {_amount(needed.index + needed.assembly)})"
    )
    raise NotEnoughMemoryError([Problem("SBB570", "error", message, "adjustment", _help(symbolic))])


def _help(symbolic: SymbolicFactor) -> str:
    """What would help, by what makes the factor large."""
    largest = int(symbolic.layout.pivots.max(initial=0))
    share = symbolic.layout.offsets[-1] - symbolic.layout.offsets[-2]
    ways = (
        "close other programs, raise the limit of the container or of `ulimit -v`, or take a larger machine"
    )
    if share > 0.5 * symbolic.factor_entries:
        return (
            f"{ways}; {largest} unknowns are eliminated together because most of the block is coupled by features that "
            "very many images see: divide such splines into shorter ones"
        )
    return f"{ways}; or adjust the block in parts that overlap"


def _amount(count: float) -> str:
    """Bytes for people."""
    return f"{count / 2**30:.1f} GiB" if count >= 0.1 * 2**30 else f"{count / 2**20:.1f} MiB"
