"""Promises that every command keeps: exit codes, JSON and nothing but JSON on stdout, -q and -v, help."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
import typer

from splinebba_cli.commands.app import app
from tests.cli.command_cases import CASES, Case, commands, run, stage


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    return stage(tmp_path_factory.mktemp("commands"))


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def words_of(case: Case, files: dict[str, str], new: Path) -> list[str]:
    return [word.format(**files, new=new) for word in case.words.split()]


def not_finite(text: str) -> Any:
    raise AssertionError(f"{text} is no JSON")


def json_of(text: str) -> Any:
    return json.loads(text, parse_constant=not_finite)


def options_of(command: str) -> dict[str, Any]:
    click = typer.main.get_command(app).commands[command]  # type: ignore[attr-defined]
    return {name: option for option in click.params for name in option.opts}


@pytest.mark.parametrize("command", commands())
def test_no_command_escapes(command: str) -> None:
    """Add cases to command_cases.py."""
    own = [case for case in CASES if case.command == command]
    assert any(case.exit_code == 0 for case in own), f"no case in which {command} succeeds"
    assert any(case.exit_code == 2 for case in own), f"no case in which {command} fails"


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_exit_codes_and_json(case: Case, files: dict[str, str], tmp_path: Path) -> None:
    result = run(case.command, *words_of(case, files, tmp_path / "new"), "--format", "json")
    assert result.exit_code == case.exit_code, result.output
    found = json_of(result.stdout)
    assert "Traceback" not in result.output
    if case.exit_code in (2, 3) and not {"statistics", "projects"} & set(found):
        assert found["problems"], found
        for problem in found["problems"]:
            assert re.fullmatch(r"SBB\d{3}", problem["code"]) and problem["message"]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_exit_codes_of_text(case: Case, files: dict[str, str], tmp_path: Path) -> None:
    result = run(case.command, *words_of(case, files, tmp_path / "new"))
    assert result.exit_code == case.exit_code, result.output
    assert "\x1b" not in result.output and "\r" not in result.output
    if case.exit_code == 2 and case.command != "check" and case.id != "batch: one invalid":
        assert re.search(r"error\[SBB\d{3}\]", result.stderr) and result.stdout == ""


@pytest.mark.parametrize("command", commands())
def test_usage_errors_as_json(command: str) -> None:
    result = run(command, "--no-such-option", "--format", "json")
    assert result.exit_code == 2
    (problem,) = json_of(result.stdout)["problems"]
    assert problem["code"] == "SBB900" and "--no-such-option" in problem["message"]
    assert run(command, "--format=json", "--no-such-option").stdout == result.stdout
    as_text = run(command, "--no-such-option")
    assert as_text.exit_code == 2 and as_text.stdout == "" and "error[SBB900]" in as_text.stderr


@pytest.mark.parametrize("command", commands())
def test_an_unexpected_error_as_json(
    command: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def broken(**_: object) -> None:
        raise ValueError("a secret of the program")

    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    group: Any = typer.main.get_command(app)
    group.commands[command].callback = broken
    needed = [parameter for parameter in group.commands[command].params if parameter.required]
    with pytest.raises(SystemExit) as ended:
        group.main([command, *("x" for _ in needed), "--format", "json"], prog_name="splinebba")
    assert ended.value.code == 70
    out, err = capsys.readouterr()
    assert json_of(out)["problems"][0]["code"] == "SBB970"
    assert "Traceback" not in err and "the details are in" in err
    (log,) = tmp_path.glob("splinebba-error-*.log")
    assert "Traceback" in log.read_text(encoding="utf-8")


@pytest.mark.parametrize("command", commands())
def test_quiet_and_verbose_are_the_same_everywhere(command: str) -> None:
    options = options_of(command)
    if command in ("schema", "explain"):  # print at once
        return
    assert options["-q"] is options["--quiet"]
    result = run(command, "-q", "-v", *("x" for each in set(options.values()) if each.required))
    if "-v" in options:
        assert result.exit_code == 2 and "contradict" in result.stderr


@pytest.mark.parametrize("command", commands())
def test_help_has_examples_and_exit_codes(command: str) -> None:
    text = run(command, "--help").stdout
    assert f"splinebba {command} " in text.partition("Examples:")[2]
    assert "3 not solvable" in " ".join(text.split())
    assert not re.search(r"<(float|int|path|str)( range)?>", text.partition("Options:")[2]), "a plain metavar"
    (line,) = re.findall(rf"^  {command} .*$", run("--help").stdout, re.MULTILINE)
    assert not line.endswith("..."), "a summary that is cut off"


@pytest.mark.parametrize("command", commands())
def test_mistyped_commands_are_suggested(command: str) -> None:
    result = run(command[:-1] + "q")
    assert result.exit_code == 2
    assert f"did you mean `{command}`" in result.stderr  # and perhaps another one that is as near


def test_mistyped_options_are_suggested() -> None:
    result = run("adjust", "x.yaml", "--formt", "json")
    assert result.exit_code == 2
    assert "no such option: --formt" in result.stderr and "did you mean `--format`?" in result.stderr


def test_quiet_says_nothing_but_results(files: dict[str, str], tmp_path: Path) -> None:
    for command, *words in (
        ("check", "{good}"),
        ("adjust", "{good}", "-o", "{new}", "--no-html"),
        ("match", "{chains}", "-o", "{new}.matched", "--no-html", "--rounds", "2"),
        ("compare", "{results}", "{results}"),
        ("report", "{results}"),
        ("fit", "{points}", "-o", "{new}.yaml"),
        ("simulate", "{good}", "-o", "{new}.simulated"),
        ("simulate", "{good}", "-o", "{new}.campaign", "--runs", "1", "--figures", "none"),
    ):
        arguments = [word.format(**files, new=tmp_path / "new") for word in words]
        result = run(command, *arguments, "-q")
        assert result.exit_code == 0 and result.stdout and result.stderr == "", command


def test_verbose_tells_times_sizes_and_memory(files: dict[str, str], tmp_path: Path) -> None:
    line = ("adjust", files["good"], "-o", tmp_path / "new", "--no-html")
    plain = run(*line).stderr
    assert plain == run(*line).stderr, "other lines for the same input"
    assert {"approximate values", "dispersion", f"writing {tmp_path / 'new'}"} <= set(plain.splitlines())
    more = run(*line, "-v").stderr
    assert re.search(
        r"^size: \d+ observations, \d+ unknowns, \d+ conditions, redundancy \d+$", more, re.MULTILINE
    )
    assert re.search(r"^time: read [\d.]+ s, .*, write [\d.]+ s, in all [\d.]+ s$", more, re.MULTILINE)
    assert re.search(r"^memory: ", more, re.MULTILINE)
    most = run(*line, "-vv").stderr
    assert re.search(r"unknowns in \d+ fronts, factor ", most) and "damping" in most
    assert "fronts" not in more and "damping" not in more
