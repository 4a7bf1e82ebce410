"""The published schemas: up to date, valid, and they say yes and no where the program does."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml

from splinebba_cli.project.json_schema import project_schema, schema_text
from tests.project.project_text import PROJECT, changed

SCHEMAS = Path(__file__).parents[2] / "schemas"


def complaints(text: str) -> list[str]:
    """What a validator says about YAML as it is commonly read, with native types."""
    validator = jsonschema.Draft202012Validator(project_schema())
    return [error.message for error in validator.iter_errors(yaml.safe_load(text))]


@pytest.mark.parametrize("which", ["project", "result", "campaign", "match"])
def test_published_schema_is_up_to_date(which: str) -> None:
    """To renew: splinebba schema project > schemas/project.schema.json (likewise result, campaign, match)."""
    published = (SCHEMAS / f"{which}.schema.json").read_text(encoding="utf-8")
    assert published == schema_text(which)


@pytest.mark.parametrize("which", ["project", "result", "campaign", "match"])
def test_schema_is_a_schema(which: str) -> None:
    jsonschema.Draft202012Validator.check_schema(json.loads(schema_text(which)))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("version: 1", "version: '1'"),
        ("principal_distance_mm: 150", "principal_distance_mm: 1e-6"),
        ("principal_distance_mm: 150", "principal_distance_mm: '150'"),
        ("sigma: 0.02}", "sigma: fixed}"),
        ("sigma: 0.02}", "sigma: [0.02, fixed, free]}"),
        ("  name: example", "  name: 2024"),
        ("    role: tie\n", "    role: tie\n    closed: yes\n"),
        ("    held: [{knot: 0}", "    check_values: {table: a.csv}\n    held: [{knot: 0}"),
        ("splines:\n", "splines:\n  - {table: knots.csv, role: tie}\n"),
    ],
)
def test_says_yes(old: str, new: str) -> None:
    assert complaints(PROJECT) == []
    assert complaints(changed(old, new)) == []


def test_one_table_in_place_of_a_list() -> None:
    text = changed(
        PROJECT[PROJECT.index("images:") : PROJECT.index("splines:")], "images: {table: images.csv}\n"
    )
    assert complaints(text) == []


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("    role: tie\n", "    rolle: tie\n"),
        ("    role: tie\n", "    role: tied\n"),
        ("version: 1\n", ""),
        ("version: 1", "version: 2"),
        ("principal_distance_mm: 150", "principal_distance_mm: 15O"),
        ("principal_distance_mm: 150", "principal_distance_mm: -150"),
        ("xyz: [100, 100, 10]", "xyz: [100, 100]"),
        ("sigma: 0.02}", "sigma: tight}"),
    ],
)
def test_says_no(old: str, new: str) -> None:
    assert complaints(changed(old, new)) != []


def properties(node: Any, name: str = "") -> list[tuple[str, dict[str, Any]]]:
    found = []
    if isinstance(node, dict):
        for key, value in node.get("properties", {}).items():
            found.append((f"{name}.{key}", value))
        for key, value in node.items():
            found += properties(value, key)
    elif isinstance(node, list):
        for value in node:
            found += properties(value, name)
    return found


def test_every_field_is_described() -> None:
    assert [name for name, field in properties(project_schema()) if not field.get("description")] == []
