"""Seconds of processor and wall time of every part of the quality figures, and the memory that they take."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from typing import Any

from splinebba_cli.core.quality import cofactors, evaluation, model_evidence
from splinebba_cli.core.quality.evaluation import Adjusted, evaluate

PARTS: tuple[tuple[str, Any, str], ...] = (
    ("selected inverse", evaluation, "Cofactors"),
    ("leverages of curve points", cofactors, "curve_figures"),
    ("redundancy numbers, all kinds", evaluation, "redundancy_numbers"),
    ("counts, global test", evaluation, "statistics_of"),
    ("residual tables", evaluation, "_residual_tables"),
    ("samples of curves", evaluation, "curve_samples"),
    ("most influential observations", evaluation, "influences"),
    ("results of images", evaluation, "_images"),
    ("results of curves", evaluation, "curve_results"),
    ("results of points", evaluation, "_points"),
    ("local tests", evaluation, "local_tests_of"),
    ("precision of positions", evaluation, "position_precision"),
    ("findings", evaluation, "findings"),
    ("findings about curves", evaluation, "curve_findings"),
    ("sums of groups, sparse rows", model_evidence, "group_sums"),
    ("variances of groups", model_evidence, "group_variances"),
    ("group tests", model_evidence, "group_tests"),
    ("residual grids", model_evidence, "residual_grids"),
    ("image means", model_evidence, "image_means"),
    ("trends of the lens", model_evidence, "lens_trends"),
    ("runs along curves", model_evidence, "runs_along_curves"),
    ("drifts", model_evidence, "drifts"),
    ("drifts of strips", model_evidence, "strip_drifts"),
)

Times = dict[str, tuple[float, float]]


def times_of_parts(adjusted: Adjusted) -> Times:
    """Wall and processor time of every part, parts inside others counted in both, and of all; one evaluation."""
    times: Times = {}
    with _timed(times):
        begin = time.perf_counter(), time.process_time()
        evaluate(adjusted)
        times["all"] = time.perf_counter() - begin[0], time.process_time() - begin[1]
    return times


@contextmanager
def _timed(times: Times) -> Iterator[None]:
    """While this is open, the parts write down their times."""
    originals = [(owner, name, getattr(owner, name)) for _, owner, name in PARTS]
    for (label, _, _), (owner, name, work) in zip(PARTS, originals, strict=True):
        setattr(owner, name, _clocked(label, work, times))
    try:
        yield
    finally:
        for owner, name, work in originals:
            setattr(owner, name, work)


def _clocked(label: str, work: Callable[..., Any], times: Times) -> Callable[..., Any]:
    @wraps(work, updated=())
    def timed(*given: Any, **named: Any) -> Any:
        begin = time.perf_counter(), time.process_time()
        found = work(*given, **named)
        wall, cpu = times.get(label, (0.0, 0.0))
        times[label] = (wall + time.perf_counter() - begin[0], cpu + time.process_time() - begin[1])
        return found

    return timed


def memory_gib(adjusted: Adjusted) -> tuple[float, float] | None:
    """Resident memory before an evaluation, and its peak; None where the system does not tell it (Linux does)."""
    status, reset = Path("/proc/self/status"), Path("/proc/self/clear_refs")
    if not reset.exists():
        return None
    reset.write_text("5")  # the peak begins anew
    before = _kib(status, "VmRSS")
    evaluate(adjusted)
    return before / 2**20, _kib(status, "VmHWM") / 2**20


def _kib(status: Path, key: str) -> int:
    line = next(line for line in status.read_text().splitlines() if line.startswith(key))
    return int(line.split()[1])
