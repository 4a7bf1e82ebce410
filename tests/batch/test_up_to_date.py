"""Results are kept where program, options and all files are the same, and in no other case."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from splinebba_cli.batch import up_to_date
from splinebba_cli.batch.adjusting import adjust_task
from splinebba_cli.batch.outcome import Outcome, Verdict
from splinebba_cli.batch.plan import Task
from splinebba_cli.batch.up_to_date import kept_outcome, kept_outcomes
from splinebba_cli.jobs.adjust_job import AdjustOptions
from tests.batch.sample_copies import not_accepted


@pytest.fixture(scope="module")
def adjusted(tmp_path_factory: pytest.TempPathFactory) -> tuple[Task, Outcome]:
    """A project with results."""
    folder = tmp_path_factory.mktemp("batch")
    project = not_accepted(folder / "block").relative_to(folder)
    task = Task(project, Path("out/project.results"), folder, AdjustOptions(html=False))
    return task, adjust_task(task)


def test_the_kept_outcome_is_that_of_the_adjustment(adjusted: tuple[Task, Outcome]) -> None:
    task, outcome = adjusted
    assert outcome.verdict is Verdict.not_accepted and outcome.seconds > 0.0
    assert outcome.problems[0].position.startswith("block/project.yaml:")
    assert kept_outcomes([task]) == [replace(outcome, up_to_date=True, seconds=0.0)]


@pytest.mark.parametrize(
    "options", [{"dispersion": "full"}, {"tables": "parquet"}, {"outliers": "huber"}, {"html": True}]
)
def test_other_options(adjusted: tuple[Task, Outcome], options: dict[str, object]) -> None:
    task, _ = adjusted
    assert kept_outcome(replace(task, options=replace(task.options, **options))) is None  # type: ignore[arg-type]


def test_another_program(adjusted: tuple[Task, Outcome], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(up_to_date, "__version__", "0.0.9")
    assert kept_outcome(adjusted[0]) is None


@pytest.mark.parametrize("name", ["project.yaml", "images.csv", "spline_observations.csv"])
def test_changed_and_missing_files(adjusted: tuple[Task, Outcome], name: str) -> None:
    task, _ = adjusted
    path = task.project_file.with_name(name)
    content = path.read_bytes()
    try:
        path.write_bytes(content + b"\n")
        assert kept_outcome(task) is None
        path.unlink()
        assert kept_outcome(task) is None
    finally:
        path.write_bytes(content)
    assert kept_outcome(task) is not None


def test_a_table_that_has_become_a_pipe(adjusted: tuple[Task, Outcome]) -> None:
    task, _ = adjusted
    path = task.project_file.with_name("images.csv")
    content = path.read_bytes()
    try:
        path.unlink()
        os.mkfifo(path)
        assert kept_outcome(task) is None
    finally:
        path.unlink()
        path.write_bytes(content)


def edited(change: Callable[[Any], object], part: str | None = "provenance") -> Callable[[str], str]:
    """An edit of a part of result.json, or of all of it."""

    def edit(text: str) -> str:
        data = json.loads(text)
        change(data if part is None else data[part])
        return json.dumps(data)

    return edit


@pytest.mark.parametrize(
    "edit",
    [
        lambda text: text[: len(text) // 2],
        lambda text: text.replace("splinebba-result/1", "splinebba-result/0"),
        edited(lambda provenance: provenance.pop("options")),
        edited(lambda provenance: provenance.pop("inputs")),
        edited(lambda provenance: provenance.clear()),
        edited(lambda provenance: provenance.update(inputs=3)),
        edited(lambda content: content.pop("provenance"), None),
        edited(lambda content: content.update(provenance=[]), None),
        edited(lambda content: content.pop("statistics"), None),
        edited(lambda content: content.update(acceptance=[{}]), None),
        edited(lambda content: content.update(problems=[{"code": "SBB520"}]), None),
    ],
)
def test_other_results(adjusted: tuple[Task, Outcome], edit: Callable[[str], str]) -> None:
    task, _ = adjusted
    path = task.result_folder / "result.json"
    text = path.read_text(encoding="utf-8")
    try:
        path.write_text(edit(text), encoding="utf-8")
        assert kept_outcome(task) is None
    finally:
        path.write_text(text, encoding="utf-8")


def test_results_of_another_project(adjusted: tuple[Task, Outcome]) -> None:
    task, _ = adjusted
    other = task.project_file.with_name("other.yaml")
    other.write_bytes(task.project_file.read_bytes())
    assert kept_outcome(replace(task, project=task.project.with_name("other.yaml"))) is None
    assert kept_outcome(replace(task, results=Path("nowhere"))) is None
