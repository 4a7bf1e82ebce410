"""The JSON Schema of match.json, format ``splinebba-match/1``: what other programs may rely on.

Keys that are not named here may be added without a new version of the format.
"""

from __future__ import annotations

from splinebba_cli.project.result_schema import PROBLEM
from splinebba_cli.project.result_schema_quality import CRITERION
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

REASONS: Schema = {
    "type": "object",
    "additionalProperties": COUNT,
    "description": "Reason → number of unmatched points: far, direction, ambiguous, chain, taken, gross, excluded, "
    "not oriented, one image.",
}
SETTINGS: Schema = {
    "type": "object",
    "description": "The settings that were used, by the keys of `matching` in the project; angles in degrees.",
}
COUNTS = object_of(
    {
        "points": {**COUNT, "description": "Unlabelled points, without those taken out."},
        "matched": COUNT,
        "share": {**NUMBER, "description": "matched / points."},
        "excluded": {**COUNT, "description": "Points taken out by the user."},
        "labelled_before": {**COUNT, "description": "Points on splines that had a label before."},
        **dict.fromkeys(
            ("chains", "chains_matched_whole", "chains_matched_in_part", "chains_unmatched"), COUNT
        ),
        "images": COUNT,
        "images_oriented": {**COUNT, "description": "Images whose orientation was found or improved."},
        "splines": {**COUNT, "description": "Splines of the project."},
        "new_splines": COUNT,
    }
)
AMBIGUITY = object_of(
    {
        "alone": {**COUNT, "description": "Matched points without a second spline near."},
        "edges": array_of(NUMBER),
        "points": array_of(COUNT),
        "close": {**COUNT, "description": "Points with a ratio above close_from."},
        "close_from": NUMBER,
    },
    about="Matched points by the distance from their spline over that from the next one, a histogram.",
)
IMAGE = object_of(
    {
        "id": TEXT,
        "points": COUNT,
        "matched": COUNT,
        "share": NUMBER_OR_NULL,
        "reasons": REASONS,
        "oriented": {**FLAG, "description": "The orientation was found or improved."},
        "in_matched_project": FLAG,
        **dict.fromkeys(EOP_KEYS, NUMBER_OR_NULL),
        "sigma": object_of(dict.fromkeys(EOP_KEYS, NUMBER_OR_NULL)),
        "moved_m": NUMBER_OR_NULL,
        "turned_deg": NUMBER_OR_NULL,
    },
    about="Orientation after matching: metres, degrees.",
)
SPLINE = object_of(
    {
        "id": TEXT,
        "role": TEXT,
        "new": FLAG,
        "points": {**COUNT, "description": "Points that found this spline; not those with a label before."},
        "images": COUNT,
        "chains": COUNT,
        "rms_distance": {**NUMBER_OR_NULL, "description": "Across the spline, over the predicted σ."},
    }
)
ROUND = object_of(
    {
        "stage": TEXT,
        "number": COUNT,
        "gate_px": {
            **NUMBER_OR_NULL,
            "description": "Median half width; mm of cameras without a pixel size.",
        },
        "matched": COUNT,
        "changed": COUNT,
        "sigma0": {**NUMBER_OR_NULL, "description": "Large residuals weigh less in these adjustments."},
        "position_step_m": NUMBER_OR_NULL,
        "angle_step_deg": NUMBER_OR_NULL,
    }
)
WEAK_PART = object_of(
    {
        "first": NUMBER,
        "last": NUMBER,
        "kind": {"enum": ["epipolar", "bridged", "two_images"]},
        "sigma_m": {**NUMBER_OR_NULL, "description": "Largest, across the spline."},
    },
    about="A part of a spline, from location to location, that its images hold badly.",
)
NEW_SPLINE = object_of(
    {
        "id": TEXT,
        "knots": COUNT,
        "closed": FLAG,
        "images": array_of(TEXT),
        "chains": {**array_of(TEXT), "description": "image/chain."},
        "length_m": NUMBER,
        "length_in_three_images_m": NUMBER,
        "weak_parts": array_of(WEAK_PART),
    }
)


def match_schema() -> Schema:
    """The JSON Schema of match.json."""
    content = object_of(
        {
            "format": {"const": "splinebba-match/1"},
            "provenance": {"type": "object"},
            "settings": SETTINGS,
            "acceptance": array_of(CRITERION),
            "counts": COUNTS,
            "reasons": REASONS,
            "ambiguity": AMBIGUITY,
            "images": array_of(IMAGE),
            "splines": array_of(SPLINE),
            "history": array_of(ROUND),
            "new_splines": array_of(NEW_SPLINE),
            "problems": array_of(PROBLEM),
        },
        about="What matching has found; every point and chain stands in the tables beside it.",
    )
    head = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": "https://splinebba.org/schemas/match.schema.json",
    }
    return {**head, **content}
