"""Designs of projects: truth from the file or the approximate values, places as measured or placed."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from splinebba_cli import load_project, simulate
from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.camera.rotation import angles_from_rotation
from splinebba_cli.core.network import Curve, FloatArray, Network
from splinebba_cli.core.observations.location_search import squared_distance
from splinebba_cli.core.state import prepare
from splinebba_cli.errors import ProjectError, SimulationError
from splinebba_cli.project.loading import LoadedProject
from splinebba_cli.simulation.observation_kinds import measured_xy
from splinebba_cli.simulation.project_design import project_design
from splinebba_cli.simulation.six_image_block import simulate_block
from splinebba_cli.simulation.truth import Truth, shape_of, true_state, with_fixed_parameters

SAMPLES = Path(__file__).parents[2] / "sample_projects"


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """The mixed sample, to be changed."""
    folder = tmp_path / "project"
    shutil.copytree(
        SAMPLES / "six_image_mixed", folder, ignore=shutil.ignore_patterns("expected", "*.results")
    )
    return folder


def for_simulation(folder: Path) -> LoadedProject:
    return load_project(folder, "simulation")


def edit(folder: Path, old: str, new: str, file: str = "project.yaml") -> None:
    text = (folder / file).read_text(encoding="utf-8")
    assert old in text, old
    (folder / file).write_text(text.replace(old, new), encoding="utf-8")


def largest_residual(network: Network, truth: Truth) -> float:
    """Largest distance of the measurements on curves from their true places, in σ."""
    prepared = prepare(network)
    return float(np.sqrt(squared_distance(prepared, true_state(prepared, truth)).max()))


def test_truth_beside_the_project_is_the_truth(project: Path) -> None:
    design = project_design(for_simulation(project)).design
    network, truth = simulate_block("six-image-mixed", 1)
    np.testing.assert_allclose(design.truth.eop[:, 3:], truth.eop[:, 3:], atol=1e-9)
    np.testing.assert_allclose(design.truth.rotation, truth.rotation, atol=1e-12)
    np.testing.assert_allclose(design.truth.points, truth.points, atol=1e-9)
    np.testing.assert_allclose(design.truth.locations, truth.locations, atol=1e-12)
    for one, other in zip(design.truth.curves, truth.curves, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-9)
    np.testing.assert_array_equal(design.network.curve_observations.image, network.curve_observations.image)
    assert largest_residual(design.network, design.truth) < 1e-6


def test_without_it_the_approximate_values_are_true_and_locations_foot_points(project: Path) -> None:
    (project / "truth.json").unlink()
    loaded = for_simulation(project)
    design = project_design(loaded).design
    np.testing.assert_allclose(design.truth.eop[:, 3:], loaded.network.images.position)
    np.testing.assert_allclose(design.truth.rotation, loaded.network.images.rotation, atol=1e-12)
    for curve, values in zip(loaded.network.curves, design.truth.curves, strict=True):
        np.testing.assert_array_equal(curve.values, values)
    known = np.isfinite(loaded.network.points.xyz)
    np.testing.assert_array_equal(design.truth.points[known], loaded.network.points.xyz[known])
    assert np.isfinite(design.truth.points).all()  # tie points are intersected
    assert largest_residual(design.network, design.truth) < 1e-6
    # the new measurements lie at the feet of the old ones: along the true curve nothing is left
    old, new = loaded.network.curve_observations, design.network.curve_observations
    difference = old.photo_xy - new.photo_xy
    along = tangent_in_image(design.network, design.truth)
    inner = np.abs(np.sum(difference * along, axis=1)) < 1e-6
    assert inner.mean() > 0.97  # but for points beyond the ends of what a curve may be


def tangent_in_image(network: Network, truth: Truth) -> FloatArray:
    """Unit directions of the projected curves at the true locations, by a difference quotient."""
    prepared = prepare(network)
    state = true_state(prepared, truth)
    seen = network.curve_observations
    ends = [
        measured_xy(
            prepared, state, seen.image, prepared.curves.evaluate(state.coefficients, seen.curve, u)[0]
        )
        for u in (state.location - 1e-5, state.location + 1e-5)
    ]
    step = ends[1] - ends[0]
    return np.asarray(step / np.linalg.norm(step, axis=1)[:, None])


def test_a_truth_of_another_project_is_refused(project: Path) -> None:
    edit(project, '"id": "tie-1"', '"id": "other"', "truth.json")
    with pytest.raises(SimulationError, match="has no spline `tie-1`") as refused:
        project_design(for_simulation(project))
    assert refused.value.code == "SBB701"


@pytest.mark.parametrize("text", ["[]", "no json", '{"format": "splinebba-truth/1", "images": 3}'])
def test_what_is_no_truth_is_refused(project: Path, text: str) -> None:
    (project / "truth.json").write_text(text, encoding="utf-8")
    with pytest.raises(SimulationError) as refused:
        project_design(for_simulation(project))
    assert refused.value.code == "SBB701"


def test_other_knots_than_the_truth_are_refused(project: Path) -> None:
    content = json.loads((project / "truth.json").read_text(encoding="utf-8"))
    content["splines"][0]["values"].pop()
    (project / "truth.json").write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(SimulationError, match="6 values, the project 7"):
        project_design(for_simulation(project))


def without_observations(folder: Path) -> None:
    text = (folder / "project.yaml").read_text(encoding="utf-8")
    start, stop = text.index("observations:"), text.index("adjustment:")
    (folder / "project.yaml").write_text(text[:start] + text[stop:], encoding="utf-8")


def test_a_project_without_observations_is_refused_but_for_simulation(project: Path) -> None:
    without_observations(project)
    with pytest.raises(ProjectError) as refused:
        load_project(project)
    assert [d.code for d in refused.value.diagnostics] == ["SBB303"]
    assert len(for_simulation(project).network.curve_observations) == 0


def test_observations_are_placed_inside_the_format(project: Path) -> None:
    without_observations(project)
    edit(project, "image_sigma_um: 5.0", "image_sigma_um: 4.0, points_per_spline: 12")
    made = project_design(for_simulation(project))
    network, truth = made.design.network, made.design.truth
    seen = network.curve_observations
    assert (np.abs(seen.photo_xy) <= 115.0 + 1e-6).all()
    counts = np.unique(np.column_stack([seen.image, seen.curve]), axis=0, return_counts=True)[1]
    assert (counts == 12).all() and len(counts) > 10
    assert (seen.sigma == 0.004).all()
    assert len(network.point_observations) > 0
    assert largest_residual(network, truth) < 1e-6
    result = adjust(simulate(project, seed=3)[0])
    assert abs(result.statistics.sigma0 - 1.0) < 0.2


def test_kinds_of_observations_that_are_there_stay(project: Path) -> None:
    edit(project, "  spline_points:\n  - {name: spline points, table: spline_observations.csv}\n", "")
    before = for_simulation(project).network
    network = project_design(for_simulation(project)).design.network
    np.testing.assert_array_equal(network.point_observations.image, before.point_observations.image)
    assert len(network.curve_observations) > 0


def test_placing_needs_a_sigma_and_a_format(project: Path) -> None:
    without_observations(project)
    edit(project, ", image_sigma_um: 5.0", "")
    with pytest.raises(SimulationError, match="no σ for the observations") as refused:
        project_design(for_simulation(project))
    assert refused.value.code == "SBB702"
    edit(project, "  format_mm: [230.0, 230.0]\n", "")
    with pytest.raises(SimulationError, match="camera `camera` has no format"):
        project_design(for_simulation(project), 0.005)


def test_missing_approximate_values_are_named(project: Path) -> None:
    without_observations(project)
    (project / "truth.json").unlink()
    with pytest.raises(SimulationError, match="point `tie-1`, point `tie-2`"):
        project_design(for_simulation(project), 0.005)


def test_distortion_is_in_the_measurements(project: Path) -> None:
    edit(project, "  format_mm", "  distortion: {k1: 2.0e-6, p1: 1.0e-6}\n  format_mm")
    design = project_design(for_simulation(project)).design
    plain = simulate_block("six-image-mixed", 1, 0.0)[0]
    shift = np.abs(design.network.curve_observations.photo_xy - plain.curve_observations.photo_xy).max()
    assert shift > 0.5  # mm: k1 r³ at the edge
    assert largest_residual(design.network, design.truth) < 1e-6
    assert adjust(simulate(project, image_mm=0.0)[0]).statistics.vtpv < 1e-6


def test_another_rotation_sequence(project: Path) -> None:
    edit(project, "omega-phi-kappa", "phi-omega-kappa", "images.csv")
    (project / "truth.json").unlink()
    loaded = for_simulation(project)
    design = project_design(loaded).design
    np.testing.assert_allclose(design.truth.rotation, loaded.network.images.rotation, atol=1e-12)
    assert design.truth.sequence == ("phi-omega-kappa",) * 6
    first = angles_from_rotation(loaded.network.images.rotation[:1], "phi-omega-kappa")
    np.testing.assert_allclose(design.truth.eop[:1, :3], first, atol=1e-12)


def test_parameters_of_chord_lengths_are_those_of_the_true_curve(project: Path) -> None:
    """Wrong starts of knots must not make other knot parameters, that is another family of curves."""
    edit(project, "parameterization: uniform", "parameterization: chord_length")
    network, truth = simulate(project, seed=1, start_knots_m=1.5, image_mm=0.0)
    tie = [curve.id for curve in network.curves].index("tie-1")
    assert network.curves[tie].knot_parameters is not None
    basis, _ = shape_of(network.curves[tie], truth.curves[tie])
    np.testing.assert_allclose(
        np.diff(basis.break_points), np.linalg.norm(np.diff(truth.curves[tie], axis=0), axis=1)
    )
    assert np.abs(network.curves[tie].values - truth.curves[tie]).max() > 0.5
    assert adjust(network).statistics.vtpv < 1e-6


@pytest.mark.parametrize("family", ["natural_cubic", "cardinal", "catmull_rom"])
def test_other_families_keep_the_parameters_of_the_truth_as_well(family: str) -> None:
    true = np.array([[0.0, 0, 0], [10, 5, 1], [25, 4, 2], [31, 9, 2]])
    curve = Curve("a", "tie", family, true + 2.0, np.full((4, 3), np.inf))
    fixed = with_fixed_parameters(curve, true)
    assert fixed.knot_parameters is not None
    np.testing.assert_allclose(
        shape_of(fixed, true + [[0], [3], [0], [0]])[0].break_points, shape_of(curve, true)[0].break_points
    )


def test_simulate_of_a_kind_is_the_block() -> None:
    found, expected = simulate("strip", seed=4)[0], simulate_block("strip", 4)[0]
    np.testing.assert_array_equal(found.curve_observations.photo_xy, expected.curve_observations.photo_xy)
    np.testing.assert_array_equal(found.images.position, expected.images.position)
