"""Runs that are ended at random moments leave the old or the new results; the long version is the command."""

from __future__ import annotations

import signal
import sys

import pytest

from benchmarks.kill_nine import Scene, digest, strike

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    return Scene.set_up(tmp_path_factory.mktemp("kill"), "strip", html=False)


@pytest.mark.parametrize(
    ("number", "runs", "codes"),
    [
        (signal.SIGKILL, 6, {-9}),
        (signal.SIGINT, 4, {130, -signal.SIGINT}),  # the second: before the program has begun
    ],
)
def test_folders_stay_whole(scene: Scene, number: int, runs: int, codes: set[int]) -> None:
    tally = strike(scene, runs, 4, number)
    assert tally.faults == 0, tally
    assert tally.kills and set(tally.codes) <= codes, tally
    assert tally.found["old"] + tally.found["new"] == runs


def test_a_mixture_would_be_seen(scene: Scene) -> None:
    before = digest(scene.target)
    table = scene.target / "residuals.csv"
    content = table.read_bytes()
    table.write_bytes(content[: len(content) // 2])
    assert digest(scene.target) != before
    table.write_bytes(content)
    assert digest(scene.target) == before
