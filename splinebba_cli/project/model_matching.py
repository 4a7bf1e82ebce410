"""How unlabelled chains are matched."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from splinebba_cli.project.scalars import Model, PositiveNumber, Share


class Matching(Model):
    """How `match` finds the splines to which unlabelled chains belong; not used by the adjustment."""

    position_sigma_m: PositiveNumber | None = Field(
        default=None,
        description="How far given perspective centres may be off: σ of every coordinate, m. Images with a σ of their "
        "own keep that. Default: found from the measurements.",
    )
    angle_sigma_deg: PositiveNumber | None = Field(
        default=None,
        description="How far given angles may be off: σ of every angle, degrees. Default: as for positions.",
    )
    alpha: PositiveNumber = Field(
        default=0.001, lt=1, description="Share of right points that the gate may lose (innovation test)."
    )
    wrong_share: Share = Field(
        default=0.3, description="Largest share of points that belong to no spline of the project."
    )
    direction_tolerance_deg: PositiveNumber = Field(
        default=20.0,
        le=90,
        description="A point whose edge runs in another direction than the projected spline, by more than this, does "
        "not belong to it; degrees.",
    )
    new_curves: bool = Field(
        default=False,
        description="Whether tie splines are built from chains that no spline of the project explains.",
    )
    knot_tolerance_sigma: PositiveNumber = Field(
        default=3.0,
        description="A built spline gets another knot where it is farther from its points than this, in their σ.",
    )
    orient_freely: bool = Field(
        default=True,
        description="Whether an orientation is searched for images that have no approximate one.",
    )
    rounds: Annotated[int, Field(ge=1, le=1000)] = Field(
        default=30, description="Largest number of rounds of matching and adjustment."
    )
    seed: Annotated[int, Field(ge=0)] = Field(default=1, description="Seed of all random choices.")
    min_matched_share: Share | None = Field(
        default=None,
        description="Smallest share of the image points on splines and in chains that must have a label, of this "
        "matching or from before: below it `match` ends with exit code 1.",
    )
