"""A network written as a project loads back to itself."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from splinebba_cli.core.camera.rotation import rotation_object_from_photo
from splinebba_cli.core.network import Curve, KnotPolicy, Network, Settings
from splinebba_cli.errors import OutputError
from splinebba_cli.project.loading import load_project
from splinebba_cli.project.writer import write_project
from tests.project.project_text import written

ORIGIN = np.array([7_672_000.0, 512_000.0, 0.0])


def differences(a: Any, b: Any, name: str = "network") -> Iterator[str]:
    """Where two networks differ by more than the rounding of coordinates of millions of metres."""
    if isinstance(a, np.ndarray):
        if a.shape != b.shape or not np.allclose(a, b, rtol=1e-15, atol=1e-9, equal_nan=True):
            yield f"{name}: {a} {b}"
    elif is_dataclass(a):
        for field in fields(a):
            yield from differences(getattr(a, field.name), getattr(b, field.name), f"{name}.{field.name}")
    elif isinstance(a, tuple):
        if len(a) != len(b):
            yield f"{name}: {len(a)} {len(b)}"
        for number, (x, y) in enumerate(zip(a, b, strict=False)):
            yield from differences(x, y, f"{name}[{number}]")
    elif a != b:
        yield f"{name}: {a!r} {b!r}"


def rich_network(folder: Path) -> Network:
    """The example project as a network, with something of every kind."""
    network = load_project(written(folder)).network
    angles = np.array([[0.1, 0.2, 3.0], [-0.01, 0.02, -2.9]])
    images = replace(
        network.images,
        sequence=("omega-phi-kappa", "phi-omega-kappa"),
        rotation=np.stack(
            [
                rotation_object_from_photo(angles[0]),
                rotation_object_from_photo(angles[1], "phi-omega-kappa"),
            ]
        ),
        prior=np.array([[0.1, 0.2, 3.0, 1.0, 2.0, 3.0], [np.nan, np.nan, np.nan, 500.1, np.nan, 999.0]]),
        prior_sigma=np.array([[1e-4, 1e-4, 1e-4, 0.1, 0.1, 0.1], [np.inf, np.inf, np.inf, 0.3, np.inf, 0.5]]),
    )
    coast, road = network.curves
    curves = (
        replace(
            coast,
            knot_parameters=np.array([0.0, 0.25, 1.5]),
            breaks=(1,),
            reference=coast.values + 0.125,
        ),
        replace(
            road,
            role="check",
            sigma=np.full((3, 3), np.inf),
            closed=True,
            check_values=np.arange(12.0).reshape(4, 3),
        ),
        Curve("0102", "control", "free_cubic", np.arange(12.0).reshape(4, 3) / 7, np.full((4, 3), 0.25)),
        Curve("line", "partial", "straight_line", np.eye(2, 3), np.array([[0.0] * 3, [0.1, np.inf, 0.2]])),
    )
    observed = network.curve_observations
    more = np.array([0, 1, 0, 1, 0, 1, 0, 1])
    observed = replace(
        observed,
        image=more,
        curve=np.repeat(np.arange(4), 2),
        photo_xy=np.arange(16.0).reshape(8, 2) / 3,
        sigma=np.arange(1.0, 17.0).reshape(8, 2) / 1000,
        location=np.array([0.5, np.nan, *[1 / 3] * 6]),
        segment=np.array([1, -1, -1, -1, -1, -1, -1, -1]),
        group=np.array([0, 0, 0, 1, 1, 1, 1, 1]),
        group_names=("first", "second"),
    )
    camera = replace(
        network.cameras[0],
        principal_point_mm=np.array([0.01, -0.02]),
        radial=np.array([1e-5, -1e-9, 1e-13]),
        decentring=np.array([1e-6, -2e-6]),
        affinity=np.array([1e-4, 2e-4]),
        pixel_size_mm=0.006,
        format_mm=(230.0, 229.5),
    )
    settings = Settings(
        datum="minimal",
        sigma0_prior=2.0,
        alpha=0.01,
        max_iterations=7,
        gauge_sigma_m=0.3,
        scale_dispersion=False,
        staged=False,
        knots=KnotPolicy(3.0, True, True),
    )
    return replace(
        network,
        origin=ORIGIN,
        images=images,
        curves=curves,
        curve_observations=observed,
        cameras=(camera,),
        settings=settings,
    )


@pytest.mark.parametrize("unit", ["deg", "gon", "rad"])
def test_loads_back_to_the_same_network(unit: str, tmp_path: Path) -> None:
    network = rich_network(tmp_path)
    path = write_project(network, tmp_path / "out", name="0815", angle_unit=unit, comment="two\nlines")
    loaded = load_project(path)
    assert list(differences(network, loaded.network)) == []
    assert loaded.name == "0815"


def test_difference_is_noticed(tmp_path: Path) -> None:
    """The comparison of these tests sees a small change."""
    network = rich_network(tmp_path)
    changed = replace(network, origin=network.origin + 1e-3)
    assert len(list(differences(network, changed))) == 1


def test_writing_twice_gives_the_same_bytes(tmp_path: Path) -> None:
    network = rich_network(tmp_path)
    for name in ("a", "b"):
        write_project(network, tmp_path / name, name="x", simulation={"block": "test", "seed": 3})
    files = sorted(path.name for path in (tmp_path / "a").iterdir())
    assert "project.yaml" in files and "knots.csv" in files
    for file in files:
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()


def test_free_coefficient_vectors_are_not_shifted(tmp_path: Path) -> None:
    path = write_project(rich_network(tmp_path), tmp_path / "out", name="x")
    rows = [
        line.split(",")
        for line in (path.parent / "knots.csv").read_text().splitlines()
        if line.startswith("0102")
    ]
    assert float(rows[0][1]) == ORIGIN[0]
    assert [float(row[1]) for row in rows[1:]] == [3 / 7, 6 / 7, 9 / 7]


def test_first_line_names_the_schema(tmp_path: Path) -> None:
    path = write_project(rich_network(tmp_path), tmp_path / "out", name="x")
    assert path.read_text().startswith("# yaml-language-server: $schema=project.schema.json")


def test_folder_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="SBB601"):
        write_project(rich_network(tmp_path), tmp_path / "file", name="x")
