"""Full disks, forbidden folders, names that will not do, other runs: a message of its own, the old results whole."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from benchmarks.kill_nine import digest
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.errors import ExitCode, OutputError
from splinebba_cli.output.atomic import replace_directory, reserve_directory, write_file_atomically
from splinebba_cli.output.locking import lock_path
from splinebba_cli.output.publish import published
from splinebba_cli.output.result_folder import is_result_folder
from tests.output.factory import make_result, write_results

resource = pytest.importorskip("resource", reason="limits of POSIX")
ROOT = hasattr(os, "geteuid") and os.geteuid() == 0
NOBODY = 65534


@pytest.fixture(scope="module")
def result() -> AdjustmentResult:
    return make_result()


def write(folder: Path, result: AdjustmentResult, text: str = "new") -> None:
    write_results(folder, result, adjusted_files={"adjusted.yaml": text}, html=False)


@contextmanager
def largest_file(size: int) -> Iterator[None]:
    """No file of this process can become larger: the system says so as it does when a disk is full."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@contextmanager
def mounted(folder: Path, *options: str) -> Iterator[Path]:
    """A small file system in memory."""
    if not ROOT or shutil.which("mount") is None:
        pytest.skip("only root mounts file systems")
    folder.mkdir()
    done = subprocess.run(["mount", "-t", "tmpfs", *options, "tmpfs", str(folder)], capture_output=True)
    if done.returncode != 0:
        pytest.skip("this system lets nobody mount a file system")
    try:
        yield folder
    finally:
        subprocess.run(["umount", str(folder)], check=True)


def test_no_room_for_any_of_the_files(tmp_path: Path, result: AdjustmentResult) -> None:
    """Every file in turn is the first that does not fit."""
    target = tmp_path / "out"
    write(target, result, "old")
    before = digest(target)
    sizes = sorted({path.stat().st_size for path in target.iterdir()} - {0})
    assert len(sizes) > 8
    for size in sizes:
        with largest_file(size - 1), pytest.raises(OutputError) as caught:
            write(target, result, "x" * 10)
        assert caught.value.code == "SBB604" and str(target) in caught.value.message, size
        assert caught.value.exit_code == ExitCode.INVALID and caught.value.help
        assert digest(target) == before
        assert [entry.name for entry in tmp_path.iterdir()] == ["out"]


def test_a_full_disk(tmp_path: Path, result: AdjustmentResult) -> None:
    with mounted(tmp_path / "disk", "-o", "size=256k") as disk:
        write(disk / "out", result, "old")
        before = digest(disk / "out")
        (disk / "ballast").write_bytes(b"x" * (os.statvfs(disk).f_bavail * os.statvfs(disk).f_frsize - 4096))
        with pytest.raises(OutputError) as caught:
            write(disk / "out", result)
        assert caught.value.code == "SBB604"
        assert digest(disk / "out") == before
        assert {entry.name for entry in disk.iterdir()} == {"out", "ballast"}
        with pytest.raises(OutputError) as caught:
            write_file_atomically(disk / "out" / "report.txt", "x" * 10_000)
        assert caught.value.code == "SBB604" and digest(disk / "out") == before


def test_a_read_only_disk(tmp_path: Path, result: AdjustmentResult) -> None:
    with mounted(tmp_path / "disk", "-o", "size=1m") as disk:
        write(disk / "out", result, "old")
        before = digest(disk / "out")
        subprocess.run(["mount", "-o", "remount,ro", str(disk)], check=True)
        for attempt in (
            lambda: write(disk / "out", result),
            lambda: write_file_atomically(disk / "out" / "report.txt", "x"),
            lambda: _publish(disk / "block"),
        ):
            with pytest.raises(OutputError) as caught:
                attempt()
            assert caught.value.code == "SBB605"
        assert digest(disk / "out") == before


def test_a_mounted_folder_cannot_be_replaced(tmp_path: Path, result: AdjustmentResult) -> None:
    with mounted(tmp_path / "disk", "-o", "size=1m") as disk:
        with pytest.raises(OutputError) as caught:
            write(disk, result)
        assert caught.value.code == "SBB601" and "inside" in caught.value.help
        assert list(disk.iterdir()) == []
        _publish(disk)  # files find their places in it
        assert {entry.name for entry in disk.iterdir()} == {"project.yaml", "points.csv"}


def test_somebody_elses_folder(tmp_path: Path, result: AdjustmentResult) -> None:
    if ROOT and not hasattr(os, "seteuid"):
        pytest.skip("root may write everywhere")
    folder = tmp_path / "theirs"
    write(folder / "out", result, "old")
    before = digest(folder / "out")
    folder.chmod(0o555)
    for parent in (tmp_path, *tmp_path.parents[:2]):
        parent.chmod(parent.stat().st_mode | 0o055)
    try:
        if ROOT:
            os.seteuid(NOBODY)
        with pytest.raises(OutputError) as caught:
            write(folder / "out", result)
    finally:
        if ROOT:
            os.seteuid(0)
        folder.chmod(0o755)
    assert caught.value.code == "SBB605" and "may write" in caught.value.help
    assert digest(folder / "out") == before


