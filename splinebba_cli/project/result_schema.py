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
CHECK_TEST = object_of(
    {"statistic": NUMBER, "degrees": NUMBER, "critical": NUMBER, "passed": FLAG},
    about="d′C⁻¹d of differences with their predicted dispersion, and the largest accepted value.",
)
TEST_OR_NULL: Schema = {"anyOf": [CHECK_TEST, {"type": "null"}]}
_LEVELS = object_of(dict.fromkeys(("horizontal", "vertical"), NUMBER))
CHECKS = object_of(
    {"points": {"type": "array"}, "splines": {"type": "array"}},
    {
        "points_summary": object_of(
            {
                "count": COUNT,
                "rmse": object_of(dict.fromkeys(("x", "y", "z", "horizontal", "vertical"), NUMBER)),
                "mean": _xyz(),
                "largest": _xyz(),
                "given": _LEVELS,
                "accuracy": object_of(dict.fromkeys(("horizontal", "vertical", "3d"), NUMBER)),
                "alpha": NUMBER,
                "critical": NUMBER,
                "beyond": COUNT,
                "together": TEST_OR_NULL,
                "shift": TEST_OR_NULL,
            },
            about="All check points, metres; accuracies include that of the given coordinates.",
        )
    },
)
CRITERION = object_of(
    {
        "criterion": TEXT,
        "title": TEXT,
        "value": NUMBER_OR_NULL,
        "limit": NUMBER_OR_NULL,
        "unit": TEXT,
        "status": {"enum": ["passed", "failed", "untested"]},
        "message": TEXT,
        "subject": TEXT,
    },
    about="A key of `acceptance` in the project with what was found; limit null: a test.",
)
_POSITIONS = object_of(
    {
        "count": COUNT,
        "horizontal_rms_m": NUMBER_OR_NULL,
        "vertical_rms_m": NUMBER_OR_NULL,
        "worst": array_of(
            object_of(
                {
                    "id": TEXT,
                    "semi_axes_m": array_of(NUMBER, 2),
                    "azimuth_deg": NUMBER,
                    "ellipsoid_m": array_of(NUMBER, 3),
                    "horizontal_m": NUMBER,
                    "vertical_m": NUMBER,
                }
            )
        ),
    }
)
PRECISION = object_of(
    {
        "confidence": NUMBER,
        "degrees": {**NUMBER_OR_NULL, "description": "Redundancy behind σ̂₀; null: σ₀ is known."},
        "interval_factor": NUMBER,
        "ellipse_factor": NUMBER,
        "ellipsoid_factor": NUMBER,
        "images": _POSITIONS,
        "points": _POSITIONS,
        "correlation_threshold": NUMBER,
        "correlations_found": COUNT,
        "correlations": array_of(object_of({"first": TEXT, "second": TEXT, "r": NUMBER})),
    },
    about="Standard ellipses, uncertainties with the confidence, correlations beyond the threshold.",
)

