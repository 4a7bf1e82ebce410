"""``kill -9`` (or Ctrl-C, SIGTERM) at random moments of an adjustment: the result folder is the old or the new one.

Two projects of other noise are adjusted in turn into one folder, with ``SOURCE_DATE_EPOCH``, so that all bytes of both
results are known.  Half of the runs are killed at a moment that is uniform over the time of a whole run, a quarter at
one that is uniform over the time of writing, a quarter within milliseconds after the new folder has got its place,
while the old one is taken away.  After each kill the folder must be one of the two results, file by file; the next run
that is not killed must leave nothing beside it.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

VERSIONS = ("a", "b")
TARGET = "out"
DONE = (0, 1)  # exit codes of an adjustment that has written its results
POLL_S = 0.002
POLL_EXCHANGE_S = 0.0002
AFTER_EXCHANGE_S = 0.005
BEYOND = 1.1  # of a phase: some kills come too late, so that none of its moments is left out

Digest = tuple[tuple[str, str], ...]


@dataclass
class Tally:
    """What the kills have found."""

    kills: int = 0
    finished: int = 0  # runs that were faster than the signal
    writing: int = 0  # kills that left a half-written folder: they fell into the writing
    after_swap: int = 0  # of these: the new folder had its place already
    found: Counter[str] = field(default_factory=Counter)  # "old", "new", "mixture", "missing"
    strays: list[str] = field(
        default_factory=list
    )  # beside the folder after a whole run, or after an orderly end
    codes: Counter[int] = field(default_factory=Counter)  # exit codes of the runs that got the signal

    @property
    def faults(self) -> int:
        """Folders that were neither of the two results, and files left beside them."""
        return self.found["mixture"] + self.found["missing"] + len(self.strays)


@dataclass(frozen=True)
class Scene:
    """Two projects and the folder that both are adjusted into."""

    folder: Path
    html: bool

    @property
    def target(self) -> Path:
        """The result folder."""
        return self.folder / "results" / TARGET

    @classmethod
    def set_up(cls, folder: Path, kind: str, *, html: bool) -> Scene:
        """Simulate the projects."""
        for seed, name in enumerate(VERSIONS):
            arguments = ["simulate", kind, "-o", str(folder / name), "--seed", str(seed), "-q"]
            subprocess.run(
                [sys.executable, "-m", "splinebba_cli", *arguments], check=True, capture_output=True
            )
        (folder / "results").mkdir()
        return cls(folder, html)

    def start(self, version: str) -> subprocess.Popen[bytes]:
        """Begin to adjust."""
        options = [] if self.html else ["--no-html"]
        command = [sys.executable, "-m", "splinebba_cli", "adjust", str(self.folder / version)]
        return subprocess.Popen(
            [*command, "-o", str(self.target), "-q", *options],
            env={**os.environ, "SOURCE_DATE_EPOCH": "1700000000"},
            preexec_fn=listening,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )

    def half_written(self) -> set[Path]:
        """Folders that are being filled, or that killed runs have left."""
        return set(self.target.parent.glob(f".{TARGET}.new-*"))

    def strays(self) -> list[str]:
        """What lies beside the folder."""
        return sorted(entry.name for entry in self.target.parent.iterdir() if entry.name != TARGET)


def listening() -> None:
    """Let a new process hear Ctrl-C: shells have it ignored by what they run in the background."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def digest(folder: Path) -> Digest:
    """Names and hashes of all files."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return tuple((str(p.relative_to(folder)), hashlib.sha256(p.read_bytes()).hexdigest()) for p in files)


def measured(scene: Scene, version: str) -> tuple[float, float]:
    """Seconds of a whole run, and of its writing."""
    begin, writing = time.perf_counter(), 0.0
    process = scene.start(version)
    while process.poll() is None:
        if not writing and scene.half_written():
            writing = time.perf_counter()
        time.sleep(POLL_S)
    end = time.perf_counter()
    if process.returncode not in DONE:
        raise RuntimeError(f"the adjustment of version {version} ended with {process.returncode}")
    return end - begin, end - (writing or end)


def strike(scene: Scene, runs: int, seed: int, number: int = signal.SIGKILL) -> Tally:
    """Send a signal to so many runs; after each, look at what is there."""
    chance, tally = random.Random(seed), Tally()
    known: dict[Digest, str] = {}
    for version in VERSIONS:
        whole, writing = measured(scene, version)
        known[digest(scene.target)] = version
    there = VERSIONS[-1]
    if len(known) != len(VERSIONS):
        raise RuntimeError("both results are the same: nothing could be told apart")
    for run in range(runs):
        wanted, before = VERSIONS[1 - VERSIONS.index(there)], scene.half_written()
        process = scene.start(wanted)
        if run % 4 == 3:
            _wait_for_exchange(process, scene, scene.target.stat().st_ino)
            _end_after(process, number, chance.uniform(0.0, AFTER_EXCHANGE_S), tally)
        elif run % 2:
            _wait_for_writing(process, scene, before)
            _end_after(process, number, chance.uniform(0.0, BEYOND * writing), tally)
        else:
            _end_after(process, number, chance.uniform(0.0, BEYOND * whole), tally)
        found = known.get(digest(scene.target)) if scene.target.is_dir() else "missing"
        half_written = bool(scene.half_written() - before)
        if number != signal.SIGKILL:
            tally.strays += scene.strays()
        tally.writing += half_written
        tally.after_swap += half_written and found == wanted
        tally.found["new" if found == wanted else "old" if found == there else found or "mixture"] += 1
        there = found if found in VERSIONS else there
    measured(scene, there)
    tally.strays += scene.strays()
    tally.found["mixture"] += known.get(digest(scene.target)) != there
    return tally


def _end_after(process: subprocess.Popen[bytes], number: int, seconds: float, tally: Tally) -> None:
    """Send the signal after some time, if the process runs still."""
    try:
        process.wait(seconds)
        tally.finished += 1
    except subprocess.TimeoutExpired:
        process.send_signal(number)
        code = process.wait()
        if code in DONE:  # in the meantime
            tally.finished += 1
        else:
            tally.codes[code] += 1
            tally.kills += 1


def _wait_for_writing(process: subprocess.Popen[bytes], scene: Scene, before: set[Path]) -> None:
    """Until a run begins to write, or ends."""
    while process.poll() is None and not scene.half_written() - before:
        time.sleep(POLL_S)


def _wait_for_exchange(process: subprocess.Popen[bytes], scene: Scene, inode: int) -> None:
    """Until the new folder has its place, or the run ends."""
    while process.poll() is None and scene.target.stat().st_ino == inode:
        time.sleep(POLL_EXCHANGE_S)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--signal", default="KILL", choices=("KILL", "INT", "TERM"))
    parser.add_argument("--kind", default="six-image-mixed", help="kind of block")
    parser.add_argument("--no-html", action="store_true", help="without report.html: writing is shorter")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        scene = Scene.set_up(Path(folder), chosen.kind, html=not chosen.no_html)
        tally = strike(scene, chosen.runs, chosen.seed, signal.Signals[f"SIG{chosen.signal}"])
    codes = ", ".join(f"{count} with exit code {code}" for code, count in sorted(tally.codes.items()))
    print(f"{tally.kills} runs ended by SIG{chosen.signal} ({codes}), {tally.finished} had finished before")
    print(
        f"{tally.writing} left a half-written folder, {tally.after_swap} of them with the new one in its place"
    )
    print(", ".join(f"{tally.found[name]} {name}" for name in ("old", "new", "mixture", "missing")))
    print(f"left beside the folder: {', '.join(tally.strays) or 'nothing'}")
    sys.exit(1 if tally.faults else 0)


if __name__ == "__main__":
    main()