def test_names_that_will_not_do(tmp_path: Path, result: AdjustmentResult) -> None:
    (tmp_path / "file").touch()
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    for target in (tmp_path / ("x" * 300), tmp_path / "file" / "out", tmp_path / "loop" / "out"):
        for attempt in (lambda at: write(at, result), lambda at: write_file_atomically(at, "x"), _publish):
            with pytest.raises(OutputError) as caught:
                attempt(target)
            assert caught.value.code in ("SBB607", "SBB601"), target
            assert caught.value.exit_code == ExitCode.INVALID
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["file", "loop"]


def test_the_folder_vanishes_while_it_is_filled(tmp_path: Path) -> None:
    parent = tmp_path / "parent"
    with pytest.raises(OutputError) as caught, replace_directory(parent / "out", lambda _: True) as folder:
        (folder / "a").touch()
        shutil.rmtree(parent)
    assert caught.value.code == "SBB601" and "removed meanwhile" in caught.value.help


def test_what_cannot_be_written_is_said_before_the_work(tmp_path: Path) -> None:
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "chapter.txt").touch()
    worked = False
    with pytest.raises(OutputError), reserve_directory(tmp_path / "thesis", is_result_folder):
        worked = True
    assert not worked


def test_no_folders_are_left_of_a_run_without_results(tmp_path: Path) -> None:
    with pytest.raises(ValueError), reserve_directory(tmp_path / "a" / "b" / "out", lambda _: True):  # noqa: PT011
        raise ValueError
    assert list(tmp_path.iterdir()) == []


_HOLDER = """
import sys
from pathlib import Path
from splinebba_cli.output.atomic import reserve_directory
with reserve_directory(Path(sys.argv[1]), lambda _: True):
    print("held", flush=True)
    sys.stdin.read()
"""


def test_two_runs_at_once(tmp_path: Path, result: AdjustmentResult) -> None:
    target = tmp_path / "out"
    write(target, result, "old")
    before = digest(target)
    with subprocess.Popen(
        [sys.executable, "-c", _HOLDER, str(target)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as other:
        assert other.stdout is not None and other.stdout.readline() == b"held\n"
        with pytest.raises(OutputError) as caught:
            write(target, result)
        assert caught.value.code == "SBB606" and "another run is writing" in caught.value.message
        assert digest(target) == before
        other.kill()
    assert lock_path(target).exists(), "the dead run has left its lock"
    write(target, result)
    assert digest(target) != before
    assert [entry.name for entry in tmp_path.iterdir()] == ["out"]


def test_files_of_killed_runs_are_removed_and_those_at_work_are_not(tmp_path: Path) -> None:
    import fcntl

    dead, alive = tmp_path / ".a.txt.new-123-1", tmp_path / ".a.txt.new-124-1"
    dead.touch()
    with alive.open("w") as stream:
        fcntl.flock(stream, fcntl.LOCK_EX)
        write_file_atomically(tmp_path / "a.txt", "x")
        assert {entry.name for entry in tmp_path.iterdir()} == {"a.txt", alive.name}


def _publish(folder: Path) -> None:
    with published(folder, "project.yaml") as fresh:
        (fresh / "points.csv").write_text("x", encoding="utf-8")
        (fresh / "project.yaml").write_text("x", encoding="utf-8")


def test_published_files_come_together_or_not_at_all(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine", encoding="utf-8")
    with pytest.raises(RuntimeError), published(tmp_path / "block", "project.yaml") as fresh:
        (fresh / "points.csv").touch()
        raise RuntimeError
    assert [entry.name for entry in tmp_path.iterdir()] == ["notes.txt"]
    (tmp_path / ".splinebba-new-killed").mkdir()
    _publish(tmp_path)
    assert {entry.name for entry in tmp_path.iterdir()} == {"notes.txt", "points.csv", "project.yaml"}
    with pytest.raises(OutputError), published(tmp_path, "project.yaml"), published(tmp_path, "project.yaml"):
        pass
    assert (tmp_path / "project.yaml").read_text(encoding="utf-8") == "x"


def test_the_last_file_is_missing_while_the_others_take_their_places(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _publish(tmp_path)
    place, seen = os.replace, []

    def looking(source: Path, target: Path) -> None:
        seen.append((target.name, (tmp_path / "project.yaml").exists()))
        place(source, target)

    monkeypatch.setattr(os, "replace", looking)
    _publish(tmp_path)
    assert seen == [("points.csv", False), ("project.yaml", False)]


def test_a_signal_waits_until_published_files_are_in_their_places(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    place = os.replace

    def interrupted(source: Path, target: Path) -> None:
        signal.raise_signal(signal.SIGINT)
        place(source, target)

    monkeypatch.setattr(os, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        _publish(tmp_path)
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["points.csv", "project.yaml"]
