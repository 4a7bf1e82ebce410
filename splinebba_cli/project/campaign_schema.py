"""The JSON Schema of campaign.json, format ``splinebba-campaign/1``: what other programs may rely on.

Keys that are not named here may be added without a new version of the format.
"""

from __future__ import annotations

from splinebba_cli.project.schema_parts import (
    COUNT,
    EOP_KEYS,
    FLAG,
    NUMBER,
    NUMBER_OR_NULL,
    TEXT,
    Schema,
    array_of,
    object_of,
)

FIGURE = object_of(
    {"value": NUMBER_OR_NULL, "lower": NUMBER, "upper": NUMBER_OR_NULL, "inside": FLAG},
    about="A figure and the interval in which a correct program finds it with the probability `interval`.",
)
REASONS = array_of(
    object_of(
        {"code": TEXT, "title": TEXT, "count": COUNT, "example": TEXT}, about="Why runs have no solution."
    )
)


def _or_null(schema: Schema) -> Schema:
    return {"anyOf": [schema, {"type": "null"}]}


ELEMENT = _or_null(
    object_of(
        {
            "runs": COUNT,
            "bias": {**NUMBER, "description": "Mean error, estimated − true."},
            "bias_sigma": {**NUMBER, "description": "σ of the bias, from the scatter of the runs."},
            "empirical": {**NUMBER, "description": "Root mean square error."},
            "predicted": {**NUMBER, "description": "Root mean square of the a-priori σ."},
            "ratio": {**FIGURE, "description": "Root mean square of error over a-priori σ."},
            "coverage": {**FIGURE, "description": "Share of confidence intervals that hold the truth."},
        },
        about="An estimated number; metres, degrees.",
    )
)
SPLINE = _or_null(
    object_of(
        {
            "runs": COUNT,
            **dict.fromkeys(("bias_left", "bias_up"), NUMBER_OR_NULL),
            **dict.fromkeys(("bias_left_sigma", "bias_up_sigma"), NUMBER_OR_NULL),
            "largest_bias_in_sigma": {**NUMBER, "description": "Of a single place, in σ of its bias."},
            "largest_bias_place": {**NUMBER, "description": "Where that is: 0 the beginning, 1 the end."},
            "largest_bias_limit": {
                **NUMBER,
                "description": "Exceeded by chance in one campaign of a hundred.",
            },
            "empirical": NUMBER_OR_NULL,
            "ratio": FIGURE,
            "coverage": {
                **FIGURE,
                "description": "Of lateral confidence ellipses at places along the spline.",
            },
        },
        about="Errors across a spline, metres.",
    )
)
KIND = _or_null(
    object_of(
        {"elements": COUNT, "coverage": FIGURE, "smallest_ratio": FIGURE, "largest_ratio": FIGURE},
        about="All numbers of a kind; the limits of the ratios hold for all of them together.",
    )
)
LOCATIONS = _or_null(
    object_of(
        {
            "elements": {**COUNT, "description": "Points that are measured on the spline."},
            "coverage": FIGURE,
            "smallest_ratio": FIGURE,
            "largest_ratio": FIGURE,
            "largest_bias_in_sigma": {**NUMBER, "description": "Of a single location, in σ of its bias."},
            "largest_bias_limit": {
                **NUMBER,
                "description": "Exceeded by chance in one campaign of a hundred.",
            },
        },
        about="Locations along a spline whose every value is given; null: they depend on the datum.",
    )
)
KINDS = ("eop", "points", "splines", "locations")
HISTOGRAM = object_of(
    {"edges": array_of(NUMBER), **dict.fromkeys(KINDS, array_of(COUNT))},
    about="Errors over their a-priori σ; values beyond the edges are in the last bins.",
)
STATISTICS = object_of(
    {
        "alpha": NUMBER,
        "sigmas_scaled_by_sigma0": FLAG,
        "acceptance": {
            **_or_null(FIGURE),
            "description": "Share of accepted global tests; 1 − alpha is right.",
        },
        "mean_square": {
            **FIGURE,
            "description": "Mean of eᵀ D⁻¹ e over the elements of all images; 1 is right.",
        },
        "sigma0_rms": {**NUMBER_OR_NULL, "description": "Root mean square of σ̂₀/σ₀."},
        "kinds": object_of(dict.fromkeys(KINDS, KIND)),
        "images": array_of(object_of({"id": TEXT, **dict.fromkeys(EOP_KEYS, ELEMENT)})),
        "points": array_of(object_of({"id": TEXT, **dict.fromkeys("xyz", ELEMENT)})),
        "splines": array_of(object_of({"id": TEXT, "role": TEXT, "across": SPLINE, "locations": LOCATIONS})),
        "histogram": HISTOGRAM,
    }
)
STUDY = object_of(
    {
        "factor": NUMBER,
        **dict.fromkeys(("position_m", "angle_deg", "knots_m"), NUMBER_OR_NULL),
        "runs": COUNT,
        "same": object_of(
            {"value": NUMBER, "lower": NUMBER, "upper": NUMBER},
            about="Share that came back to the solution that starts at the truth; interval of the true share.",
        ),
        "other_minimum": COUNT,
        "failed": COUNT,
        "iterations_median": NUMBER_OR_NULL,
        "reasons": REASONS,
    },
    about="Where starts led whose errors are at most position_m, angle_deg and knots_m.",
)


def campaign_schema() -> Schema:
    """The JSON Schema of campaign.json."""
    content = object_of(
        {
            "format": {"const": "splinebba-campaign/1"},
            "target": {**TEXT, "description": "Name of the project or kind of the block."},
            "inputs": {
                "type": "object",
                "description": "File → sha256 of the project, its tables and its truth.",
            },
            "options": {"type": "object", "description": "Seed, sizes of all errors, factors of the study."},
            "program": {**TEXT, "description": "Version of the program."},
            "confidence": {**NUMBER, "description": "Of the intervals whose coverage is counted."},
            "interval": {**NUMBER, "description": "Probability of the intervals of all figures."},
            "runs": object_of(
                {**dict.fromkeys(("asked", "finished", "solved", "failed"), COUNT), "reasons": REASONS}
            ),
            "statistics": _or_null(STATISTICS),
            "study": array_of(STUDY),
        },
        about="What a Monte Carlo campaign of simulated adjustments found.",
    )
    head = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": "https://splinebba.org/schemas/campaign.schema.json",
    }
    return {**head, **content}
