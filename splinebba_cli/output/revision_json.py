"""The ``revision`` part of result.json: what the search for outliers did."""

from __future__ import annotations

from typing import Any

import numpy as np

from splinebba_cli.core.evidence import ObservationKind
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.output.revision_tables import status_of

_KINDS: tuple[ObservationKind, ...] = ("point", "spline", "arc length", "tangent", "distance")


def revision_to_dict(result: AdjustmentResult) -> dict[str, Any]:
    """Method, counts by status, and the log; residuals in mm, of tangents in degrees, of distances in metres."""
    revision = result.revision
    status = [word for kind in _KINDS for word in status_of(result, kind)]
    return {
        "method": revision.method,
        "start": revision.start,
        "rounds": revision.rounds,
        "used": status.count("used"),
        "reweighted": status.count("reweighted"),
        "rejected": status.count("rejected"),
        "excluded_by_user": status.count("excluded by user"),
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
