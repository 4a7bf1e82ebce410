"""The published schema on YAML as editors read it: it accepts what the program accepts and flags what it refuses."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from splinebba_cli.project.json_schema import project_schema
from tests.editors.yaml_core import load
from tests.project.project_text import changed

ROOT = Path(__file__).parents[2]
SAMPLES = sorted(ROOT.glob("sample_projects/**/project.yaml"))
FIRST = "# yaml-language-server: $schema="


def complaints(text: str) -> list[str]:
    return [
        error.message for error in jsonschema.Draft202012Validator(project_schema()).iter_errors(load(text))
    ]


def test_scalars_are_those_of_yaml_1_2() -> None:
    assert load("[0101, no, 12:30, 1e-6, 0x10, true, ~, .5]") == [
        101,
        "no",
        "12:30",
        1e-6,
        16,
        True,
        None,
        0.5,
    ]


@pytest.mark.parametrize("path", SAMPLES, ids=lambda path: path.parent.name)
def test_samples(path: Path) -> None:
    """Their first line leads to the published schema, and that accepts them."""
    text = path.read_text(encoding="utf-8")
    first = text.splitlines()[0]
    assert first.startswith(FIRST)
    schema = json.loads((path.parent / first.removeprefix(FIRST)).read_text(encoding="utf-8"))
    validator = jsonschema.Draft202012Validator(schema)
    assert [error.message for error in validator.iter_errors(load(text))] == []


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("version: 1\n", "version: 1\n"),
        ("  - {id: t1, role: tie}", "  - {id: 0x10, role: tie}\n  - {id: t1, role: tie}"),
        ("  name: example", "  name: 2024-05-01"),
        ("    role: tie\n", "    role: tie\n    closed: yes\n"),
        ("    role: tie\n", "    role: tie\n    closed: false\n    breaks: [0]\n"),
        ("sigma: 0.02}", "sigma: [free, .5, +2.e-2]}"),
        (
            "      sigma_um: 5\n      columns: [image, spline",
            "      sigma_um: [5, 6]\n      columns: [image, spline",
        ),
        ("  name: example", "  name: example\n  crs:"),
    ],
)
def test_accepted(old: str, new: str) -> None:
    assert complaints(changed(old, new)) == []


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("sigma: 0.02}", "sigma: 0}"),
        ("sigma: 0.02}", "sigma: -1}"),
        ("sigma: 0.02}", "sigma: '0.0'}"),
        ("sigma: 0.02}", "sigma: loose}"),
        (
            "      sigma_um: 5\n      columns: [image, spline",
            "      sigma_um: 0\n      columns: [image, spline",
        ),
        (
            "      sigma_um: 5\n      columns: [image, spline",
            "      sigma_um: [5, -5]\n      columns: [image, spline",
        ),
        ("    role: tie\n", "    role: tie\n    closed: maybe\n"),
        ("    role: tie\n", "    role: tie\n    breaks: [-1]\n"),
        ("kappa: 90}}", "kapa: 90}}"),
        ("version: 1\n", "version: 1\nobservation: {}\n"),
        ("version: 1\n", "version: 1\nadjustment: {outliers: {metod: huber}}\n"),
    ],
)
def test_flagged(old: str, new: str) -> None:
    assert complaints(changed(old, new)) != []


def objects(node: Any) -> list[dict[str, Any]]:
    """All schemas of mappings with known keys."""
    if isinstance(node, dict):
        own = [node] if isinstance(node.get("properties"), dict) and node.get("type") == "object" else []
        return own + [each for value in node.values() for each in objects(value)]
    return [each for value in node for each in objects(value)] if isinstance(node, list) else []


def test_unknown_keys_are_flagged_everywhere() -> None:
    found = objects(project_schema())
    assert len(found) > 20
    assert [
        list(each["properties"])[:3] for each in found if each.get("additionalProperties") is not False
    ] == []


def test_patterns_say_what_is_expected() -> None:
    """Editors show this instead of the pattern."""
    text = json.dumps(project_schema())
    assert text.count('"pattern":') == text.count('"patternErrorMessage":') > 20
