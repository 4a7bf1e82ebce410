"""Strands one after another as one strand."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from splinebba_cli.core.matching.shapes.merging import refitted
from splinebba_cli.core.matching.shapes.strand import Strand


def end_to_end(strands: list[Strand], ring: bool) -> Strand:
    """Strands one after another as one."""
    if len(strands) == 1 and not ring:
        return strands[0]
    shifted, at = [], 0.0
    for number, strand in enumerate(strands):
        if number:
            at += float(np.linalg.norm(strand.line[0] - strands[number - 1].line[-1]))
        shift = at - float(strand.location[0])
        shifted.append(
            replace(strand, location=strand.location + shift, link_location=strand.link_location + shift)
        )
        at += strand.length
    joined: dict[str, Any] = {name: np.concatenate([getattr(s, name) for s in shifted]) for name in _ARRAYS}
    whole = replace(
        shifted[0],
        **joined,
        period=at + float(np.linalg.norm(strands[0].line[0] - strands[-1].line[-1])) if ring else 0.0,
    )
    kept = np.unique(whole.link_row, return_index=True)[1]
    whole = replace(whole, link_row=whole.link_row[kept], link_location=whole.link_location[kept])
    return refitted(whole, 1)


_ARRAYS = (
    "xyz", "line", "dispersion", "image_count", "weak", "location", "link_row", "link_location",
)  # fmt: skip
