"""What the search for outliers did to every observation, and its log.

``weight`` is the factor of the weight 1/σ² that an observation had (0: it took no part), ``status`` says why: used,
reweighted, rejected (by the run), excluded by user.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.evidence import ObservationKind, Rejection
from splinebba_cli.core.network import BoolArray, FloatArray
from splinebba_cli.core.quality.observation_names import distance_name
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.output.columns import Column, Table
from splinebba_cli.project.labels import Labels

_NUMBER = "%.6g"
STATUS = ("used", "reweighted", "rejected", "excluded by user")


def weights_of(result: AdjustmentResult, kind: ObservationKind) -> FloatArray:
    """Factors of the weights of one kind of observations, (n,)."""
    network, revision = result.network, result.revision
    weight, count = {
        "point": (revision.point_weights, len(network.point_observations)),
        "spline": (revision.curve_weights, len(network.curve_observations)),
        "arc length": (revision.arc_weights, len(network.arc_lengths)),
        "tangent": (revision.tangent_weights, len(network.tangents)),
        "distance": (revision.distance_weights, len(network.distances)),
    }[kind]
    return np.ones(count) if weight is None else weight


def status_of(result: AdjustmentResult, kind: ObservationKind) -> Labels:
    """What became of every observation of one kind."""
    network, weight = result.network, weights_of(result, kind)
    given: BoolArray | None = {
        "point": network.point_observations.excluded,
        "spline": network.curve_observations.excluded,
        "arc length": network.arc_lengths.excluded,
        "tangent": network.tangents.excluded,
        "distance": network.distances.excluded,
    }[kind]
    excluded = np.zeros(len(weight), dtype=bool) if given is None else given
    number = np.where(weight == 1.0, 0, np.where(weight > 0.0, 1, 2))
    return Labels(STATUS, np.where(excluded, 3, number))


def revision_columns(result: AdjustmentResult, *kinds: ObservationKind) -> list[Column]:
    """Columns ``weight`` and ``status`` of the observations of some kinds."""
    weight = np.concatenate([weights_of(result, kind) for kind in kinds])
    status = np.concatenate([status_of(result, kind).number for kind in kinds])
    return [Column("weight", weight, _NUMBER), Column("status", Labels(STATUS, status))]


def rejections_tables(result: AdjustmentResult) -> tuple[Table, ...]:
    """One row a decision of the search, in their order; no table where there was none.

    ``row`` counts from 1 within the observations of a kind, as in residuals.csv; ``predicted_w`` and
    ``predicted_residual`` are against the last solution.
    """
    log = result.revision.rejections
    if not log:
        return ()
    where = [_place(result, each) for each in log]
    angular = np.array([each.kind == "tangent" for each in log])
    residual = np.array([each.residual for each in log])
    columns = (
        Column("round", np.array([each.round for each in log], dtype=np.int64)),
        Column("kind", [each.kind for each in log]),
        Column("image", [image for image, _ in where]),
        Column("feature", [feature for _, feature in where]),
        Column("row", np.array([each.row + 1 for each in log], dtype=np.int64)),
        Column("statistic", np.array([each.statistic for each in log]), "%.4f"),
        Column("reason", [each.reason for each in log]),
        Column("predicted_w", np.array([each.predicted for each in log]), "%.4f"),
        Column("predicted_residual", np.where(angular, np.degrees(residual), residual), "%.7f"),
        Column("unit", [{"tangent": "deg", "distance": "m"}.get(each.kind, "mm") for each in log]),
        Column("returned", ["yes" if each.returned else "no" for each in log]),
    )
    return (Table("rejections", columns),)


def _place(result: AdjustmentResult, rejection: Rejection) -> tuple[str, str]:
    """Image and feature of an observation."""
    network = result.network
    if rejection.kind == "point":
        seen = network.point_observations
        return network.images.ids[seen.image[rejection.row]], network.points.ids[seen.point[rejection.row]]
    row = rejection.row
    if rejection.kind == "distance":
        return "", distance_name(network, row)
    if rejection.kind == "arc length":
        row = int(network.arc_lengths.first[row])
    elif rejection.kind == "tangent":
        row = int(network.tangents.point[row])
    curves = network.curve_observations
    return network.images.ids[curves.image[row]], network.curves[curves.curve[row]].id
