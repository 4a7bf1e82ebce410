"""Markdown tables from the JSON files of the benchmarks, printed or put in their places in a document.

    python -m benchmarks.performance_tables FIGURES.json ... [--into docs/performance.md]

A place in the document is what stands between

    <!-- figures: NAME -->
    <!-- end of figures -->

with the names of :func:`tables_of`.
"""

from __future__ import annotations

import argparse
import json
import re
import statistics
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from benchmarks.comparisons import Ratio, ratios_of
from benchmarks.measurements import SPEED, Run, runs_of, select
from benchmarks.start_up import ratios_of as start_up_ratios

PLACE = re.compile(r"(<!-- figures: (?P<name>[\w-]+) -->\n).*?(<!-- end of figures -->)", re.DOTALL)
Content = dict[str, Any]
AGREEMENT = {
    "cost": "vᵀPv, relative",
    "cost_peer_rule": "the same by the peer's rule at joints",
    "largest_difference": "orientations, largest, σ",
    "rms_difference": "orientations, RMS, σ",
    "sigma_x": "σX, relative",
    "sigma_z": "σZ, relative",
}


def markdown_table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table in GitHub's Markdown; all columns but the first to the right."""
    lines = [head, ["---", *["---:"] * (len(head) - 1)], *rows]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in lines) + "\n"


def tables_of(content: Content) -> dict[str, str]:
    """The tables of one JSON file, by the name of their place."""
    name = content["benchmark"]
    found = {f"{name}{suffix}": table for suffix, table in TABLES[name](content).items()}
    if name == "coastline":
        found = {f"coastline-{content['role']}": found["coastline"]}
    first = next(iter(found))
    return {**found, first: f"{found[first]}\n{measured_on(content['machine'])}"}


def measured_on(machine: dict[str, Any]) -> str:
    """One line: machine, versions, load."""
    versions = ", ".join(f"{name} {version}" for name, version in machine["packages"].items())
    return (
        f"{machine['processor']}, {machine['cores']} cores, {machine['memory_bytes'] / 2**30:.0f} GiB, "
        f"load {machine['load_average'][0]:.1f} at the start; Python {machine['python']}, {versions}; "
        f"commit {machine['commit']}, {machine['started'][:10]}\n"
    )


def _number(value: float) -> str:
    """Three significant digits."""
    return f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"


def _ratio_row(ratio: Ratio) -> list[str]:
    wanted, compared = ratio.wanted, ratio.comparison
    mark = {None: "", True: "yes", False: "**no**"}[ratio.reached]
    return [
        compared.name, str(ratio.images), {"plain": "numpy", "speed": "compiled"}.get(compared.mode, ""),
        _number(ratio.seconds), compared.other_name, _number(ratio.other_seconds),
        " / ".join(_number(value) for value in (ratio.least, ratio.median, ratio.most)),
        "" if wanted is None else _number(wanted), mark,
    ]  # fmt: skip


def _against_ceres(content: Content) -> dict[str, str]:
    runs = runs_of(content)
    head = (
        "what",
        "images",
        "mode",
        "s",
        "against",
        "s",
        "ratio: least / median / most",
        "wanted",
        "reached",
    )
    ratios = sorted(ratios_of(runs), key=lambda ratio: (ratio.comparison.name, ratio.images))
    table = markdown_table(head, map(_ratio_row, ratios))
    agreement = markdown_table(("images", *AGREEMENT.values()), _agreement_rows(content))
    first = markdown_table(
        ("images", "import s", "process with an empty cache s", "its first solution s", "first solution, cached s"),
        [
            [str(run.size), _number(run.figures["import_s"]), _number(run.wall_s),
             _number(run.figures["warm_up_s"]), _cached_warm_up(runs, run.size)]
            for run in runs if run.task == "first_use"
        ],
    )  # fmt: skip
    return {"": table, "-agreement": agreement, "-first-use": first}


def _agreement_rows(content: Content) -> Iterable[list[str]]:
    for images, values in content.get("agreement", {}).items():
        yield [images, *("–" if values[name] is None else f"{values[name]:+.1e}" for name in AGREEMENT)]


def _cached_warm_up(runs: list[Run], images: int) -> str:
    later = [run.figures["warm_up_s"] for run in select(runs, images, "solve", SPEED)]
    return _number(statistics.median(later)) if later else "–"


