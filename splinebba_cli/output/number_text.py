"""The text of many numbers at once, as rows of four-byte words in which zero bytes are blanks.

    |x| 10^d rounded to the integer k,   k = i 10^d + f

The digits of i and f come from tables, four at a time; the blanks (leading zeros, unused bytes) are dropped when the
rows of a table are put together.  The digits are those of printf: a product near a tie is left to it.
"""

from __future__ import annotations

from functools import cache, lru_cache

import numpy as np
from numpy.typing import NDArray

from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

Words = NDArray[np.uint32]  # (n, w), four characters each

GROUP = 10_000  # numbers of four digits
_LARGEST = 2.0**50  # beyond which products with a power of ten are no safe integers
_TIE = 2.0**-51  # relative distance from a tie within which printf decides


def fixed_words(values: FloatArray, decimals: int) -> Words | None:
    """Numbers with a fixed number of decimals, as ``%.<decimals>f`` prints them.

    Parameters
    ----------
    values : (n,) float
        What is not finite becomes blank.
    decimals : int

    Returns
    -------
    Words or None
        None where a number is too large for this way.
    """
    finite = np.isfinite(values)
    given = np.where(finite, values, 0.0)
    scaled = scaled_integers(given, decimals)
    if scaled is None:
        return None
    power = 10**decimals
    whole = scaled // power
    parts = [signs(given < 0.0), *whole_words(whole)]
    if decimals:
        parts.append(np.full(len(given), word(b"."), dtype=np.uint32))
        parts += fraction_words(scaled - whole * power, decimals)
    words = np.stack(parts, axis=1)
    if not finite.all():
        words[~finite] = 0
    return words


def scaled_integers(values: FloatArray, decimals: int) -> IntArray | None:
    """|x| 10^decimals, rounded as printf does, (n,); None where a number is too large."""
    product = np.abs(values) * 10.0**decimals
    if product.max(initial=0.0) >= _LARGEST:
        return None
    nearest = np.rint(product)
    scaled = nearest.astype(np.int64)
    unsure = np.abs(np.abs(product - nearest) - 0.5) <= product * _TIE
    for row in np.flatnonzero(unsure):
        scaled[row] = int(f"{abs(values[row]):.{decimals}f}".replace(".", ""))
    return scaled


def rounded(values: FloatArray, decimals: int) -> FloatArray:
    """The numbers that are read back from ``%.<decimals>f``, (n,)."""
    finite = np.isfinite(values)
    scaled = scaled_integers(np.where(finite, values, 0.0), decimals)
    if scaled is None:
        return np.array([float(f"{x:.{decimals}f}") for x in values.tolist()])
    return np.where(finite, np.copysign(scaled / 10.0**decimals, values), np.nan)


def integer_words(values: IntArray) -> Words:
    """Whole numbers, (n,)."""
    return np.stack([signs(values < 0), *whole_words(np.abs(values))], axis=1)


def text_words(texts: list[str]) -> Words:
    """Texts in UTF-8, (n,)."""
    try:
        encoded = np.array(texts, dtype=np.bytes_)
    except UnicodeEncodeError:
        encoded = np.array([text.encode() for text in texts], dtype=np.bytes_)
    width = -(-max(1, encoded.dtype.itemsize) // 4)
    return encoded.astype(f"S{4 * width}").view(np.uint32).reshape(len(texts), width)


def lines(cells: list[Words], separator: bytes) -> bytearray:
    """Rows of cells as lines of text.

    Parameters
    ----------
    cells : list of (n, w) words
        The cells of every column.
    """
    count, width = len(cells[0]), sum(cell.shape[1] for cell in cells) + len(cells)
    buffer = bytearray(4 * count * width)
    words = np.frombuffer(buffer, dtype=np.uint32).reshape(count, width)
    place = 0
    for cell in cells:
        words[:, place : place + cell.shape[1]] = cell
        place += cell.shape[1] + 1
        words[:, place - 1] = word(separator)
    words[:, -1] = word(b"\n")
    return buffer.translate(None, b"\0")


def signs(negative: BoolArray) -> NDArray[np.uint32]:
    """A minus or nothing, (n,)."""
    return np.where(negative, np.uint32(word(b"-")), np.uint32(0))


def whole_words(whole: IntArray) -> list[NDArray[np.uint32]]:
    """Digits of whole numbers (n,) without leading zeros; words of (n,), most significant first."""
    first, further = _leading_tables()
    groups: list[NDArray[np.uint32]] = []
    rest = whole
    while True:
        above = rest // GROUP
        index = rest - above * GROUP + GROUP * (above > 0)
        groups.append((further if groups else first)[index])
        if not above.any():
            return groups[::-1]
        rest = above


def fraction_words(fraction: IntArray, decimals: int) -> list[NDArray[np.uint32]]:
    """All digits after the point; words of (n,), most significant first."""
    groups = -(-decimals // 4)
    rest = fraction * 10 ** (4 * groups - decimals)
    words = []
    for number in range(groups):
        above = rest // GROUP
        used = 4 if number else 4 - (4 * groups - decimals)
        words.append(digit_table(used)[rest - above * GROUP])
        rest = above
    return words[::-1]


def word(text: bytes) -> int:
    """Up to four characters as a number."""
    return int(np.frombuffer(text.ljust(4, b"\0"), dtype=np.uint32)[0])


@cache
def digit_table(used: int) -> NDArray[np.uint32]:
    """The first digits of "0000" to "9999", the others blank."""
    digits = np.arange(GROUP)[:, None] // np.array([1000, 100, 10, 1]) % 10 + ord("0")
    digits[:, used:] = 0
    return np.asarray(digits.astype(np.uint8).view(np.uint32).ravel())


@lru_cache(maxsize=1)
def _leading_tables() -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
    """Four digits without leading zeros, then with them: of the last group (0 is "0"), and of one before it."""
    full = digit_table(4)
    digits = full.view(np.uint8).reshape(GROUP, 4).copy()
    leading = np.arange(GROUP)[:, None] < np.array([1000, 100, 10, 1])
    digits[leading] = 0
    before = digits.view(np.uint32).ravel()
    last = before.copy()
    last[0] = np.frombuffer(b"\0\0\0" + b"0", dtype=np.uint32)[0]
    return np.concatenate([last, full]), np.concatenate([before, full])
