"""Input that is wrong as a whole is named: mirrored image coordinates, a σ that is far too large."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.matching.doubts import SMALL_MEDIAN, doubts
from splinebba_cli.core.matching.matches import MatchResult
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.project.loading import LoadedProject, load_project
from tests.labelled_chains import known_matching, street


@pytest.fixture(scope="module")
def loaded(tmp_path_factory: pytest.TempPathFactory) -> LoadedProject:
    return load_project(street(tmp_path_factory.mktemp("street")), "matching")


@pytest.fixture(scope="module")
def result(loaded: LoadedProject) -> MatchResult:
    return known_matching(loaded, lost="")


def settings_of(loaded: LoadedProject) -> MatchSettings:
    settings: MatchSettings = loaded.match_settings
    return settings


def with_nothing_matched(result: MatchResult, flip: tuple[float, float]) -> MatchResult:
    """What matching gives of a mirrored frame: nothing, or nearly so."""
    points = result.given.unlabelled
    mirrored = replace(result.given, unlabelled=replace(points, photo_xy=points.photo_xy * flip))
    none = replace(result.matches, curve=np.full(len(points), -1))
    return replace(result, given=mirrored, matches=none)


@pytest.mark.parametrize(
    ("flip", "word"),
    [((1.0, -1.0), "y mirrored"), ((-1.0, 1.0), "x mirrored"), ((-1.0, -1.0), "half a turn")],
    ids=["y", "x", "turned"],
)
def test_a_mirrored_frame_is_named(
    loaded: LoadedProject, result: MatchResult, flip: tuple[float, float], word: str
) -> None:
    (problem,) = doubts(with_nothing_matched(result, flip), settings_of(loaded))
    assert problem.code == "SBB336" and word in problem.message and "as given 0" in problem.message


def test_the_right_frame_is_not_doubted(loaded: LoadedProject, result: MatchResult) -> None:
    """Other frames bring nothing: little was matched for another reason."""
    assert doubts(with_nothing_matched(result, (1.0, 1.0)), settings_of(loaded)) == ()


def test_where_enough_is_matched_nothing_is_tried(
    loaded: LoadedProject, result: MatchResult, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delattr("splinebba_cli.core.matching.doubts.match_known_curves")
    assert doubts(result, settings_of(loaded)) == ()


@pytest.mark.parametrize(
    ("median", "said"), [(0.5 * SMALL_MEDIAN, True), (2.0 * SMALL_MEDIAN, False), (1e-6, False)]
)
def test_distances_that_are_too_small_for_their_sigma(
    loaded: LoadedProject, result: MatchResult, median: float, said: bool
) -> None:
    near = replace(
        result, matches=replace(result.matches, distance=np.full(len(result.matches.curve), median))
    )
    assert [problem.code for problem in doubts(near, settings_of(loaded))] == (["SBB337"] if said else [])
