"""Ends of strands, and whether two of them meet when they are carried on straight."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.matching.shapes.place_fit import normal_frames
from splinebba_cli.core.matching.shapes.strand import Strand
from splinebba_cli.core.network import FloatArray

SAG = 0.1  # sigma of the bend in a gap, of its length
STRAIGHT_ON = float(np.cos(np.radians(35.0)))
LEVER = 5  # places that give the direction of an end


@dataclass(frozen=True)
class StrandEnds:
    """Ends of all strands, two each, (2 n, ...)."""

    xyz: FloatArray
    outward: FloatArray  # (2 n, 3) unit
    dispersion: FloatArray
    spacing: FloatArray
    length: FloatArray  # of the strand

    @classmethod
    def of(cls, strands: list[Strand]) -> StrandEnds:
        """Those of some strands."""
        xyz, outward, dispersion, spacing, length = [], [], [], [], []
        for strand in strands:
            for end, sign in ((0, 1.0), (-1, -1.0)):
                back = strand.location[end] + sign * LEVER * strand.spacing
                inner = int(np.argmin(np.abs(strand.location - back)))
                step = strand.line[end] - strand.line[inner]
                xyz.append(strand.line[end])
                outward.append(step / max(float(np.linalg.norm(step)), 1e-300))
                dispersion.append(strand.dispersion[end])
                spacing.append(strand.spacing)
                length.append(strand.length)
        return cls(
            np.array(xyz), np.array(outward), np.array(dispersion), np.array(spacing), np.array(length)
        )


def runs_on(ends: StrandEnds, a: int, b: int, gap: float) -> bool:
    """Whether both ends point at each other and along the gap."""
    if ends.outward[a] @ ends.outward[b] > -STRAIGHT_ON:
        return False
    if gap < 2.0 * max(ends.spacing[a], ends.spacing[b]):
        return True
    across = (ends.xyz[b] - ends.xyz[a]) / gap
    return bool(ends.outward[a] @ across > STRAIGHT_ON and -(ends.outward[b] @ across) > STRAIGHT_ON)


def meeting(ends: StrandEnds, a: int, b: int) -> float:
    """Squared distance of both ends carried on to the middle of the gap, over its dispersion."""
    step = ends.xyz[b] - ends.xyz[a]
    direction = ends.outward[a] - ends.outward[b]
    direction = direction / max(float(np.linalg.norm(direction)), 1e-300)
    half = 0.5 * float(step @ direction)
    apart = (ends.xyz[a] + half * ends.outward[a]) - (ends.xyz[b] + half * ends.outward[b])
    frame = normal_frames(direction[None])[0]
    lever = LEVER * 0.5 * (ends.spacing[a] + ends.spacing[b])
    growth = 1.0 + 2.0 * (half / lever) ** 2
    inner = growth * frame.T @ (ends.dispersion[a] + ends.dispersion[b]) @ frame
    inner += (SAG * half) ** 2 * np.eye(2)
    d = frame.T @ apart
    return float(d @ np.linalg.solve(inner, d))
