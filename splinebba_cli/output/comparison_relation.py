"""What two adjustments have in common, and the dispersion of their differences that follows from it.

independent   nothing measured in common           C = C_a + C_b
nested        one is adjusted from a part of the   C = s^2 (Q_part - Q_whole): the whole is the best unbiased
              observations of the other            estimate, so that cov(part, whole) = Q_whole (Hausman 1978)
same-data     the same observations, one model     C = s^2 (Q_more - Q_fewer), by the same argument under the
              has more unknowns than the other     hypothesis that the additional ones are 0
overlapping   some measurements in common          C_a + C_b is too large: only what is significant against it is

s^2 is that of the part, or of the model with more unknowns: differences are functions of its estimates, which are
independent of its residuals, so that its redundancy gives exact F tests.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from splinebba_cli.output.stored_result import StoredResult

RelationName = Literal["independent", "nested", "same-data", "overlapping"]
Side = Literal["a", "b"]


@dataclass(frozen=True)
class Relation:
    """How two adjustments are related."""

    name: RelationName
    less_precise: Side | None  # nested: the part; same-data: the model with more unknowns; None: neither
    reason: str  # how it was chosen
    explanation: str  # what it means for the dispersion of the differences
    shared: int  # measured image points in common
    only_a: int
    only_b: int


def compared_inputs(a: StoredResult, b: StoredResult) -> list[dict[str, str]]:
    """Input files of both: same (whatever their folder or name is), changed, only in one; by their hashes."""
    first, second = ({item["file"]: item["sha256"] for item in _inputs(result)} for result in (a, b))
    shared = set(first.values()) & set(second.values())
    found = [{"file": file, "status": "same"} for file in first if first[file] in shared]
    left_a = {file for file in first if first[file] not in shared}
    left_b = {file for file in second if second[file] not in shared}
    found += [{"file": file, "status": "changed"} for file in left_a & left_b]
    found += [{"file": file, "status": "only A"} for file in left_a - left_b]
    found += [{"file": file, "status": "only B"} for file in left_b - left_a]
    return sorted(found, key=lambda item: (item["file"], item["status"]))


def relation_of(a: StoredResult, b: StoredResult, wanted: RelationName | None = None) -> Relation:
    """The relation that is wanted, else the one that inputs and measurements show."""
    inputs = compared_inputs(a, b)
    shared, only_a, only_b = (
        len(a.measured & b.measured),
        len(a.measured - b.measured),
        len(b.measured - a.measured),
    )
    if wanted is not None:
        name, reason = wanted, "as asked for"
    else:
        name, reason = _seen(a, b, inputs, (shared, only_a, only_b))
    side = _less_precise(name, a, b)
    return Relation(name, side, reason, _explained(name, side), shared, only_a, only_b)


def _seen(
    a: StoredResult, b: StoredResult, inputs: list[dict[str, str]], counts: tuple[int, int, int]
) -> tuple[RelationName, str]:
    shared, only_a, only_b = counts
    if inputs and all(item["status"] == "same" for item in inputs):
        return "same-data", "all input files have the same hashes"
    if not shared:
        return "independent", "no measured image point is in both"
    if only_a and only_b:
        return (
            "overlapping",
            f"{shared} measured image points are in both, {only_a} only in A, {only_b} only in B",
        )
    if only_a or only_b:
        whole, part = ("A", "B") if only_a else ("B", "A")
        return (
            "nested",
            f"all measured image points of {part} are in {whole}, which has {only_a + only_b} more",
        )
    if _count(a, "observations") != _count(b, "observations"):
        part = "A" if _count(a, "observations") < _count(b, "observations") else "B"
        return (
            "nested",
            f"the same measured image points, but {part} has fewer other observations (control, priors)",
        )
    return "same-data", f"all {shared} measured image points are the same"


def _less_precise(name: RelationName, a: StoredResult, b: StoredResult) -> Side | None:
    if name == "nested":
        return "a" if _count(a, "observations") < _count(b, "observations") else "b"
    if name == "same-data" and a.sum_of_squares.redundancy != b.sum_of_squares.redundancy:
        return "a" if a.sum_of_squares.redundancy < b.sum_of_squares.redundancy else "b"
    return None


def _explained(name: RelationName, side: Side | None) -> str:
    if name == "independent":
        return "C = C_A + C_B; control and priors that both share are not taken into account: they make σ too large"
    if name == "overlapping":
        return (
            "C = C_A + C_B is too large, as measurements are shared: what is not significant may still differ"
        )
    if name == "nested":
        part, whole = ("A", "B") if side == "a" else ("B", "A")
        return f"C = σ̂₀² (Q_{part} − Q_{whole}) with σ̂₀ of {part}, which is adjusted from a part of {whole}"
    if side is None:
        return "the same data and as many unknowns: differences come from the model alone and have no σ"
    more, fewer = ("A", "B") if side == "a" else ("B", "A")
    return (
        f"C = σ̂₀² (Q_{more} − Q_{fewer}) with σ̂₀ of {more}, which has more unknowns for the same observations"
    )


def _inputs(result: StoredResult) -> list[dict[str, Any]]:
    return list(result.content["provenance"].get("inputs", []))


def _count(result: StoredResult, key: str) -> int:
    return int(result.content["statistics"][key])
