"""What people see in an editor: yaml-language-server on samples and starters (npm install -g yaml-language-server)."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from splinebba_cli.starters.catalogue import TEMPLATES, build
from splinebba_cli.starters.folder import write_starter
from tests.editors.language_server import LanguageServer

ROOT = Path(__file__).parents[2]
COMMAND = os.environ.get("SPLINEBBA_YAML_LANGUAGE_SERVER") or shutil.which("yaml-language-server")
SAMPLES = sorted(ROOT.glob("sample_projects/**/project.yaml"))
HEAD = "# yaml-language-server: $schema=project.schema.json\n"

pytestmark = pytest.mark.skipif(
    COMMAND is None,
    reason="yaml-language-server is not installed (or SPLINEBBA_YAML_LANGUAGE_SERVER not set)",
)


@pytest.fixture(scope="module")
def server() -> Iterator[LanguageServer]:
    with LanguageServer([str(COMMAND)], ROOT) as running:
        yield running


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An aerial starter; other files may refer to its schema."""
    path = tmp_path_factory.mktemp("editor") / "aerial"
    write_starter(path, build("aerial").files)
    return path


@pytest.mark.parametrize("path", SAMPLES, ids=lambda path: path.parent.name)
def test_samples_are_clean(path: Path, server: LanguageServer) -> None:
    assert server.diagnostics(path, path.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize("name", TEMPLATES)
def test_starters_are_clean(name: str, server: LanguageServer, tmp_path: Path) -> None:
    path = write_starter(tmp_path / name, build(name).files)
    assert server.diagnostics(path, path.read_text(encoding="utf-8")) == []


def test_mistakes_are_flagged_where_they_stand(server: LanguageServer, folder: Path) -> None:
    lines = (folder / "project.yaml").read_text(encoding="utf-8").splitlines()
    number = next(n for n, line in enumerate(lines, start=1) if line.startswith("  principal_distance_mm:"))
    lines[number - 1] = "  principal_distance_mm: 15O"
    lines[number] = "  image_cordinates: pixel_corner"
    found = server.diagnostics(folder / "mistakes.yaml", "\n".join(lines))
    assert f"{number}: A number is expected, with a decimal point." in found
    assert f"{number + 1}: Property image_cordinates is not allowed." in found


def test_hover_has_meaning_and_unit(server: LanguageServer, folder: Path) -> None:
    path = folder / "project.yaml"
    text = path.read_text(encoding="utf-8")
    server.diagnostics(path, text)
    line = next(n for n, row in enumerate(text.splitlines(), start=1) if "principal_distance_mm" in row)
    assert "Principal distance c, mm" in server.hover(path, line, 5)


@pytest.mark.parametrize(
    ("text", "line", "column", "offered"),
    [
        ("version: 1\n\n", 3, 1, {"project", "cameras", "observations", "acceptance"}),
        ("project:\n  angle_unit: \n", 3, 15, {"deg", "gon", "rad"}),
        ("splines:\n- id: a\n  role: \n", 4, 9, {"control", "partial", "tie", "check"}),
        ("splines:\n- id: a\n  ro", 4, 5, {"role", "knots", "sigma"}),
        ("adjustment:\n  outliers:\n    method: \n", 4, 13, {"snooping", "huber", "danish"}),
        ("images:\n  table: a\n  c", 4, 4, {"camera", "columns"}),
    ],
)
def test_completion(
    text: str, line: int, column: int, offered: set[str], server: LanguageServer, folder: Path
) -> None:
    path = folder / f"completion-{line}-{column}-{len(text)}.yaml"
    server.diagnostics(path, HEAD + text)
    assert offered <= set(server.completion(path, line, column))
