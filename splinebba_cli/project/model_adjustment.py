"""How to adjust, and what a result must satisfy."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from splinebba_cli.project.scalars import Model, Name, PositiveNumber


class Knots(Model):
    """What the program may do with the knots of tie splines."""

    spacing_m: PositiveNumber | None = Field(
        default=None, description="Space knots to about this distance, m; default: keep."
    )
    insert: bool = Field(
        default=False, description="Insert knots where residuals along a curve are systematic."
    )
    drop: bool = Field(default=False, description="Drop knots that no measurement supports.")


class DatumFeatures(Model):
    """Over which coordinates inner constraints run: the trace of their dispersion is the smallest of all datums."""

    points: Literal["all"] | list[Name] = Field(
        default_factory=list, description="Points whose free coordinates carry the datum, or all."
    )
    images: Literal["all"] | list[Name] = Field(
        default_factory=list, description="Images whose perspective centres carry the datum, or all."
    )
    splines: Literal["all"] | list[Name] = Field(
        default_factory=list, description="Splines whose knots carry the datum, or all."
    )


class LocalTests(Model):
    """Tests of single observations."""

    alpha: PositiveNumber = Field(
        default=0.001,
        lt=1,
        description="Significance of one test, or of all together where `multiplicity` is not none.",
    )
    multiplicity: Literal["none", "sidak", "bonferroni"] = Field(
        default="none",
        description="none: α belongs to every test; sidak, bonferroni: to all of them together.",
    )
    power: PositiveNumber = Field(
        default=0.8, lt=1, description="Power 1 − β with which a minimal detectable bias is found."
    )
    statistic: Literal["w", "tau"] = Field(
        default="w", description="w (Baarda): σ₀ is known; tau (Pope): σ₀ is estimated from the residuals."
    )


class Outliers(Model):
    """What is done with gross errors."""

    method: Literal["none", "snooping", "huber", "cauchy", "tukey", "danish"] = Field(
        default="none",
        description="none; snooping: the worst observation is rejected, one after another; or the weight function of "
        "a reweighted adjustment.",
    )
    start: Literal["least_squares", "high_breakdown"] = Field(
        default="least_squares",
        description="high_breakdown: begins with a start that up to 40 % gross errors on splines do not spoil.",
    )
    max_share: PositiveNumber = Field(
        default=0.1, le=0.5, description="Largest share of the observations that snooping may reject."
    )
    max_rounds: int = Field(default=200, ge=1, le=100_000, description="Largest number of rounds.")
    at_once: int = Field(
        default=1,
        ge=1,
        description="Rejections in one round; they belong to different images and different features.",
    )


class Adjustment(Model):
    """Settings of the adjustment."""

    datum: Literal["control", "minimal", "inner"] = Field(
        default="control",
        description="control: by control and priors; minimal: some orientation unknowns are held, as many as nothing "
        "determines; inner: a free network, its datum spread over `datum_features` as their approximate values are.",
    )
    datum_features: DatumFeatures | None = Field(
        default=None,
        description="Which features carry an inner datum; default: all points, or all images where there are fewer "
        "than three points.",
    )
    max_iterations: int = Field(default=50, ge=1, le=10_000, description="Largest number of iterations.")
    alpha: PositiveNumber = Field(default=0.05, lt=1, description="Level of significance of the tests.")
    sigma0_prior: PositiveNumber = Field(
        default=1.0, description="A-priori standard deviation of unit weight."
    )
    gauge_sigma_m: PositiveNumber | None = Field(
        default=None,
        description=(
            "σ of the gauge conditions along curves, m; default: a tenth of the mean knot distance for natural and "
            "cardinal splines and lines, a thousandth of it (conics, Fourier: of the radius) for other families."
        ),
    )
    gauge_conditions: Literal["needed", "all"] = Field(
        default="needed",
        description="needed: conditions are dropped where the measurements determine the place along the curve; "
        "all: every condition stays (knots that the program spaces itself always keep theirs).",
    )
    scale_dispersion: bool = Field(
        default=True, description="Whether standard deviations are multiplied by σ̂₀."
    )
    staged: bool = Field(
        default=True, description="Orientation from points first, then curves, then all together."
    )
    knots: Knots = Field(default_factory=Knots, description="Policy for the knots of tie splines.")
    local_tests: LocalTests = Field(
        default_factory=LocalTests, description="Significance and power of the tests of single observations."
    )
    outliers: Outliers = Field(
        default_factory=Outliers, description="How gross errors are found and treated."
    )
    variance_components: bool = Field(
        default=False,
        description="Whether the σ of every group of observations is estimated: groups by their `name`, else by kind.",
    )
    confidence: PositiveNumber = Field(
        default=0.95, lt=1, description="Confidence of ellipses and positional uncertainties."
    )
    correlation_threshold: PositiveNumber = Field(
        default=0.95, lt=1, description="Correlations beyond it are named."
    )
