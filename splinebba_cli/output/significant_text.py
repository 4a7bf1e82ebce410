"""The text of many numbers with so many significant digits, as ``%.<p>g`` prints them.

    |x| = m 10^(e - p + 1),   m an integer of p digits

Without exponent for -4 <= e < p; zeros at the end of the fraction are left out.  printf decides near ties.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.output.number_text import (
    GROUP,
    Words,
    digit_table,
    signs,
    whole_words,
    word,
)

_LARGEST = 120  # power of ten that is needed
_RANGE = (1e-98, 1e98)  # exponents of two digits
_TIE = 2.0**-48  # relative distance from a tie within which printf decides; powers of ten are rounded


def significant_words(values: FloatArray, digits: int) -> Words | None:
    """Numbers with `digits` (at most 12) significant digits, (n,); what is not finite is blank.

    None where a number is too large or too small for this way.
    """
    finite = np.isfinite(values)
    size = np.where(finite, np.abs(values), 0.0)
    if digits > 12 or ((size > 0.0) & ((size < _RANGE[0]) | (size > _RANGE[1]))).any():
        return None
    mantissa, exponent = _decimal(size, digits)
    shown = np.where((exponent >= -4) & (exponent < digits), digits - 1 - exponent, -1)
    words = np.zeros(
        (len(values), 9), dtype=np.uint32
    )  # sign, 3 of the whole, point, 4 of fraction and exponent
    words[:, 0] = signs(values < 0.0)
    for decimals in np.unique(shown):
        rows = np.flatnonzero(shown == decimals)
        scientific = decimals < 0
        parts = _trimmed(mantissa[rows], digits - 1 if scientific else int(decimals))
        if scientific:
            parts.append(_exponents()[exponent[rows] + 99])
        words[rows[:, None], np.arange(1, 1 + len(parts))] = np.stack(parts, axis=1)
    words[size == 0.0, 1:] = 0
    words[size == 0.0, 1] = word(b"0")
    words[~finite] = 0
    return words


def _decimal(size: FloatArray, digits: int) -> tuple[IntArray, IntArray]:
    """Mantissa of `digits` digits and exponent of positive numbers, (n,) each."""
    exponent = np.floor(np.log10(np.where(size > 0.0, size, 1.0))).astype(np.int64)
    product = size * _powers()[digits - 1 - exponent + _LARGEST]
    mantissa = np.rint(product)
    shift = (mantissa >= 10.0**digits).astype(np.int64) - ((mantissa < 10.0 ** (digits - 1)) & (size > 0.0))
    moved = np.flatnonzero(shift)
    exponent[moved] += shift[moved]
    product[moved] = size[moved] * _powers()[digits - 1 - exponent[moved] + _LARGEST]
    mantissa[moved] = np.rint(product[moved])
    found = mantissa.astype(np.int64)
    unsure = np.abs(np.abs(product - mantissa) - 0.5) <= product * _TIE
    out_of_step = (size > 0.0) & ((found >= 10**digits) | (found < 10 ** (digits - 1)))
    for row in np.flatnonzero(unsure | out_of_step):
        text, _, power = f"{size[row]:.{digits - 1}e}".partition("e")
        found[row], exponent[row] = int(text.replace(".", "")), int(power)
    return found, exponent


def _trimmed(mantissa: IntArray, decimals: int) -> list[NDArray[np.uint32]]:
    """Digits with a point before the last `decimals`, without zeros at the end of the fraction."""
    whole = mantissa // 10**decimals
    fraction = mantissa - whole * 10**decimals
    point = np.where(fraction > 0, np.uint32(word(b".")), np.uint32(0))
    padded = -decimals % 4
    rest = fraction * 10**padded
    groups: list[NDArray[np.uint32]] = []
    ended = np.ones(len(mantissa), dtype=bool)  # nothing but zeros from here on
    for _ in range(-(-decimals // 4)):
        above = rest // GROUP
        group = rest - above * GROUP
        groups.append(_ending_table()[group + np.where(ended, 0, GROUP)])
        ended &= group == 0
        rest = above
    return [*whole_words(whole), point, *groups[::-1]]


@lru_cache(maxsize=1)
def _ending_table() -> NDArray[np.uint32]:
    """Four digits without zeros at their end, then with them."""
    full = digit_table(4)
    digits = full.view(np.uint8).reshape(GROUP, 4).copy()
    digits[np.arange(GROUP)[:, None] % np.array([10_000, 1000, 100, 10]) == 0] = 0
    return np.concatenate([digits.view(np.uint32).ravel(), full])


@lru_cache(maxsize=1)
def _powers() -> FloatArray:
    """Powers of ten from -LARGEST to LARGEST."""
    return np.array([float(f"1e{power}") for power in range(-_LARGEST, _LARGEST + 1)])


@lru_cache(maxsize=1)
def _exponents() -> NDArray[np.uint32]:
    """The texts e-99 to e+99."""
    return np.array([word(f"e{power:+03d}".encode()) for power in range(-99, 100)], dtype=np.uint32)
