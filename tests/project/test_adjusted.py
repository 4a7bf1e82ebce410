"""The adjusted project: approximate values move, everything else stays."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.core.settings import WeightPolicy
from splinebba_cli.project.adjusted import adjusted_project
from splinebba_cli.project.loading import LoadedProject, load_project
from tests.project.project_text import PROJECT, changed, written
from tests.project.small_result import result_of


def readjusted(loaded: LoadedProject, folder: Path, result: AdjustmentResult) -> LoadedProject:
    """The adjusted project, loaded from its folder."""
    folder.mkdir()
    for name, text in adjusted_project(loaded, result, folder).items():
        (folder / name).write_text(text, encoding="utf-8")
    return load_project(folder / "adjusted.yaml")


def with_table(folder: Path) -> LoadedProject:
    """The example with its spline observations in a side table, in gon, with settings."""
    start, end = PROJECT.index("      data: |\n"), PROJECT.index("  points:\n    - sigma_um")
    (folder / "tables").mkdir()
    (folder / "tables" / "o.txt").write_text(PROJECT[start:end].partition("\n")[2], encoding="utf-8")
    text = PROJECT[:start] + "      table: tables/o.txt\n" + PROJECT[end:]
    text = changed("angle_unit: deg", "angle_unit: gon", text)
    text += "adjustment: {alpha: 0.01, knots: {spacing_m: 3}}\nacceptance: {max_sigma0: 2}\n"
    return load_project(written(folder, text))


def test_values_move_and_the_rest_stays(tmp_path: Path) -> None:
    before = with_table(tmp_path)
    result = result_of(before.network)
    after = readjusted(before, tmp_path / "somewhere", result)
    a, b = before.network, after.network
    np.testing.assert_allclose(b.images.position[1], a.images.position[1] + 0.5)
    np.testing.assert_allclose(b.images.rotation[1], result.images.rotation[1], atol=1e-14)
    np.testing.assert_allclose(b.images.position[0], a.images.position[0])  # fixed
    np.testing.assert_allclose(b.images.prior, a.images.prior)
    np.testing.assert_array_equal(b.images.prior_sigma, a.images.prior_sigma)
    np.testing.assert_allclose(b.points.xyz, [a.points.xyz[0], [0.125] * 3])  # control stays, the tie moves
    np.testing.assert_array_equal(b.points.sigma, a.points.sigma)
    for old, new in zip(a.curves, b.curves, strict=True):
        held = np.isfinite(old.sigma)
        np.testing.assert_allclose(new.values, np.where(held, old.values, old.values + 0.25))
        np.testing.assert_array_equal(new.sigma, old.sigma)
        assert new.reference is not None and new.knot_parameters is not None
        np.testing.assert_allclose(new.reference, old.values)
        np.testing.assert_allclose(new.knot_parameters, [0.0, 0.5, 1.0])
    np.testing.assert_array_equal(b.curve_observations.photo_xy, a.curve_observations.photo_xy)
    np.testing.assert_array_equal(b.point_observations.photo_xy, a.point_observations.photo_xy)
    assert b.curve_observations.group_names == a.curve_observations.group_names


def test_knots_are_final(tmp_path: Path) -> None:
    before = with_table(tmp_path)
    after = readjusted(before, tmp_path / "out", result_of(before.network))
    assert before.network.settings.knots.spacing_m == 3.0
    assert after.network.settings.knots.spacing_m is None
    assert not after.network.settings.staged
    assert after.network.settings.alpha == 0.01
    assert after.model.acceptance.max_sigma0 == 2.0
    assert after.model.cameras == before.model.cameras


def test_paths_without_a_folder_are_absolute(tmp_path: Path) -> None:
    before = with_table(tmp_path)
    files = adjusted_project(before, result_of(before.network))
    assert str((tmp_path / "tables" / "o.txt").resolve()) in files["adjusted.yaml"]


def test_locations_go_when_the_knots_have_changed(tmp_path: Path) -> None:
    text = changed("columns: [image, spline, x, y]", "columns: [image, spline, x, y, location]")
    for row in ("no    coast 1.5 2", "12:30 coast 2.5 3", "no    road  1.5 2", "12:30 road  2.5 3"):
        text = changed(row + "\n", row + " 0.5\n", text)
    before = load_project(written(tmp_path, text))
    result = result_of(before.network)
    kept = readjusted(before, tmp_path / "kept", result)
    assert kept.network.curve_observations.location.tolist() == [0.5] * 4
    coast = replace(before.network.curves[0], values=np.eye(4, 3), sigma=np.full((4, 3), math.inf))
    moved = replace(before.network, curves=(coast, before.network.curves[1]))
    after = readjusted(before, tmp_path / "changed", result_of(moved))
    assert np.isnan(after.network.curve_observations.location).all()


def test_ids_survive(tmp_path: Path) -> None:
    before = load_project(written(tmp_path, PROJECT))
    after = readjusted(before, tmp_path / "out", result_of(before.network))
    assert after.network.images.ids == ("no", "12:30")
    assert after.network.points.ids == ("1e-6", "t1")
    assert after.network.cameras[0].id == "0101"


@pytest.mark.parametrize("sequence", ["omega-phi-kappa", "phi-omega-kappa"])
def test_sequence_of_rotations_is_kept(sequence: str, tmp_path: Path) -> None:
    before = load_project(written(tmp_path, changed("omega-phi-kappa", sequence)))
    after = readjusted(before, tmp_path / "out", result_of(before.network))
    assert after.network.images.sequence == (sequence, sequence)


def test_groups_keep_the_name_of_their_table(tmp_path: Path) -> None:
    text = changed("    - name: traced\n      sigma_um: 5\n", "    - sigma_um: 5\n")
    start, end = text.index("      columns: [image, spline"), text.index("  points:\n    - sigma_um")
    text = text[:start] + "      table: traced.csv\n" + text[end:]
    rows = "image,spline,x,y\nno,coast,1.5,2\n12:30,coast,2.5,3\nno,road,1.5,2\n12:30,road,2.5,3\n"
    before = load_project(written(tmp_path, text, traced=rows))
    after = readjusted(before, tmp_path / "out", result_of(before.network))
    assert after.network.curve_observations.group_names == ("traced.csv",)
    assert before.network.curve_observations.group_names == ("traced.csv",)


@pytest.mark.parametrize("road", ["yes", "no"])
def test_features_that_are_left_out_are_not_measured_in_the_adjusted_project(
    road: str, tmp_path: Path
) -> None:
    """A tie spline that one image sees, and with it all others: no row names what is no longer there."""
    text = changed("columns: [image, spline, x, y]", "columns: [image, spline, x, y, use]")
    for row, use in (("no    coast 1.5 2", "yes"), ("12:30 coast 2.5 3", "no")):
        text = changed(row + "\n", f"{row} {use}\n", text)
    for row in ("no    road  1.5 2", "12:30 road  2.5 3"):
        text = changed(row + "\n", f"{row} {road}\n", text)
    before = load_project(written(tmp_path, text))
    after = readjusted(before, tmp_path / "out", result_of(before.network))
    a, b = before.network, after.network
    assert [curve.id for curve in b.curves] == ([] if road == "no" else ["road"])
    np.testing.assert_array_equal(b.curve_observations.photo_xy, a.curve_observations.photo_xy)
    np.testing.assert_array_equal(b.point_observations.photo_xy, a.point_observations.photo_xy)


SAMPLE = Path(__file__).resolve().parents[2] / "sample_projects" / "six_image_mixed" / "project.yaml"


def test_estimated_weights_are_estimated_again(tmp_path: Path) -> None:
    """The σ in the files are the given ones, control too; adjusting again ends at the same factors and place.

    Factors stand to 1e-3 of their σ at the end of each run; orientations move by less than that share of theirs.
    """
    before = load_project(SAMPLE)
    settings = replace(before.network.settings, weights=WeightPolicy(variance_components=True))
    points = replace(before.network.points, sigma=3.0 * before.network.points.sigma)  # far too large
    network = replace(before.network, settings=settings, points=points)
    first = adjust(network)
    factors = {each.group: each.factor for each in first.evidence.variance_components}
    assert any(factor != 1.0 for factor in factors.values())
    after = readjusted(before, tmp_path / "out", first)
    np.testing.assert_allclose(after.network.points.sigma, points.sigma, rtol=1e-9)
    np.testing.assert_allclose(
        after.network.point_observations.sigma, network.point_observations.sigma, rtol=1e-9
    )
    again = adjust(replace(after.network, settings=replace(after.network.settings, weights=settings.weights)))
    sigma = np.sqrt(np.einsum("mii->mi", first.images.dispersion))
    assert (np.abs(again.images.eop - first.images.eop) <= 5e-3 * sigma).all()
    for each in again.evidence.variance_components:
        assert each.factor == pytest.approx(factors[each.group], rel=4e-3 * each.sigma0_sigma)
