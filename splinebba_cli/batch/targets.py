"""The projects that targets name: files, folders with a project.yaml, patterns such as ``blocks/**/project.yaml``."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterable, Sequence
from pathlib import Path

from splinebba_cli.errors import ProjectError
from splinebba_cli.output.match_folder import is_match_folder
from splinebba_cli.output.result_folder import is_result_folder
from splinebba_cli.project.diagnostics import Diagnostic
from splinebba_cli.project.file_content import PROJECT_FILE

_SUFFIXES = (".yaml", ".yml")


class TargetError(ProjectError):
    """Targets name no project, or results have no place; carries everything that is wrong."""

    subject = "the targets"


def find_projects(targets: Sequence[str]) -> list[Path]:
    """Project files of all targets, each once, in the order of the targets.

    Parameters
    ----------
    targets : sequence of str
        A project file; a folder that holds ``project.yaml``; a pattern with ``*``, ``?``, ``[…]`` or ``**``, whose
        matches are taken in alphabetical order where they are project files or folders with one.  Folders that
        `adjust` or `match` wrote are left out.

    Returns
    -------
    list of Path
        Relative to the working directory where they lie inside of it, else absolute.

    Raises
    ------
    TargetError
        SBB810 for every target that names no project.
    """
    found: dict[Path, Path] = {}  # where it really is → as it is shown
    wrong: list[Diagnostic] = []
    for target in targets:
        path = Path(target)
        if path.is_dir() and not (path / PROJECT_FILE).is_file():
            help = f"give the project file, or all of them below as '{target.rstrip('/')}/**/{PROJECT_FILE}'"
            wrong.append(_no_project(f"folder `{target}` holds no {PROJECT_FILE}", help))
        elif path.exists():
            files = [path / PROJECT_FILE if path.is_dir() else path]
            found.update((file.resolve(), _shown(file)) for file in files if file.resolve() not in found)
        elif glob.has_magic(target):
            files = list(_matches(target))
            if not files:
                wrong.append(_no_project(f"no project matches `{target}`", _about_patterns(target)))
            found.update((file.resolve(), _shown(file)) for file in files if file.resolve() not in found)
        else:
            wrong.append(
                _no_project(f"`{target}` does not exist", "names are relative to the working directory")
            )
    if wrong:
        raise TargetError(wrong)
    return list(found.values())


def _matches(pattern: str) -> Iterable[Path]:
    """Project files that match, alphabetically."""
    for match in sorted(glob.glob(pattern, recursive=True)):
        path = Path(match)
        file = path / PROJECT_FILE if path.is_dir() else path
        if file.suffix.lower() in _SUFFIXES and file.is_file() and not _is_derived(file.parent):
            yield file


def _is_derived(folder: Path) -> bool:
    """Whether the projects in a folder were written by `adjust` or `match`."""
    return is_result_folder(folder) or is_match_folder(folder)


def _about_patterns(pattern: str) -> str:
    if "**" in pattern:
        return "relative to the working directory; matches are project files, or folders with a project.yaml"
    return f"`**` matches any depth of folders: '**/{PROJECT_FILE}'"


def _shown(file: Path) -> Path:
    """Relative to the working directory where the file lies inside of it, else absolute; without `..`."""
    whole, here = Path(os.path.abspath(file)), Path.cwd()
    return whole.relative_to(here) if whole.is_relative_to(here) else whole


def _no_project(message: str, help: str) -> Diagnostic:
    return Diagnostic("SBB810", "error", message, help)
