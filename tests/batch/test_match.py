"""A batch that matches chains first: which project is adjusted, and what is kept on --resume."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from splinebba_cli.batch.adjusting import adjust_task
from splinebba_cli.batch.outcome import Verdict
from splinebba_cli.batch.plan import Task
from splinebba_cli.batch.targets import find_projects
from splinebba_cli.batch.up_to_date import kept_outcome
from splinebba_cli.jobs.adjust_job import AdjustOptions
from splinebba_cli.output.result_json import load_result_json
from splinebba_cli.project.loading import load_project
from tests.batch.sample_copies import sample
from tests.labelled_chains import known_matching, street

OPTIONS = AdjustOptions(html=False, dispersion="none", match=True)


@pytest.fixture
def task(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Task:
    """A street to be matched and adjusted, by a matching that knows the truth."""
    project = street(tmp_path / "street")
    found = known_matching(load_project(project, "matching"))
    monkeypatch.setattr("splinebba_cli.core.matching.match.match", lambda *_, **__: found)
    return Task(Path("street/project.yaml"), Path("out/street/project.results"), tmp_path, OPTIONS)


def test_the_matched_project_is_adjusted_and_kept(task: Task) -> None:
    outcome = adjust_task(task)
    assert outcome.verdict is Verdict.accepted, outcome.problems
    assert (
        task.matched == Path("out/street/project.matched") and (task.matched_folder / "match.json").exists()
    )
    origin = load_result_json(task.result_folder)["provenance"]
    assert origin["project"]["file"] == "matched.yaml" and origin["options"]["match"] is True
    kept = kept_outcome(task)
    assert kept is not None and kept.up_to_date and kept.verdict is outcome.verdict
    assert kept_outcome(replace(task, options=replace(OPTIONS, match=False))) is None


@pytest.mark.parametrize("name", ["street/chains.csv", "out/street/project.matched/matched_points.csv"])
def test_changed_files_are_matched_and_adjusted_again(task: Task, name: str) -> None:
    adjust_task(task)
    path = task.folder / name
    path.write_bytes(path.read_bytes() + b"\n")
    assert kept_outcome(task) is None


def test_a_project_without_chains_is_adjusted_as_it_is(tmp_path: Path) -> None:
    sample(tmp_path / "block")
    task = Task(Path("block/project.yaml"), Path("block/project.results"), tmp_path, OPTIONS)
    assert adjust_task(task).verdict is Verdict.accepted
    assert not task.matched_folder.exists()
    assert kept_outcome(task) is not None


def test_too_little_matched_is_not_accepted_and_not_adjusted(task: Task) -> None:
    text = task.project_file.read_text(encoding="utf-8").replace("new_curves: true", "min_matched_share: 0.9")
    task.project_file.write_text(text, encoding="utf-8")
    found = known_matching(load_project(task.project_file, "matching"))
    assert found.network is not None
    outcome = adjust_task(task)
    assert outcome.verdict is Verdict.not_accepted and outcome.results == "out/street/project.matched"
    assert [problem.code for problem in outcome.problems if problem.severity == "error"] == ["SBB510"]
    assert outcome.acceptance[0]["criterion"] == "min_matched_share"
    assert not task.result_folder.exists()


def test_a_broken_project_is_told_as_always(task: Task) -> None:
    text = task.project_file.read_text(encoding="utf-8").replace("chains.csv", "nothing.csv")
    task.project_file.write_text(text, encoding="utf-8")
    outcome = adjust_task(task)
    assert outcome.verdict is Verdict.invalid
    assert [problem.code for problem in outcome.problems] == ["SBB401"]


def test_patterns_pass_over_what_match_has_written(task: Task, monkeypatch: pytest.MonkeyPatch) -> None:
    adjust_task(replace(task, results=Path("street/project.results")))
    monkeypatch.chdir(task.folder)
    assert find_projects(["**/*.yaml"]) == [Path("street/project.yaml")]
