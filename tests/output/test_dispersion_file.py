"""dispersion.npz: blocks and full matrix in metres and degrees, named; same numbers, same bytes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from splinebba_cli.output.dispersion_file import dispersion_arrays, write_dispersion
from splinebba_cli.output.result_json import result_to_dict
from tests.output.factory import make_result


def test_blocks_agree_with_result_json(tmp_path: Path) -> None:
    result = make_result()
    write_dispersion(tmp_path / "d.npz", dispersion_arrays(result, full=False))
    images = result_to_dict(result)["images"]
    with np.load(tmp_path / "d.npz") as file:
        assert "matrix" not in file
        names, units = list(file["image_parameters"]), list(file["image_units"])
        assert units == ["deg"] * 3 + ["m"] * 3
        sigma = np.sqrt(file["image_dispersion"][1].diagonal())
        assert sigma[names.index("kappa")] == pytest.approx(images[1]["sigma"]["kappa"])
        assert sigma[names.index("Y0")] == pytest.approx(images[1]["sigma"]["y"])
        assert file["spline_value_dispersion"].shape == (10, 3, 3)
        assert file["spline_value_names"][5] == "spline kerb-2 value 0"
        assert file["point_dispersion"].shape == (5, 3, 3)


def test_full_matrix_in_degrees() -> None:
    arrays = dispersion_arrays(make_result(), full=True)
    assert list(arrays["units"]) == ["deg"] * 3 + ["m"] * 3
    np.testing.assert_allclose(np.sqrt(np.diag(arrays["matrix"])[:3]), np.degrees(np.sqrt([1.0, 2.0, 3.0])))
    with pytest.raises(ValueError, match="not computed"):
        dispersion_arrays(make_result(dispersion=None), full=True)


def test_same_numbers_same_bytes(tmp_path: Path) -> None:
    for name in "ab":
        write_dispersion(tmp_path / name, dispersion_arrays(make_result(), full=True))
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_no_curves() -> None:
    assert dispersion_arrays(make_result(splines=0, points=0), full=False)[
        "spline_value_dispersion"
    ].shape == (0, 3, 3)
