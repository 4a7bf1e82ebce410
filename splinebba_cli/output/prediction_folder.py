"""The folder of a pre-analysis: prediction.json (format ``splinebba-prediction/1``) and tables of predicted σ.

Images, splines and points are laid out as in result.json; their standard deviations are a priori (σ0 = 1).
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.output.atomic import replace_directory
from splinebba_cli.output.columns import write_table
from splinebba_cli.output.json_text import json_text
from splinebba_cli.output.result_json import result_to_dict
from splinebba_cli.output.tables import (
    exterior_orientation_table,
    points_table,
    spline_coefficients_table,
    spline_samples_table,
)
from splinebba_cli.simulation.prediction import redundancy_summary

PREDICTION_FORMAT = "splinebba-prediction/1"
PREDICTION_FILE = "prediction.json"
_COUNTS = ("observations", "unknowns", "conditions", "rank_defect", "redundancy", "sum_redundancy_numbers")
_TABLES = (exterior_orientation_table, points_table, spline_coefficients_table, spline_samples_table)


def prediction_content(
    result: AdjustmentResult, identity: Mapping[str, Any], left_out: Sequence[str]
) -> dict[str, Any]:
    """The content of prediction.json.

    Parameters
    ----------
    identity : target, inputs and program
    left_out : features that too few images would see
    """
    content = result_to_dict(result)
    return {
        "format": PREDICTION_FORMAT,
        **identity,
        "statistics": {key: content["statistics"][key] for key in _COUNTS},
        "problems": content["problems"],
        "left_out": list(left_out),
        "redundancy_numbers": [asdict(each) for each in redundancy_summary(result)],
        **{key: content[key] for key in ("settings", "cameras", "images", "splines", "points")},
    }


def write_prediction(directory: Path, result: AdjustmentResult, content: Mapping[str, Any]) -> None:
    """Write prediction.json and its tables; the folder is replaced as a whole.

    Raises
    ------
    OutputError
        SBB601, SBB602: cannot be written, not a folder of predictions.
    """
    with replace_directory(directory, _is_prediction) as folder:
        (folder / PREDICTION_FILE).write_text(json_text(dict(content)), encoding="utf-8", newline="\n")
        for table in _TABLES:
            write_table(folder, table(result), "csv")


def _is_prediction(folder: Path) -> bool:
    try:
        content = json.loads((folder / PREDICTION_FILE).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(content, dict) and content.get("format") == PREDICTION_FORMAT
