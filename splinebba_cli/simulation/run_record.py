"""What is kept of one run of a campaign: one line of JSON."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.simulation.run_errors import (
    SAMPLES_PER_CURVE,
    CurveErrors,
    Reference,
    RunErrors,
    run_errors,
)

StudyOutcome = Literal["same", "other minimum", "failed"]


@dataclass(frozen=True)
class Places:
    """Where the features of a run stand in the design of its campaign."""

    points: IntArray  # (n,) numbers of the run's points
    point_count: int
    curves: IntArray  # (k,) numbers of the run's curves
    curve_count: int
    locations: IntArray  # (q,) of its locations on given curves among all of these
    location_count: int


@dataclass(frozen=True)
class Failure:
    """Why a run has no solution."""

    code: str  # "SBB502"
    message: str


@dataclass(frozen=True)
class StudyPoint:
    """Where one wrong start led."""

    factor: float
    outcome: StudyOutcome
    deviation: float  # largest difference from the solution that starts at the truth, in σ; NaN: failed
    iterations: int
    failure: Failure | None = None


@dataclass(frozen=True)
class RunRecord:
    """One run: its errors where it was solved, the reason where it was not."""

    run: int
    failure: Failure | None
    errors: RunErrors | None  # in the numbering of the design; NaN for what the run left out
    sigma0: float  # σ̂₀/σ₀; NaN without redundancy
    redundancy: int
    accepted: bool | None  # global test; None without redundancy
    iterations: int
    study: tuple[StudyPoint, ...] = ()

    def line(self) -> str:
        """The record as one line of JSON; the same record gives the same line."""
        errors = None if self.errors is None else _errors_data(self.errors)
        data = {
            "run": self.run,
            "failure": None if self.failure is None else vars(self.failure),
            "sigma0": _number(self.sigma0),
            "redundancy": self.redundancy,
            "accepted": self.accepted,
            "iterations": self.iterations,
            "errors": errors,
            "study": [
                {
                    **vars(point),
                    "deviation": _number(point.deviation),
                    "failure": None if point.failure is None else vars(point.failure),
                }
                for point in self.study
            ],
        }
        return json.dumps(data, ensure_ascii=False, allow_nan=False)


def record_from(data: dict[str, Any]) -> RunRecord:
    """A record of the data of its line."""
    errors = data["errors"]
    return RunRecord(
        run=data["run"],
        failure=None if data["failure"] is None else Failure(**data["failure"]),
        errors=None if errors is None else _errors_from(errors),
        sigma0=_of(data["sigma0"]),
        redundancy=data["redundancy"],
        accepted=data["accepted"],
        iterations=data["iterations"],
        study=tuple(
            StudyPoint(
                point["factor"],
                point["outcome"],
                _of(point["deviation"]),
                point["iterations"],
                None if point["failure"] is None else Failure(**point["failure"]),
            )
            for point in data["study"]
        ),
    )


def solved_record(
    run: int,
    result: AdjustmentResult,
    reference: Reference,
    places: Places | None = None,
    study: tuple[StudyPoint, ...] = (),
) -> RunRecord:
    """The record of a solved run; without `places` it numbers its features as the result does."""
    errors = run_errors(result, reference)
    if places is not None:
        errors = _in_design(errors, places)
    statistics = result.statistics
    test = statistics.global_test
    return RunRecord(
        run=run,
        failure=None,
        errors=errors,
        sigma0=statistics.sigma0 / statistics.sigma0_prior,
        redundancy=statistics.redundancy,
        accepted=None if test is None else test.passed,
        iterations=len(result.iterations),
        study=study,
    )


def failed_record(run: int, failure: Failure) -> RunRecord:
    """The record of a run without a solution."""
    return RunRecord(run, failure, None, float("nan"), 0, None, 0)


def _in_design(errors: RunErrors, places: Places) -> RunErrors:
    def spread(rows: FloatArray, at: IntArray, count: int) -> FloatArray:
        out = np.full((count, *rows.shape[1:]), np.nan)
        out[at] = rows
        return out

    none = np.full((SAMPLES_PER_CURVE, 2), np.nan)
    all_curves = [CurveErrors(none, none)] * places.curve_count
    for place, found in zip(places.curves, errors.curves, strict=True):
        all_curves[int(place)] = found
    points = places.points, places.point_count
    locations = places.locations, places.location_count
    return replace(
        errors,
        points=spread(errors.points, *points),
        points_normalized=spread(errors.points_normalized, *points),
        curves=tuple(all_curves),
        locations=spread(errors.locations, *locations),
        locations_normalized=spread(errors.locations_normalized, *locations),
    )


_ARRAYS = {
    "eop": 6,
    "eop_normalized": 6,
    "image_squares": 0,
    "points": 3,
    "points_normalized": 3,
    "locations": 0,
    "locations_normalized": 0,
}


def _errors_data(errors: RunErrors) -> dict[str, Any]:
    data: dict[str, Any] = {name: _rounded(getattr(errors, name)) for name in _ARRAYS}
    data["across"] = [_rounded(curve.across) for curve in errors.curves]
    data["across_normalized"] = [_rounded(curve.normalized) for curve in errors.curves]
    return data


def _errors_from(data: dict[str, Any]) -> RunErrors:
    arrays = {name: _array(data[name], width) for name, width in _ARRAYS.items()}
    curves = tuple(
        CurveErrors(_array(a, 2), _array(b, 2))
        for a, b in zip(data["across"], data["across_normalized"], strict=True)
    )
    return RunErrors(**arrays, curves=curves)


def _rounded(values: FloatArray) -> list[Any]:
    """Nested lists of numbers with seven digits; NaN is None."""
    if values.ndim > 1:
        return [_rounded(row) for row in values]
    return [_number(value) for value in values.tolist()]


def _array(values: Sequence[Any], width: int) -> FloatArray:
    flat = np.array(values, dtype=np.float64)
    return flat.reshape(-1, width) if width else flat


def _number(value: float) -> float | None:
    return float(f"{value:.7g}") if np.isfinite(value) else None


def _of(value: float | None) -> float:
    return float("nan") if value is None else value
