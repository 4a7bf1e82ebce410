"""Many splines share tables, with their parameters and reference values, and load to the same curves."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from splinebba_cli.core.network import Curve, Network
from splinebba_cli.errors import ProjectError
from splinebba_cli.project import writer
from splinebba_cli.project.loading import load_project
from splinebba_cli.project.writer import write_project
from tests.project.project_text import PROJECT, changed, written

TABLE = "splines: {table: splines.csv, role: tie, parameterization: uniform}\n"
OLD = PROJECT[PROJECT.index("splines:") : PROJECT.index("points:\n  - {id")]
GOOD = "coast,0,0,0,0\ncoast,1,0,0,2\ncoast,2,0,0,3\nroad,0,1,0,1\nroad,1,1,0,2\nroad,2,1,0,5\n"


def network_of_many(folder: Path) -> Network:
    """The example with its splines three times; those of the second and third round with parameters and references."""
    network = load_project(written(folder, PROJECT)).network
    curves: list[Curve] = list(network.curves)
    for round in (1, 2):
        for curve in network.curves:
            u = np.arange(len(curve.values)) * (1.0 + round)
            reference = curve.values + 0.125
            curves.append(replace(curve, id=f"{curve.id}-{round}", knot_parameters=u, reference=reference))
    observed = network.curve_observations
    thrice = replace(
        observed,
        curve=np.concatenate([observed.curve + k * len(network.curves) for k in range(3)]),
        **{
            name: np.concatenate([getattr(observed, name)] * 3)
            for name in ("image", "photo_xy", "sigma", "location", "segment")
        },
        group=None,
        group_names=(),
    )
    return replace(network, curves=tuple(curves), curve_observations=thrice)


@pytest.mark.parametrize("many", [2, 100])
def test_they_come_back(many: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(writer, "MANY", many)
    network = network_of_many(tmp_path)
    path = write_project(network, tmp_path / "out", name="many")
    assert (tmp_path / "out" / "splines_1.csv").exists() == (many == 2)
    found = {curve.id: curve for curve in load_project(path).network.curves}
    assert len(found) == len(network.curves)
    for curve in network.curves:
        new = found[curve.id]
        assert (new.role, new.family, new.closed) == (curve.role, curve.family, curve.closed)
        for name in ("values", "sigma", "knot_parameters", "reference"):
            old_values, new_values = getattr(curve, name), getattr(new, name)
            assert (old_values is None) == (new_values is None), name
            if old_values is not None:
                np.testing.assert_array_equal(new_values, old_values)


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("road,1,1,0,2", "road,1,1,0,1", "SBB205"),
        ("road,1,1,0,2", "road,0,1,0,2", "SBB206"),
        ("road,1,1,0,2", "road,1,1,0,", "SBB403"),
        ("road,1,1,0,2\nroad,2,1,0,5\n", "", "SBB307"),
        ("road,2,1,0,5\n", "road,2,1,0,5\nroad,3,1,0,5\n", "SBB205"),
    ],
)
def test_one_bad_spline_among_good_ones(tmp_path: Path, old: str, new: str, code: str) -> None:
    """The second of two splines alike is wrong: it must not pass because the first one did."""
    text = changed(OLD, TABLE)
    table = "spline,x,y,z,u\n" + GOOD.replace(old, new)
    with pytest.raises(ProjectError) as caught:
        load_project(written(tmp_path, text, splines=table))
    assert code in [d.code for d in caught.value.diagnostics]


def test_a_spline_given_twice_in_two_tables(tmp_path: Path) -> None:
    both = "splines:\n  - {table: splines.csv, role: tie}\n  - {table: others.csv, role: tie}\n"
    table = "spline,x,y,z\ncoast,0,0,0\ncoast,1,0,0\nroad,0,1,0\nroad,1,1,0\n"
    with pytest.raises(ProjectError) as caught:
        load_project(written(tmp_path, changed(OLD, both), splines=table, others=table))
    found = [d for d in caught.value.diagnostics if d.code == "SBB302"]
    assert [(Path(d.file).name, d.line, d.help) for d in found] == [
        ("others.csv", 2, "first given in line 2"),
        ("others.csv", 4, "first given in line 4"),
    ]
