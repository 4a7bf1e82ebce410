"""``splinebba batch`` as a user and a CI system run it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import pytest
from typer.testing import CliRunner, Result

from splinebba_cli.batch import worker_process
from splinebba_cli.batch.outcome import Outcome
from splinebba_cli.commands.app import app
from splinebba_cli.output.result_json import load_result_json
from tests.batch.faulty_worker import start_code
from tests.batch.sample_copies import invalid, not_accepted, not_solvable, sample

OUTCOMES = {
    "accepted": "accepted", "dies": "killed", "invalid": "invalid", "not_accepted": "not accepted",
    "not_solvable": "not solvable", "raises": "program error", "sleeps": "timed out",
}  # fmt: skip
PLAIN = ("--no-html", "--dispersion", "none")


def run(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["batch", *map(str, arguments)])


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working directory, with worker processes that misbehave for projects of some names."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("GITHUB_STEP_SUMMARY", raising=False)
    monkeypatch.setattr(worker_process, "_START", start_code())
    return tmp_path


@pytest.fixture
def one_of_each(here: Path) -> Path:
    sample(here / "blocks" / "accepted")
    not_accepted(here / "blocks" / "not_accepted")
    invalid(here / "blocks" / "invalid")
    not_solvable(here / "blocks" / "not_solvable")
    for name in ("dies", "raises", "sleeps"):
        sample(here / "blocks" / name)
    return here


def lines_of(log: Path) -> list[dict[str, object]]:
    return [json.loads(line) for line in log.read_text(encoding="utf-8").splitlines()]


def test_one_of_each_outcome(one_of_each: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(one_of_each / "step.md"))
    files = ("--junit", "junit.xml", "--log", "batch.jsonl")
    result = run("blocks/sleeps", "blocks/**/project.yaml", "--jobs", 2, "--timeout", 12, *PLAIN, *files)
    assert result.exit_code == 70, result.output
    table = {line.split("/")[1]: line for line in result.stdout.splitlines() if line.startswith(" blocks/")}
    order = ["raises", "sleeps", "dies", "not_solvable", "invalid", "not_accepted", "accepted"]
    assert [*table] == order
    for name, verdict in OUTCOMES.items():
        assert f" {verdict} " in table[name]
    assert "blocks/accepted/project.results" in table["accepted"]
    assert "error[SBB801] its process was killed (SIGKILL)" in result.stdout
    assert "error[SBB802] not finished after 12 s" in result.stdout
    assert (
        "error[SBB970] unexpected error inside the program: RuntimeError: a mistake of ours" in result.stdout
    )
    assert "--> blocks/invalid/project.yaml:" in result.stdout
    assert result.stdout.rstrip().endswith(
        "7 projects: 1 accepted, 1 not accepted, 1 invalid, 1 not solvable, 1 killed, 1 timed out, 1 program error"
    )
    assert result.stderr.count("/7] blocks/") == 7
    written = {path.parent.name for path in one_of_each.glob("blocks/*/project.results")}
    assert written == {"accepted", "not_accepted"}
    _check_files(one_of_each)


def _check_files(folder: Path) -> None:
    root = ElementTree.parse(folder / "junit.xml").getroot()
    broken = {suite.attrib["name"].split("/")[1]: suite for suite in root}
    assert {name: int(suite.attrib["errors"]) for name, suite in broken.items()} == {
        name: int(name not in ("accepted", "not_accepted")) for name in OUTCOMES
    }
    (failure,) = broken["not_accepted"].iter("failure")
    assert failure.attrib["message"].endswith("exceeds 0.001 m") and root.attrib["failures"] == "1"
    assert (folder / "step.md").read_text(encoding="utf-8").count("| blocks/") == 7
    head, *lines, last = lines_of(folder / "batch.jsonl")
    assert (head["projects"], last["finished"], last["not_run"]) == (7, 7, 0)
    assert {str(line["project"]).split("/")[1]: line["verdict"] for line in lines} == OUTCOMES
    (raised,) = (line for line in lines if line["verdict"] == "program error")
    assert "a mistake of ours" in str(raised["details"]) and "Traceback" in str(raised["details"])


def test_resume_repeats_what_is_not_done(here: Path) -> None:
    sample(here / "done")
    again = invalid(here / "again")
    first = run("again", "done", *PLAIN, "--output", "out", "--jobs", 1)
    assert first.exit_code == 2, first.output
    before = (here / "out" / "done" / "project.results" / "result.json").stat()
    again.write_text(
        again.read_text(encoding="utf-8").replace("acceptanze:", "acceptance:"), encoding="utf-8"
    )
    listed = run("again", "done", *PLAIN, "--output", "out", "--resume", "--dry-run")
    assert listed.stdout.splitlines() == [
        "again/project.yaml -> out/again/project.results",
        "done/project.yaml -> out/done/project.results (up to date)",
    ]
    second = run("again", "done", *PLAIN, "--output", "out", "--resume", "--format", "json", "-q")
    assert (second.exit_code, second.stderr) == (0, "")
    data = json.loads(second.stdout)
    assert [(each["verdict"], each["up_to_date"]) for each in data["projects"]] == [
        ("accepted", False), ("accepted", True),
    ]  # fmt: skip
    after = (here / "out" / "done" / "project.results" / "result.json").stat()
    assert (before.st_ino, before.st_mtime_ns) == (after.st_ino, after.st_mtime_ns)
    kept = Outcome.of_data(data["projects"][1])
    assert kept.statistics == load_result_json(here / kept.results)["statistics"]


def test_results_are_those_of_adjust(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    sample(here / "block")
    assert run("block", "--output", "batch").exit_code == 0
    alone = CliRunner().invoke(app, ["adjust", "block", "-o", "alone"])
    assert alone.exit_code == 0, alone.output
    folder = here / "batch" / "block" / "project.results"
    names = sorted(path.name for path in folder.iterdir())
    assert names == sorted(path.name for path in (here / "alone").iterdir())
    different = {
        name for name in names if (folder / name).read_bytes() != (here / "alone" / name).read_bytes()
    }
    assert different <= {"adjusted.yaml"}  # its tables are named relative to it


def test_fail_fast_and_annotations(here: Path) -> None:
    for name in ("a", "b", "c"):
        invalid(here / name)
    result = run("a", "b", "c", "--fail-fast", "--jobs", 1, "--format", "github")
    assert result.exit_code == 2
    *annotations, count = result.stdout.splitlines()
    assert count == "3 projects: 2 not run, 1 invalid"
    assert annotations[0].startswith("::error file=a/project.yaml,line=") and "title=SBB201" in annotations[0]
    assert not any("file=b" in line or line.startswith("::notice") for line in annotations)


def begun_batch(folder: Path, *words: str) -> tuple[subprocess.Popen[str], int]:
    """A batch in a process of its own, and the number of its worker process, once that is at project `sleeps`."""
    code = (
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
        "from splinebba_cli.batch import worker_process; from tests.batch.faulty_worker import start_code; "
        "from splinebba_cli.commands.app import app; worker_process._START = start_code(); app()"
    )
    batch = subprocess.Popen(
        [sys.executable, "-c", code, "batch", *words, "--jobs", "1", *PLAIN],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])},
    )
    begun = folder / "sleeps" / "begun"
    assert _comes(lambda: begun.exists() and begun.read_text() != "")
    return batch, int(begun.read_text())


def _comes(state: Callable[[], bool]) -> bool:
    """Whether something is so, at last."""
    end = time.monotonic() + 120.0
    while not state() and time.monotonic() < end:
        time.sleep(0.05)
    return state()


def _gone(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    return False


def _ignores(process: int, number: int) -> bool:
    """Whether a process ignores a signal, as far as the system tells."""
    status = Path(f"/proc/{process}/status")
    if not status.exists():
        return True
    (mask,) = (line.split()[1] for line in status.read_text().splitlines() if line.startswith("SigIgn:"))
    return bool(int(mask, 16) >> (number - 1) & 1)


def test_interrupted(here: Path) -> None:
    sample(here / "done")
    sample(here / "sleeps")
    batch, worker = begun_batch(here, "done", "sleeps", "--log", "log.jsonl", "--junit", "junit.xml")
    assert _ignores(worker, signal.SIGINT)  # Ctrl-C reaches all processes of a terminal, and is for the batch
    os.killpg(batch.pid, signal.SIGINT)
    output, errors = batch.communicate(timeout=120)
    assert batch.returncode == 130, errors
    assert "2 projects: 1 accepted, 1 not run" in output
    assert "interrupted; 1 of 2 projects are done, --resume goes on" in errors
    assert (here / "done" / "project.results" / "result.json").exists()
    assert _gone(worker)
    assert len(list(ElementTree.parse(here / "junit.xml").getroot().iter("skipped"))) == 1
    assert lines_of(here / "log.jsonl")[-1]["not_run"] == 1


def test_a_killed_batch_leaves_no_workers(here: Path) -> None:
    sample(here / "sleeps")
    batch, worker = begun_batch(here, "sleeps")
    batch.kill()
    batch.communicate()
    assert _comes(lambda: _gone(worker))


def test_nothing_begins_where_something_is_wrong(here: Path) -> None:
    project = sample(here / "block")
    (here / "block" / "project.yml").write_bytes(project.read_bytes())
    for words, code in (
        (["nothing/**/project.yaml"], "SBB810"),
        (["block", "block/project.yml"], "SBB811"),
        (["block", "--junit", "no/such/folder.xml"], "SBB601"),
        (["block", "--log", "no/such/folder.jsonl"], "SBB601"),
    ):
        result = run(*words)
        assert result.exit_code == 2 and code in result.stderr, result.output
        as_json = run(*words, "--format", "json")
        assert json.loads(as_json.stdout)["problems"][0]["code"] == code
    assert not list(here.glob("block/*.results"))
