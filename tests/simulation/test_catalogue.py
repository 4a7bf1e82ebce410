"""Simulated blocks as projects, and their truth."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from splinebba_cli.simulation.catalogue import KINDS, truth_data, write
from splinebba_cli.simulation.six_image_block import simulate_block


@pytest.mark.parametrize("kind", KINDS)
def test_writing_twice_gives_the_same_bytes(kind: str, tmp_path: Path) -> None:
    first, second = write(kind, tmp_path / "a", 7, 5.0), write(kind, tmp_path / "b", 7, 5.0)
    files = sorted(path.name for path in first.parent.iterdir())
    assert first.name in files and "truth.json" in files
    for name in files:
        assert (first.parent / name).read_bytes() == (second.parent / name).read_bytes()


def test_truth_is_in_the_frame_of_the_user(tmp_path: Path) -> None:
    path = write("strip", tmp_path, 7, 5.0)
    data = json.loads((path.parent / "truth.json").read_text(encoding="utf-8"))
    network, truth = simulate_block("strip", 7)
    assert data["format"] == "splinebba-truth/1"
    assert data["images"][2]["x"] == pytest.approx(truth.eop[2, 3] + 7_672_000.0, abs=1e-9)
    assert data["images"][2]["kappa"] == pytest.approx(np.degrees(truth.eop[2, 2]), abs=1e-12)
    assert [s["id"] for s in data["splines"]] == [c.id for c in network.curves]
    np.testing.assert_allclose(data["splines"][1]["values"], truth.curves[1] + network.origin, atol=1e-9)
    assert len(data["locations"]) == len(network.curve_observations)


def test_vectors_of_a_segment_are_not_shifted() -> None:
    """Of a free segment only a0 is a position; a1 to a3 are the same in every frame."""
    network, truth = simulate_block("six-image-singular")
    network.origin[:] = [1000.0, 2000.0, 0.0]
    values = truth_data("six-image-singular", 1, 5.0, network, truth)["splines"][0]["values"]
    assert values[0] == [4335.0, 6343.0, 52.0]
    assert values[1] == [70.5, 63.0, 8.0]
