"""Chains of a simulation: pieces of the measured curves, wrong ones among them, and the truth about both."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from splinebba_cli.project.loading import load_project
from splinebba_cli.simulation.catalogue import write
from splinebba_cli.simulation.six_image_block import simulate_block
from splinebba_cli.simulation.targets import project_target, write_target
from splinebba_cli.simulation.unlabelling import ChainStyle, unlabelled

STYLE = ChainStyle(points=12, wrong_share=0.25, hides_ties=True)


def test_right_chains_are_the_measured_points() -> None:
    network, _ = simulate_block("edge-chains", 5)
    made = unlabelled(network, STYLE, 5)
    points, observed = made.network.unlabelled, network.curve_observations
    names = [curve.id for curve in network.curves]
    known = {
        tuple(xy): (i, c)
        for xy, i, c in zip(observed.photo_xy.tolist(), observed.image, observed.curve, strict=True)
    }
    right = 0
    for xy, image, chain in zip(points.photo_xy.tolist(), points.image, points.chain, strict=True):
        label = made.labels[chain]
        assert label[0] == network.images.ids[image]
        if label[2]:
            assert known[tuple(xy)] == (image, names.index(label[2]))
            right += 1
        else:
            assert tuple(xy) not in known
    assert right == len(observed)


def test_chains_are_traced_in_order_and_short() -> None:
    network, truth = simulate_block("edge-chains", 5)
    made = unlabelled(network, STYLE, 5)
    points = made.network.unlabelled
    location = dict(
        zip(map(tuple, network.curve_observations.photo_xy.tolist()), truth.locations, strict=True)
    )
    senses = set()
    for chain, (_, _, spline) in enumerate(made.labels):
        rows = np.flatnonzero(points.chain == chain)
        assert np.array_equal(rows, np.arange(rows[0], rows[-1] + 1)) and len(rows) < STYLE.points + 3
        if spline and spline != "pool":
            step = np.diff([location[tuple(xy)] for xy in points.photo_xy[rows].tolist()])
            assert (step > 0).all() or (step < 0).all()
            senses.add(bool(step[0] > 0))
    assert senses == {True, False}


def test_wrong_chains_have_their_share_and_lie_in_the_images() -> None:
    network, _ = simulate_block("edge-chains", 5)
    made = unlabelled(network, STYLE, 5)
    points = made.network.unlabelled
    wrong = np.array([not spline for _, _, spline in made.labels])[points.chain]
    assert wrong.mean() == pytest.approx(STYLE.wrong_share, abs=0.01)
    assert (np.abs(points.photo_xy[wrong]) <= [27.0, 18.0]).all()


def test_hidden_ties_leave_the_project_and_stay_in_the_truth(tmp_path: Path) -> None:
    project = write("edge-chains", tmp_path, 2)
    network = load_project(project, "matching").network
    truth = json.loads((tmp_path / "truth.json").read_text(encoding="utf-8"))
    assert {curve.role for curve in network.curves} == {"control"}
    assert {"path", "roof", "wall", "pool"} <= {spline["id"] for spline in truth["splines"]}
    assert [f"{each['image']}/{each['chain']}" for each in truth["chains"]] == list(
        network.unlabelled.chain_ids
    )


def test_a_project_says_that_it_wants_chains(tmp_path: Path) -> None:
    project = write("strip", tmp_path / "a", 2)
    text = project.read_text(encoding="utf-8").partition("\nsimulation:")[0]
    project.write_text(f"{text}\nsimulation: {{chains: true, chain_points: 10}}\n", encoding="utf-8")
    loaded = load_project(project, "simulation")
    again = write_target(project_target(loaded, {}), tmp_path / "b", 4)
    network = load_project(again, "matching").network
    assert len(network.unlabelled) == len(loaded.network.curve_observations)
    assert len(network.curve_observations) == 0
    assert len(network.point_observations) == len(loaded.network.point_observations)
    assert [curve.id for curve in network.curves] == [curve.id for curve in loaded.network.curves]


def test_chains_are_written_and_read_as_they_are(tmp_path: Path) -> None:
    from splinebba_cli.project.writer import write_project

    given = load_project(write("edge-chains", tmp_path / "a", 2), "matching").network
    points = given.unlabelled
    from dataclasses import replace

    direction = np.where(np.arange(len(points)) % 2 == 0, 0.3, np.nan)
    chain = np.where(points.chain == 4, -1, points.chain)
    sigma = points.sigma * (1.0 + (np.arange(len(points)) % 2))[:, None]
    changed = replace(points, direction=direction, sigma=sigma, chain=chain)
    network = replace(given, unlabelled=changed)
    path = write_project(network, tmp_path / "b", name="again", matching={"seed": 4})
    loaded = load_project(path, "matching")
    found = loaded.network.unlabelled
    np.testing.assert_array_equal(found.photo_xy, changed.photo_xy)
    np.testing.assert_array_equal(found.sigma, changed.sigma)
    np.testing.assert_allclose(np.mod(found.direction, np.pi), np.mod(direction, np.pi))
    assert [changed.chain_ids[k] if k >= 0 else "" for k in chain] == [
        found.chain_ids[k] if k >= 0 else "" for k in found.chain
    ]
    assert loaded.match_settings.seed == 4
