"""The folder of a matching: figures that add up, old or new as a whole, same input same bytes."""

from __future__ import annotations

import csv
import json
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

from splinebba_cli.core.matching.matches import Matches, MatchResult
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.errors import NotSolvableError, OutputError
from splinebba_cli.jobs import match_job
from splinebba_cli.jobs.match_job import MatchOptions, MatchOutcome, run_match
from splinebba_cli.output.json_text import json_text
from splinebba_cli.output.match_counts import MatchCounts
from splinebba_cli.output.match_folder import is_match_folder
from splinebba_cli.output.match_json import load_match_json, match_content
from splinebba_cli.output.provenance import provenance
from splinebba_cli.project.loading import LoadedProject, load_project
from splinebba_cli.project.match_schema import match_schema
from tests.labelled_chains import LOST, known_matching, street


@pytest.fixture(scope="module")
def loaded(tmp_path_factory: pytest.TempPathFactory) -> LoadedProject:
    return load_project(street(tmp_path_factory.mktemp("street")), "matching")


@pytest.fixture
def run(loaded: LoadedProject, monkeypatch: pytest.MonkeyPatch) -> Callable[..., MatchOutcome]:
    """The job with a matching that knows the truth."""
    monkeypatch.setattr("splinebba_cli.core.matching.match.match", lambda *_, **__: known_matching(loaded))
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")

    def job(output: Path, **options: Any) -> MatchOutcome:
        return run_match(loaded.path, MatchOptions(output=output, **options))

    return job


def content_of(result: MatchResult, smallest: float | None = None) -> dict[str, Any]:
    from splinebba_cli.core.matching.settings import MatchSettings

    return match_content(result, MatchSettings(), {}, smallest)


def test_figures_add_up(loaded: LoadedProject) -> None:
    result = known_matching(loaded)
    content = content_of(result)
    counts, images, splines = content["counts"], content["images"], content["splines"]
    matched = int((result.matches.curve >= 0).sum())
    assert counts["points"] == len(loaded.network.unlabelled) and counts["matched"] == matched
    assert counts["share"] == pytest.approx(matched / counts["points"])
    assert sum(content["reasons"].values()) == counts["points"] - matched
    for rows, key in ((images, "points"), (images, "matched"), (splines, "points")):
        whole = counts["points"] if (rows is images and key == "points") else matched
        assert sum(row[key] for row in rows) == whole
    parts = ("chains_matched_whole", "chains_matched_in_part", "chains_unmatched")
    assert sum(counts[part] for part in parts) == counts["chains"]
    assert sum(content["ambiguity"]["points"]) + content["ambiguity"]["alone"] == matched


@pytest.mark.parametrize("smallest", [None, 0.5])
def test_the_published_schema_holds(loaded: LoadedProject, smallest: float | None) -> None:
    """Every key of match.json is named in its schema, and of its kind."""
    content = match_content(known_matching(loaded), MatchSettings(), provenance(loaded), smallest)
    schema = match_schema()
    jsonschema.Draft202012Validator(schema).validate(json.loads(json_text(content)))
    for key in ("counts", "ambiguity"):
        assert set(content[key]) == set(schema["properties"][key]["properties"])
    for key in ("images", "splines", "history", "new_splines"):
        assert set(content[key][0]) == set(schema["properties"][key]["items"]["properties"])
    assert set(content) == set(schema["properties"])


def test_images_say_how_they_moved_and_whether_they_are_left(loaded: LoadedProject) -> None:
    result = known_matching(loaded)
    images = {image["id"]: image for image in content_of(result)["images"]}
    assert [id for id, image in images.items() if not image["in_matched_project"]] == [LOST]
    moved = np.linalg.norm(result.network.images.position - loaded.network.images.position, axis=1)
    assert images["2"]["moved_m"] == pytest.approx(moved[1])
    turn = result.network.images.rotation[1] @ loaded.network.images.rotation[1].T
    assert images["2"]["turned_deg"] == pytest.approx(np.degrees(np.arccos((np.trace(turn) - 1) / 2)))


