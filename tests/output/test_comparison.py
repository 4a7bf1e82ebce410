"""Two result folders: how they are related, what is compared, free datums."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust, points_only
from splinebba_cli.core.camera.rotation import angles_from_rotation, rotation_from_vector
from splinebba_cli.core.network import Network
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.errors import OutputError
from splinebba_cli.output.comparison import compare
from splinebba_cli.output.comparison_json import comparison_to_dict
from splinebba_cli.output.result_folder import DispersionChoice, reserve_result_folder, write_result_folder
from splinebba_cli.output.stored_result import read_result
from splinebba_cli.simulation.six_image_block import simulate_block
from tests.output.factory import Loaded, make_result


def stored(
    folder: Path, result: AdjustmentResult, digest: str = "", dispersion: DispersionChoice = "blocks"
) -> Path:
    """A result folder whose input has a hash of its own."""
    loaded = Loaded(source_hashes={"block/project.yaml": digest or folder.name})
    with reserve_result_folder(folder) as place:
        write_result_folder(place, result, loaded=loaded, adjusted_files={}, dispersion=dispersion)
    return folder


@cache
def network() -> Network:
    return simulate_block("six-image-mixed", 5)[0]


@cache
def result() -> AdjustmentResult:
    return adjust(network())


def test_the_same_result_does_not_differ(tmp_path: Path) -> None:
    a, b = stored(tmp_path / "a", result(), "same"), stored(tmp_path / "b", result(), "same")
    found = compare(a, b)
    assert found.relation.name == "same-data" and "hashes" in found.relation.reason
    assert found.inputs == [{"file": "project.yaml", "status": "same"}]
    assert not found.significant
    assert np.abs(found.images.difference).max() == np.abs(found.points.difference).max() == 0.0
    assert {spline.id for spline in found.splines} == {curve.id for curve in network().curves}
    assert max(spline.largest for spline in found.splines) < 1e-6  # samples are written with 1 µm


@pytest.mark.parametrize("dispersion", ["blocks", "none"])
def test_a_point_that_nothing_locates_is_not_tested(tmp_path: Path, dispersion: DispersionChoice) -> None:
    """A search for outliers may take all rays of a point: it keeps its place and has no precision."""
    spread = result().points.dispersion.copy()
    spread[3] = np.nan
    lost = replace(result(), points=replace(result().points, dispersion=spread))
    a, b = (stored(tmp_path / name, r, dispersion=dispersion) for name, r in (("a", lost), ("b", result())))
    for first, second in ((a, b), (b, a)):
        points = compare(first, second, relation="independent").points
        assert points.dimensions[3] == 0 and not points.significant.any()
        assert np.isnan(points.sigma[3]).all() and np.isfinite(np.delete(points.sigma, 3, axis=0)).all()


def test_measurements_that_take_no_part_are_not_shared(tmp_path: Path) -> None:
    """Rows that the user has taken out of B stand in its tables, but B is adjusted from a part of A."""
    seen = network().curve_observations
    out = np.arange(len(seen)) % 4 == 0
    excluded = replace(network(), curve_observations=replace(seen, excluded=out))
    a, b = stored(tmp_path / "a", result()), stored(tmp_path / "b", adjust(excluded))
    relation = compare(a, b).relation
    assert (relation.name, relation.less_precise) == ("nested", "b")
    assert (relation.only_a, relation.only_b) == (out.sum(), 0)
    assert "all measured image points of B are in A" in relation.reason


def test_an_inner_datum_that_nothing_needs_is_no_free_network(tmp_path: Path) -> None:
    """Control determines the network: both results stand in its datum, and are not moved onto each other."""
    inner = replace(network(), settings=replace(network().settings, datum="inner"))
    a, b = stored(tmp_path / "a", result()), stored(tmp_path / "b", adjust(inner))
    assert compare(a, b).similarity is None


def test_what_is_written_is_read_back(tmp_path: Path) -> None:
    """Orientations, dispersions in radians, curves with their ellipses."""
    read = read_result(stored(tmp_path / "a", result()))
    assert read.correlated
    assert read.rotation == pytest.approx(result().images.rotation, abs=1e-12)
    assert read.position == pytest.approx(result().images.eop[:, 3:], abs=1e-9)
    assert read.image_dispersion == pytest.approx(result().images.dispersion, rel=1e-12, abs=1e-30)
    assert read.point_dispersion == pytest.approx(result().points.dispersion, rel=1e-12)
    assert read.sum_of_squares.variance == pytest.approx(result().statistics.sigma0 ** 2)
    curves = read.curves(np.zeros(3))
    for given, found in zip(network().curves, result().curves, strict=True):
        curve = curves[given.id]
        assert curve.basis.evaluate(curve.u, curve.coefficients) == pytest.approx(found.sample_xyz, abs=2e-6)


def test_a_circle_is_read_back_too(tmp_path: Path) -> None:
    block = adjust(simulate_block("circle-three-ways", 1)[0])
    curves = read_result(stored(tmp_path / "a", block)).curves(np.zeros(3))
    assert set(curves) == {"as-circle", "as-spline", "as-fourier"}
    for curve in curves.values():
        assert curve.basis.evaluate(curve.u, curve.coefficients) == pytest.approx(curve.xyz, abs=2e-6)


def test_one_moved_image_is_found(tmp_path: Path) -> None:
    """A change of five times its difference's sigma, of one image of an independent adjustment."""
    other = adjust(simulate_block("six-image-mixed", 6)[0])
    eop = other.images.eop.copy()
    eop[2, 3] += 5.0 * np.sqrt(2.0 * other.images.dispersion[2, 3, 3])
    moved = replace(other, images=replace(other.images, eop=eop))
    found = compare(stored(tmp_path / "a", result()), stored(tmp_path / "b", moved))
    assert found.relation.name == "independent"
    assert [found.images.ids[k] for k in np.flatnonzero(found.images.significant)] == ["3"]
    data = comparison_to_dict(found)
    assert data["images"]["differences"][0]["id"] == "3" and data["significant"]


