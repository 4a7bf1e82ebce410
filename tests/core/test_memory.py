"""What memory is left, from a system that a test has made up."""

from __future__ import annotations

from pathlib import Path

import pytest

from splinebba_cli.core.memory import available_memory


def _write(root: Path, files: dict[str, str]) -> None:
    for name, text in files.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="ascii")


MACHINE = {"proc/meminfo": "MemTotal: 900 kB\nMemFree: 100 kB\nMemAvailable:    500 kB\n"}
VERSION_2 = {
    "proc/self/cgroup": "0::/jobs/job7\n",
    "sys/fs/cgroup/jobs/memory.max": "400000\n",
    "sys/fs/cgroup/jobs/memory.current": "300000\n",
    "sys/fs/cgroup/jobs/memory.stat": "anon 200000\ninactive_file 50000\n",
    "sys/fs/cgroup/jobs/job7/memory.max": "max\n",
    "sys/fs/cgroup/jobs/job7/memory.current": "300000\n",
}
VERSION_1 = {
    "proc/self/cgroup": "5:cpu,cpuacct:/x\n4:memory:/job\n0::/\n",
    "sys/fs/cgroup/memory/job/memory.limit_in_bytes": "300000\n",
    "sys/fs/cgroup/memory/job/memory.usage_in_bytes": "250000\n",
}


@pytest.mark.parametrize(
    ("files", "left"),
    [
        (MACHINE, 512_000.0),
        (MACHINE | VERSION_2, 150_000.0),
        (MACHINE | VERSION_1, 50_000.0),
        ({}, float("inf")),
    ],
    ids=["machine", "cgroup 2, the folder above", "cgroup 1", "nothing known"],
)
def test_the_least_of_all_limits(tmp_path: Path, files: dict[str, str], left: float) -> None:
    _write(tmp_path, files)
    assert available_memory(tmp_path) == left


def test_a_limit_of_the_address_space(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    resource = pytest.importorskip("resource")
    page = resource.getpagesize()
    monkeypatch.setattr(resource, "getrlimit", lambda _: (1000 * page, 2000 * page))
    _write(tmp_path, {"proc/self/statm": "900 300 20 1 0 100 0\n"})
    assert available_memory(tmp_path) == 100 * page


def test_this_machine_has_some() -> None:
    assert available_memory() > 0.0
