"""What must hold of a project that is accepted, whatever was done to its files."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from splinebba_cli.jobs.adjust_job import AdjustOptions, run_adjustment
from splinebba_cli.project.loading import LoadedProject, load_project

LARGEST_DIFFERENCE = 0.02  # of a value and of its σ, in σ, after an adjustment from adjusted values


class OracleError(AssertionError):
    """Something was accepted that is wrong."""


def fingerprint(loaded: LoadedProject) -> str:
    """A hash of all that the project means: its network, its settings, what it accepts."""
    digest = hashlib.sha256()
    for part in _parts(
        (
            loaded.network,
            loaded.model.project.model_dump_json(),
            loaded.model.acceptance,
            loaded.model.simulation,
        )
    ):
        digest.update(part)
    return digest.hexdigest()


def _parts(value: Any) -> Iterator[bytes]:
    if isinstance(value, np.ndarray):
        yield str(value.shape).encode() + np.ascontiguousarray(value).tobytes()
    elif dataclasses.is_dataclass(value):
        for one in dataclasses.fields(value):
            yield one.name.encode()
            yield from _parts(getattr(value, one.name))
    elif isinstance(value, (list, tuple)):
        for item in value:
            yield from _parts(item)
    else:
        yield repr(value).encode()


def adjusted(project: Path, folder: Path) -> dict[str, Any]:
    """Content of result.json of an adjustment, checked; SplinebbaError where there is none."""
    options = AdjustOptions(output=folder, html=False)
    run_adjustment(project, options)
    content = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    check_finite(content)
    return dict(content)


def check_finite(content: dict[str, Any]) -> None:
    """Adjusted values are numbers, standard deviations are not negative."""
    for image in content["images"]:
        values = [image[key] for key in ("x", "y", "z", "omega", "phi", "kappa")]
        if not all(isinstance(v, (int, float)) and math.isfinite(v) for v in values):
            raise OracleError(f"image {image['id']} without numbers: {values}")
        sigmas = [s for s in image["sigma"].values() if s is not None]
        if len(sigmas) < 6 or min(sigmas) < 0.0:
            raise OracleError(f"image {image['id']} with σ {sigmas}")
    statistics = content["statistics"]
    if statistics["redundancy"] > 0 and not math.isfinite(statistics["sigma0"] or math.nan):
        raise OracleError(f"σ̂₀ is {statistics['sigma0']}")


def check_repeatable(first: dict[str, Any], folder: Path, again: Path) -> None:
    """`adjusted.yaml` adjusts to the same values and the same σ."""
    second = adjusted(folder / "adjusted.yaml", again)
    for one, other in zip(first["images"], second["images"], strict=True):
        for key in ("x", "y", "z", "omega", "phi", "kappa"):
            sigma = one["sigma"][key]
            apart = abs(one[key] - other[key])
            if key in ("omega", "phi", "kappa"):
                apart = min(apart, abs(apart - 360.0))
            if apart > LARGEST_DIFFERENCE * sigma + 1e-6:
                raise OracleError(f"{key} of image {one['id']}: {one[key]} then {other[key]}, σ {sigma}")
            if abs(sigma - other["sigma"][key]) > LARGEST_DIFFERENCE * sigma + 1e-6:
                raise OracleError(f"σ of {key} of image {one['id']}: {sigma} then {other['sigma'][key]}")


def check_meant(base: str, project: Path) -> None:
    """A number that was replaced by another changes what the project means."""
    if fingerprint(load_project(project)) == base:
        raise OracleError("a number was changed, and the project means the same")
