"""The sample projects as a new user runs them: the same results within declared tolerances, and near the truth.

The tolerances stand in each sample's expected/tolerances.json:

    value_of_sigma    values, in units of their own σ: the iterations end below 0.05 σ, wherever they run
    sigma_relative    σ themselves, relative
    sigma0_relative   σ̂₀ and what follows from v'Pv, relative: the iterations end where v'Pv is stationary to 1e-7
    held_m            values that are held (σ = 0), metres
"""

from __future__ import annotations

import copy
import json
import math
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.special import chdtri

from tests.regenerate_expected import FOLDER, SAMPLES, Sample, adjust, run, simulate

SOLVABLE = [sample for sample in SAMPLES if sample.exit_code == 0 and not sample.match]
SINGULAR = next(sample for sample in SAMPLES if sample.exit_code == 3)
EOP = ("omega", "phi", "kappa", "x", "y", "z")
COUNTS = ("observations", "unknowns", "conditions", "rank_defect", "redundancy")


def name_of(sample: Sample) -> str:
    return sample.name


@pytest.fixture(scope="module", params=SOLVABLE, ids=name_of)
def adjusted(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Sample, Any]:
    """A sample and the result.json of its adjustment."""
    sample: Sample = request.param
    output = tmp_path_factory.mktemp(sample.name) / "out"
    result = adjust(sample, output)
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout)["accepted"] is True
    return sample, json.loads((output / "result.json").read_text(encoding="utf-8"))


def differences(found: Any, expected: Any, tolerance: dict[str, float]) -> list[str]:
    """What differs by more than the tolerances, as lines of text."""
    lines: list[str] = []

    def same(what: str, a: Any, b: Any) -> None:
        if a != b:
            lines.append(f"{what}: {a!r}, expected {b!r}")

    def value(what: str, a: float, b: float, sigma: float, sigma_expected: float) -> None:
        if not abs(a - b) <= max(tolerance["value_of_sigma"] * sigma_expected, tolerance["held_m"]):
            lines.append(f"{what}: {a!r}, expected {b!r} ± {sigma_expected!r}")
        if not math.isclose(sigma, sigma_expected, rel_tol=tolerance["sigma_relative"], abs_tol=1e-12):
            lines.append(f"σ of {what}: {sigma!r}, expected {sigma_expected!r}")

    def relative(what: str, a: float, b: float) -> None:
        if not math.isclose(a, b, rel_tol=tolerance["sigma0_relative"]):
            lines.append(f"{what}: {a!r}, expected {b!r}")

    for key in COUNTS:
        same(key, found["statistics"][key], expected["statistics"][key])
    relative("sigma0", found["statistics"]["sigma0"], expected["statistics"]["sigma0"])
    for key in ("statistic", "lower", "upper"):
        test = (found["statistics"]["global_test"][key], expected["statistics"]["global_test"][key])
        relative(f"global test, {key}", *test)
    for part in ("images", "splines", "points"):
        ids = [[item["id"] for item in content[part]] for content in (found, expected)]
        same(part, *ids)
    for a, b in zip(found["images"], expected["images"], strict=True):
        for key in EOP:
            value(f"image {a['id']} {key}", a[key], b[key], a["sigma"][key], b["sigma"][key])
    for a, b in zip(found["splines"], expected["splines"], strict=True):
        rows = zip(a["knots"], b["knots"], a["knot_sigma"], b["knot_sigma"], strict=True)
        for number, row in enumerate(rows):
            for axis, cells in enumerate(zip(*row, strict=True)):
                value(f"spline {a['id']} knot {number} {'xyz'[axis]}", *cells)
    for a, b in zip(found["points"], expected["points"], strict=True):
        for key in "xyz":
            value(f"point {a['id']} {key}", a[key], b[key], a["sigma"][key], b["sigma"][key])
    same(
        "problems",
        *([(p["code"], p["subject"]) for p in content["problems"]] for content in (found, expected)),
    )
    return lines


def test_same_results_as_expected(adjusted: tuple[Sample, Any]) -> None:
    sample, found = adjusted
    assert differences(found, sample.expected("result.json"), sample.expected("tolerances.json")) == []


def test_the_comparison_sees_what_it_should(adjusted: tuple[Sample, Any]) -> None:
    sample, found = adjusted
    tolerance = sample.expected("tolerances.json")
    for part in ("images", "splines", "statistics"):
        changed = copy.deepcopy(found)
        if part == "images":
            changed["images"][2]["x"] += 2.0 * tolerance["value_of_sigma"] * found["images"][2]["sigma"]["x"]
        elif part == "splines":
            changed["splines"][-1]["knot_sigma"][1][2] *= 1.0 + 2.0 * tolerance["sigma_relative"]
        else:
            changed["statistics"]["redundancy"] += 1
        assert len(differences(changed, found, tolerance)) == 1, part


def moved_onto(truth: Any, found: Any) -> Any:
    """Orientations after the shift and rotation by which the points, which carry the datum, fit the true ones best."""
    both = [
        np.array([[point[k] for k in "xyz"] for point in content["points"]]) for content in (truth, found)
    ]
    centre = [xyz.mean(axis=0) for xyz in both]
    turn = Rotation.align_vectors(both[0] - centre[0], both[1] - centre[1])[0]
    out = copy.deepcopy(found)
    for image in out["images"]:
        xyz = centre[0] + turn.apply(np.array([image[k] for k in "xyz"]) - centre[1])
        own = Rotation.from_euler("XYZ", [image[k] for k in EOP[:3]], degrees=True)
        angles = (turn * own).as_euler("XYZ", degrees=True)
        image |= dict(zip(EOP, [*angles, *xyz], strict=True))
    return out


