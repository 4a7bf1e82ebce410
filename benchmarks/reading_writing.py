"""What reading a project and writing its results cost, against plain readers and writers of the same numbers.

    python -m benchmarks.reading_writing FOLDER [--repeats 5] [--adjust]

FOLDER is a project of :mod:`benchmarks.bench_project`. Reading, validating and building the network is held against
``pyarrow.csv.read_csv`` and ``numpy.loadtxt`` (numbers only) of its largest table alone. With ``--adjust`` the project
is adjusted once and its results are written, file by file; residuals.csv against ``pyarrow.csv.write_csv`` and
``numpy.savetxt`` of its columns of numbers. Least CPU seconds of the repeats.
"""

from __future__ import annotations

import argparse
import gc
import resource
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from splinebba_cli.__main__ import COLLECT_AFTER
from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.output.columns import Table, write_table
from splinebba_cli.output.dispersion_file import dispersion_arrays, write_dispersion
from splinebba_cli.output.result_folder import Written
from splinebba_cli.output.result_json import result_json_text, result_to_dict
from splinebba_cli.output.tables import all_tables
from splinebba_cli.project.adjusted import adjusted_project
from splinebba_cli.project.loading import LoadedProject, load_project
from splinebba_cli.report.build import write_reports
from splinebba_cli.report.result_data import ResultData


def cpu(work: Callable[[], Any], repeats: int) -> float:
    """Least CPU seconds of some runs."""
    found = []
    for _ in range(repeats):
        start = time.process_time()
        work()
        found.append(time.process_time() - start)
    return min(found)


def reading(folder: Path, repeats: int) -> None:
    import pyarrow.csv

    path = folder / "spline_observations.csv"
    ours = cpu(lambda: load_project(folder), repeats)
    arrow = cpu(lambda: pyarrow.csv.read_csv(path), repeats)
    columns = (2, 3, 4)
    loadtxt = cpu(lambda: np.loadtxt(path, delimiter=",", skiprows=1, usecols=columns), repeats)
    print(f"read, validate, build     {ours:7.3f} s")
    print(f"pyarrow.csv.read_csv      {arrow:7.3f} s   ratio {ours / arrow:5.2f}  (largest table alone)")
    print(f"numpy.loadtxt             {loadtxt:7.3f} s   ratio {ours / loadtxt:5.2f}  (its numbers alone)")


def numbers_of(table: Table) -> dict[str, Any]:
    return {c.name: np.asarray(c.values) for c in table.columns if isinstance(c.values, np.ndarray)}


def writing(loaded: LoadedProject, result: AdjustmentResult, repeats: int) -> None:
    import pyarrow
    import pyarrow.csv

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        total = 0.0

        def shown(what: str, work: Callable[[], Any]) -> float:
            nonlocal total
            seconds = cpu(work, repeats)
            total += seconds
            print(f"{what:25s} {seconds:7.3f} s")
            return seconds

        shown("content of result.json", lambda: result_to_dict(result))
        content = result_to_dict(result)
        shown("text of result.json", lambda: result_json_text(content))
        shown("tables as arrays", lambda: all_tables(result))
        tables = all_tables(result)
        took = {
            table.name: shown(f"{table.name}.csv", lambda table=table: write_table(folder, table, "csv"))
            for table in tables
        }
        shown("adjusted.yaml", lambda: adjusted_project(loaded, result, folder))
        path = folder / "dispersion.npz"
        shown("dispersion.npz", lambda: write_dispersion(path, dispersion_arrays(result, full=False)))
        data = Written(content, tables, {})
        shown("report.txt", lambda: write_reports(folder, ResultData.of(data), ["text"]))
        print(f"{'all':25s} {total:7.3f} s")
        (residuals,) = (table for table in tables if table.name == "residuals")
        columns = numbers_of(residuals)
        plain = pyarrow.table(columns)
        arrow = cpu(lambda: pyarrow.csv.write_csv(plain, folder / "a.csv"), repeats)
        matrix = np.column_stack(list(columns.values()))
        savetxt = cpu(lambda: np.savetxt(folder / "b.csv", matrix, fmt="%.7f", delimiter=","), 1)
        ours = took["residuals"]
        print(f"residuals.csv against pyarrow.csv.write_csv: {ours:.3f} / {arrow:.3f} s = {ours / arrow:.2f}")
        print(
            f"residuals.csv against numpy.savetxt:         {ours:.3f} / {savetxt:.3f} s = {ours / savetxt:.2f}"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--adjust", action="store_true")
    arguments = parser.parse_args()
    gc.set_threshold(COLLECT_AFTER, 20, 50)  # as the program does
    reading(arguments.folder, arguments.repeats)
    if arguments.adjust:
        loaded = load_project(arguments.folder)
        writing(loaded, adjust(loaded.network), arguments.repeats)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"peak memory {peak:.0f} MiB")


if __name__ == "__main__":
    main()
