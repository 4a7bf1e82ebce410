"""Run Lee's experiments again, write them as projects, and write docs/dissertation.md.

    python -m docs.build_dissertation

Every experiment is measured anew (seed 1) at the published geometry, starts from Lee's initial values, and is counted,
predicted and adjusted by the program; nothing in the page is typed but the sentences and what Lee printed.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.budget import Budget, budget
from splinebba_cli.core.curves.nearest import nearest_on_curve
from splinebba_cli.core.curves.polynomial import polynomial_basis
from splinebba_cli.core.network import FloatArray, Network
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.errors import NotSolvableError
from splinebba_cli.project.writer import write_project
from splinebba_cli.simulation.dense_prediction import DensePrediction, dense_prediction, with_true_locations
from splinebba_cli.simulation.dissertation import PHOTO_SIGMA_MM, Experiment, design_of, experiments
from splinebba_cli.simulation.noise import Noise
from splinebba_cli.simulation.realization import Design, realize
from splinebba_cli.simulation.truth_file import TRUTH_FILE, truth_content, truth_text

WORDS = Path(__file__).with_name("dissertation.words.md")
PAGE = Path(__file__).with_name("dissertation.md")
PROJECTS = Path(__file__).parents[1] / "sample_projects" / "dissertation"
SEED = 1
SCHEMA = ("=project.schema.json", "=../../../schemas/project.schema.json")
EOP = ("X₀", "Y₀", "Z₀", "ω", "φ", "κ")


def main() -> None:
    """Write all projects and the page."""
    words = _words()
    parts = [words[""]]
    rows = []
    for made in experiments():
        design = design_of(made)
        network = realize(design, Noise(), SEED).network
        _write_project(made, design, network)
        found = budget(network)
        rows.append(_count_row(made, found))
        parts.append(_section(made, words[made.name], design, network, found))
        print(made.name)
    parts.insert(1, _table(_COUNT_HEAD, rows))
    PAGE.write_text("\n\n".join(parts) + "\n", encoding="utf-8", newline="\n")


def _words() -> dict[str, str]:
    """What the page says in words: the introduction under "", and a paragraph for each experiment."""
    parts = re.split(r"^<!-- (\w+) -->$", WORDS.read_text(encoding="utf-8"), flags=re.MULTILINE)
    return {"": parts[0].strip(), **{name: text.strip() for name, text in _pairs(parts[1:])}}


def _pairs(parts: list[str]) -> list[tuple[str, str]]:
    """Names and texts that follow each other."""
    return list(zip(parts[::2], parts[1::2], strict=True))


def _write_project(made: Experiment, design: Design, network: Network) -> None:
    folder = PROJECTS / made.name
    path = write_project(
        network,
        folder,
        name=made.name.replace("_", "-"),
        description=f"{made.title} (W. H. Lee 2008), from Lee's initial values",
        simulation={"block": made.name, "seed": SEED, "image_sigma_um": 1e3 * PHOTO_SIGMA_MM[made.geometry]},
    )
    path.write_text(path.read_text(encoding="utf-8").replace(*SCHEMA, 1), encoding="utf-8", newline="\n")
    note = {"kind": made.name, "seed": SEED, "noise_um": 1e3 * PHOTO_SIGMA_MM[made.geometry]}
    text = truth_text(truth_content(network, design.truth, note))
    (folder / TRUTH_FILE).write_text(text, encoding="utf-8", newline="\n")


_COUNT_HEAD = (
    "experiment", "equations", "unknowns", "rank", "nullity", "redundancy", "Lee's redundancy",
    "smallest singular value",
)  # fmt: skip


def _count_row(made: Experiment, found: Budget) -> tuple[str, ...]:
    plain = dense_prediction(with_true_locations(design_of(made)), conditions=False)
    return (
        f"[{made.title.split(':')[0]}](#{made.name.replace('_', '-')})",
        *(str(getattr(found, key)) for key in ("equations", "unknowns", "rank", "nullity", "redundancy")),
        str(made.lee_redundancy),
        f"{plain.smallest:.0e}",
    )


def _section(made: Experiment, words: str, design: Design, network: Network, found: Budget) -> str:
    at_truth = with_true_locations(design)
    plain, conditioned = (dense_prediction(at_truth, conditions=c) for c in (False, True))
    result, refusal = _attempt(network)
    parts = [f'<a id="{made.name.replace("_", "-")}"></a>\n\n## {made.title}', words]
    parts.append("\n".join(_runs(made, found, result, refusal)))
    if made.published.orientations is not None:
        parts.append(_orientations(made, design, result, plain))
    if made.published.coefficients is not None:
        parts.append(_coefficients(made, design, result, conditioned))
    if made.published.locations:
        parts.append(_locations(made, network, design, result, conditioned))
    return "\n\n".join(parts)


def _attempt(network: Network) -> tuple[AdjustmentResult | None, NotSolvableError | None]:
    try:
        return adjust(network), None
    except NotSolvableError as error:
        return None, error


def _runs(
    made: Experiment, found: Budget, result: AdjustmentResult | None, refusal: NotSolvableError | None
) -> list[str]:
    """As published, and with the gauge conditions."""
    lines = [
        f"- `splinebba check sample_projects/dissertation/{made.name}`, as published, without conditions: "
    ]
    errors = [p.message for p in found.problems if p.severity != "info"]
    lines[0] += "; ".join(errors) + "." if errors else "every unknown is determined."
    command = f"- `splinebba adjust sample_projects/dissertation/{made.name}`, from Lee's initial values: "
    if result is not None:
        s = result.statistics
        lines.append(
            command
            + f"{result.termination} after {len(result.iterations)} iterations, {s.conditions} gauge conditions, "
            f"redundancy {s.redundancy}, σ̂₀ = {s.sigma0:.3f}."
        )
    elif refusal is not None:
        first = refusal.problems[0].message
        lines.append(f"{command}exit code 3. {first[0].upper()}{first[1:]}.")
    return lines


def _orientations(
    made: Experiment, design: Design, result: AdjustmentResult | None, predicted: DensePrediction
) -> str:
    table = made.published.orientations
    assert table is not None
    order, unit = [3, 4, 5, 0, 1, 2], np.array([1.0, 1.0, 1.0, *[np.degrees(1.0)] * 3])
    sigma = predicted.eop[:, order] * unit
    origin = np.concatenate([design.network.origin, np.zeros(3)])
    truth = design.truth.eop[:, order] * unit + origin
    rows = []
    for image, id_ in enumerate(design.network.images.ids):
        for k, name in enumerate(EOP):
            digits = 2 if k < 3 else 4
            true = truth[image, k] + (
                360.0 if k == 5 and table.estimate[image, k] - truth[image, k] > 180 else 0.0
            )
            rows.append(
                (
                    f"{id_} {name}", f"{table.start[image, k]:.{digits}f}", f"{true:.{digits}f}",
                    _of_result(result, image, order[k], unit[k], origin[k], digits),
                    _length(sigma[image, k]) if k < 3 else f"{sigma[image, k]:.3g}°",
                    f"{table.estimate[image, k]:.{digits}f}", f"{table.sigma[image, k]:.{digits}f}",
                )
            )  # fmt: skip
    head = ("", "initial (Lee)", "truth", "estimated", "predicted σ", "estimated (Lee)", "σ (Lee)")
    return "Orientations (m, degrees):\n\n" + _table(head, rows)


def _of_result(
    result: AdjustmentResult | None, image: int, k: int, unit: float, origin: float, digits: int
) -> str:
    return "–" if result is None else f"{result.images.eop[image, k] * unit + 0.0 * origin:.{digits}f}"


def _coefficients(
    made: Experiment, design: Design, result: AdjustmentResult | None, predicted: DensePrediction
) -> str:
    table = made.published.coefficients
    assert table is not None
    number = next(i for i, s in enumerate(made.segments) if s.role != "control")
    true = made.segments[number].true
    own = None if result is None else result.curves[number].values
    rows = []
    for axis, letter in enumerate("abc"):
        for power in range(4):
            if np.isnan(table.estimate[power, axis]):
                continue
            rows.append(
                (
                    f"{letter}{power}", f"{table.start[power, axis]:.2f}", f"{true[power, axis]:.3f}",
                    "–" if own is None else f"{own[power, axis]:.3f}",
                    f"{predicted.coefficients[4 * number + power, axis]:.3f}",
                    f"{table.estimate[power, axis]:.4f}", f"{table.sigma[power, axis]:.4f}",
                )
            )  # fmt: skip
    head = ("", "initial (Lee)", "truth", "estimated", "predicted σ", "estimated (Lee)", "σ (Lee)")
    places = []
    for t in (0.0, 0.3, 0.6):
        weights = np.zeros(len(predicted.coefficients))
        weights[4 * number : 4 * number + 4] = t ** np.arange(4)
        slope = np.array([0.0, 1.0, 2.0 * t, 3.0 * t**2])
        axes = predicted.across(weights, slope @ true)
        places.append(f"t = {t:g}: {axes[0]:.3f} and {axes[1]:.3f} m")
    text = "Predicted σ of the coefficients belong to the gauge conditions; those across the curve do not: "
    lee = np.where(np.isnan(table.estimate), true, table.estimate)
    other = lee * np.where(np.arange(12).reshape(3, 4).T == 3, -1.0, 1.0)  # a3 with the other sign
    apart, changed = (_largest_apart(values, true, made, number) for values in (lee, other))
    printed = (
        f"Lee's estimated segment is at most {apart:.2f} m across from the true one where it is measured"
    )
    printed += f"; with the other sign of a₃ {changed:.2f} m." if changed < 0.5 * apart else "."
    return "Coefficients (m):\n\n" + _table(head, rows) + f"\n\n{text}{'; '.join(places)}. {printed}"


def _largest_apart(printed: FloatArray, true: FloatArray, made: Experiment, number: int) -> float:
    """Largest distance across, printed segment to true one, over the measured stretch, m."""
    basis = polynomial_basis(3, np.array([0.0, 1.0]))
    t = made.segments[number].locations
    origin = np.vstack([true[0], np.zeros((3, 3))])
    places = basis.evaluate(np.linspace(t.min(), t.max(), 101), printed - origin)
    return float(nearest_on_curve(basis, true - origin, places)[1].max())


def _locations(
    made: Experiment,
    network: Network,
    design: Design,
    result: AdjustmentResult | None,
    predicted: DensePrediction,
) -> str:
    rows, begin = [], 0
    for segment in made.segments:
        key = "control" if segment.role == "control" else "tie"
        table = made.published.locations[key]
        for image, id_ in enumerate(network.images.ids):
            each = segment.locations.shape[1]
            place = slice(begin, begin + each)
            begin += each
            own = "–" if result is None else _numbers(result.curve_residuals.location[place])
            rows.append(
                (
                    f"{id_}, {segment.id}", _numbers(design.truth.locations[place]), own,
                    _numbers(predicted.location[place]), _numbers(table.sigma[image]),
                )
            )  # fmt: skip
    head = ("image", "truth = estimated (Lee)", "estimated", "predicted σ", "σ (Lee)")
    return "Locations t:\n\n" + _table(head, rows)


def _numbers(values: FloatArray) -> str:
    return " ".join(f"{v:.4f}" if v < 10 else f"{v:.3g}" for v in values)


def _length(metres: float) -> str:
    return f"{metres / 1000:.3g} km" if metres >= 1000 else f"{metres:.3g} m"


def _table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    lines = [head, ("---",) * len(head), *rows]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in lines)


if __name__ == "__main__":
    main()