def test_orientations_are_near_the_truth(adjusted: tuple[Sample, Any]) -> None:
    """Errors in units of their σ: a correct program fails once in 1e5 seeds; the samples have one seed."""
    sample, found = adjusted
    truth = json.loads((sample.folder / "truth.json").read_text(encoding="utf-8"))
    assert [image["id"] for image in found["images"]] == [true["id"] for true in truth["images"]]
    if found["settings"]["datum"] == "inner":
        found = moved_onto(truth, found)
    pairs = zip(found["images"], truth["images"], strict=True)
    error = np.array([[(image[k] - true[k]) / image["sigma"][k] for k in EOP] for image, true in pairs])
    assert np.abs(error).max() < math.sqrt(chdtri(1, 1e-5 / error.size))
    # the mean square is 1; highly correlated errors vary at most like six independent ones
    assert chdtri(6, 1.0 - 1e-5) / 6 < np.mean(error**2) < chdtri(6, 1e-5) / 6


def test_expected_statistics_of_a_sample_agree_with_each_other(adjusted: tuple[Sample, Any]) -> None:
    statistics = adjusted[1]["statistics"]
    balance = statistics["observations"] + statistics["conditions"] - statistics["unknowns"]
    assert statistics["redundancy"] == balance
    assert statistics["sum_redundancy_numbers"] == pytest.approx(balance, rel=1e-9)
    assert statistics["sigma0"] ** 2 * balance == pytest.approx(statistics["vtpv"])


def test_check_of_a_sample() -> None:
    for sample in SOLVABLE:
        result = run("check", sample.folder, "--format", "json")
        assert result.exit_code == 0, result.output
        assert json.loads(result.stdout)["budget"]["nullity"] == sample.nullity


def test_one_control_segment_is_refused_with_the_reason(tmp_path: Path) -> None:
    output = tmp_path / "out"
    as_json = adjust(SINGULAR, output)
    assert as_json.exit_code == 3
    problems = json.loads(as_json.stdout)["problems"]
    assert problems == SINGULAR.expected("problems.json")["problems"]
    assert [problem["subject"] for problem in problems] == [f"image `{k}`" for k in range(1, 7)]
    as_text = run("adjust", SINGULAR.folder, "-o", output, "-q")
    assert as_text.exit_code == 3
    assert as_text.stdout == ""
    assert as_text.stderr.count("error[SBB522]: image `") == 6
    assert "2 combinations of" in as_text.stderr
    assert "measure more control or tie features" in as_text.stderr
    assert list(tmp_path.iterdir()) == []


def test_budget_of_one_control_segment() -> None:
    result = run("check", SINGULAR.folder, "--format", "json")
    assert result.exit_code == 3
    # 24 measured points: 48 equations; 6 x 6 orientation unknowns and 24 locations; each image lacks 2
    assert json.loads(result.stdout)["budget"] == {
        "equations": 48, "unknowns": 60, "rank": 48, "nullity": 12, "redundancy": 0,
    }  # fmt: skip


def test_without_control_the_whole_block_moves_together(tmp_path: Path) -> None:
    """Seven directions, one problem: it names every image."""
    folder = tmp_path / "block"
    shutil.copytree(FOLDER / "six_image_mixed", folder)
    for name, old, new in (
        ("points.csv", ",control,", ",tie,"),
        ("points.csv", ",0.02", ",free"),
        ("project.yaml", "role: partial", "role: tie"),
        ("knots.csv", ",fixed", ",free"),
        ("knots.csv", ",0.05", ",free"),
    ):
        text = (folder / name).read_text(encoding="utf-8")
        (folder / name).write_text(text.replace(old, new), encoding="utf-8")
    result = run("check", folder, "--format", "json")
    assert result.exit_code == 3, result.output
    content = json.loads(result.stdout)
    assert content["budget"]["nullity"] == 7
    (problem,) = content["problems"]
    assert problem["code"] == "SBB523"
    assert all(f"`{k}`" in problem["message"] for k in range(1, 7))


@pytest.mark.parametrize("sample", SAMPLES, ids=name_of)
def test_samples_are_what_simulate_writes(sample: Sample, tmp_path: Path) -> None:
    """To renew: python -m tests.regenerate_expected."""
    simulate(sample, tmp_path / "new")
    for path in sorted((tmp_path / "new").iterdir()):
        new, old = path.read_text(encoding="utf-8"), (sample.folder / path.name).read_text(encoding="utf-8")
        if path.suffix == ".csv":
            _assert_same_table(path.name, new, old)
        elif path.suffix == ".yaml":
            assert new == old


def _assert_same_table(name: str, new: str, old: str) -> None:
    """The same cells; numbers to 1e-9 (the last digits belong to the machine's sine and cosine)."""
    for a, b in zip(new.splitlines(), old.splitlines(), strict=True):
        for x, y in zip(a.split(","), b.split(","), strict=True):
            if x != y:
                assert float(x) == pytest.approx(float(y), rel=1e-9, abs=1e-9), name
