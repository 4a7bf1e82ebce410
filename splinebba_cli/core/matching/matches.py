"""What matching gives back: plain data, one row an unlabelled point."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum

from splinebba_cli.core.network import BoolArray, FloatArray, IntArray, Network
from splinebba_cli.core.result import Problem


class Reason(IntEnum):
    """Why a point has no curve."""

    MATCHED = 0
    FAR = 1  # no curve inside the gate
    DIRECTION = 2  # only curves that run another way
    AMBIGUOUS = 3  # two curves fit equally well
    CHAIN = 4  # the rest of its chain follows no curve, or another one
    TAKEN = 5  # another chain fits better to this stretch of the curve
    GROSS = 6  # its residual after the adjustment is no chance
    EXCLUDED = 7  # taken out by the user
    NOT_ORIENTED = 8  # its image has no orientation
    ONE_IMAGE = 9  # its curve has no known shape, and no other image sees it


@dataclass(frozen=True)
class Matches:
    """The curve of every unlabelled point; all arrays (n,)."""

    curve: IntArray  # index into the curves of the result's network, -1: none
    location: FloatArray  # u, NaN where unmatched
    distance: (
        FloatArray  # across the curve over its predicted sigma; of the best candidate, inf where none is near
    )
    runner_up: FloatArray  # the same of the next curve, inf where none is near
    reason: IntArray  # a Reason


@dataclass(frozen=True)
class GateStep:
    """One round of matching and adjustment."""

    stage: str
    number: int
    gate_px: float  # median half width of the gate, pixels (mm of cameras without)
    matched: int
    changed: int  # points with another curve than in the round before
    sigma0: float  # of the adjustment of this round, NaN where none was made
    position_step_m: float  # largest change of a perspective centre
    angle_step_rad: float


@dataclass(frozen=True)
class WeakPart:
    """A stretch of a built curve that its images do not hold: along the epipolar direction, or bridged."""

    first: float  # location
    last: float
    kind: str  # "epipolar", "bridged", "two_images"
    sigma_m: float  # largest across


@dataclass(frozen=True)
class BuiltCurve:
    """A curve made from chains."""

    curve: int  # index into the curves of the result's network
    chains: IntArray  # linked chains
    images: IntArray  # that see it
    length_m: float
    length_in_three_images_m: float
    weak_parts: tuple[WeakPart, ...] = ()


@dataclass(frozen=True)
class MatchResult:
    """The labelled network and how it came about."""

    network: Network  # with matched points among the curve observations; `unlabelled` holds the rest
    given: Network  # as it was: rows of `matches` are its unlabelled points
    matches: Matches
    oriented: BoolArray  # (m,) images whose orientation was found or improved
    eop_dispersion: FloatArray  # (m, 6, 6) of omega, phi, kappa, X0, Y0, Z0 (rad, m); NaN where not estimated
    history: tuple[GateStep, ...] = ()
    built: tuple[BuiltCurve, ...] = ()
    problems: tuple[Problem, ...] = ()
    timings: dict[str, float] = field(default_factory=dict)
