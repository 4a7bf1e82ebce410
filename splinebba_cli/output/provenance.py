"""Where a result comes from: program, libraries, platform, options, input files with their hashes, time.

Everything that changes from run to run is in the one block ``timestamps``; the environment variable
``SOURCE_DATE_EPOCH`` (seconds since 1970) freezes it.
"""

from __future__ import annotations

import os
import platform
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path, PurePath
from typing import Any, Protocol

from splinebba_cli.errors import UsageError


class LoadedProject(Protocol):
    """What is needed of a loaded project."""

    @property
    def path(self) -> Path:
        """The project file, as the user gave it."""

    @property
    def name(self) -> str:
        """Name of the project."""

    @property
    def source_hashes(self) -> dict[str, str]:
        """File name → sha256, the project file and its side tables."""


def provenance(
    loaded: LoadedProject,
    timings: Mapping[str, float] | None = None,
    options: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """The ``provenance`` part of result.json.

    Parameters
    ----------
    loaded : LoadedProject
    timings : mapping, optional
        Seconds per stage.
    options : mapping, optional
        What was asked for besides the project, JSON types only.

    Returns
    -------
    dict
        File names are relative to the project's folder: results do not tell about the machine's folders.
    """
    from importlib.metadata import version

    import splinebba_cli

    names = {_name(file, loaded.path): digest for file, digest in loaded.source_hashes.items()}
    return {
        "project": {"name": loaded.name, "file": loaded.path.name},
        "program": {"name": "splinebba", "version": splinebba_cli.__version__},
        "libraries": {
            "python": platform.python_version(),
            "numpy": version("numpy"),
            "scipy": version("scipy"),
        },
        "platform": f"{platform.system()} {platform.machine()}",
        "options": dict(options or {}),
        "inputs": [{"file": name, "sha256": names[name]} for name in sorted(names)],
        "timestamps": _timestamps(timings or {}),
    }


def _name(file: str, project: Path) -> str:
    """The file relative to the project's folder where it is inside of it, else as the user gave it."""
    folder = project.parent
    path = Path(file)
    if path.is_absolute():
        for base in (folder, folder.resolve()):
            if path.is_relative_to(base):
                return path.relative_to(base).as_posix()
    elif folder != Path() and path.is_relative_to(folder):
        return path.relative_to(folder).as_posix()
    return PurePath(file).as_posix()


def _timestamps(timings: Mapping[str, float]) -> dict[str, Any]:
    frozen = os.environ.get("SOURCE_DATE_EPOCH")
    if frozen is not None:
        try:
            moment = datetime.fromtimestamp(int(frozen), UTC)
        except (ValueError, OverflowError, OSError) as error:
            raise UsageError("SBB900", f"SOURCE_DATE_EPOCH is not a number of seconds: {frozen!r}") from error
        return {"written": moment.strftime("%Y-%m-%dT%H:%M:%SZ"), "timings_s": {}}
    return {
        "written": datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ"),
        "timings_s": {stage: round(seconds, 3) for stage, seconds in timings.items()},
    }
