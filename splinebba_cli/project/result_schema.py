"""The JSON Schema of result.json, format ``splinebba-result/1``: what other programs may rely on.

Keys that are not named here may be added without a new version of the format.
"""

from __future__ import annotations

from typing import Any

Schema = dict[str, Any]

NUMBER: Schema = {"type": "number"}
NUMBER_OR_NULL: Schema = {"type": ["number", "null"]}
COUNT: Schema = {"type": "integer", "minimum": 0}
TEXT: Schema = {"type": "string"}
FLAG: Schema = {"type": "boolean"}
EOP_KEYS = ("x", "y", "z", "omega", "phi", "kappa")


def array_of(items: Schema, length: int | None = None) -> Schema:
    """Schema of an array, of fixed length where it is given."""
    size = {} if length is None else {"minItems": length, "maxItems": length}
    return {"type": "array", "items": items, **size}


def object_of(
    required: dict[str, Schema], optional: dict[str, Schema] | None = None, about: str = ""
) -> Schema:
    """Schema of an object with needed and further properties."""
    described = {"description": about} if about else {}
    properties = {**required, **(optional or {})}
    return {"type": "object", **described, "properties": properties, "required": list(required)}


def _xyz(about: str = "") -> Schema:
    return object_of(dict.fromkeys("xyz", NUMBER_OR_NULL), about=about)


PROBLEM = object_of(
    {
        "code": {"type": "string", "pattern": "^SBB[0-9]{3}$"},
        "severity": {"enum": ["error", "warning", "info"]},
        "message": TEXT,
        "subject": TEXT,
    },
    {"help": TEXT},
)
GLOBAL_TEST = object_of(
    {"statistic": NUMBER, "lower": NUMBER, "upper": NUMBER, "alpha": NUMBER, "passed": FLAG},
    about="Two-sided χ² test of r σ̂₀²/σ₀².",
)
STATISTICS = object_of(
    {
        "observations": COUNT,
        "unknowns": COUNT,
        "conditions": {**COUNT, "description": "Gauge and datum conditions."},
        "rank_defect": {**COUNT, "description": "Defect of measurements and priors alone."},
        "redundancy": {"type": "integer", "description": "observations + conditions − unknowns."},
        "sigma0_prior": NUMBER,
        "sigma0": {
            **NUMBER_OR_NULL,
            "description": "A-posteriori σ of unit weight; null without redundancy.",
        },
        "global_test": {"anyOf": [GLOBAL_TEST, {"type": "null"}]},
    }
)
IMAGE = object_of(
    {
        "id": TEXT,
        "camera": TEXT,
        **dict.fromkeys(EOP_KEYS, NUMBER),
        "sigma": object_of(dict.fromkeys(EOP_KEYS, NUMBER_OR_NULL)),
        "correlations": {"type": "array"},
    },
    about="Adjusted exterior orientation: metres, degrees.",
)
SEGMENT = object_of(
    {
        "interval": array_of(NUMBER, 2),
        **{letter: array_of(NUMBER) for letter in "abc"},
        **{f"sigma_{letter}": array_of(NUMBER_OR_NULL) for letter in "abc"},
    },
    about="Coefficients of the powers of t in [0, 1] for X (a), Y (b), Z (c), metres.",
)
CONIC = object_of(
    {
        "centre": array_of(NUMBER, 3),
        "semi_axes": array_of(NUMBER, 2),
        "axes": array_of(array_of(NUMBER, 3), 2),
        "normal": array_of(NUMBER, 3),
        "eccentricity": NUMBER,
        "form": {"enum": ["circle", "ellipse", "parabola", "hyperbola"]},
        "sigma": object_of(
            {
                "centre": array_of(NUMBER_OR_NULL, 3),
                "semi_axes": array_of(NUMBER_OR_NULL, 2),
                "eccentricity": NUMBER_OR_NULL,
                "normal_deg": NUMBER_OR_NULL,
            }
        ),
    },
    about="Elements of a conic or circle: metres, unit directions. A bounded curve is always a circle or an ellipse.",
)
ELLIPSE = object_of(
    {
        "centre": array_of(NUMBER, 3),
        "semi_axes": array_of(NUMBER, 2),
        "normal": array_of(NUMBER, 3),
        "rms": NUMBER,
        "max": NUMBER,
    },
    about="The ellipse nearest to a closed spline of any family and the distance of the spline from it, metres.",
)
SPLINE = object_of(
    {
        "id": TEXT,
        "role": {"enum": ["control", "partial", "tie", "check"]},
        "family": TEXT,
        "closed": FLAG,
        "knots": array_of(array_of(NUMBER, 3)),
        "knot_sigma": array_of(array_of(NUMBER_OR_NULL, 3)),
        "sigma_across": object_of(
            {"max": NUMBER_OR_NULL, "mean": NUMBER_OR_NULL},
            about="Semi-axes of the lateral standard ellipse, m.",
        ),
        "segments": {**array_of(SEGMENT), "description": "None of trigonometric families."},
    },
    {
        "values": {
            **array_of(array_of(NUMBER, 3)),
            "description": "Rows of the family that are no points of the curve.",
        },
        "value_sigma": array_of(array_of(NUMBER_OR_NULL, 3)),
        "conic": CONIC,
        "ellipse": ELLIPSE,
    },
)
POINT = object_of(
    {
        "id": TEXT,
        "role": {"enum": ["control", "tie", "check"]},
        **dict.fromkeys("xyz", NUMBER),
        "sigma": _xyz("Metres."),
    }
)


REJECTION = object_of(
    {
        "kind": {"enum": ["point", "spline", "arc length", "tangent", "distance"]},
        "row": {**COUNT, "description": "Of the observations of its kind, from 1, as in residuals.csv."},
        "name": TEXT,
        "round": {**COUNT, "description": "0: high-breakdown start."},
        "reason": TEXT,
        "statistic": NUMBER_OR_NULL,
        "predicted_w": {**NUMBER_OR_NULL, "description": "Against the last solution; null: not predictable."},
        "predicted_residual": {**NUMBER_OR_NULL, "description": "mm, of tangents degrees."},
        "returned": {**FLAG, "description": "It takes part again."},
    }
)
REVISION = object_of(
    {
        "method": {"enum": ["none", "snooping", "huber", "cauchy", "tukey", "danish"]},
        "start": {"enum": ["least_squares", "high_breakdown"]},
        "rounds": COUNT,
        "used": COUNT,
        "reweighted": COUNT,
        "rejected": COUNT,
        "excluded_by_user": COUNT,
        "rejections": array_of(REJECTION),
    },
    about="What the search for outliers did, every decision in its order.",
)


def result_schema() -> Schema:
    """The JSON Schema of result.json."""
    content = object_of(
        {
            "format": {"const": "splinebba-result/1"},
            "provenance": {"type": "object"},
            "status": object_of({"converged": FLAG, "termination": TEXT, "iterations": COUNT}),
            "statistics": STATISTICS,
            "cameras": array_of(object_of({"id": TEXT, "principal_distance_mm": NUMBER})),
            "images": array_of(IMAGE),
            "splines": array_of(SPLINE),
            "points": array_of(POINT),
            "checks": object_of({"points": {"type": "array"}, "splines": {"type": "array"}}),
            "residuals": {"type": "object"},
            "problems": array_of(PROBLEM),
        },
        {"revision": REVISION},
        about="Results of an adjustment, but for the large tables beside it.",
    )
    head = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": "https://splinebba.org/schemas/result.schema.json",
    }
    return {**head, **content}