def test_relations_that_are_asked_for(tmp_path: Path) -> None:
    a, b = stored(tmp_path / "a", result()), stored(tmp_path / "b", result())
    found = compare(a, b, relation="independent")
    assert found.relation.reason == "as asked for"
    assert found.variance_test is not None and found.variance_test.statistic == pytest.approx(1.0)
    assert found.images.sigma == pytest.approx(
        np.sqrt(2.0 * np.einsum("mii->mi", result().images.dispersion)), rel=1e-9
    )


def test_a_wrong_relation_is_said(tmp_path: Path) -> None:
    """The part of the data more precise than the whole: its dispersion cannot be."""
    better = replace(
        result(),
        images=replace(result().images, dispersion=result().images.dispersion / 4.0),
        statistics=replace(result().statistics, observations=result().statistics.observations - 10),
    )
    found = compare(stored(tmp_path / "a", result()), stored(tmp_path / "b", better))
    assert (found.relation.name, found.relation.less_precise) == ("nested", "b")
    assert "SBB614" in {problem.code for problem in found.problems}


def test_without_dispersion_images_are_not_tested(tmp_path: Path) -> None:
    a = stored(tmp_path / "a", result(), dispersion="none")
    found = compare(a, stored(tmp_path / "b", result()), relation="independent")
    assert {problem.code for problem in found.problems} == {"SBB613"}
    assert (found.images.dimensions == 0).all() and np.isfinite(found.images.sigma).all()


def test_a_free_network_is_transformed_first(tmp_path: Path) -> None:
    """The same network turned, scaled and moved: everything lies on itself again, and nothing has a σ."""
    rotation = rotation_from_vector(np.array([[0.02, -0.01, 0.5]]))[0]
    moved = adjust(points_only(network()))
    eop = moved.images.eop.copy()
    eop[:, 3:] = 1.001 * eop[:, 3:] @ rotation.T + 7.0
    eop[:, :3] = angles_from_rotation(rotation @ moved.images.rotation)
    points = replace(moved.points, xyz=1.001 * moved.points.xyz @ rotation.T + 7.0)
    free = replace(moved.network, settings=replace(moved.network.settings, datum="minimal"))
    undetermined = replace(moved.statistics, rank_defect=7)
    turned = replace(
        moved, network=free, statistics=undetermined, images=replace(moved.images, eop=eop), points=points
    )
    found = compare(stored(tmp_path / "a", moved), stored(tmp_path / "b", turned))
    assert found.similarity is not None
    assert found.similarity.scale == pytest.approx(1.0 / 1.001)
    assert np.abs(found.images.difference).max() < 1e-8 and np.abs(found.points.difference).max() < 1e-8
    assert np.isnan(found.images.sigma).all()
    assert "SBB612" in {problem.code for problem in found.problems}


def test_nothing_in_common(tmp_path: Path) -> None:
    other = make_result(splines=0, points=0)
    ids = tuple(f"other-{name}" for name in other.network.images.ids)
    other = replace(other, network=replace(other.network, images=replace(other.network.images, ids=ids)))
    with pytest.raises(OutputError, match="in common") as caught:
        compare(stored(tmp_path / "a", make_result(splines=0, points=0)), stored(tmp_path / "b", other))
    assert caught.value.code == "SBB611"
