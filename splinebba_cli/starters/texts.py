"""The texts of the starters: project files and notes with a few values to fill in."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.resources import files
from string import Template

from splinebba_cli.project.file_content import PROJECT_FILE
from splinebba_cli.project.json_schema import schema_text
from splinebba_cli.project.yaml_writing import FIRST_LINE

SCHEMA_FILE = "project.schema.json"


def project_texts(template: str, values: Mapping[str, object]) -> dict[str, str]:
    """Project file, notes and schema of a starter, name to text.

    Parameters
    ----------
    template : name of the starter
    values : what stands for ``${name}`` in its texts
    """
    project = Template(stored_text(template, PROJECT_FILE)).substitute(values)
    notes = Template(stored_text(template, "README.md")).substitute(values)
    return {PROJECT_FILE: FIRST_LINE + project, "README.md": notes, SCHEMA_FILE: schema_text("project")}


def stored_text(template: str, file: str) -> str:
    """A file of a starter as it is stored in the package."""
    return files(__package__).joinpath("texts", template, file).read_text(encoding="utf-8")
