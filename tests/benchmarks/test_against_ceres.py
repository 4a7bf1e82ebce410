"""A small block through the comparison: without the peer, and with it where it is installed."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks import against_ceres
from benchmarks.agreement import orientation_differences
from benchmarks.blocks import NotAvailableError, bench_folder
from benchmarks.peer import find_peer
from splinebba_cli.core.camera.rotation import (
    angles_from_rotation,
    rotation_from_vector,
    rotation_object_from_photo,
)

SIZE = "20"
OPTIONS = ["--sizes", SIZE, "--repeats", "1", "--solves", "1", "--modes", "plain"]


@pytest.fixture(scope="module")
def generator() -> Path:
    try:
        return bench_folder()
    except NotAvailableError as reason:
        pytest.skip(str(reason))


def compared(folder: Path, *options: str) -> dict[str, Any]:
    """The JSON of a run of the command."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sys.argv", ["against_ceres", *OPTIONS, "--folder", str(folder), "--json",
                                   str(folder / "out.json"), *options])  # fmt: skip
        against_ceres.main()
    content: dict[str, Any] = json.loads((folder / "out.json").read_text(encoding="utf-8"))
    return content


def test_without_the_peer(generator: Path, tmp_path: Path) -> None:
    content = compared(tmp_path, "--peer", str(tmp_path / "missing"), "--plot", str(tmp_path / "out.svg"))
    assert [(run["task"], run["mode"]) for run in content["runs"]] == [
        ("solve", "plain"),
        ("adjust", "plain"),
    ]
    solve, adjust = content["runs"]
    assert solve["figures"]["images"] == 20
    assert 0.0 < solve["figures"]["solve_s"][0] < solve["wall_s"]
    assert (tmp_path / "r20" / "result.json").exists()
    assert adjust["peak_bytes"] > 2**25
    assert content["agreement"] == {}
    assert (tmp_path / "out.svg").exists()


def test_with_the_peer(generator: Path, tmp_path: Path) -> None:
    """Both find the same.

    The peer stops where vᵀPv changes by 1e-10 of itself: its last step is at most sqrt(1e-10 · 3213) = 6e-4 σ.  It
    prints σ to 1e-6 m, which is 1.7e-5 of the σ of Z, 3 cm.
    """
    try:
        find_peer(None, generator, tmp_path)
    except NotAvailableError as reason:
        pytest.skip(str(reason))
    content = compared(tmp_path, "--adjust", "0")
    assert [run["task"] for run in content["runs"]] == ["ceres_cov", "ceres_knots", "ceres_vp", "solve"]
    found = content["agreement"][SIZE]
    assert abs(found["cost_peer_rule"]) < 1e-8
    assert abs(found["cost"]) < 1e-6
    assert found["largest_difference"] < 1e-3
    assert abs(found["sigma_x"]) < 3e-5
    assert abs(found["sigma_z"]) < 3e-5


def test_skipped_without_the_generator(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sys.argv", ["against_ceres", *OPTIONS, "--generator", str(tmp_path)])
        against_ceres.main()
    assert "skipped: block generator not found" in capsys.readouterr().err


def test_differences_of_orientations_are_in_the_frame_of_their_sigma() -> None:
    """theta of R_other = R exp([theta]), positions apart, each over its sigma."""
    rng = np.random.default_rng(1)
    ours = np.column_stack([rng.normal(0.0, 0.3, (5, 3)), rng.normal(0.0, 100.0, (5, 3))])
    theta, shift = rng.normal(0.0, 1e-6, (5, 3)), rng.normal(0.0, 0.01, (5, 3))
    rotation = rotation_object_from_photo(ours[:, :3]) @ rotation_from_vector(theta)
    other = np.column_stack([angles_from_rotation(rotation), ours[:, 3:] + shift])
    sigma = np.array([1e-5, 2e-5, 3e-5, 0.1, 0.2, 0.3])
    expected = np.column_stack([theta, shift]) / sigma
    # rounding of angles near 1: 1e-16 / 1e-5
    np.testing.assert_allclose(
        orientation_differences(ours, other, np.tile(sigma, (5, 1))), expected, atol=1e-9
    )
