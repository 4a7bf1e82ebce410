"""Break projects at random and look for what must not happen: ``python -m tests.bad_input.fuzz --cases 20000``.

Every case is one of the projects of `base/` and `sample_projects/` with one to three mutations.  It is loaded, counted,
and a share of the accepted ones is adjusted.  Wrong are: an exception that is no SplinebbaError, more than the time
limit, values that are no numbers, a changed number that changes nothing, adjusted values that adjust to others.
A case depends on the seed and its number alone: ``--first N --cases 1 --keep DIR`` makes one again.
"""

from __future__ import annotations

import argparse
import collections
import random
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from types import FrameType

from splinebba_cli.core.budget import budget
from splinebba_cli.errors import SplinebbaError
from splinebba_cli.project.diagnostics import render_github, render_json, render_text
from splinebba_cli.project.loading import load_project
from tests.bad_input.cases import BASES, HERE
from tests.bad_input.mutations import OF_BYTES, Files, NumberChange, changed_data, changed_number
from tests.bad_input.oracles import OracleError, adjusted, check_meant, check_repeatable, fingerprint
from tests.bad_input.other_inputs import case_of_points, case_of_results

SAMPLES = HERE.parent.parent / "sample_projects"
SMALL = ("inline", "tables", "everything", "everything")
LARGE = ("six_image_mixed", "free_network", "circle_three_ways", "table_5_7_one_control_segment")
SHARE_OF_LARGE = 0.1
SHARE_COUNTED = 0.3  # of the accepted projects, of which counts and ranks are made
TIME_LIMIT = 120  # seconds of computing for one case: a search for outliers takes some hundred iterations
WAITING = 3  # times as long, a case may take on a busy machine
MEMORY = 6 * 2**30
WITHOUT_MEANING = ("truth.json", "README.md")


class TooSlowError(BaseException):
    """A case has used up its time; no handler of the program catches it."""


@dataclass
class Findings:
    """What came out of all cases."""

    outcomes: collections.Counter[str] = field(default_factory=collections.Counter)
    bugs: list[str] = field(default_factory=list)
    slowest: tuple[float, str] = (0.0, "")

    def report(self) -> str:
        """Counts, slowest case, bugs."""
        counts = "\n".join(f"  {name:32s} {count}" for name, count in sorted(self.outcomes.items()))
        bugs = "\n\n".join(self.bugs)
        return f"{counts}\nslowest: {self.slowest[0]:.1f} s, {self.slowest[1]}\n{len(self.bugs)} bugs\n{bugs}"


@cache
def project_files(name: str) -> dict[str, bytes]:
    """The files of a project by name."""
    folder = BASES / name if (BASES / name).exists() else SAMPLES / name
    return {
        p.name: p.read_bytes()
        for p in sorted(folder.iterdir())
        if p.is_file() and p.name not in WITHOUT_MEANING
    }


@cache
def meaning(name: str) -> str:
    """What a project means before it is broken."""
    with tempfile.TemporaryDirectory() as folder:
        return fingerprint(load_project(written(project_files(name), Path(folder))))


def written(files: Files, folder: Path) -> Path:
    """The project file of files in a folder."""
    for name, content in files.items():
        (folder / name).write_bytes(content)
    return folder / "project.yaml"


def broken(seed: int, number: int) -> tuple[str, Files, NumberChange | None, random.Random]:
    """Name and files of a broken project, and the number that was changed if that is all."""
    chance = random.Random(f"{seed} {number}")
    name = chance.choice(LARGE if chance.random() < SHARE_OF_LARGE else SMALL)
    files = dict(project_files(name))
    how = chance.random()
    if how < 0.15:
        return name, files, changed_number(files, chance.choice(sorted(files)), chance), chance
    if how < 0.4:
        for _ in range(chance.randint(1, 3)):
            files["project.yaml"] = changed_data(files["project.yaml"], chance)
        return name, files, None, chance
    for _ in range(chance.randint(1, 3)):
        one = "project.yaml" if chance.random() < 0.4 else chance.choice(sorted(files))
        files[one] = chance.choice(OF_BYTES)(files[one], chance)
    return name, files, None, chance