def _growth(content: Content) -> dict[str, str]:
    head = ("images", "mode", "observations", "wall s", "CPU s", "iterations", "s an iteration", "quality s",
            "peak GiB", "results GiB")  # fmt: skip
    rows = [
        [
            str(run.size), run.mode, str(run.figures["observations"]), _number(run.wall_s), _number(run.cpu_s),
            str(run.figures["iterations"]), _number(run.figures["estimation_s"] / run.figures["iterations"]),
            _number(run.figures["quality_s"]), _number(run.peak_bytes / 2**30),
            _number(run.figures["result_bytes"] / 2**30),
        ]
        for run in runs_of(content)
    ]  # fmt: skip
    return {"": markdown_table(head, rows) + _exponents(content, f" from {content['first']} images on")}


def _coastline(content: Content) -> dict[str, str]:
    head = ("knots", "images", "points", "mode", "iterations", "approximation s", "estimation s", "quality s",
            "ms a knot", "ms a knot and iteration", "peak KiB a knot")  # fmt: skip
    rows = []
    for run in runs_of(content):
        f = run.figures
        each = f["total_s"] / run.size
        rows.append([
            str(run.size), str(f["images"]), str(f["points"]), run.mode, str(f["iterations"]),
            *(_number(f[name]) for name in ("approximation_s", "estimation_s", "quality_s")),
            _number(1e3 * each), _number(1e3 * f["estimation_s"] / run.size / f["iterations"]),
            _number(run.peak_bytes / 2**10 / run.size),
        ])  # fmt: skip
    return {"": markdown_table(head, rows) + _exponents(content, "")}


def _exponents(content: Content, since: str) -> str:
    lines = [
        f"Exponents{since} ({mode}): "
        + ", ".join(f"{name} {value:.2f}" for name, value in found.items() if value is not None)
        + ".\n"
        for mode, found in content.get("exponents", {}).items()
    ]
    return "".join("\n" + line for line in lines)


def _roofline(content: Content) -> dict[str, str]:
    peaks = content["peaks"]
    limits = peaks["GFLOP/s, all threads"], peaks["GB/s, all threads"]
    rows = []
    for step in content["steps"]:
        bound = max(step["operations"] / limits[0], step["bytes"] / limits[1])
        rows.append([
            step["name"], _number(1e3 * step["seconds"]), _number(step["operations"] / 1e9),
            _number(step["bytes"] / 1e6), _number(step["operations"] / step["seconds"] / 1e9),
            _number(step["bytes"] / step["seconds"] / 1e9), f"{bound / step['seconds']:.1%}",
        ])  # fmt: skip
    head = (f"{content['images']} images", "ms", "GFLOP", "MB", "GFLOP/s", "GB/s", "share of the roofline")
    measured = ", ".join(f"{value / 1e9:.1f} {name}" for name, value in peaks.items())
    return {"": markdown_table(head, rows) + f"\nPeaks: {measured}.\n"}


def _start_up(content: Content) -> dict[str, str]:
    rows = []
    for row in start_up_ratios(runs_of(content)):
        figures = min(row.ratios), statistics.median(row.ratios), max(row.ratios)
        reached = "yes" if figures[1] <= row.pair.wanted else "**no**"
        shown = " / ".join(map(_number, figures))
        rows.append([row.pair.name, _number(row.command_s), f"`{row.pair.imports}`", _number(row.imports_s), shown,
                     _number(row.pair.wanted), reached])  # fmt: skip
    head = ("command", "s", "against", "s", "ratio: least / median / most", "wanted", "reached")
    return {"": markdown_table(head, rows)}


TABLES: dict[str, Callable[[Content], dict[str, str]]] = {
    "against_ceres": _against_ceres,
    "growth": _growth,
    "coastline": _coastline,
    "roofline": _roofline,
    "start_up": _start_up,
}


def filled(document: str, tables: dict[str, str]) -> str:
    """The document with tables in their places; places without a table stay as they are.

    Raises
    ------
    KeyError
        If a table has no place.
    """
    places = {match["name"] for match in PLACE.finditer(document)}
    if missing := sorted(set(tables) - places):
        raise KeyError(f"no place for {', '.join(missing)}")

    def replaced(match: re.Match[str]) -> str:
        table = tables.get(match["name"])
        return match[0] if table is None else f"{match[1]}\n{table}\n{match[3]}"

    return PLACE.sub(replaced, document)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("figures", type=Path, nargs="+")
    parser.add_argument("--into", type=Path, help="document whose places are filled")
    chosen = parser.parse_args()
    tables: dict[str, str] = {}
    for path in chosen.figures:
        tables |= tables_of(json.loads(path.read_text(encoding="utf-8")))
    if chosen.into:
        chosen.into.write_text(filled(chosen.into.read_text(encoding="utf-8"), tables), encoding="utf-8")
        return
    for name, table in tables.items():
        print(f"## {name}\n\n{table}")


if __name__ == "__main__":
    main()
