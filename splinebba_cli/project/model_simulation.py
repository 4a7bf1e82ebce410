"""How a project is simulated: sizes of all errors, and where it is measured."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from splinebba_cli.project.scalars import Model, NonNegativeNumber, Note, Share


class Simulation(Model):
    """How `simulate` measures a project anew; not used by the adjustment."""

    block: Note | None = Field(default=None, description="Kind of the simulated block; a note.")
    seed: Annotated[int | None, Field(ge=0)] = Field(default=None, description="Seed of all errors.")
    image_sigma_um: NonNegativeNumber | None = Field(
        default=None,
        description="σ of the noise in the image, µm; default: the σ of the observations. Observations that "
        "`simulate` places itself have this σ.",
    )
    points_per_spline: int = Field(
        default=20,
        ge=1,
        le=100_000,
        description="Measured points for every spline and image that sees it, in a project without observations "
        "of splines.",
    )
    least_visible_share: Share = Field(
        default=0.02,
        description="An image that sees a smaller share of a spline does not measure it; without observations.",
    )
    given_errors: bool | None = Field(
        default=None,
        description="Whether control, priors and check features get errors of their σ; default: unless the "
        "noise is 0.",
    )
    blunder_share: Share = Field(
        default=0.0, description="Share of the measured image points with a blunder."
    )
    blunder_size_sigma: NonNegativeNumber = Field(
        default=20.0, description="Size of a blunder, in σ of the measurement; its direction is random."
    )
    missing_point_share: Share = Field(
        default=0.0, description="Share of the measured image points that are not measured."
    )
    missing_pair_share: Share = Field(
        default=0.0, description="Share of the pairs of image and feature that are not measured."
    )
    start_position_m: NonNegativeNumber | None = Field(
        default=None,
        description="Largest error of approximate coordinates of perspective centres, m; default: the project's "
        "own approximate values.",
    )
    start_angle_deg: NonNegativeNumber | None = Field(
        default=None, description="Largest error of approximate angles, degrees; default: as for positions."
    )
    start_knots_m: NonNegativeNumber | None = Field(
        default=None,
        description="Largest error of approximate coordinates of knots, m; default: as for positions.",
    )
    chains: bool = Field(
        default=False,
        description="Whether image points on splines are written as chains without the names of their splines, for "
        "`match`; truth.json has the names.",
    )
    chain_points: int = Field(
        default=25,
        ge=3,
        le=100_000,
        description="Largest number of points of a chain; longer ones are broken.",
    )
    wrong_chain_share: Share = Field(
        default=0.0, description="Share of the points of chains that belong to no spline."
    )
    hidden_ties: bool = Field(
        default=False, description="Whether tie splines are left out of the project; their chains stay in it."
    )
