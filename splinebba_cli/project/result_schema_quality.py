"""The JSON Schema of result.json: tests, reliability, precision, checks, weights and the search for outliers."""

from __future__ import annotations

from splinebba_cli.project.schema_parts import (
    COUNT,
    FLAG,
    NUMBER,
    NUMBER_OR_NULL,
    TEXT,
    Schema,
    array_of,
    object_of,
    xyz_of,
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
                "mean": xyz_of(),
                "largest": xyz_of(),
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
