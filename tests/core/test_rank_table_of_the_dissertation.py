"""Every experiment of Lee (2008), chapter 5: equations, unknowns, rank and redundancy as `check` counts them.

The rank belongs to the geometry, so that it must come out at Lee's rough initial values (angles off by degrees) as at
the true ones, and whether locations are given or searched.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from splinebba_cli.commands.app import app
from splinebba_cli.core.budget import Budget, budget
from splinebba_cli.core.network import ArcLengths, Network
from splinebba_cli.errors import NotSolvableError
from splinebba_cli.project.writer import write_project
from splinebba_cli.simulation.dissertation import design_of, experiment, experiments
from splinebba_cli.simulation.truth import at_truth

ROWS = {  # equations, unknowns, rank, nullity, redundancy
    "table_5_4": (30, 24, 22, 2, 8),
    "table_5_5": (30, 21, 20, 1, 10),
    "table_5_6": (36, 18, 18, 0, 18),
    "table_5_7": (66, 60, 60, 0, 6),
    "section_5_3": (132, 102, 97, 5, 35),
    "table_5_8": (96, 84, 82, 2, 14),
    "table_5_10": (24, 21, 19, 2, 5),
    "table_5_11": (12, 6, 6, 0, 6),
    "table_5_12": (33, 30, 30, 0, 3),
}
FIGURES = ("equations", "unknowns", "rank", "nullity", "redundancy")


def figures(found: Budget) -> tuple[int, ...]:
    return tuple(getattr(found, key) for key in FIGURES)


def starting_at(name: str, start: str) -> Network:
    """The network of an experiment at Lee's initial values or at the true ones."""
    design = design_of(experiment(name))
    return design.network if start == "rough" else at_truth(design.network, design.truth)


def without_locations(network: Network) -> Network:
    observed = network.curve_observations
    unknown = np.full(len(observed), np.nan)
    return replace(network, curve_observations=replace(observed, location=unknown))


def test_every_experiment_has_a_row() -> None:
    assert set(ROWS) == {made.name for made in experiments()}


@pytest.mark.parametrize("start", ["rough", "true"])
@pytest.mark.parametrize("name", list(ROWS))
def test_row(name: str, start: str) -> None:
    assert figures(budget(starting_at(name, start))) == ROWS[name]


@pytest.mark.parametrize("start", ["rough", "true"])
@pytest.mark.parametrize("name", list(ROWS))
def test_row_with_searched_locations(name: str, start: str) -> None:
    """Locations that run into the ends of the curve, as rough values make them do, stay unknowns of their own."""
    assert figures(budget(without_locations(starting_at(name, start)))) == ROWS[name]


@pytest.mark.parametrize(
    ("name", "row"),
    [
        ("table_5_4", (24, 24, 22, 2, 2)),
        ("table_5_5", (24, 21, 20, 1, 4)),
        ("table_5_7", (48, 60, 48, 12, 0)),
        ("section_5_3", (96, 102, 96, 6, 0)),
    ],
)
def test_row_without_arc_lengths(name: str, row: tuple[int, ...]) -> None:
    """Rough locations that are no foot points: no equation along the curve may be left over."""
    network = replace(starting_at(name, "rough"), arc_lengths=ArcLengths.none())
    assert figures(budget(network)) == row


@pytest.mark.parametrize("name", list(ROWS))
def test_row_from_the_command_line(name: str, tmp_path: Path) -> None:
    path = write_project(design_of(experiment(name)).network, tmp_path, name=name)
    result = CliRunner().invoke(app, ["check", str(path), "--format", "json"])
    found = json.loads(result.stdout)
    assert tuple(found["budget"][key] for key in FIGURES) == ROWS[name]
    arcs = ROWS[name][0] - 2 * found["counts"]["spline_observations"]
    assert (found["counts"]["arc_lengths"], found["counts"]["tangents"]) == (arcs, 0)


@pytest.mark.parametrize("made", experiments(), ids=lambda made: made.name)
def test_the_printed_count_is_reproduced_beside_the_rank(made) -> None:  # type: ignore[no-untyped-def]
    """Tables 5.1 and 5.2 feature by feature, and the orientations, add up to what the dissertation counts."""
    found = budget(design_of(made).network)
    orientations = sum(image.orientation for image in found.images)
    unknowns = sum(feature.lee_unknowns or 0 for feature in found.features)
    redundancy = sum(feature.lee_redundancy or 0 for feature in found.features)
    assert unknowns + orientations == made.lee_unknowns
    assert redundancy - orientations == made.lee_redundancy
    assert any(feature.reason for feature in found.features) == (made.lee_redundancy != found.redundancy)


def test_cameras_below_the_ground_are_no_place_to_count_at() -> None:
    network = starting_at("table_5_7", "true")
    images = replace(network.images, position=network.images.position - np.array([0.0, 0.0, 2000.0]))
    with pytest.raises(NotSolvableError) as refused:
        budget(replace(network, images=images))
    assert refused.value.code == "SBB505"