def one_case(seed: int, number: int, folder: Path, share_adjusted: float) -> str:
    """Load, count, perhaps adjust one broken project; what came of it."""
    name, files, change, chance = broken(seed, number)
    project = written(files, folder)
    try:
        loaded = load_project(project)
    except SplinebbaError as error:
        found = getattr(error, "diagnostics", ())
        for text in (render_text(found), render_json(found), render_github(found)):
            text.encode()
            if "\x1b" in text:
                raise OracleError("an escape sequence in a message") from None
        return f"refused {error.code}"
    render_text(loaded.diagnostics)
    if change is not None and not _is_label(change, files):
        check_meant(meaning(name), project)
    try:
        if chance.random() < SHARE_COUNTED:
            budget(loaded.network)
    except SplinebbaError as error:
        return f"not counted {error.code}"
    if chance.random() >= share_adjusted * (0.1 if name in LARGE else 1.0):
        return "accepted"
    try:
        content = adjusted(project, folder / "results")
    except SplinebbaError as error:
        return f"not solvable {error.code}"
    fits = not {"SBB510", "SBB531"} & {problem["code"] for problem in content["problems"]}
    if chance.random() < 0.3 and content["status"]["converged"] and fits:
        check_repeatable(content, folder / "results", folder / "again")
        return "adjusted twice"
    return "adjusted"


def _is_label(change: NumberChange, files: Files) -> bool:
    """Whether a changed number is a mark, which is a name."""
    header, *_ = files[change.file].splitlines()
    cells = files[change.file].split(b"\n")[change.line - 1].split(b",")
    names = header.split(b",")
    return b"mark" in names and cells[names.index(b"mark")] == repr(change.new).encode()


@contextmanager
def limited(seconds: int) -> Iterator[None]:
    """TooSlowError after some seconds of computing, or a multiple of it of waiting."""

    def stop(signal_number: int, frame: FrameType | None) -> None:
        raise TooSlowError

    kinds = ((signal.ITIMER_PROF, signal.SIGPROF, 1), (signal.ITIMER_REAL, signal.SIGALRM, WAITING))
    before = [signal.signal(number, stop) for _, number, _ in kinds]
    for timer, _, factor in kinds:
        signal.setitimer(timer, factor * seconds)
    try:
        yield
    finally:
        for (timer, number, _), handler in zip(kinds, before, strict=True):
            signal.setitimer(timer, 0)
            signal.signal(number, handler)


def run(
    numbers: range, case: Callable[[int, Path], str], keep: Path | None = None, limit: int = TIME_LIMIT
) -> Findings:
    """Run some cases; the files of those in which a bug was found are kept in a folder.

    Parameters
    ----------
    case : callable
        Gets the number of a case and an empty folder, gives what came of it.
    """
    findings = Findings()
    for number in numbers:
        folder = Path(tempfile.mkdtemp(prefix="fuzz-"))
        start = time.perf_counter()
        try:
            with limited(limit), warnings.catch_warnings():
                warnings.simplefilter("ignore")
                outcome = case(number, folder)
        except TooSlowError:
            outcome = "bug: too slow"
            findings.bugs.append(f"case {number}: more than {limit} s\n{traceback.format_exc(limit=-4)}")
        except Exception as error:  # noqa: BLE001 — a bug can be any of them
            outcome = f"bug: {type(error).__name__}"
            findings.bugs.append(f"case {number}: {traceback.format_exc(limit=-6)}")
        seconds = time.perf_counter() - start
        findings.outcomes[outcome] += 1
        findings.slowest = max(findings.slowest, (seconds, f"case {number}: {outcome}"))
        if keep is not None and (outcome.startswith("bug") or len(numbers) == 1):
            shutil.copytree(folder, keep / f"case_{number}", dirs_exist_ok=True)
        shutil.rmtree(folder)
        if (number + 1) % 1000 == 0:
            print(f"{number + 1}: {len(findings.bugs)} bugs", file=sys.stderr, flush=True)
    return findings


def main() -> int:
    """Exit code 1 where a bug was found."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--what", choices=("projects", "points", "results", "blunders"), default="projects")
    parser.add_argument("--cases", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--share-adjusted", type=float, default=0.15, help="of the accepted projects")
    parser.add_argument("--keep", type=Path, help="folder for the projects in which a bug was found")
    parser.add_argument("--limit", type=int, default=TIME_LIMIT, help="seconds for one case")
    options = parser.parse_args()
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    sys.setrecursionlimit(1000)
    start = time.perf_counter()
    numbers = range(options.first, options.first + options.cases)
    from tests.bad_input.blunders import case_of_blunders

    cases: dict[str, Callable[[int, Path], str]] = {
        "projects": lambda number, folder: one_case(options.seed, number, folder, options.share_adjusted),
        "points": lambda number, folder: case_of_points(options.seed, number, folder),
        "blunders": lambda number, folder: case_of_blunders(options.seed, number, folder),
        "results": lambda number, folder: case_of_results(options.seed, number, folder),
    }
    findings = run(numbers, cases[options.what], options.keep, options.limit)
    print(findings.report())
    print(f"{options.cases} cases with seed {options.seed} in {time.perf_counter() - start:.0f} s")
    return int(bool(findings.bugs))


if __name__ == "__main__":
    raise SystemExit(main())
