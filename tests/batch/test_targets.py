"""Which projects targets name, and where their results go."""

from __future__ import annotations

from pathlib import Path

import pytest

from splinebba_cli.batch.plan import Task, plan
from splinebba_cli.batch.targets import TargetError, find_projects
from splinebba_cli.jobs.adjust_job import AdjustOptions


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working directory with projects, tables, results and a folder without a project."""
    files = ["blocks/b/project.yaml", "blocks/a/project.yaml", "blocks/a/deep/project.yaml", "single.yml"]
    for name in [
        *files,
        "blocks/a/images.csv",
        "blocks/empty/notes.txt",
        "blocks/a/project.results/adjusted.yaml",
    ]:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("version: 1\n")
    (tmp_path / "blocks/a/project.results/result.json").write_text('{"format": "splinebba-result/1"}')
    monkeypatch.chdir(tmp_path)
    return tmp_path


def found(*targets: str) -> list[str]:
    return [path.as_posix() for path in find_projects(targets)]


def test_files_folders_and_patterns(here: Path) -> None:
    assert found("single.yml") == ["single.yml"]
    assert found("blocks/b") == found("blocks/b/") == ["blocks/b/project.yaml"]
    assert found("blocks/*") == ["blocks/a/project.yaml", "blocks/b/project.yaml"]
    deep = ["blocks/a/deep/project.yaml", "blocks/a/project.yaml", "blocks/b/project.yaml"]
    assert found("blocks/**/project.yaml") == found("blocks/**/*.yaml") == deep
    assert found(str(here / "blocks" / "b")) == ["blocks/b/project.yaml"]


def test_projects_outside_of_the_working_directory(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(here / "blocks" / "a")
    assert found("../b", "deep") == [(here / "blocks/b/project.yaml").as_posix(), "deep/project.yaml"]


def test_each_project_once_in_the_order_of_the_targets(here: Path) -> None:
    (here / "link.yaml").symlink_to(here / "blocks/a/project.yaml")
    same = found("blocks/b", "link.yaml", "blocks/*", "blocks/a/../a/project.yaml")
    assert same == ["blocks/b/project.yaml", "link.yaml"]


def test_all_wrong_targets_at_once(here: Path) -> None:
    with pytest.raises(TargetError) as caught:
        find_projects(
            ["single.yml", "nowhere.yaml", "blocks/empty", "blocks/*.yaml", "nothing/**/project.yaml"]
        )
    messages = [item.message for item in caught.value.diagnostics]
    assert [item.code for item in caught.value.diagnostics] == ["SBB810"] * 4
    for message, name in zip(
        messages, ("nowhere.yaml", "blocks/empty", "blocks/*.yaml", "nothing/**/project.yaml"), strict=True
    ):
        assert f"`{name}`" in message
    assert "'blocks/empty/**/project.yaml'" in caught.value.diagnostics[1].help


def test_a_file_whose_name_looks_like_a_pattern(here: Path) -> None:
    (here / "block[1].yaml").write_text("version: 1\n")
    assert found("block[1].yaml") == ["block[1].yaml"]


def results(*targets: str, output: str | None = None) -> list[str]:
    options = AdjustOptions(output=None if output is None else Path(output))
    return [task.results.as_posix() for task in plan(find_projects(targets), options)]


def test_results_keep_the_places_of_their_projects(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert results("blocks/a", "single.yml") == ["blocks/a/project.results", "single.results"]
    assert results("blocks/a", "single.yml", output="out") == [
        "out/blocks/a/project.results", "out/single.results",
    ]  # fmt: skip
    assert results("blocks/a", output="out") == ["out/blocks/a/project.results"]  # alone or with others
    monkeypatch.chdir(here / "blocks" / "b")
    outside = (here / "blocks/a/project.results").as_posix().lstrip("/")
    assert results("../a", output="out") == [f"out/{outside}"]


def test_two_results_in_one_place_are_refused(here: Path) -> None:
    (here / "single.yaml").write_text("version: 1\n")
    with pytest.raises(TargetError) as caught:
        results("single.yml", "single.yaml", "blocks/b", output="out")
    (item,) = caught.value.diagnostics
    assert item.code == "SBB811"
    assert (
        "`single.yaml`" in item.message
        and "`single.yml`" in item.message
        and "`out/single.results`" in item.message
    )
    inside = here / "blocks.results" / "inside"
    inside.mkdir(parents=True)
    (inside / "project.yaml").write_text("version: 1\n")
    (here / "blocks.yaml").write_text("version: 1\n")
    with pytest.raises(TargetError):
        results("blocks.results/inside", "blocks.yaml")


def test_a_task_survives_json(here: Path) -> None:
    (task,) = plan(
        find_projects(["single.yml"]), AdjustOptions(Path("out"), "full", "parquet", "huber", html=False)
    )
    assert Task.of_data(task.data()) == task
    assert task.options.output is None
    assert (task.project_file, task.result_folder) == (here / "single.yml", here / "out" / "single.results")
