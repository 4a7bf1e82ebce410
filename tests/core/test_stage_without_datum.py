"""A stage that has no datum of its own ends as soon as it has settled, and the joint adjustment takes over."""

from __future__ import annotations

from pathlib import Path

from splinebba_cli import adjust, load_project
from splinebba_cli.core.result import Iteration
from splinebba_cli.starters.catalogue import build


def test_tie_points_without_control(tmp_path: Path) -> None:
    """Control splines alone carry this block: its points can be bent into shape, but never placed."""
    for name, text in build("control-splines").files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    log: list[Iteration] = []
    result = adjust(load_project(tmp_path / "project.yaml").network, observer=log.append)
    assert result.termination == "step negligible"
    points = [each for each in log if each.stage == "points"]
    assert 3 < len(points) < 15
    assert points[-1].step < 1e-6
