"""Strasbourg, points only, without initial orientations: DBAT 0.9.2 to the printed digits (result/report.txt).

The report prints orientations with six decimals (degrees, metres) and stopped at a relative change of 1e-6, positions
of points with three, standard deviations with three significant digits.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.result import AdjustmentResult
from tests import reference_data


@cache
def adjusted(approximate: bool = False) -> AdjustmentResult:
    """The block from nothing, or from the orientations of the report."""
    return adjust(reference_data.strasbourg_points_network(approximate))


def orientation(result: AdjustmentResult) -> tuple[FloatArray, FloatArray]:
    """Orientations and their sigma, (5, 6) each; degrees, metres."""
    eop = result.images.eop.copy()
    sigma = np.sqrt(np.einsum("mii->mi", result.images.dispersion))
    eop[:, :3], sigma[:, :3] = np.degrees(eop[:, :3]), np.degrees(sigma[:, :3])
    return eop, sigma


def half_a_digit(printed: FloatArray) -> FloatArray:
    """Half a unit of the third significant digit, and rounding."""
    return np.asarray(0.5001 * 10.0 ** (np.floor(np.log10(printed)) - 2.0))


def printed_points(heading: str) -> tuple[list[str], FloatArray, FloatArray]:
    """Ids, coordinates and sigma of the posterior table under a heading of the report."""
    path = reference_data.reference_dir() / "strasbourg_aerial/points/result/report.txt"
    table = path.read_text(encoding="utf-8").split(heading)[1].split("Posterior")[1].split("Diff (")[0]
    rows = [[cell.strip() for cell in line.split(",")] for line in table.splitlines()[2:] if "," in line]
    values = np.array([[float(cell) for cell in row[1:7]] for row in rows])
    return [row[0] for row in rows], values[:, :3], values[:, 3:]


def test_counts_and_variance_of_unit_weight() -> None:
    report, statistics = reference_data.strasbourg_report(), adjusted().statistics
    assert (report.sigma0, report.redundancy, report.observations, report.unknowns) == (
        1.1786,
        1261,
        2434,
        1173,
    )
    assert statistics.sigma0 == pytest.approx(report.sigma0, abs=0.5e-4)
    assert statistics.redundancy == report.redundancy
    assert statistics.observations == report.observations
    assert statistics.unknowns == report.unknowns
    assert (statistics.conditions, statistics.rank_defect) == (0, 0)
    assert statistics.sum_redundancy_numbers == pytest.approx(1261.0, abs=1e-8)


def test_the_global_test_of_this_block_fails() -> None:
    """1261 x 1.1786^2 lies far above the 97.5 % quantile of chi-square: the given sigma are a little small."""
    test = adjusted().statistics.global_test
    assert test is not None and not test.passed and test.statistic > test.upper


def test_every_orientation_to_the_printed_digits() -> None:
    """Six decimals of degrees and metres: one unit of the last digit, a millionth of sigma."""
    report = reference_data.strasbourg_report()
    assert adjusted().network.images.ids == report.ids
    eop, _ = orientation(adjusted())
    np.testing.assert_allclose(eop, report.eop, rtol=0.0, atol=1e-6)


def test_every_sigma_of_an_orientation_to_the_printed_digits() -> None:
    report = reference_data.strasbourg_report()
    _, sigma = orientation(adjusted())
    assert (np.abs(sigma - report.sigma) < half_a_digit(report.sigma)).all()


@pytest.mark.parametrize(("heading", "count"), [("Ctrl measurements", 14), ("Check measurements", 2)])
def test_given_points_afterwards_to_the_printed_digits(heading: str, count: int) -> None:
    ids, xyz, sigma = printed_points(heading)
    assert len(ids) == count
    result = adjusted()
    rows = [result.network.points.ids.index(id) for id in ids]
    np.testing.assert_allclose(result.points.xyz[rows], xyz, rtol=0.0, atol=0.51e-3)
    found = np.sqrt(np.einsum("nii->ni", result.points.dispersion[rows]))
    assert (np.abs(found - sigma) < half_a_digit(sigma)).all()


def test_check_points_are_reported_with_the_sigma_of_the_difference() -> None:
    result = adjusted()
    ids, xyz, sigma = printed_points("Check measurements")
    checks = {check.id: check for check in result.checks.points}
    assert sorted(checks) == sorted(reference_data.STRASBOURG_CHECKS) == sorted(ids)
    given = np.array([0.02, 0.02, 0.04])
    for id, found, own in zip(ids, xyz, sigma, strict=True):
        row = result.network.points.ids.index(id)
        known = result.network.points.xyz[row] + result.network.origin
        np.testing.assert_allclose(checks[id].difference, found - known, rtol=0.0, atol=0.51e-3)
        np.testing.assert_allclose(checks[id].sigma, np.hypot(own, given), rtol=5e-3)


def test_the_most_and_the_least_precise_point() -> None:
    """Point Precision of the report: 0.052 (422) to 0.64 (65265); largest in X, Y, Z 0.18, 0.095, 0.61."""
    result = adjusted()
    ids = np.array(result.network.points.ids)
    sigma = np.sqrt(np.einsum("nii->ni", result.points.dispersion))
    total = np.linalg.norm(sigma, axis=1)
    assert (ids[total.argmin()], f"{total.min():.2g}") == ("422", "0.052")
    assert (ids[total.argmax()], f"{total.max():.2g}") == ("65265", "0.64")
    assert list(ids[sigma.argmax(axis=0)]) == ["65265", "65297", "65561"]
    assert [f"{value:.2g}" for value in sigma.max(axis=0)] == ["0.18", "0.095", "0.61"]


def test_residuals_of_the_report() -> None:
    """Overall 1.101 px RMS, the largest 2.729 px on point 563 in photo 5."""
    result = adjusted()
    residual = np.linalg.norm(result.point_residuals.residual, axis=1) / reference_data.STRASBOURG_PIXEL_MM
    worst = int(residual.argmax())
    observed = result.network.point_observations
    assert np.sqrt(np.mean(residual**2)) == pytest.approx(1.101, abs=0.0005)
    assert residual[worst] == pytest.approx(2.729, abs=0.0005)
    assert (result.network.points.ids[observed.point[worst]], observed.image[worst]) == ("563", 4)


def test_the_start_does_not_matter() -> None:
    """From the orientations of the report the same solution, to a ten-thousandth of sigma."""
    first, second = adjusted(), adjusted(True)
    _, sigma = orientation(first)
    assert np.abs((orientation(first)[0] - orientation(second)[0]) / sigma).max() < 1e-4
    assert first.statistics.sigma0 == pytest.approx(second.statistics.sigma0, rel=1e-9)


def test_control_points_of_a_single_ray_stay() -> None:
    """Point 403 has a single ray and stays in the adjustment: without such points sigma0 would be 1.1727."""
    result = adjusted()
    row = result.network.points.ids.index("403")
    assert result.points.rays[row] == 1
    assert np.isfinite(result.points.dispersion[row]).all()
