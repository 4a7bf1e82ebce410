"""Folders and files are the old ones or the new ones, whatever happens."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from splinebba_cli.errors import OutputError
from splinebba_cli.output import atomic
from splinebba_cli.output.atomic import replace_directory, write_file_atomically


def _always(_: Path) -> bool:
    return True


def _write(target: Path, text: str) -> None:
    with replace_directory(target, _always) as folder:
        (folder / "a").write_text(text)
        (folder / "b").write_text(text)


def _leftovers(parent: Path) -> list[str]:
    return [entry.name for entry in parent.iterdir() if entry.name.startswith(".")]


@pytest.mark.parametrize("exchange", [True, False])
def test_replaces_and_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, exchange: bool) -> None:
    if not exchange:
        monkeypatch.setattr(atomic, "exchange", lambda *_: False)
    target = tmp_path / "deep" / "out"
    _write(target, "old")
    (target / "stale").touch()
    _write(target, "new")
    assert sorted(entry.name for entry in target.iterdir()) == ["a", "b"]
    assert (target / "a").read_text() == "new"
    assert _leftovers(target.parent) == []


def test_a_folder_keeps_its_permissions(tmp_path: Path) -> None:
    target = tmp_path / "out"
    before = os.umask(0o027)
    try:
        _write(target, "old")
        assert target.stat().st_mode & 0o777 == 0o750  # those of any new folder, not of a temporary one
        target.chmod(0o705)
        _write(target, "new")
    finally:
        os.umask(before)
    assert target.stat().st_mode & 0o777 == 0o705


def test_a_folder_is_on_the_disk_before_it_takes_its_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A power failure finds whole files under the final name."""
    forced: list[int] = []
    at_the_exchange: list[int] = []
    real_exchange, real_fsync = atomic.exchange, os.fsync

    def fsync(descriptor: int) -> None:
        forced.append(os.fstat(descriptor).st_ino)
        real_fsync(descriptor)

    def exchange(first: Path, second: Path) -> bool:
        at_the_exchange.extend(forced)
        return real_exchange(first, second)

    target = tmp_path / "out"
    _write(target, "old")
    monkeypatch.setattr(os, "fsync", fsync)
    monkeypatch.setattr(atomic, "exchange", exchange)
    with replace_directory(target, _always) as folder:
        (folder / "a").write_text("new")
        (folder / "inside").mkdir()
        (folder / "inside" / "b").write_text("new")
    written = {
        path.stat().st_ino for path in (target, target / "a", target / "inside", target / "inside" / "b")
    }
    assert written <= set(at_the_exchange)
    assert tmp_path.stat().st_ino == forced[-1]


def test_failure_leaves_the_old_folder(tmp_path: Path) -> None:
    target = tmp_path / "out"
    _write(target, "old")
    with pytest.raises(RuntimeError), replace_directory(target, _always) as folder:
        (folder / "a").write_text("half")
        raise RuntimeError
    assert (target / "a").read_text() == "old"
    assert _leftovers(tmp_path) == []


def test_failed_second_rename_brings_the_old_folder_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = tmp_path / "out"
    _write(target, "old")
    monkeypatch.setattr(atomic, "exchange", lambda *_: False)
    rename = os.rename
    calls = []

    def failing(source: Path, destination: Path) -> None:
        calls.append(source)
        if len(calls) == 2:
            raise OSError(28, "No space left on device")
        rename(source, destination)

    monkeypatch.setattr(atomic.os, "rename", failing)
    with pytest.raises(OutputError, match="No space left"):
        _write(target, "new")
    assert (target / "b").read_text() == "old"


def test_recovers_what_a_killed_run_renamed_away(tmp_path: Path) -> None:
    _write(tmp_path / "out", "old")
    (tmp_path / "out").rename(tmp_path / ".out.old-77")
    (tmp_path / ".out.new-xyz").mkdir()
    with pytest.raises(RuntimeError), replace_directory(tmp_path / "out", _always):
        raise RuntimeError
    assert (tmp_path / "out" / "a").read_text() == "old"
    assert _leftovers(tmp_path) == []


def test_refuses_a_foreign_folder_and_a_file(tmp_path: Path) -> None:
    home = tmp_path / "home"
    home.mkdir()
    (home / "thesis.doc").touch()
    with pytest.raises(OutputError) as caught, replace_directory(home, lambda _: False):
        pass
    assert caught.value.code == "SBB602"
    assert (home / "thesis.doc").exists()
    with pytest.raises(OutputError, match="is a file"), replace_directory(home / "thesis.doc", _always):
        pass


def test_second_run_is_refused_while_the_first_writes(tmp_path: Path) -> None:
    target = tmp_path / "out"
    with replace_directory(target, _always) as folder:
        (folder / "a").write_text("first")
        with pytest.raises(OutputError, match="another run"), replace_directory(target, _always):
            pass
    assert (target / "a").read_text() == "first"


def test_follows_a_symbolic_link(tmp_path: Path) -> None:
    _write(tmp_path / "real", "old")
    (tmp_path / "link").symlink_to(tmp_path / "real")
    _write(tmp_path / "link", "new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real" / "a").read_text() == "new"


_WRITER = """
import sys
from pathlib import Path
from splinebba_cli.output.atomic import replace_directory
number = 0
while True:
    number += 1
    with replace_directory(Path(sys.argv[1]), lambda _: True) as folder:
        for name in "abc":
            (folder / name).write_text(str(number))
    print(number, flush=True)
"""


def test_killed_runs_leave_whole_folders(tmp_path: Path) -> None:
    target = tmp_path / "out"
    for attempt in range(8):
        process = subprocess.Popen([sys.executable, "-c", _WRITER, str(target)], stdout=subprocess.PIPE)
        assert process.stdout is not None
        process.stdout.readline()
        time.sleep(0.002 * attempt)
        process.send_signal(signal.SIGKILL)
        process.wait()
        process.stdout.close()
        assert len({(target / name).read_text() for name in "abc"}) == 1
    _write(target, "last")
    assert _leftovers(tmp_path) == []


def test_file(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    write_file_atomically(path, "σ\n")
    path.chmod(0o640)
    write_file_atomically(path, b"two")
    assert path.read_bytes() == b"two"
    assert path.stat().st_mode & 0o777 == 0o640
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.txt"]
    with pytest.raises(OutputError) as caught:
        write_file_atomically(tmp_path / "no" / "a", "x")
    assert caught.value.code == "SBB601"