def test_a_point_between_two_splines_is_a_close_decision(loaded: LoadedProject) -> None:
    result = known_matching(loaded)
    found = result.matches
    runner_up = np.full(len(found.curve), np.inf)
    row = int(np.flatnonzero(found.curve >= 0)[0])
    runner_up[row] = found.distance[row] * 1.01
    ambiguity = content_of(replace(result, matches=replace(found, runner_up=runner_up)))["ambiguity"]
    assert (ambiguity["close"], ambiguity["points"][-1], sum(ambiguity["points"])) == (1, 1, 1)


def test_points_taken_out_do_not_count(loaded: LoadedProject) -> None:
    result = known_matching(loaded)
    excluded = np.zeros(len(loaded.network.unlabelled), dtype=bool)
    excluded[np.flatnonzero(result.matches.curve < 0)[:5]] = True
    points = replace(loaded.network.unlabelled, excluded=excluded)
    content = content_of(replace(result, given=replace(loaded.network, unlabelled=points)))
    assert content["counts"]["excluded"] == 5
    assert content["counts"]["points"] == len(excluded) - 5
    assert content["counts"]["share"] == pytest.approx(
        MatchCounts(result).matched.sum() / (len(excluded) - 5)
    )


def test_a_chain_is_whole_without_the_points_taken_out(loaded: LoadedProject) -> None:
    result = known_matching(loaded)
    out = int(np.flatnonzero(result.matches.curve >= 0)[0])
    excluded = np.zeros(len(loaded.network.unlabelled), dtype=bool)
    excluded[out] = True
    curve = result.matches.curve.copy()
    curve[out] = -1
    given = replace(loaded.network, unlabelled=replace(loaded.network.unlabelled, excluded=excluded))
    found = replace(result, given=given, matches=replace(result.matches, curve=curve))
    whole = content_of(result)["counts"]["chains_matched_whole"]
    assert content_of(found)["counts"]["chains_matched_whole"] == whole


def test_a_share_below_the_limit_is_not_accepted(loaded: LoadedProject) -> None:
    share = MatchCounts(known_matching(loaded)).labelled_share
    for limit, status in ((share - 1e-6, "passed"), (share + 1e-6, "failed")):
        (criterion,) = content_of(known_matching(loaded), limit)["acceptance"]
        assert criterion["status"] == status


def test_matching_again_is_accepted_where_it_was_accepted_before(loaded: LoadedProject) -> None:
    """The second time only points without a label are left, and none of them finds a spline."""
    first = known_matching(loaded)
    share = MatchCounts(first).labelled_share
    left = first.matches.curve < 0
    nothing = replace(
        first.matches,
        **{field: getattr(first.matches, field)[left] for field in ("curve", "location", "distance")},
        **{field: getattr(first.matches, field)[left] for field in ("runner_up", "reason")},
    )
    again = replace(first, given=first.network, matches=nothing)
    for limit, status in ((share - 1e-6, "passed"), (share + 1e-6, "failed")):
        (criterion,) = content_of(again, limit)["acceptance"]
        assert criterion["status"] == status
    assert f", {len(first.network.curve_observations)} of them before" in criterion["message"]


def test_the_folder_has_everything(run: Callable[..., MatchOutcome], tmp_path: Path) -> None:
    done = run(tmp_path / "out")
    names = {path.name for path in done.directory.iterdir()}
    assert names >= {"match.json", "match.txt", "match.html", "matched.yaml", "matched_points.csv",
                     "matched_images.csv", "matched_chains.csv", "unmatched_points.csv", "chains.csv"}  # fmt: skip
    assert load_match_json(done.directory) == json.loads(json.dumps(done.content))
    assert done.accepted and is_match_folder(done.directory)


