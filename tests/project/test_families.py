"""Families in the project file: what is refused, with code and place, and what comes back as it was written."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.network import Network
from splinebba_cli.errors import ProjectError
from splinebba_cli.project.adjusted import adjusted_project
from splinebba_cli.project.diagnostics import Diagnostic
from splinebba_cli.project.loading import load_project
from splinebba_cli.project.writer import write_project
from tests.core.family_features import ALL
from tests.core.free_curves import block_with
from tests.project.project_text import changed, written

LINE = 16  # of the first key after the role
POINTS = [
    [0, 0, 0],
    [100, 10, 5],
    [200, 20, 0],
    [250, 90, 3],
    [200, 150, 1],
    [90, 140, 2],
    [20, 70, 4],
    [30, 20, 7],
]


def errors(folder: Path, options: str, rows: list[list[float]], role: str = "tie") -> list[Diagnostic]:
    """Errors of the example project whose coast has other rows and options."""
    listed = "\n".join(f"      {x} {y} {z}" for x, y, z in rows)
    text = changed("    role: tie\n", f"    role: {role}\n{options}")
    start = text.index("      0 0 0\n")
    end = text.index("      200 20 0\n") + len("      200 20 0\n")
    text = text[:start] + listed + "\n" + text[end:]
    with pytest.raises(ProjectError) as caught:
        load_project(written(folder, text))
    return [d for d in caught.value.diagnostics if d.severity == "error"]


BAD = [
    # options, rows, code, what it says
    ("family: cardinal\n    tension: 1", 4, "SBB205", "[-1, 1)"),
    ("family: cardinal\n    tension: -1.5", 4, "SBB205", "[-1, 1)"),
    ("family: cardinal\n    tension: tight", 4, "SBB203", "tight"),
    ("family: catmull_rom\n    tension: 0.5", 4, "SBB209", "family: cardinal"),
    ("family: cardinal\n    closed: true", 2, "SBB307", "needs 3"),
    ("continuity: C1", 4, "SBB209", "`continuity` in a curve of family natural_cubic"),
    ("family: free_cubic\n    continuity: C3", 4, "SBB204", "C2"),
    ("family: polynomial_2\n    continuity: C2", 3, "SBB205", "at most C1"),
    ("family: polynomial_1\n    continuity: C1", 4, "SBB205", "at most C0"),
    ("family: polynomial_0\n    continuity: C0", 1, "SBB205", "at most C-1"),
    ("family: free_cubic", 5, "SBB206", "free_cubic has 4 a segment"),
    ("family: polynomial_2", 2, "SBB307", "polynomial_2 has 3 a segment"),
    ("family: polynomial_0", 2, "SBB206", "polynomial_0 has 1"),
    ("family: free_cubic\n    natural_ends: true", 8, "SBB209", "continuity: C2"),
    ("family: polynomial_2\n    natural_ends: true", 3, "SBB209", "free_cubic"),
    ("natural_ends: true", 4, "SBB209", "`natural_ends`"),
    ("family: polynomial_3\n    closed: true", 4, "SBB209", "can be closed"),
    ("family: polynomial_3\n    knot_parameters: [0, 2, 3]", 4, "SBB206", "2 needed"),
    ("family: bspline_3", 3, "SBB307", "needs 4"),
    ("family: bspline_2\n    closed: true", 2, "SBB307", "needs 3"),
    ("family: bspline_2\n    knot_parameters: [0, 1, 2, 3]", 4, "SBB206", "3 needed"),
    ("family: bspline_2\n    knot_parameters: [0, 2, 1]", 4, "SBB205", "parameter 2"),
    ("family: bspline_2\n    breaks: [1]", 4, "SBB209", "corners"),
    ("family: fourier", 4, "SBB206", "odd number of rows"),
    ("family: fourier\n    knot_parameters: [0, 1]", 3, "SBB209", "knot parameters"),
    ("family: conic", 2, "SBB307", "conic has 3"),
    ("family: circle", 5, "SBB206", "circle has 3"),
    ("family: conic\n    closed: true\n    knot_parameters: [0, 1]", 3, "SBB209", "an arc is not closed"),
    ("family: conic\n    knot_parameters: [0, 7]", 3, "SBB205", "2π"),
    ("family: conic\n    knot_parameters: [1, 0]", 3, "SBB205", "not larger"),
    ("family: conic\n    knot_parameters: [0, 1, 2]", 3, "SBB206", "2 needed"),
    ("family: spiral", 3, "SBB204", "spiral"),
]


@pytest.mark.parametrize(("options", "rows", "code", "says"), BAD)
def test_options_of_other_families_are_refused(
    options: str, rows: int, code: str, says: str, tmp_path: Path
) -> None:
    """One error each, at the option (or the rows) that it is about."""
    (found,) = errors(tmp_path, f"    {options}\n", POINTS[:rows])
    assert found.code == code, found
    assert says in found.message + found.help
    assert found.line is not None and LINE - 1 <= found.line <= LINE + 3


def test_parallel_radius_vectors_span_no_plane(tmp_path: Path) -> None:
    (found,) = errors(tmp_path, "    family: conic\n", [[0, 0, 0], [10, 0, 0], [-20, 0, 0]])
    assert found.code == "SBB206" and "parallel" in found.message


def test_fixed_radius_vectors_must_be_those_of_a_circle(tmp_path: Path) -> None:
    options = "    family: circle\n    sigma: fixed\n"
    (found,) = errors(tmp_path, options, [[0, 0, 0], [10, 0, 0], [0, 10.1, 0]], "control")
    assert found.code == "SBB206" and "family: conic" in found.help


def test_parts_of_the_radius_vectors_cannot_be_held(tmp_path: Path) -> None:
    options = "    family: circle\n    held: [{knot: 1, components: [x]}]\n"
    (found,) = errors(tmp_path, options, [[0, 0, 0], [10, 0, 0], [0, 10, 0]], "partial")
    assert found.code == "SBB209" and "all components" in found.help


def test_fixed_segments_must_be_continuous(tmp_path: Path) -> None:
    lines = [[0, 0, 0], [100, 10, 5], [100, 10, 5.1], [50, 60, 1]]
    (found,) = errors(
        tmp_path, "    family: polynomial_1\n    continuity: C0\n    sigma: fixed\n", lines, "control"
    )
    assert found.code == "SBB206" and "not joined C0" in found.message


@pytest.fixture(scope="module")
def network() -> Network:
    """All families and options, as ties, in the six images."""
    return replace(block_with(*ALL, per_curve=12)[0], origin=np.array([7_600_000.0, 512_000.0, 0.0]))


def same_curves(found: Network, expected: Network) -> None:
    for mine, yours in zip(found.curves, expected.curves, strict=True):
        for name in ("id", "role", "family", "continuity", "natural_ends", "tension", "parameterization"):
            assert getattr(mine, name) == getattr(yours, name), mine.id
        for name in ("values", "reference", "knot_parameters"):
            a, b = getattr(mine, name), getattr(yours, name)
            assert (a is None) == (b is None), (mine.id, name)
            if a is not None:
                np.testing.assert_allclose(a, b, rtol=0.0, atol=1e-8, err_msg=mine.id)


def test_written_and_read_again(network: Network, tmp_path: Path) -> None:
    """Vectors among the values are not shifted by the origin of 7 600 km."""
    loaded = load_project(write_project(network, tmp_path, name="families"))
    assert loaded.diagnostics == ()
    same_curves(loaded.network, network)


def test_adjusting_the_adjusted_project_changes_nothing(network: Network, tmp_path: Path) -> None:
    """The same σ̂₀ and curves; references of the gauge conditions and parameters stay."""
    loaded = load_project(write_project(network, tmp_path / "first", name="families"))
    first = adjust(loaded.network)
    (tmp_path / "second").mkdir()
    for name, text in adjusted_project(loaded, first, tmp_path / "second").items():
        (tmp_path / "second" / name).write_text(text, encoding="utf-8")
    again = load_project(tmp_path / "second" / "adjusted.yaml")
    second = adjust(again.network)
    assert second.statistics.sigma0 == pytest.approx(first.statistics.sigma0, rel=1e-6)
    assert second.statistics.redundancy == first.statistics.redundancy
    for curve, mine, yours in zip(again.network.curves, second.curves, first.curves, strict=True):
        spread = max(yours.sigma_across_max, 1e-4)
        assert np.abs(mine.sample_xyz - yours.sample_xyz).max() < 20.0 * spread, curve.id
        assert mine.sigma_across_mean == pytest.approx(yours.sigma_across_mean, rel=1e-2)
