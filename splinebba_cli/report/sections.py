"""What a report says, in the order in which an engineer asks: verdict, problems, results, evidence."""

from __future__ import annotations

from typing import Any

from splinebba_cli.report.blocks import (
    Block,
    Fact,
    Facts,
    Note,
    ProblemItem,
    ProblemList,
    Report,
    Section,
    Verdict,
)
from splinebba_cli.report.check_sections import acceptance_section, checks_section
from splinebba_cli.report.feature_sections import points_section, splines_section
from splinebba_cli.report.figure_blocks import plan_blocks
from splinebba_cli.report.model_sections import groups_section, systematic_section, variance_section
from splinebba_cli.report.orientation_section import cameras_section, orientation_section
from splinebba_cli.report.outlier_section import outliers_section
from splinebba_cli.report.precision_section import precision_section
from splinebba_cli.report.reliability_section import reliability_section
from splinebba_cli.report.residual_sections import conditions_section, priors_section, residuals_section
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.run_sections import convergence_section, provenance_section
from splinebba_cli.report.scale import length_scale
from splinebba_cli.report.scale import plural as _plural

_SEVERITIES = ("error", "warning", "info")


def build_report(data: ResultData) -> Report:
    """All sections of the report of one adjustment.

    Parameters
    ----------
    data : ResultData
        Content of a result folder.

    Returns
    -------
    Report
        Plain data for the renderers (:mod:`.text`, :mod:`.html`).
    """
    provenance = data["provenance"]
    project = provenance.get("project", {})
    program = provenance.get("program", {})
    written = provenance.get("timestamps", {}).get("written", "")
    subtitle = " · ".join(
        part
        for part in (
            project.get("file", ""),
            f"{program.get('name', 'splinebba')} {program.get('version', '')}".strip(),
            written.replace("T", " ").replace("Z", " UTC"),
        )
        if part
    )
    sections = [
        acceptance_section(data),
        problems_section(data),
        statistics_section(data),
        plan_section(data),
        orientation_section(data),
        splines_section(data),
        points_section(data),
        precision_section(data),
        checks_section(data),
        residuals_section(data),
        reliability_section(data),
        variance_section(data),
        groups_section(data),
        systematic_section(data),
        outliers_section(data),
        priors_section(data),
        conditions_section(data),
        cameras_section(data),
        convergence_section(data),
        provenance_section(data),
    ]
    return Report(
        title=project.get("name") or "Adjustment",
        subtitle=subtitle,
        verdict=verdict(data),
        key_facts=key_facts(data),
        sections=tuple(section for section in sections if section.blocks),
    )


def verdict(data: ResultData) -> Verdict:
    """Whether the result can be used, and the reason."""
    status, statistics = data["status"], data["statistics"]
    count = {s: sum(p["severity"] == s for p in data["problems"]) for s in _SEVERITIES}
    if not status["converged"]:
        return Verdict(
            "bad",
            "Not converged",
            f"The iterations ended with: {status['termination']}. Do not use these results.",
        )
    test = statistics["global_test"]
    weights_reduced = bool((data.content.get("revision") or {}).get("reweighted"))
    test_text = _test_sentence(statistics, weights_reduced)
    if count["error"]:
        criteria = _plural(count["error"], "problem")
        return Verdict(
            "bad", "Adjusted, but not acceptable", f"{criteria} below must be solved first. {test_text}"
        )
    if test is None:
        return Verdict("warning", "Adjusted, but without any check", test_text)
    if not test["passed"] and not (weights_reduced and test["statistic"] < test["lower"]):
        return Verdict("warning", "Adjusted, but the global test failed", test_text)
    if count["warning"]:
        return Verdict("warning", f"Adjusted, with {_plural(count['warning'], 'warning')}", test_text)
    return Verdict("good", "Adjusted and accepted", test_text)


def _test_sentence(statistics: dict[str, Any], weights_reduced: bool) -> str:
    test, sigma0 = statistics["global_test"], statistics["sigma0"]
    if test is None or sigma0 is None:
        return (
            "The redundancy is 0: no observation checks another; the precision rests on the declared σ alone."
        )
    value = f"σ̂₀ = {sigma0:.4f} against σ₀ = {statistics['sigma0_prior']:g}"
    interval = f"accepted from {test['lower']:.1f} to {test['upper']:.1f} at α = {test['alpha']:g}"
    bounds = f"χ² = {test['statistic']:.1f}, {interval}"
    if test["passed"]:
        return f"{value}: the residuals agree with the declared precision ({bounds})."
    if test["statistic"] > test["upper"]:
        return (
            f"{value}: the residuals are larger than the declared σ allow ({bounds}). Look for gross errors "
            "and systematic residuals first; otherwise the measurements are less precise than declared."
        )
    if weights_reduced:
        return (
            f"{value}: smaller than the declared σ ({bounds}), as reduced weights make it: "
            "it says nothing about the σ of the observations."
        )
    return (
        f"{value}: the residuals are smaller than the declared σ ({bounds}). "
        "The measurements are more precise than declared; state a smaller σ."
    )


