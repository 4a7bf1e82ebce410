"""What group tests and tests for systematic effects mean in words: the worst of each kind by name."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.evidence import GroupTest, SystematicEffect
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.result import Problem, Severity

NAMED = 5  # of one kind
CERTAIN = 1e-3  # probability by chance below which an effect is a warning
EFFECTS = {
    "image mean": (
        "SBB547",
        (
            "the residuals of {subject} have a common part of {estimate:.2g} µm ({detail}); its orientation takes up "
            "all but {shown:.2g} % of a common error"
        ),
        "look at the labels and the control in it, at its camera, and at film or scanner",
    ),
    "radial trend": (
        "SBB548",
        "the residuals of {subject} have a radial trend: {detail}",
        "it looks like distortion that the camera model lacks: the K1 named would take it out; better calibrate",
    ),
    "tangential trend": (
        "SBB548",
        "the residuals of {subject} have a tangential trend: {detail}",
        "check the principal point, the decentring distortion and the affinity of the camera",
    ),
    "grid": (
        "SBB551",
        "the residuals of {subject} agree in parts of the image format: {estimate:.2g} µm in {detail}",
        "see the figure of mean residuals: a pattern that all images share belongs to the camera",
    ),
    "run along curve": (
        "SBB549",
        "residuals run along {subject}: neighbours are correlated by {estimate:.2f} ({detail})",
        (
            "knots too far apart for its shape, a traced chain on a wrong edge, or an edge detector that smooths: "
            "neighbours are then no independent measurements, and the precision is too optimistic"
        ),
    ),
    "drift": (
        "SBB550",
        "the residuals of {subject} change with the order of the images: {detail}",
        "a camera that warms up: give such images a camera of their own",
    ),
    "strip": (
        "SBB550",
        "the {subject} have a common error: {detail}",
        "a shift or drift of GNSS in this strip: process the trajectory again, or give its positions a larger σ",
    ),
}


LEAST_CRITICAL = 1e-12  # a level of significance near 1/2 makes critical values of 0


def systematic_findings(effects: tuple[SystematicEffect, ...]) -> list[Problem]:
    """Significant effects, the most certain first."""
    found = []
    for kind, (code, message, help) in EFFECTS.items():
        own = sorted(
            (effect for effect in effects if effect.significant and effect.kind == kind),
            key=lambda effect: -effect.statistic / max(effect.critical, LEAST_CRITICAL),
        )
        for effect in own[:NAMED]:
            text = message.format(
                subject=effect.subject,
                estimate=effect.estimate,
                detail=effect.detail,
                shown=100.0 * effect.shown,
            )
            text += _more(effect is own[min(NAMED, len(own)) - 1], len(own))
            found.append(Problem(code, _severity(effect.probability), text, effect.subject, help))
    return found


def group_findings(tests: tuple[GroupTest, ...]) -> list[Problem]:
    """Groups with a common error, the most certain first: it spoils its neighbours too."""
    failed = sorted(
        (test for test in tests if not test.passed),
        key=lambda test: -test.statistic / max(test.critical, LEAST_CRITICAL),
    )
    found = []
    for number, test in enumerate(failed[:NAMED]):
        if test.kind == "chain":
            message = (
                f"{test.name}: all {test.observations} points are shifted by {_um(test.estimate[0])} µm across "
                f"(σ {_um(test.sigma[0])} µm)"
            )
            help = "wrong edge or wrong label? Correct the first of these, or leave it out, and adjust again"
        else:
            message = f"{test.name}: {_displaced(test)}"
            help = "wrong coordinates, wrong label or wrong datum? Give it as check, adjust again and compare"
        message += _more(number == min(NAMED, len(failed)) - 1, len(failed))
        found.append(Problem("SBB546", _severity(test.probability), message, test.name, help))
    return found


def _severity(probability: float) -> Severity:
    return "warning" if probability < CERTAIN else "info"


def _more(last: bool, count: int) -> str:
    return f" (and {count - NAMED} more)" if last and count > NAMED else ""


def _um(value: float) -> str:
    return "?" if np.isnan(value) else f"{1e3 * value:.2g}".replace("-", "−")


def _displaced(test: GroupTest) -> str:
    """Displacement with its sigma, metres; a question mark where the residuals do not show a component."""

    def text(values: FloatArray) -> str:
        return ", ".join("?" if np.isnan(v) else f"{v:.3g}".replace("-", "−") for v in values)

    if np.isnan(test.estimate).all():
        return f"its given position is wrong; the residuals show it in {test.parameters} of 3 directions only"
    return f"its given position is displaced by ({text(test.estimate)}) m (σ {text(test.sigma)} m)"
