"""Where the results of every project of a batch go."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from splinebba_cli.batch.targets import TargetError
from splinebba_cli.jobs.adjust_job import AdjustOptions, default_output
from splinebba_cli.jobs.matched_adjust_job import match_folder
from splinebba_cli.project.diagnostics import Diagnostic


@dataclass(frozen=True)
class Task:
    """One project to adjust: what a worker is told.

    Attributes
    ----------
    project, results : Path
        Project file and result folder as the user sees them, relative to `folder` where they lie inside of it.
    folder : Path
        Working directory of the batch, absolute.
    options : AdjustOptions
        Without the result folder.
    """

    project: Path
    results: Path
    folder: Path
    options: AdjustOptions

    @property
    def project_file(self) -> Path:
        """The project file, absolute."""
        return self.folder / self.project

    @property
    def result_folder(self) -> Path:
        """The result folder, absolute."""
        return self.folder / self.results

    @property
    def matched(self) -> Path:
        """The folder of the matching as the user sees it, beside the results."""
        return match_folder(self.results)

    @property
    def matched_folder(self) -> Path:
        """The folder of the matching, absolute."""
        return self.folder / self.matched

    def data(self) -> dict[str, Any]:
        """JSON types only."""
        options = {key: value for key, value in asdict(self.options).items() if key != "output"}
        return {
            "project": str(self.project),
            "results": str(self.results),
            "folder": str(self.folder),
            "options": options,
        }

    @classmethod
    def of_data(cls, data: dict[str, Any]) -> Task:
        """The task that :meth:`data` describes."""
        project, results, folder = (Path(data[key]) for key in ("project", "results", "folder"))
        return cls(project, results, folder, AdjustOptions(**data["options"]))


def plan(projects: Sequence[Path], options: AdjustOptions) -> list[Task]:
    """A task for every project.

    Parameters
    ----------
    projects : sequence of Path
        From :func:`~splinebba_cli.batch.targets.find_projects`.
    options : AdjustOptions
        ``output``: one folder for all results, in which every project has the place that it has below the working
        directory (``DIR/blocks/a/project.results``); without it results lie beside their projects.

    Raises
    ------
    TargetError
        SBB811, if results of two projects would come into the same folder or one into the other.
    """
    plain = replace(options, output=None)
    tasks = [Task(project, _results(project, options.output), Path.cwd(), plain) for project in projects]
    wrong = list(_collisions(tasks))
    if wrong:
        raise TargetError(wrong)
    return tasks


def _results(project: Path, output: Path | None) -> Path:
    beside = default_output(project)
    return beside if output is None else output / beside.relative_to(beside.anchor)


def _collisions(tasks: Iterable[Task]) -> Iterable[Diagnostic]:
    """One for every task whose results would come into the folder of another one, or into a folder inside of it."""
    taken: dict[Path, Task] = {}
    for task in tasks:
        place = Path(os.path.realpath(task.result_folder))
        if place in taken:
            yield _collision(task, taken[place])
        else:
            taken[place] = task
    for place, task in taken.items():
        yield from (_collision(task, taken[folder]) for folder in place.parents if folder in taken)


def _collision(task: Task, other: Task) -> Diagnostic:
    message = (
        f"results of `{task.project}` would come into `{other.results}`, where those of `{other.project}` go"
    )
    help = "rename one of the project files, or adjust them in two runs with different --output"
    return Diagnostic("SBB811", "error", message, help)
