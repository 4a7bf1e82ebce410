"""The synthetic aerial block of the benchmark, as a project: ``python -m benchmarks.bench_project BLOCK.npz FOLDER``.

The project loads to the network of :func:`benchmarks.bench_block.network_from_npz`, its control splines first:
angles in radians, local origin 0, all digits of every number, approximate locations of all measured points.
Tables are written a hundred thousand rows at a time.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from benchmarks.bench_block import FORMAT_MM
from splinebba_cli.project.model_images import EOP_KEYS
from splinebba_cli.project.yaml_writing import project_yaml

Format = Literal["csv", "parquet"]
Columns = Mapping[str, NDArray[Any]]
ROWS_AT_ONCE = 100_000
_ORDER = [3, 4, 5, 0, 1, 2]  # of the archive's omega, phi, kappa, X0, Y0, Z0


def write_project(npz: str | Path, folder: str | Path, fmt: Format = "csv") -> Path:
    """Write ``project.yaml`` and its tables; the path of the project file.

    Parameters
    ----------
    npz : path of an archive of the block generator
    folder : made if it does not exist
    fmt : format of the tables
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    with np.load(npz) as archive:
        data: dict[str, Any] = {name: archive[name] for name in archive.files}
    tables = {"images": _images(data), **_splines(data), **_points(data), **_observations(data)}
    write = _write_parquet if fmt == "parquet" else _write_csv
    for name, columns in tables.items():
        write(folder / f"{name}.{fmt}", columns)
    path = folder / "project.yaml"
    path.write_text(project_yaml(_project(data, tables, fmt)), encoding="utf-8")
    return path


def _project(data: dict[str, Any], tables: Mapping[str, Columns], fmt: Format) -> dict[str, Any]:
    def table(name: str) -> dict[str, str]:
        return {"table": f"{name}.{fmt}"}

    sigma = {"sigma_mm": float(data["sigma"])}
    splines = []
    if "control_knots" in tables:
        head = {"role": "control", "parameterization": "uniform", "sigma": "fixed"}
        splines.append({**head, **table("control_knots")})
    if "knots" in tables:
        head = {"role": "partial", "parameterization": "uniform", "sigma": float(data["knot_sigma"])}
        splines.append({**head, **table("knots")})
    observations = {"spline_points": [{**table("spline_observations"), **sigma}]}
    out = {
        "version": 1,
        "project": {
            "name": f"block-{len(data['eop0'])}",
            "angle_unit": "rad",
            "rotation_sequence": "omega-phi-kappa",
            "local_origin": [0.0, 0.0, 0.0],
        },
        "cameras": [
            {
                "id": "camera",
                "principal_distance_mm": float(data["f"]),
                "image_coordinates": "photo_mm",
                "format_mm": list(FORMAT_MM),
            }
        ],
        "images": {"camera": "camera", **table("images")},
        "splines": splines,
    }
    if "points" in tables:
        out["points"] = {"role": "tie", **table("points")}
        observations["points"] = [{**table("point_observations"), **sigma}]
    return {**out, "observations": observations}


def _images(data: dict[str, Any]) -> Columns:
    count = len(data["eop0"])
    given = (
        ("", data["eop0"]),
        ("prior_", data["eop_prior"]),
        ("sigma_", np.tile(data["eop_sigma"], (count, 1))),
    )
    columns = {
        prefix + key: values[:, column]
        for prefix, values in given
        for key, column in zip(EOP_KEYS, _ORDER, strict=True)
    }
    return {"image": np.arange(count), **columns}


def _splines(data: dict[str, Any]) -> dict[str, Columns]:
    """Tables of the fixed splines and of the others; the rows of one spline in their order."""
    knots, fixed = data["knots0"], np.asarray(data["fixed"], dtype=bool)
    out = {}
    for name, numbers in (("control_knots", np.flatnonzero(fixed)), ("knots", np.flatnonzero(~fixed))):
        if len(numbers):
            xyz = knots[numbers].reshape(-1, 3)
            spline = np.repeat(numbers, knots.shape[1])
            out[name] = {"spline": spline, **{axis: xyz[:, i] for i, axis in enumerate("xyz")}}
    return out


def _points(data: dict[str, Any]) -> dict[str, Columns]:
    xyz, measured = data["tie0"].reshape(-1, 3), data["tie_xy"].reshape(-1, 2)
    if not len(xyz):
        return {}
    return {
        "points": {"point": np.arange(len(xyz)), **{axis: xyz[:, i] for i, axis in enumerate("xyz")}},
        "point_observations": {
            "image": data["tie_img"],
            "point": data["tie_pt"],
            "x": measured[:, 0],
            "y": measured[:, 1],
        },
    }


def _observations(data: dict[str, Any]) -> dict[str, Columns]:
    columns = {
        "image": data["img"],
        "spline": data["spl"],
        "x": data["xy"][:, 0],
        "y": data["xy"][:, 1],
        "location": data["seg"] + data["t0"],
    }
    return {"spline_observations": columns}


def _chunks(columns: Columns) -> Iterator[dict[str, NDArray[Any]]]:
    rows = len(next(iter(columns.values())))
    for first in range(0, rows, ROWS_AT_ONCE):
        yield {name: values[first : first + ROWS_AT_ONCE] for name, values in columns.items()}


def _write_csv(path: Path, columns: Columns) -> None:
    with path.open("w", encoding="utf-8", newline="") as stream:
        stream.write(",".join(columns) + "\n")
        for chunk in _chunks(columns):
            texts = [map(repr, values.tolist()) for values in chunk.values()]
            stream.write("\n".join(map(",".join, zip(*texts, strict=True))) + "\n")


def _write_parquet(path: Path, columns: Columns) -> None:
    """Identifiers as texts, encoded by a dictionary."""
    import pyarrow
    from pyarrow import parquet

    def arrow(values: NDArray[Any]) -> Any:
        if values.dtype.kind == "f":
            return pyarrow.array(values)
        return pyarrow.array(values).cast(pyarrow.string()).dictionary_encode()

    writer = None
    for chunk in _chunks(columns):
        table = pyarrow.table({name: arrow(values) for name, values in chunk.items()})
        if writer is None:
            writer = parquet.ParquetWriter(path, table.schema, compression="zstd")
        writer.write_table(table)
    if writer is not None:
        writer.close()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("npz")
    parser.add_argument("folder")
    parser.add_argument("--format", choices=["csv", "parquet"], default="csv")
    arguments = parser.parse_args()
    print(write_project(arguments.npz, arguments.folder, arguments.format))


if __name__ == "__main__":
    main()