def key_facts(data: ResultData) -> Facts:
    """The few numbers on top."""
    statistics, images, splines = data["statistics"], data["images"], data["splines"]
    sigma0 = statistics["sigma0"]
    position = [image["sigma"][axis] for image in images for axis in "xyz"]
    items = [
        Fact(
            "σ̂₀",
            "–" if sigma0 is None else f"{sigma0:.4f}",
            f"a priori {statistics['sigma0_prior']:g}",
            number=sigma0,
        ),
        Fact("Redundancy", f"{statistics['redundancy']}", f"{statistics['observations']} observations"),
    ]
    for group in data["residuals"]["kinds"]:
        if group["n"]:
            name = "RMS, points" if group["kind"] == "points" else "RMS across, splines"
            note = _plural(group["n"], "image point")
            if group["rms_px"] is not None:
                fact = Fact(name, f"{group['rms_px']:.3f} px", note, number=group["rms_px"], unit="px")
            else:
                micrometres = 1e3 * group["rms_mm"]
                fact = Fact(name, f"{micrometres:.2f} µm", note, number=micrometres, unit="µm")
            items.append(fact)
    largest = max((s for s in position if s is not None), default=None)
    if largest != 0.0 and images:  # none where all images are fixed
        items.append(_length_fact("Largest σ of a station", largest, _plural(len(images), "image")))
    across = [
        spline["sigma_across"]["mean"] for spline in splines if spline["sigma_across"]["mean"] is not None
    ]
    if across:
        mean = sum(across) / len(across)
        items.append(_length_fact("Mean σ across splines", mean, _plural(len(splines), "spline")))
    return Facts(tuple(items), headline=True)


def _length_fact(label: str, metres: float | None, note: str) -> Fact:
    return Fact(label, length_scale([metres]).text(metres), note, number=metres, unit="m")


def problems_section(data: ResultData) -> Section:
    """Problems and suggestions, the worst first."""
    problems = sorted(data["problems"], key=lambda p: _SEVERITIES.index(p["severity"]))
    items = tuple(
        ProblemItem(p["code"], p["severity"], p["subject"], p["message"], p["help"]) for p in problems
    )
    return Section("problems", "Problems and suggestions", (ProblemList(items),))


def statistics_section(data: ResultData) -> Section:
    """Counts, variance of unit weight, global test."""
    s = data["statistics"]
    test = s["global_test"]
    items = [
        Fact(
            "Observations",
            f"{s['observations']}",
            "image coordinates, arc lengths, tangents, distances, control, priors",
        ),
        Fact("Unknowns", f"{s['unknowns']}", "locations on splines included"),
        Fact(
            "Gauge and datum conditions",
            f"{s['conditions']}",
            f"they fill a rank defect of {s['rank_defect']}" if s["conditions"] else "",
        ),
        Fact("Redundancy", f"{s['redundancy']}", "observations + conditions − unknowns"),
        Fact(
            "Sum of redundancy numbers",
            _number(s["sum_redundancy_numbers"], ".4f"),
            "must equal the redundancy",
            number=s["sum_redundancy_numbers"],
        ),
        Fact("v′Pv", _number(s["vtpv"], ".4f"), number=s["vtpv"]),
        Fact("σ₀ a priori", f"{s['sigma0_prior']:g}"),
        Fact("σ̂₀ a posteriori", _number(s["sigma0"], ".5f"), number=s["sigma0"]),
    ]
    if test is not None:
        text = f"{test['statistic']:.2f} in [{test['lower']:.2f}, {test['upper']:.2f}]"
        if not test["passed"]:
            text = text.replace(" in ", " not in ")
        passed = "passed" if test["passed"] else "failed"
        note = f"two-sided, α = {test['alpha']:g}: {passed}"
        items.append(Fact("Global test, χ²", text, note, "good" if test["passed"] else "warning"))
    scaled = data["settings"]["sigmas_scaled_by_sigma0"]
    blocks: list[Block] = [Facts(tuple(items)), Facts(_count_facts(data)), Note(_scaling_note(scaled))]
    return Section("statistics", "Statistics", tuple(blocks))


def _number(value: float | None, spec: str) -> str:
    return "–" if value is None else format(value, spec)


def _count_facts(data: ResultData) -> tuple[Fact, ...]:
    items = [Fact("Images", f"{len(data['images'])}", _plural(len(data["cameras"]), "camera"))]
    for name in ("splines", "points"):
        roles: dict[str, int] = {}
        for feature in data[name]:
            roles[feature["role"]] = roles.get(feature["role"], 0) + 1
        note = ", ".join(
            f"{roles[role]} {role}" for role in ("control", "partial", "tie", "check") if role in roles
        )
        items.append(Fact(name.capitalize(), f"{len(data[name])}", note))
    names = {"points": "Image points of points", "splines": "Image points on splines"}
    items += [Fact(names[kind["kind"]], f"{kind['n']}") for kind in data["residuals"]["kinds"]]
    return tuple(items)


def _scaling_note(scaled: bool) -> str:
    if scaled:
        return "All standard deviations in this report are multiplied by σ̂₀."
    return "All standard deviations in this report refer to σ₀ a priori."


def plan_section(data: ResultData) -> Section:
    """The block seen from above."""
    return Section("plan", "Block plan", tuple(plan_blocks(data)))
