"""The JSON Schema of result.json, format ``splinebba-result/1``: what other programs may rely on.

Keys that are not named here may be added without a new version of the format.
"""

from __future__ import annotations

from splinebba_cli.project.result_schema_quality import (
    CHECKS,
    CRITERION,
    GROUP_TEST,
    PRECISION,
    RESIDUAL_GRID,
    REVISION,
    SYSTEMATIC_EFFECT,
    TESTS,
    VARIANCE_COMPONENT,
)
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
    xyz_of,
)

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
        "segments": {
            **array_of(SEGMENT),
            "description": "None of trigonometric families; none where they stand in `segments_table`.",
        },
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
        "sigma": xyz_of("Metres."),
    }
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
            "checks": CHECKS,
            "residuals": {"type": "object"},
            "tests": {"anyOf": [TESTS, {"type": "null"}]},
            "problems": array_of(PROBLEM),
            "variance_components": array_of(VARIANCE_COMPONENT),
            "group_tests": object_of({"possible": COUNT, "tested": COUNT, "tests": array_of(GROUP_TEST)}),
            "systematic": object_of(
                {"effects": array_of(SYSTEMATIC_EFFECT), "grids": array_of(RESIDUAL_GRID)}
            ),
        },
        {
            "acceptance": array_of(CRITERION),
            "segments_table": {
                **TEXT,
                "description": "Table of the segments of all splines, where they are too many to stand here.",
            },
            "precision": {"anyOf": [PRECISION, {"type": "null"}]},
            "revision": REVISION,
        },
        about="Results of an adjustment, but for the large tables beside it.",
    )
    head = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": "https://splinebba.org/schemas/result.schema.json",
    }
    return {**head, **content}
