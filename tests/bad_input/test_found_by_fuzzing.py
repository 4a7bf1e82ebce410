"""What the fuzzer has found and has no place in the catalogue, because the project is right."""

from __future__ import annotations

import shutil
from pathlib import Path

from typer.testing import CliRunner

from splinebba_cli.commands.app import app
from tests.bad_input.cases import BASES


def test_a_level_of_significance_of_one_half(tmp_path: Path) -> None:
    """The critical value of a one-sided test is 0 then."""
    project = tmp_path / "p"
    shutil.copytree(BASES / "tables", project)
    path = project / "project.yaml"
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("alpha: 0.05", "alpha: 0.5"), encoding="utf-8")
    done = CliRunner().invoke(app, ["adjust", str(path), "--no-html", "-q"])
    assert done.exit_code in (0, 1), done.output
