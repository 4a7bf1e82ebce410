"""The result folder: all files of one adjustment, replaced in one step."""

from __future__ import annotations

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
from splinebba_cli.output.folder_files import begins_with_format, keep_foreign_files, write_inside
from splinebba_cli.output.provenance import LoadedProject, provenance
from splinebba_cli.output.result_json import RESULT_FORMAT, result_json_text, result_to_dict
from splinebba_cli.output.tables import all_tables

DispersionChoice = Literal["full", "blocks", "none"]

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
_OWN_TABLE_FILES = frozenset(f"{name}.{suffix}" for name in _OWN_TABLES for suffix in ("csv", "parquet"))


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
        write_inside(folder, "result.json", result_json_text(written.content))
        for table in written.tables:
            write_table(folder, table, tables)
        for name, text in adjusted_files.items():
            write_inside(folder, name, text)
        if arrays:
            write_dispersion(folder / "dispersion.npz", arrays)
        if reports is not None:
            reports(folder, written)
        keep_foreign_files(place.final, folder, _is_own)
    return written


def is_result_folder(folder: Path) -> bool:
    """Whether a folder holds results of this program: a result.json that begins as ours."""
    return begins_with_format(folder / "result.json", RESULT_FORMAT)


def _is_own(name: str) -> bool:
    """Whether a file of a result folder is the program's own."""
    return name in _OWN_FILES or name in _OWN_TABLE_FILES or name.startswith("adjusted")
