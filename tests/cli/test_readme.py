"""The README shows what the program prints, and commands that exist."""

from __future__ import annotations

import re

import jsonschema
import pytest
import yaml

from splinebba_cli import adjust, load_project
from splinebba_cli.commands.app import app
from splinebba_cli.errors import ExitCode
from splinebba_cli.project.json_schema import project_schema
from tests.regenerate_expected import FOLDER, README, SHOWN, output_of, shown_in_readme

NUMBER = re.compile(r"-?\d+(?:\.\d+)?")


def same_output(found: str, shown: str) -> bool:
    """The same text; numbers may differ by two units of their last digit, as another machine may round them."""
    if NUMBER.sub("#", " ".join(found.split())) != NUMBER.sub("#", " ".join(shown.split())):
        return False
    pairs = zip(NUMBER.findall(found), NUMBER.findall(shown), strict=True)
    return all(abs(float(a) - float(b)) <= 2.001 * 10.0 ** -len(b.partition(".")[2]) for a, b in pairs)


@pytest.mark.parametrize("arguments", SHOWN, ids=" ".join)
def test_shown_output_is_real(arguments: tuple[str, ...]) -> None:
    """To renew: python -m tests.regenerate_expected."""
    start, end = shown_in_readme(arguments)
    shown = README.read_text(encoding="utf-8")[start:end]
    assert same_output(output_of(arguments), shown)


def test_comparison_of_outputs() -> None:
    assert same_output("σ 1.234  x", "σ 1.235 x")
    assert not same_output("σ 1.234", "σ 1.237")
    assert not same_output("redundancy 772", "redundancy 778")
    assert not same_output("accepted", "rejected")


def test_exactly_two_commands_to_begin_with() -> None:
    commands = re.findall(r"^python3 -m venv .*$", README.read_text(encoding="utf-8"), re.MULTILINE)
    assert len(commands) == 2
    assert commands[0].endswith(" adjust sample_projects/six_image_block")
    assert (FOLDER / "six_image_block" / "project.yaml").exists()
    assert commands[1].endswith(" -m pytest")


def test_the_example_is_a_project() -> None:
    (example,) = re.findall(
        r"^```yaml\n(.*?)^```", README.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL
    )
    validator = jsonschema.Draft202012Validator(project_schema())
    assert [error.message for error in validator.iter_errors(yaml.safe_load(example))] == []


def test_the_python_example() -> None:
    loaded = load_project(FOLDER / "six_image_mixed" / "project.yaml")
    assert adjust(loaded.network).converged


def test_every_command_and_exit_code_is_explained() -> None:
    text = README.read_text(encoding="utf-8")
    for command in app.registered_commands:
        assert f"| `{command.name} " in text, command.name
    for code in ExitCode:
        assert f"| {int(code)} |" in text, code
