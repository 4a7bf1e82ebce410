"""The result folder: all files of one adjustment, replaced in one step."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from numpy.typing import NDArray

from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.output.atomic import ReservedDirectory, reserve_directory
from splinebba_cli.output.columns import Table, TableFormat, write_table
from splinebba_cli.output.dispersion_file import dispersion_arrays, write_dispersion
from splinebba_cli.output.provenance import LoadedProject, provenance
from splinebba_cli.output.result_json import RESULT_FORMAT, result_json_text, result_to_dict
from splinebba_cli.output.tables import all_tables

DispersionChoice = Literal["full", "blocks", "none"]

_HEAD = 200  # characters in which the format of result.json stands
_OWN_FILES = frozenset({"result.json", "report.html", "report.txt", "dispersion.npz", "adjusted.yaml"})
_OWN_TABLES = frozenset(
    {
        "exterior_orientation",
        "points",
        "error_ellipses",
        "spline_coefficients",
        "spline_samples",
        "spline_locations",
        "residuals",
        "arc_residuals",
        "tangent_residuals",
        "distance_residuals",
        "prior_residuals",
        "group_tests",
        "systematic_effects",
        "rejections",
    }
)


@dataclass(frozen=True)
class Written:
    """What a result folder holds, for those who would else read it back."""

    content: dict[str, Any]  # of result.json
    tables: tuple[Table, ...]
    dispersion: Mapping[str, NDArray[Any]]  # of dispersion.npz; empty where it is not wanted


@contextmanager
def reserve_result_folder(directory: Path) -> Iterator[ReservedDirectory]:
    """Keep a result folder for this run, before anything is computed: whether it can be written, nobody else writes it.

    Raises
    ------
    OutputError
        SBB602 not a result folder, SBB606 another run writes it, SBB601, SBB604, SBB605, SBB607 cannot be written.
    """
    with reserve_directory(directory, is_result_folder) as place:
        yield place


def write_result_folder(
    place: ReservedDirectory,
    result: AdjustmentResult,
    *,
    loaded: LoadedProject,
    adjusted_files: Mapping[str, str],
    dispersion: DispersionChoice = "blocks",
    tables: TableFormat = "csv",
    reports: Callable[[Path, Written], object] | None = None,
    timings: Mapping[str, float] | None = None,
    options: Mapping[str, Any] | None = None,
) -> Written:
    """Write everything that `adjust` promises; the folder is the old one or the new one, never a mixture.

    Parameters
    ----------
    place : ReservedDirectory
        Replaced as a whole.  Files in it that are not the program's own are kept.
    result : AdjustmentResult
    loaded : LoadedProject
        Name, file and input hashes of the project.
    adjusted_files : mapping
        File name → text: ``adjusted.yaml`` and the tables that it refers to; a name may hold subfolders.
    dispersion : {"full", "blocks", "none"}
        What ``dispersion.npz`` holds; "none" writes no such file.
    tables : {"csv", "parquet"}
    reports : callable, optional
        Writes the reports into the new folder, whose path and content it gets, before that takes the place of the
        old one.
    timings : mapping, optional
        Seconds per stage, by default those of `result`.
    options : mapping, optional
        What was asked for besides the project, for the provenance.

    Returns
    -------
    Written
        What stands in the folder.

    Raises
    ------
    OutputError
        SBB601, SBB604, SBB605, SBB607: cannot be written; SBB406: pyarrow missing.
    """
    with place.replaced() as folder:
        origin = provenance(loaded, timings if timings is not None else result.timings, options)
        arrays = {} if dispersion == "none" else dispersion_arrays(result, full=dispersion == "full")
        written = Written(result_to_dict(result, origin), all_tables(result), arrays)
        _write(folder / "result.json", result_json_text(written.content))
        for table in written.tables:
            write_table(folder, table, tables)
        for name, text in adjusted_files.items():
            _write(_inside(folder, name), text)
        if arrays:
            write_dispersion(folder / "dispersion.npz", arrays)
        if reports is not None:
            reports(folder, written)
        _keep_foreign_files(place.final, folder, set(adjusted_files))
    return written


def is_result_folder(folder: Path) -> bool:
    """Whether a folder holds results of this program: a result.json that begins as ours."""
    try:
        with (folder / "result.json").open(encoding="utf-8") as stream:
            head = stream.read(_HEAD)
    except (OSError, UnicodeDecodeError):
        return False
    return re.match(rf'\{{\s*"format":\s*"{re.escape(RESULT_FORMAT)}"', head) is not None


def _inside(folder: Path, name: str) -> Path:
    path = (folder / name).resolve()
    if not path.is_relative_to(folder.resolve()):
        raise ValueError(f"{name!r} is outside of the result folder")
    return path


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8", newline="\n")


def _keep_foreign_files(old: Path, new: Path, written: set[str]) -> None:
    """Take over what people have put into the old folder: notes, plots."""
    if not old.is_dir():
        return
    own_tables = {f"{name}.{suffix}" for name in _OWN_TABLES for suffix in ("csv", "parquet")}
    own = _OWN_FILES | own_tables | {name.split("/")[0] for name in written}
    for entry in old.iterdir():
        if entry.name in own or entry.name.startswith("adjusted"):
            continue
        if entry.is_dir() and not entry.is_symlink():
            shutil.copytree(entry, new / entry.name, symlinks=True, copy_function=_link_or_copy)
        else:
            _link_or_copy(str(entry), str(new / entry.name))


def _link_or_copy(source: str, target: str) -> str:
    try:
        os.link(source, target, follow_symlinks=False)
    except OSError:
        shutil.copy2(source, target, follow_symlinks=False)
    return target
