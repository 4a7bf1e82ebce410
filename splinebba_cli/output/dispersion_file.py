"""dispersion.npz: covariances with the names of their rows, in metres and degrees.

``numpy.load`` opens it.  The zip members carry no time, so the same numbers give the same bytes.
"""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.quality.curve_columns import CurveColumns
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.output.tables import ANGLES, EOP_NAMES

DISPERSION_FORMAT = "splinebba-dispersion/1"


def dispersion_arrays(result: AdjustmentResult, *, full: bool) -> dict[str, NDArray[Any]]:
    """Arrays of the file, by name.

    Returns
    -------
    dict
        ``image_ids`` (m,), ``image_parameters`` (6,), ``image_units`` (6,), ``image_dispersion`` (m, 6, 6);
        ``point_ids`` (n,), ``point_dispersion`` (n, 3, 3) m²;
        ``spline_value_names`` (k,) "spline id value number", ``spline_value_dispersion`` (k, 3, 3) m²;
        with `full` also ``names`` (N,), ``units`` (N,), ``matrix`` (N, N).

    Raises
    ------
    ValueError
        If the full matrix is asked for but was not computed.
    """
    scale = np.where(np.arange(6) < 3, 180.0 / np.pi, 1.0)
    curves = CurveColumns.of(result.curves)
    counts = np.diff(curves.value_bounds).tolist()
    names = [
        f"spline {curve.id} value {i}"
        for curve, count in zip(result.network.curves, counts, strict=True)
        for i in range(count)
    ]
    arrays: dict[str, NDArray[Any]] = {
        "format": _text([DISPERSION_FORMAT]),
        "image_ids": _text(result.network.images.ids),
        "image_parameters": _text(EOP_NAMES),
        "image_units": _text(["deg"] * 3 + ["m"] * 3),
        "image_dispersion": result.images.dispersion * np.outer(scale, scale),
        "point_ids": _text(result.network.points.ids),
        "point_dispersion": result.points.dispersion,
        "spline_value_names": _text(names),
        "spline_value_dispersion": curves.values_dispersion,
    }
    if full:
        if result.dispersion is None or result.dispersion.matrix is None:
            raise ValueError("the full dispersion matrix was not computed")
        arrays |= _full_arrays(result.dispersion.names, result.dispersion.matrix)
    return arrays


def _full_arrays(names: tuple[str, ...], matrix: FloatArray) -> dict[str, NDArray[Any]]:
    angular = np.array([name.rsplit(" ", 1)[-1] in ANGLES for name in names], dtype=bool)
    scale = np.where(angular, 180.0 / np.pi, 1.0)
    return {
        "names": _text(names),
        "units": _text(["deg" if is_angle else "m" for is_angle in angular]),
        "matrix": matrix * scale[:, None] * scale[None, :],
    }


def _text(values: Any) -> NDArray[np.str_]:
    return np.array(list(values), dtype=np.str_)


def write_dispersion(path: Path, arrays: dict[str, NDArray[Any]]) -> None:
    """Write an .npz file with fixed times; members in the order of `arrays`."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as archive:
        for name, array in arrays.items():
            info = zipfile.ZipInfo(f"{name}.npy", date_time=(1980, 1, 1, 0, 0, 0))
            info.external_attr = 0o644 << 16
            info.create_system = 3
            with archive.open(info, "w", force_zip64=True) as stream:
                np.lib.format.write_array(
                    stream, np.ascontiguousarray(array), version=(1, 0), allow_pickle=False
                )


def read_dispersion(path: Path) -> dict[str, NDArray[Any]]:
    """The arrays of the file by name; none where there is no file."""
    if not path.exists():
        return {}
    with np.load(path, allow_pickle=False) as archive:
        return {name: archive[name] for name in archive.files}
