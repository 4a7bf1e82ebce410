"""Make the sample projects, what is expected of them, and the console output in README.md anew.

    python -m tests.regenerate_expected

Every sample is simulated from its seed and adjusted through the command line.  Look at the difference before you
keep it: what is written here is what tests/cli/test_sample_projects.py holds the program to.
"""

from __future__ import annotations

import contextlib
import json
import shutil
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from typer.testing import CliRunner, Result

from splinebba_cli.commands.app import app

FOLDER = Path(__file__).parents[1] / "sample_projects"
SCHEMA_LINE = "# yaml-language-server: $schema="
README = FOLDER.parent / "README.md"
BEGIN, END = "<!-- output of `splinebba {}` -->\n```text\n", "```\n<!-- end of output -->"
SHOWN = (("adjust", "sample_projects/six_image_block"), ("check", "sample_projects/six_image_mixed"))
LEFT_OUT = ("provenance", "convergence")  # differ from run to run and from machine to machine


@dataclass(frozen=True)
class Sample:
    """A sample project: how it is simulated, and how its adjustment must end."""

    name: str
    kind: str
    seed: int
    exit_code: int
    acceptance: str = ""
    nullity: int = 0  # of the measurements and priors alone
    edit: Callable[[Path], None] | None = None  # of the folder, after it was simulated
    match: bool = False  # whether its chains are matched before the adjustment

    @property
    def folder(self) -> Path:
        """Where it lies."""
        return FOLDER / self.name

    def expected(self, name: str) -> Any:
        """A file of what is expected."""
        return json.loads((self.folder / "expected" / name).read_text(encoding="utf-8"))


def freed(folder: Path) -> None:
    """Control points become tie points without a given precision; the datum is inner."""
    path, table = folder / "project.yaml", folder / "points.csv"
    text = path.read_text(encoding="utf-8").replace("  datum: control\n", "  datum: inner\n")
    path.write_text(text, encoding="utf-8", newline="\n")
    rows = [row.split(",") for row in table.read_text(encoding="utf-8").splitlines()]
    rows = [[row[0], "tie", *row[2:5], "", "", ""] if row[1] == "control" else row for row in rows]
    table.write_text("".join(",".join(row) + "\n" for row in rows), encoding="utf-8", newline="\n")


SAMPLES = (
    Sample(
        "six_image_block", "six-image", 1, 0, "acceptance: {global_test: true, max_position_sigma_m: 0.1}"
    ),
    Sample(
        "six_image_mixed", "six-image-mixed", 1, 0, "acceptance: {global_test: true, max_check_rmse_m: 0.1}"
    ),
    Sample("circle_three_ways", "circle-three-ways", 1, 0, "acceptance: {global_test: true}", nullity=2),
    Sample("table_5_7_one_control_segment", "six-image-singular", 1, 3),
    Sample(
        "free_network", "close-range-ring", 1, 0, "acceptance: {global_test: true}", nullity=6, edit=freed
    ),
    Sample("edge_chains", "edge-chains", 1, 0, "acceptance: {global_test: true}", match=True),
)


def run(*arguments: object) -> Result:
    """Run the program as a user does."""
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def simulate(sample: Sample, folder: Path) -> None:
    """Write the project of a sample: as simulated, with the schema of this repository and its acceptance."""
    result = run("simulate", sample.kind, "-o", folder, "--seed", sample.seed, "--force")
    assert result.exit_code == 0, result.output
    path = folder / "project.yaml"
    head, _, rest = path.read_text(encoding="utf-8").partition("\n")
    assert head.startswith(SCHEMA_LINE), head
    text = f"{SCHEMA_LINE}../../schemas/project.schema.json\n{rest}"
    if sample.edit is not None:
        path.write_text(text, encoding="utf-8", newline="\n")
        sample.edit(folder)
        text = path.read_text(encoding="utf-8")
    if sample.acceptance:
        text += f"\n{sample.acceptance}\n"
    path.write_text(text, encoding="utf-8", newline="\n")


def adjust(sample: Sample, output: Path) -> Result:
    """Adjust a sample where it lies, after matching its chains where it has some; results go to `output`."""
    project = sample.folder
    if sample.match:
        matched = output.with_name("matched")
        result = run("match", project, "-o", matched, "--format", "json", "-q", "--no-html")
        if result.exit_code:
            return result
        return run("adjust", matched / "matched.yaml", "-o", output, "--format", "json", "-q", "--no-html")
    return run("adjust", project, "-o", output, "--format", "json", "-q")


def regenerate(sample: Sample) -> None:
    """Make one sample and its expected results anew."""
    simulate(sample, sample.folder)
    expected = sample.folder / "expected"
    expected.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / "out"
        result = adjust(sample, output)
        assert result.exit_code == sample.exit_code, result.output
        if sample.exit_code == 0:
            content = json.loads((output / "result.json").read_text(encoding="utf-8"))
            kept = {key: value for key, value in content.items() if key not in LEFT_OUT}
            _write(expected / "result.json", kept)
        else:
            _write(expected / "problems.json", json.loads(result.stdout))


def shown_in_readme(arguments: tuple[str, ...]) -> tuple[int, int]:
    """Where README.md shows the output of a command: first and last character."""
    text = README.read_text(encoding="utf-8")
    begin = BEGIN.format(" ".join(arguments))
    start = text.index(begin) + len(begin)
    return start, text.index(END, start)


def output_of(arguments: tuple[str, ...]) -> str:
    """What a command prints that is run in a fresh clone."""
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        shutil.copytree(FOLDER, FOLDER.name, ignore=shutil.ignore_patterns("*.results"))
        result = run(*arguments)
        assert result.exit_code == 0, result.output
        return "".join(f"{line.rstrip()}\n" for line in result.stdout.strip().splitlines())


def refresh_readme() -> None:
    """Replace the console output in README.md."""
    for arguments in SHOWN:
        start, end = shown_in_readme(arguments)
        text = README.read_text(encoding="utf-8")
        README.write_text(text[:start] + output_of(arguments) + text[end:], encoding="utf-8", newline="\n")


def _write(path: Path, content: Any) -> None:
    path.write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", encoding="utf-8", newline="\n")


if __name__ == "__main__":
    for each in SAMPLES:
        regenerate(each)
        print(each.folder.relative_to(FOLDER.parent))
    refresh_readme()
    print(README.name)
