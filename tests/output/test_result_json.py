"""result.json: the promised keys and units, readable and stable."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from splinebba_cli.core.network import Camera
from splinebba_cli.errors import OutputError
from splinebba_cli.output.json_text import finite, json_text
from splinebba_cli.output.result_json import load_result_json, result_json_text, result_to_dict
from tests.output.factory import make_result


def test_promised_keys() -> None:
    content = result_to_dict(make_result())
    assert content["format"] == "splinebba-result/1"
    for key in ("provenance", "status", "statistics", "cameras", "images", "splines", "points", "checks"):
        assert key in content
    assert {"residuals", "problems"} <= content.keys()
    assert content["status"] == {"converged": True, "termination": "step negligible", "iterations": 5}
    statistics = content["statistics"]
    assert statistics["redundancy"] == (
        statistics["observations"] + statistics["conditions"] - statistics["unknowns"]
    )
    assert statistics["global_test"].keys() == {"statistic", "lower", "upper", "alpha", "passed"}
    segment = content["splines"][0]["segments"][0]
    assert [len(segment[key]) for key in ("interval", "a", "b", "c", "sigma_a", "sigma_b", "sigma_c")] == [
        2
    ] + 6 * [4]
    assert content["splines"][0]["sigma_across"].keys() == {"max", "mean"}
    assert content["points"][0].keys() == {"id", "role", "x", "y", "z", "sigma", "rays"}
    assert content["problems"][0].keys() >= {"code", "severity", "message", "subject"}


def test_units_are_metres_and_degrees() -> None:
    result = make_result()
    image = result_to_dict(result)["images"][2]
    assert image["omega"] == pytest.approx(np.degrees(result.images.eop[2, 0]), rel=1e-15)
    assert image["z"] == result.images.eop[2, 5]
    assert image["sigma"]["kappa"] == pytest.approx(np.degrees(np.sqrt(result.images.dispersion[2, 2, 2])))
    assert image["sigma"]["x"] == pytest.approx(np.sqrt(result.images.dispersion[2, 3, 3]))


def test_only_strong_correlations_are_named() -> None:
    images = result_to_dict(make_result())["images"]
    assert images[0]["correlations"] == []
    (pair,) = images[1]["correlations"]
    assert (pair["a"], pair["b"]) == ("omega", "Y0")
    assert pair["r"] == pytest.approx(-0.983)


def test_fixed_orientation_has_no_sigma_and_no_correlation() -> None:
    result = make_result()
    fixed = replace(
        result.images,
        dispersion=np.zeros_like(result.images.dispersion),
        estimated=np.zeros((3, 6), dtype=bool),
    )
    image = result_to_dict(replace(result, images=fixed))["images"][1]
    assert image["fixed"] == ["omega", "phi", "kappa", "X0", "Y0", "Z0"]
    assert image["correlations"] == []
    assert set(image["sigma"].values()) == {0.0}


def test_residual_summary_against_the_definition() -> None:
    result = make_result()
    residuals = result_to_dict(result)["residuals"]
    points, splines = residuals["kinds"]
    v = result.point_residuals.residual
    assert points["rms_mm"] == pytest.approx(np.sqrt(np.mean(v**2)))
    assert points["max_px"] == pytest.approx(np.abs(v).max() / 0.012)
    mine = result.network.curve_observations.image == 1
    across = result.curve_residuals.across[mine]
    assert residuals["images"][1]["splines"]["n"] == mine.sum()
    assert residuals["images"][1]["splines"]["rms_mm"] == pytest.approx(np.sqrt(np.mean(across**2)))
    mine = result.network.curve_observations.curve == 0
    assert residuals["splines"][0]["max_mm"] == pytest.approx(
        np.abs(result.curve_residuals.across[mine]).max()
    )
    assert splines["redundancy"] == pytest.approx(result.curve_residuals.redundancy.sum())
    angle = next(group for group in residuals["priors"] if group["unit"] == "deg")
    assert angle["rms"] == pytest.approx(np.degrees(0.0001))


def test_residuals_of_every_group_of_the_project() -> None:
    result = make_result()
    observed = result.network.curve_observations
    group = np.arange(len(observed)) % 2
    split = replace(observed, group=group, group_names=("first flight", "second flight"))
    whole = replace(result, network=replace(result.network, curve_observations=split))
    groups = result_to_dict(whole)["residuals"]["groups"]
    assert [(g["group"], g["kind"]) for g in groups] == [
        ("points", "points"),
        ("first flight", "splines"),
        ("second flight", "splines"),
    ]
    for number, found in enumerate(groups[1:]):
        across = result.curve_residuals.across[group == number]
        assert found["n"] == len(across)
        assert found["rms_mm"] == pytest.approx(np.sqrt(np.mean(across**2)))
        assert found["redundancy"] == pytest.approx(result.curve_residuals.redundancy[group == number].sum())


def test_unknown_pixel_size_is_null() -> None:
    result = make_result()
    camera = replace(result.network.cameras[0], pixel_size_mm=None)
    assert isinstance(camera, Camera)
    network = replace(result.network, cameras=(camera,))
    points, splines = result_to_dict(replace(result, network=network))["residuals"]["kinds"]
    assert points["rms_px"] is None
    assert splines["max_px"] is None


def test_not_a_number_is_null_and_text_is_strict_json() -> None:
    result = make_result()
    statistics = replace(result.statistics, sigma0=float("nan"), redundancy=0, global_test=None)
    content = result_to_dict(replace(result, statistics=statistics))
    assert content["statistics"]["sigma0"] is None
    assert content["statistics"]["global_test"] is None
    text = result_json_text(content)
    assert json.loads(text) == content
    assert max(map(len, text.splitlines())) < 200
    with pytest.raises(ValueError, match="JSON"):
        json_text({"x": float("inf")})


def test_same_result_same_text() -> None:
    assert result_json_text(result_to_dict(make_result())) == result_json_text(result_to_dict(make_result()))


@pytest.mark.parametrize(
    "value", [[], {}, {"a": []}, list(range(200)), [[1.5, None], ["σ", True]], {"é": {"b": [[1]]}}]
)
def test_json_text_reads_back(value: object) -> None:
    assert json.loads(json_text(value)) == value


def test_finite() -> None:
    assert finite({"a": np.array([1.0, np.nan, -0.0]), "b": (np.int64(3), np.bool_(True))}) == {
        "a": [1.0, None, 0.0],
        "b": [3, True],
    }


def test_load(tmp_path: Path) -> None:
    content = result_to_dict(make_result())
    (tmp_path / "result.json").write_text(result_json_text(content), encoding="utf-8")
    assert load_result_json(tmp_path) == load_result_json(tmp_path / "result.json") == content
    (tmp_path / "result.json").write_text('{"format": "other"}')
    for path in (tmp_path, tmp_path / "absent"):
        with pytest.raises(OutputError) as caught:
            load_result_json(path)
        assert caught.value.code == "SBB602"


def test_the_folder_of_a_project_is_told_where_its_results_are(tmp_path: Path) -> None:
    (tmp_path / "project.results").mkdir()
    (tmp_path / "project.results" / "result.json").write_text("{}")
    with pytest.raises(OutputError) as caught:
        load_result_json(tmp_path)
    assert caught.value.help == f"results lie in `{tmp_path / 'project.results'}`"
