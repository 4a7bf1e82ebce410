"""How much memory this process may still take: the least of what the machine, its container and its limits leave.

    machine     MemAvailable of /proc/meminfo
    container   limit − usage of the memory cgroup of the process and of all above it (versions 1 and 2), where what
                the kernel keeps of files can be given back: usage − inactive_file
    limit       RLIMIT_AS − the size of the process

What a system does not say is no limit; other systems than Linux say nothing.

References
----------
proc(5), cgroups(7), getrlimit(2); Linux documentation, admin-guide/cgroup-v2 (memory.max, memory.current,
    memory.stat).
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

ROOT = Path("/")


def available_memory(root: Path = ROOT) -> float:
    """Bytes that can still be taken; infinity where nothing is known.

    Parameters
    ----------
    root : Path
        Where ``proc`` and ``sys`` lie.
    """
    return min(_of_machine(root), _of_containers(root), _of_limit(root))


def _of_machine(root: Path) -> float:
    for line in _text(root / "proc/meminfo").splitlines():
        if line.startswith("MemAvailable:"):
            return 1024.0 * float(line.split()[1])
    return float("inf")


def _of_containers(root: Path) -> float:
    least = float("inf")
    for line in _text(root / "proc/self/cgroup").splitlines():
        _, controllers, inside = line.split(":", 2)
        if controllers == "":
            top, names = root / "sys/fs/cgroup", ("memory.max", "memory.current")
        elif "memory" in controllers.split(","):
            top, names = root / "sys/fs/cgroup/memory", ("memory.limit_in_bytes", "memory.usage_in_bytes")
        else:
            continue
        parts = Path(inside.lstrip("/")).parts
        for depth in range(len(parts) + 1):
            least = min(least, _of_container(top.joinpath(*parts[:depth]), *names))
    return least


def _of_container(folder: Path, limit_name: str, usage_name: str) -> float:
    limit, usage = _number(folder / limit_name), _number(folder / usage_name)
    if limit is None or usage is None:
        return float("inf")
    statistics = dict(line.split(maxsplit=1) for line in _text(folder / "memory.stat").splitlines())
    files = statistics.get("total_inactive_file", statistics.get("inactive_file", "0"))
    return max(0.0, limit - usage + float(files))


def _of_limit(root: Path) -> float:
    try:
        resource = import_module("resource")
    except ImportError:
        return float("inf")
    soft = resource.getrlimit(resource.RLIMIT_AS)[0]
    pages = _text(root / "proc/self/statm").split()
    if soft == resource.RLIM_INFINITY or not pages:
        return float("inf")
    return max(0.0, float(soft) - float(pages[0]) * float(resource.getpagesize()))


def _number(path: Path) -> float | None:
    text = _text(path).strip()
    return float(text) if text.isdigit() else None


def _text(path: Path) -> str:
    """Content of a file of the system; empty where there is none."""
    try:
        return path.read_text(encoding="ascii", errors="replace")
    except OSError:
        return ""