INFLUENCE = object_of(
    {
        "kind": TEXT,
        "observation": TEXT,
        "redundancy": NUMBER,
        "unit": {"enum": ["mm", "deg", "m"]},
        "minimal_detectable_bias": NUMBER_OR_NULL,
        "bias_to_noise": NUMBER_OR_NULL,
        "orientation": object_of({"sigmas": NUMBER, "image": TEXT}),
        "position": object_of({"m": NUMBER, "image": TEXT}),
        "angle": object_of({"deg": NUMBER, "image": TEXT}),
        "object": object_of({"m": NUMBER, "feature": TEXT}),
    },
    about="An observation and the largest effects of an error of one minimal detectable bias.",
)
TESTS = object_of(
    {
        "statistic": {"enum": ["w", "tau"]},
        "alpha": NUMBER,
        "multiplicity": {"enum": ["none", "sidak", "bonferroni"]},
        "alpha_single": {**NUMBER, "description": "Significance of one test."},
        "power": NUMBER,
        "tests": {**COUNT, "description": "Number of tested observations."},
        "critical": {**NUMBER, "description": "Critical value of |w| or |τ|."},
        "noncentrality": NUMBER,
        "beyond": {**COUNT, "description": "Number of observations beyond the critical value."},
        "kinds": array_of(
            object_of(
                {
                    "kind": TEXT,
                    "n": COUNT,
                    "redundancy": object_of({"min": NUMBER, "mean": NUMBER, "max": NUMBER}),
                    "weak": {**COUNT, "description": "Redundancy number below 0.1."},
                    "uncontrolled": {**COUNT, "description": "Redundancy number below 0.001."},
                    "unit": {"enum": ["mm", "deg", "m"]},
                    "minimal_detectable_bias": object_of({"median": NUMBER_OR_NULL, "max": NUMBER_OR_NULL}),
                    "largest": {**NUMBER_OR_NULL, "description": "Largest |w| or |τ|."},
                }
            )
        ),
        "influences": array_of(INFLUENCE),
    },
    about="Tests of single observations and their reliability.",
)
VARIANCE_COMPONENT = object_of(
    {
        "group": TEXT,
        "kind": TEXT,
        "observations": {**COUNT, "description": "Scalar equations."},
        "redundancy": NUMBER,
        "sigma0": {**NUMBER_OR_NULL, "description": "σ̂ over the σ used."},
        "sigma0_sigma": NUMBER_OR_NULL,
        "factor": {**NUMBER, "description": "σ used over the σ given."},
        "estimated": {**FLAG, "description": "Whether the factor was estimated."},
        "freedom": {**NUMBER, "description": "Equivalent degrees of freedom of the estimate."},
        "statistic": NUMBER_OR_NULL,
        "lower": NUMBER_OR_NULL,
        "upper": NUMBER_OR_NULL,
        "passed": FLAG,
    },
    about="Variance of unit weight of one group of observations.",
)
GROUP_TEST = object_of(
    {
        "kind": {"enum": ["chain", "control spline", "control point"]},
        "name": TEXT,
        "model": TEXT,
        "observations": COUNT,
        "parameters": {**COUNT, "description": "Degrees of freedom of the statistic."},
        "estimate": array_of(NUMBER_OR_NULL),
        "sigma": array_of(NUMBER_OR_NULL),
        "unit": {"enum": ["mm", "m"]},
        "statistic": NUMBER,
        "critical": NUMBER,
        "passed": FLAG,
        "minimal_detectable": NUMBER_OR_NULL,
        "probability": NUMBER,
    },
    about="Test of a group of observations against one common error.",
)
SYSTEMATIC_EFFECT = object_of(
    {
        "kind": {
            "enum": [
                "image mean",
                "radial trend",
                "tangential trend",
                "grid",
                "run along curve",
                "drift",
                "strip",
            ]
        },
        "subject": TEXT,
        "estimate": NUMBER_OR_NULL,
        "unit": TEXT,
        "statistic": NUMBER,
        "critical": NUMBER,
        "significant": FLAG,
        "observations": COUNT,
        "detail": TEXT,
        "shown": {
            **NUMBER,
            "description": "Share of such an effect that residuals show; unknowns take up the rest.",
        },
        "probability": NUMBER,
    }
)
RESIDUAL_GRID = object_of(
    {
        "camera": TEXT,
        "x_edges_mm": array_of(NUMBER),
        "y_edges_mm": array_of(NUMBER),
        "mean_mm": array_of(array_of(array_of(NUMBER_OR_NULL, 2))),
        "sigma_mm": array_of(array_of(array_of(NUMBER_OR_NULL, 2))),
        "count": array_of(array_of(COUNT)),
    },
    about="Mean residual vectors in the cells of the image format; rows of cells from below.",
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
        "predicted_residual": {**NUMBER_OR_NULL, "description": "mm, of tangents degrees, of distances m."},
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