def test_chains_are_summed_up(
    run: Callable[..., MatchOutcome], loaded: LoadedProject, tmp_path: Path
) -> None:
    done = run(tmp_path / "out", html=False)
    with (done.directory / "chains.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == len(loaded.network.unlabelled.chain_ids)
    truth = json.loads(loaded.path.with_name("truth.json").read_text(encoding="utf-8"))
    known = {(each["image"], each["chain"]): each["spline"] or "" for each in truth["chains"]}
    for row in rows:
        found = known[row["image"], row["chain"]]
        expected = found if row["image"] != LOST and found.startswith("kerb") else ""
        assert (row["spline"], row["matched"] == row["points"]) == (expected, bool(expected))
        assert bool(row["reason"]) is not bool(expected)
    assert not (done.directory / "match.html").exists()


def test_the_same_input_gives_the_same_bytes(run: Callable[..., MatchOutcome], tmp_path: Path) -> None:
    first, second = (run(tmp_path / name / "out").directory for name in "ab")
    for path in sorted(first.iterdir()):
        assert path.read_bytes() == (second / path.name).read_bytes(), path.name


def test_other_people_s_files_stay_and_stale_ones_go(
    run: Callable[..., MatchOutcome], tmp_path: Path
) -> None:
    folder = run(tmp_path / "out").directory
    (folder / "note.txt").write_text("mine", encoding="utf-8")
    (folder / "matched.results").mkdir()
    (folder / "matched.results" / "result.json").write_text("{}", encoding="utf-8")
    (folder / "matched_chains_7.csv").write_text("stale", encoding="utf-8")
    run(tmp_path / "out")
    assert (folder / "note.txt").read_text(encoding="utf-8") == "mine"
    assert (folder / "matched.results" / "result.json").exists()  # of an adjustment
    assert not (folder / "matched_chains_7.csv").exists()


def test_a_folder_of_others_is_left_alone(run: Callable[..., MatchOutcome], tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "thesis.txt").write_text("mine", encoding="utf-8")
    with pytest.raises(OutputError) as caught:
        run(tmp_path / "out")
    assert caught.value.code == "SBB602"
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["thesis.txt"]


def test_nothing_matched_writes_nothing(
    loaded: LoadedProject, run: Callable[..., MatchOutcome], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    result = known_matching(loaded)
    count = len(loaded.network.unlabelled)
    nothing = np.full(count, np.nan)
    far = Matches(np.full(count, -1), nothing, nothing, nothing, np.ones(count, dtype=np.int64))
    empty = replace(result, network=loaded.network, matches=far)
    monkeypatch.setattr("splinebba_cli.core.matching.match.match", lambda *_, **__: empty)
    with pytest.raises(NotSolvableError) as caught:
        run(tmp_path / "out")
    assert caught.value.code == "SBB599" and f"({count} far)" in caught.value.message
    assert list(tmp_path.iterdir()) == []


def test_what_was_labelled_before_is_enough(loaded: LoadedProject) -> None:
    """Matching again a project in which nothing new is found is no error."""
    result = known_matching(loaded)
    count = Counter(result.matches.reason.tolist())
    assert count[0] > 0
    match_job.require_matches(
        replace(result, matches=replace(result.matches, curve=np.full_like(result.matches.curve, -1)))
    )


def test_options_override_the_project(
    loaded: LoadedProject, run: Callable[..., MatchOutcome], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    seen = []

    def spy(_: Any, settings: Any, **__: Any) -> MatchResult:
        seen.append(settings)
        return known_matching(loaded)

    monkeypatch.setattr("splinebba_cli.core.matching.match.match", spy)
    done = run(tmp_path / "out", new_curves=False, alpha=0.02, rounds=3, seed=8, html=False)
    (settings,) = seen
    assert (settings.new_curves, settings.alpha, settings.rounds, settings.seed) == (False, 0.02, 3, 8)
    assert settings.position_sigma_m == 0.6  # of the project
    assert done.content["provenance"]["options"]["seed"] == 8
    assert load_project(done.directory / "matched.yaml").match_settings == settings
