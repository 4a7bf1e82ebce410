"""What the report of a matching says first: a verdict in a line, and a few numbers."""

from __future__ import annotations

from typing import Any

from splinebba_cli.report.blocks import Fact, Facts, Verdict
from splinebba_cli.report.scale import plural

LITTLE = 0.25  # matched share below which the headline asks whether that is right


def percent(share: float | None) -> str:
    """A share as people read it; 100 % and 0 % are exact."""
    if share is None:
        return "–"
    text = f"{100 * share:.1f}"
    if text == "100.0" and share < 1.0:
        return "> 99.9 %"
    return f"{'< 0.1' if text == '0.0' and share > 0.0 else text} %"


def match_verdict(content: dict[str, Any]) -> Verdict:
    """How much was matched, and whether that is what the project asks for."""
    detail = _detail(content)
    failed = [each for each in content["acceptance"] if each["status"] != "passed"]
    if failed:
        limit = percent(failed[0]["limit"])
        return Verdict("bad", "Matched, but not accepted", f"{detail} The project asks for at least {limit}.")
    ask = _asks(content)
    lost = [image["id"] for image in content["images"] if not image["in_matched_project"]]
    if lost:
        where = f" Nothing was matched in {plural(len(lost), 'image')}: matched.yaml leaves them out."
        return Verdict("warning", "Matched, but not in every image", detail + where + ask)
    if ask:
        return Verdict("warning", "Little was matched", detail + ask)
    if any(problem["severity"] != "info" for problem in content["problems"]):
        return Verdict("warning", "Matched, with warnings", detail)
    return Verdict("good", "Matched and accepted" if content["acceptance"] else "Matched", detail)


def _asks(content: dict[str, Any]) -> str:
    """What to look for where little was matched; empty where it is not little."""
    counts = content["counts"]
    if content["acceptance"] or counts["labelled_before"] or counts["share"] >= LITTLE:
        return ""
    return (
        " If more of them show splines of the project, then the orientations, the camera or the σ of the points are "
        "not as declared, or the splines are not where the edges are."
    )


def _detail(content: dict[str, Any]) -> str:
    """Matched and unmatched points in a sentence or two."""
    counts = content["counts"]
    left = counts["points"] - counts["matched"]
    text = (
        f"{counts['matched']} of {plural(counts['points'], 'image point')} ({percent(counts['share'])}) lie on "
        f"splines; {left} stay without a label."
    )
    if counts["labelled_before"]:
        text += f" {counts['labelled_before']} had a label before."
    if not counts["splines"] and not counts["images_oriented"]:
        text += " The project has no spline to match against: new ones rest on the orientations as they are given."
    return text


def match_facts(content: dict[str, Any]) -> Facts:
    """The few numbers on top."""
    counts = content["counts"]
    items = [
        Fact(
            "Matched",
            percent(counts["share"]),
            f"{counts['matched']} of {counts['points']}",
            number=counts["share"],
        ),
        Fact("Images", f"{counts['images']}", f"{counts['images_oriented']} with a new orientation"),
    ]
    if counts["chains"]:
        whole = f"{counts['chains_matched_whole']} whole, {counts['chains_matched_in_part']} in part"
        items.append(Fact("Chains", f"{counts['chains']}", f"{whole}, {counts['chains_unmatched']} not"))
    given = [spline for spline in content["splines"] if not spline["new"]]
    if given:
        used = sum(spline["points"] > 0 for spline in given)
        items.append(Fact("Splines found", f"{used}", f"of {len(given)} of the project"))
    if counts["new_splines"]:
        length = sum(each["length_m"] for each in content["new_splines"])
        items.append(
            Fact("New splines", f"{counts['new_splines']}", f"built from chains, {length:.3g}\u00a0m")
        )
    return Facts(tuple(items), headline=True)
