"""How every command is called so that it succeeds, and so that it fails: for tests that no command may escape."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import typer
from typer.testing import CliRunner, Result

from splinebba_cli.commands.app import app


@dataclass(frozen=True)
class Case:
    """A command line and its exit code; words in braces are files of :func:`stage`."""

    command: str
    name: str
    words: str
    exit_code: int

    @property
    def id(self) -> str:
        """For pytest."""
        return f"{self.command}: {self.name}"


CASES = (
    Case("init", "list", "--list", 0),
    Case("init", "aerial", "{new}", 0),
    Case("init", "unknown template", "{new} --template nothing", 2),
    Case("init", "somebody's folder", "{folder}", 2),
    Case("init", "missing polyline", "{new} --polyline {nothing}", 2),
    Case("check", "valid", "{good}", 0),
    Case("check", "invalid", "{bad}", 2),
    Case("check", "too long a name", "{long}", 2),
    Case("check", "missing", "{nothing}", 2),
    Case("check", "not solvable", "{singular}", 3),
    Case("adjust", "accepted", "{good} -o {new} --no-html", 0),
    Case("adjust", "not accepted", "{strict} -o {new} --no-html", 1),
    Case("adjust", "invalid", "{bad} -o {new}", 2),
    Case("adjust", "missing", "{nothing}", 2),
    Case("adjust", "not solvable", "{singular} -o {new}", 3),
    Case("adjust", "output is a file", "{good} -o {file}", 2),
    Case("adjust", "output is somebody's folder", "{good} -o {folder}", 2),
    Case("adjust", "output has too long a name", "{good} -o {long}", 2),
    Case("adjust", "JUnit in no folder", "{good} -o {new} --junit {nothing}/j.xml", 2),
    Case("adjust", "JUnit is a folder", "{good} -o {new} --junit {folder}", 2),
    Case("adjust", "quiet and verbose", "{good} -o {new} -q -v", 2),
    Case("chains", "segments", "{segments} --columns x1,y1,x2,y2 -o {new}", 0),
    Case("chains", "missing", "{nothing} -o {new}", 2),
    Case("chains", "no header", "{segments} -o {new}", 2),
    Case("chains", "output in no folder", "{segments} --columns x1,y1,x2,y2 -o {nothing}/x.csv", 2),
    Case("chains", "output has too long a name", "{segments} --columns x1,y1,x2,y2 -o {long}", 2),
    Case("match", "matched", "{chains} -o {new} --no-html --rounds 3", 0),
    Case("match", "not accepted", "{demanding} -o {new} --no-html --rounds 3", 1),
    Case("match", "no chains", "{good} -o {new}", 2),
    Case("match", "invalid", "{bad} -o {new}", 2),
    Case("match", "missing", "{nothing}", 2),
    Case("match", "output is somebody's folder", "{chains} -o {folder}", 2),
    Case("match", "quiet and verbose", "{chains} -o {new} -q -v", 2),
    Case("simulate", "list", "list", 0),
    Case("simulate", "kind", "strip -o {new}", 0),
    Case("simulate", "project", "{good} -o {new}", 0),
    Case("simulate", "campaign", "{good} -o {new} --runs 1 --jobs 1 --figures none", 0),
    Case("simulate", "campaign without a solution", "six-image-singular -o {new} --runs 1 --figures none", 3),
    Case("simulate", "prediction", "{good} -o {new} --predict", 0),
    Case("simulate", "unknown kind", "no-such-kind", 2),
    Case("simulate", "invalid", "{bad} -o {new}", 2),
    Case("simulate", "there is one", "strip -o {good}", 2),
    Case("simulate", "bad study", "strip -o {new} --runs 1 --study x", 2),
    Case("simulate", "output has too long a name", "strip -o {long}", 2),
    Case("simulate", "campaign with too long a name", "strip -o {long} --runs 1", 2),
    Case("fit", "points", "{points} -o {new}", 0),
    Case("fit", "missing", "{nothing}", 2),
    Case("fit", "no points", "{file} -o {new}", 2),
    Case("fit", "no σ", "{points} -o {new} --role control", 2),
    Case("fit", "output in no folder", "{points} -o {nothing}/x.yaml", 2),
    Case("fit", "output has too long a name", "{points} -o {long}", 2),
    Case("compare", "same", "{results} {results}", 0),
    Case("compare", "different", "{results} {others} --fail-on-difference --alpha 0.99", 1),
    Case("compare", "no results", "{results} {folder}", 2),
    Case("compare", "bad α", "{results} {results} --alpha 7", 2),
    Case("batch", "accepted", "{good} -o {new} --no-html --jobs 1", 0),
    Case("batch", "one invalid", "{good} {bad} -o {new} --no-html", 2),
    Case("batch", "nothing found", "{nothing}/*.yaml", 2),
    Case("batch", "log in no folder", "{good} -o {new} --log {nothing}/log.jsonl", 2),
    Case("batch", "dry run", "{good} -o {new} --dry-run", 0),
    Case("report", "results", "{results}", 0),
    Case("report", "results elsewhere", "{results} -o {new}.txt", 0),
    Case("report", "no results", "{folder}", 2),
    Case("report", "output in no folder", "{results} -o {nothing}/r.html", 2),
    Case("schema", "project", "", 0),
    Case("schema", "unknown", "nosuch", 2),
    Case("explain", "code", "SBB301", 0),
    Case("explain", "unknown", "SBB000", 2),
)


def commands() -> list[str]:
    """All commands of the program."""
    return sorted(typer.main.get_command(app).commands)  # type: ignore[attr-defined]


def run(*arguments: object) -> Result:
    """A command in this process."""
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def stage(folder: Path) -> dict[str, str]:
    """Projects, results and other files for the cases."""
    for name, kind, seed in (
        ("good", "strip", 3),
        ("strict", "strip", 4),
        ("bad", "strip", 1),
    ):
        assert run("simulate", kind, "-o", folder / name, "--seed", seed).exit_code == 0
    assert run("simulate", "six-image-singular", "-o", folder / "singular").exit_code == 0
    _edit(folder / "strict", "\n", "\nacceptance: {max_sigma0: 1e-3}\n")
    _edit(folder / "bad", "cameras:", "kameras:")
    assert run("adjust", folder / "good", "-o", folder / "results", "--no-html").exit_code == 0
    assert run("adjust", folder / "strict", "-o", folder / "others", "--no-html").exit_code == 1
    _stage_chains(folder)
    (folder / "folder").mkdir()
    (folder / "folder" / "thesis.txt").write_text("mine", encoding="utf-8")
    (folder / "file").write_text("mine", encoding="utf-8")
    rows = "".join(f"{x},{0.01 * x * x},0\n" for x in range(30))
    (folder / "points.csv").write_text(f"x,y,z\n{rows}", encoding="utf-8")
    (folder / "segments.txt").write_text("1 2 30 40\n5 6 70 8\n", encoding="utf-8")
    names = (
        "good", "strict", "bad", "singular", "results", "others", "folder", "file", "nothing", "chains", "demanding",
    )  # fmt: skip
    return {name: str(folder / name) for name in names} | {
        "points": str(folder / "points.csv"),
        "segments": str(folder / "segments.txt"),
        "long": str(folder / ("x" * 300)),
    }


def _stage_chains(folder: Path) -> None:
    """A strip whose image points have no labels, a fifth of them in wrong chains; and one that asks for all of them."""
    assert run("simulate", "strip", "-o", folder / "labelled", "--seed", 3).exit_code == 0
    project = folder / "labelled" / "project.yaml"
    text = project.read_text(encoding="utf-8").partition("\nsimulation:")[0]
    errors = "start_position_m: 0.0, start_angle_deg: 0.0, start_knots_m: 0.0"
    chains = f"simulation: {{chains: true, chain_points: 15, wrong_chain_share: 0.2, {errors}}}"
    project.write_text(f"{text}\n{chains}\n", encoding="utf-8")
    for name in ("chains", "demanding"):
        assert run("simulate", folder / "labelled", "-o", folder / name).exit_code == 0
    _edit(folder / "demanding", "\n", "\nmatching: {min_matched_share: 0.999}\n")


def _edit(project: Path, old: str, new: str) -> None:
    path = project / "project.yaml"
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text + new if old == "\n" else text.replace(old, new), encoding="utf-8")
