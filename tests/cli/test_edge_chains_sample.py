"""The sample of edges without names, as a new user runs it: labels, orientations and adjustment against its truth.

Expected values stand in expected/result.json; to renew: python -m tests.regenerate_expected.
"""

from __future__ import annotations

import csv
import json
import math
from collections import Counter
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from scipy.special import chdtri

from splinebba_cli.project.match_schema import match_schema
from tests.cli.test_sample_projects import EOP, differences
from tests.regenerate_expected import SAMPLES, adjust

SAMPLE = next(sample for sample in SAMPLES if sample.match)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folders of matching and adjustment: `matched` and `out`."""
    folder = tmp_path_factory.mktemp("edges")
    result = adjust(SAMPLE, folder / "out")
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout)["accepted"] is True
    return folder


@pytest.fixture(scope="module")
def truth() -> dict[str, Any]:
    content: dict[str, Any] = json.loads((SAMPLE.folder / "truth.json").read_text(encoding="utf-8"))
    return content


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def test_labels_of_known_kerbs_are_right(folder: Path, truth: dict[str, Any]) -> None:
    """Of the points on kerbs 97 % are found; a label of a kerb is wrong at most where wrong chains cross it."""
    spline = {(each["image"], each["chain"]): each["spline"] or "" for each in truth["chains"]}
    given = Counter(spline[row["image"], row["chain"]] for row in rows_of(SAMPLE.folder / "chains.csv"))
    matched = rows_of(folder / "matched" / "matched_points.csv")
    kerbs = [row for row in matched if row["spline"].startswith("kerb")]
    right = sum(row["spline"] == spline[row["image"], row["chain"]] for row in kerbs)
    assert right >= 0.97 * sum(count for name, count in given.items() if name.startswith("kerb"))
    assert len(kerbs) - right <= 0.005 * len(kerbs)


def test_orientations_are_as_good_as_reported(folder: Path, truth: dict[str, Any]) -> None:
    """Errors in units of their σ: a correct program fails once in 1e5 seeds; the sample has one seed."""
    found = json.loads((folder / "out" / "result.json").read_text(encoding="utf-8"))
    pairs = zip(found["images"], truth["images"], strict=True)
    error = np.array([[(image[k] - true[k]) / image["sigma"][k] for k in EOP] for image, true in pairs])
    error[:, 2] = [
        math.remainder(image["kappa"] - true["kappa"], 360.0) / image["sigma"]["kappa"]
        for image, true in zip(found["images"], truth["images"], strict=True)
    ]
    assert np.abs(error).max() < math.sqrt(chdtri(1, 1e-5 / error.size))
    assert chdtri(6, 1.0 - 1e-5) / 6 < np.mean(error**2) < chdtri(6, 1e-5) / 6


def test_match_json_is_as_published(folder: Path) -> None:
    content = json.loads((folder / "matched" / "match.json").read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator(match_schema()).validate(content)
    assert content["new_splines"] and content["images"][0]["sigma"]["x"] > 0.0


def test_same_results_as_expected(folder: Path) -> None:
    found = json.loads((folder / "out" / "result.json").read_text(encoding="utf-8"))
    assert differences(found, SAMPLE.expected("result.json"), SAMPLE.expected("tolerances.json")) == []
