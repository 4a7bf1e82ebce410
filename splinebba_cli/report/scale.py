"""Units and decimals for people: a standard deviation of 0.0123 m is shown as 12.3 mm."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

_LENGTHS = (("km", 1e-3), ("m", 1.0), ("mm", 1e3), ("µm", 1e6), ("nm", 1e9))
_ANGLES = (("°", 1.0), ("′", 60.0), ("″", 3600.0), ("m″", 3.6e6))


@dataclass(frozen=True)
class Scale:
    """Factor from metres (or degrees) to `unit`, and decimals for three digits of the typical value."""

    unit: str
    factor: float
    decimals: int

    def of(self, value: float | None) -> float | None:
        """The value in `unit`; None stays None."""
        return None if value is None else value * self.factor

    def text(self, value: float | None) -> str:
        """Value and unit as text."""
        return "–" if value is None else f"{value * self.factor:.{self.decimals}f} {self.unit}"


def length_scale(metres: Iterable[float | None]) -> Scale:
    """Unit and decimals for lengths of the size of `metres`: mm for most work, m or µm where far off."""
    typical = _typical(metres)
    if typical is None:
        return Scale("mm", 1e3, 1)
    unit, factor = _LENGTHS[1]
    if typical < 0.5:
        unit, factor = next((u, f) for u, f in _LENGTHS[2:] if typical * f >= 0.05 or u == "nm")
    elif typical >= 5e4:
        unit, factor = _LENGTHS[0]
    return Scale(unit, factor, _decimals(typical * factor))


def angle_scale(degrees: Iterable[float | None]) -> Scale:
    """Unit and decimals for small angles: seconds of arc as a rule."""
    typical = _typical(degrees)
    if typical is None:
        return Scale("″", 3600.0, 1)
    unit, factor = _ANGLES[2]
    if typical >= 1.0:
        unit, factor = _ANGLES[0]
    elif typical * 3600.0 < 0.01:
        unit, factor = _ANGLES[3]
    return Scale(unit, factor, _decimals(typical * factor))


def position_decimals(sigma_metres: Iterable[float | None]) -> int:
    """Decimals of coordinates in metres: two digits of the typical standard deviation, 3 at least."""
    typical = _typical(sigma_metres)
    return 3 if typical is None else min(max(3, 1 - math.floor(math.log10(typical))), 9)


def _typical(values: Iterable[float | None]) -> float | None:
    """Median of the values that are neither missing nor zero."""
    sizes = np.abs(np.array(list(values), dtype=np.float64))  # None becomes NaN
    found = sizes[np.isfinite(sizes) & (sizes > 0.0)]
    return float(np.partition(found, len(found) // 2)[len(found) // 2]) if len(found) else None


def _decimals(value: float) -> int:
    """Decimals that show three digits."""
    return min(max(0, 2 - math.floor(math.log10(value))), 4)


def round_length(value: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is not larger than `value`."""
    power = 10.0 ** math.floor(math.log10(max(value, 1e-12)))
    return power * max(digit for digit in (1.0, 2.0, 5.0) if digit * power <= value * (1 + 1e-9))


def grouped(factor: float) -> str:
    """A factor with groups of three digits: ``20 000``; small ones as they are."""
    return f"{factor:,.0f}".replace(",", "\u202f") if factor >= 1.0 else f"{factor:g}"


def plural(count: int, noun: str) -> str:
    """``1 image``, ``2 images``."""
    return f"{count} {noun}{'' if count == 1 else 's'}"
