"""Lengths in messages: millimetres where metres would begin with zeros."""

from __future__ import annotations


def length_text(metres: float) -> str:
    """Three digits: ``0.804 mm``, ``67.5 mm``, ``1.86 m``."""
    return f"{1e3 * metres:.3g} mm" if abs(metres) < 0.5 else f"{metres:.3g} m"
