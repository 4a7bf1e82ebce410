"""The ``revision`` part of result.json: what the search for outliers did."""

from __future__ import annotations

from typing import Any

import numpy as np

from splinebba_cli.core.evidence import ObservationKind
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.output.revision_tables import STATUS, status_of

_KINDS: tuple[ObservationKind, ...] = ("point", "spline", "arc length", "tangent", "distance")


def revision_to_dict(result: AdjustmentResult) -> dict[str, Any]:
    """Method, counts by status, and the log; residuals in mm, of tangents in degrees, of distances in metres."""
    revision = result.revision
    status = np.concatenate([status_of(result, kind).number for kind in _KINDS])
    counts = np.bincount(status, minlength=len(STATUS)).tolist()
    return {
        "method": revision.method,
        "start": revision.start,
        "rounds": revision.rounds,
        **{word.replace(" ", "_"): count for word, count in zip(STATUS, counts, strict=True)},
        "rejections": [
            {
                "kind": each.kind,
                "row": each.row + 1,
                "name": each.name,
                "round": each.round,
                "reason": each.reason,
                "statistic": each.statistic,
                "predicted_w": each.predicted,
                "predicted_residual": float(np.degrees(each.residual))
                if each.kind == "tangent"
                else each.residual,
                "returned": each.returned,
            }
            for each in revision.rejections
        ],
    }
