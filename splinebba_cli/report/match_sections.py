"""What the report of a matching says: how much was matched, where not and why, how it came about, what was built."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from splinebba_cli.report.blocks import (
    Block,
    Cell,
    Column,
    Fact,
    Facts,
    FigureBlock,
    Note,
    Report,
    Section,
    Table,
)
from splinebba_cli.report.match_headline import match_facts, match_verdict, percent
from splinebba_cli.report.match_panels import SHOWN, drawn_images
from splinebba_cli.report.new_spline_section import new_splines_section
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.run_sections import provenance_section
from splinebba_cli.report.scale import length_scale, plural
from splinebba_cli.report.sections import problems_section

SCANT = 0.2  # of the share of all images: an image with less deserves a look
REASONS = {
    "far": "no spline inside of the gate",
    "direction": "only splines that run in another direction",
    "ambiguous": "two splines fit equally well",
    "chain": "the rest of its chain follows no spline, or another one",
    "taken": "another chain fits better to that part of the spline",
    "gross": "its residual after the adjustment is no chance",
    "excluded": "taken out by the user (`use: no`)",
    "not oriented": "its image has no orientation",
    "one image": "its spline has no known shape, and no other image sees it",
}


def build_match_report(content: dict[str, Any]) -> Report:
    """All sections of the report.

    Parameters
    ----------
    content : dict
        Of match.json.

    Returns
    -------
    Report
        Plain data for the renderers.
    """
    data = ResultData(content)
    provenance = content["provenance"]
    program, written = provenance["program"], provenance["timestamps"]["written"]
    sections = [
        problems_section(data),
        unmatched_section(content),
        images_section(content),
        splines_section(content),
        ambiguity_section(content),
        new_splines_section(content),
        history_section(content),
        settings_section(content),
        provenance_section(data),
    ]
    return Report(
        title=provenance["project"]["name"],
        subtitle=" · ".join(
            (
                provenance["project"]["file"],
                f"{program['name']} {program['version']}",
                written.replace("T", " ").replace("Z", " UTC"),
            )
        ),
        verdict=match_verdict(content),
        key_facts=match_facts(content),
        sections=tuple(section for section in sections if section.blocks),
        kicker="Matching of chains",
    )


def unmatched_section(content: dict[str, Any]) -> Section:
    """Why points have no spline."""
    reasons = content["reasons"]
    if not reasons:
        return Section("unmatched", "Unmatched points", (Note("Every image point has a spline."),))
    total = sum(reasons.values())
    rows = tuple(
        (word, REASONS[word].replace("`", ""), number, 100.0 * number / total)
        for word, number in sorted(reasons.items(), key=lambda each: -each[1])
    )
    columns = (
        Column("Reason", numeric=False),
        Column("Meaning", numeric=False),
        Column("Points"),
        Column("Share", "%", 1),
    )
    table = Table("Reasons", columns, rows, source="unmatched_points.csv")
    return Section("unmatched", "Unmatched points", (table,))


def images_section(content: dict[str, Any]) -> Section:
    """Figures of every image, and drawings of those with the smallest share."""
    images = content["images"]
    position = length_scale([image["moved_m"] for image in images])
    columns = (
        Column("Image", numeric=False),
        Column("Points"),
        Column("Matched"),
        Column("Share", "%", 1),
        Column("Orientation", numeric=False),
        Column("Moved", position.unit, position.decimals, help="from the given perspective centre"),
        Column("Turned", "°", 4, help="from the given angles"),
        Column("Most frequent reason", numeric=False),
    )
    rows = tuple(
        (
            image["id"],
            image["points"],
            image["matched"],
            None if image["share"] is None else 100.0 * image["share"],
            _orientation(image),
            position.of(image["moved_m"]),
            image["turned_deg"],
            max(image["reasons"], key=image["reasons"].get) if image["reasons"] else "",
        )
        for image in images
    )
    marked = frozenset(k for k, image in enumerate(images) if _doubtful(image, content))
    note = "Marked: nothing, or next to nothing, was matched in the image: look whether its orientation can be right."
    table = Table("Images", columns, rows, marked, source="match.json", note=note if marked else "")
    blocks: list[Block] = [table]
    drawn = drawn_images(images)
    if drawn:
        caption = _caption(len(drawn), sum(image["points"] > 0 for image in images))
        worst = images[drawn[0]]
        alt = (
            f"Chains of {plural(len(drawn), 'image')}, matched and unmatched; smallest share "
            f"{percent(worst['share'])} in image {worst['id']}"
        )
        blocks.append(FigureBlock("match_images", caption, alt))
    return Section("images", "Images", tuple(blocks))


def _caption(drawn: int, images: int) -> str:
    """What the drawings show; of large blocks they are some images."""
    of = (
        "every image"
        if drawn == images
        else f"the {drawn} images with the smallest matched share (of {images})"
    )
    first = f"; the {SHOWN} images with the smallest matched share first" if drawn == images > SHOWN else ""
    return (
        f"Chains of {of} over the splines as each image sees them with the orientation found{first}. "
        "Point at a chain for its name, its spline, or the reason why it has none."
    )


def _doubtful(image: dict[str, Any], content: dict[str, Any]) -> bool:
    """Whether so few points of an image are matched that chance would do it; labels of before speak for an image."""
    if not image["in_matched_project"]:
        return True
    few = image["share"] is not None and image["share"] < SCANT * content["counts"]["share"]
    return few and not content["counts"]["labelled_before"]


def _orientation(image: dict[str, Any]) -> str:
    if not image["in_matched_project"]:
        return "left out"
    return "found" if image["oriented"] else "as given"


def splines_section(content: dict[str, Any]) -> Section:
    """What was matched to every spline."""
    columns = (
        Column("Spline", numeric=False),
        Column("Role", numeric=False),
        Column("Points"),
        Column("Images"),
        Column("Chains"),
        Column("RMS distance", "σ", 2, help="across the spline, over the predicted σ of the distance"),
        Column("New", numeric=False),
    )
    rows = tuple(
        (
            spline["id"],
            spline["role"],
            spline["points"],
            spline["images"],
            spline["chains"],
            spline["rms_distance"],
            "new" if spline["new"] else "",
        )
        for spline in content["splines"]
    )
    if not rows:
        return Section("splines", "Splines", ())
    marked = frozenset(k for k, spline in enumerate(content["splines"]) if not spline["points"])
    note = "Marked: nothing was matched to the spline." if marked else ""
    return Section(
        "splines", "Splines", (Table("Matched splines", columns, rows, marked, "match.json", note=note),)
    )


def ambiguity_section(content: dict[str, Any]) -> Section:
    """How clear the matches are."""
    found = content["ambiguity"]
    matched = content["counts"]["matched"]
    if not matched:
        return Section("ambiguity", "Ambiguity", ())
    near = sum(found["points"])
    if not near:
        text = "No matched point had a second spline inside of its gate."
        return Section("ambiguity", "Ambiguity", (Note(text),))
    limit = found["close_from"]
    items = (
        Fact("Only one spline near", f"{found['alone']}", "points"),
        Fact("A second spline near", f"{near}", "points"),
        Fact("Close decisions", f"{found['close']}", f"ratio of the distances above {limit:g}"),
    )
    caption = (
        "Matched points that have a second spline inside of the gate, by the distance from the chosen spline over that "
        f"from the next one: 0 is clear, 1 is a guess. Beyond {limit:g} (dashed) look at the images."
    )
    alt = f"Histogram of the ratio of distances of {near} points; {found['close']} beyond {limit:g}"
    return Section("ambiguity", "Ambiguity", (Facts(items), FigureBlock("ambiguity", caption, alt)))


def history_section(content: dict[str, Any]) -> Section:
    """Rounds of matching and adjustment."""
    log = content["history"]
    if not log:
        return Section("history", "Gate history", ())
    columns = (
        Column("Stage", numeric=False),
        Column("Round"),
        Column("Gate", "px", 2, help="median half width; mm where a camera has no pixel size"),
        Column("Matched"),
        Column("Changed", help="points with another spline than in the round before"),
        Column("σ̂₀", "", 4, help="large residuals weigh less here: `adjust` finds a larger one"),
        Column("Largest step", "m", 4, help="of a perspective centre"),
        Column("Largest turn", "°", 5),
    )
    rows: Sequence[tuple[Cell, ...]] = tuple(
        (
            step["stage"],
            step["number"],
            step["gate_px"],
            step["matched"],
            step["changed"],
            step["sigma0"],
            step["position_step_m"],
            step["angle_step_deg"],
        )
        for step in log
    )
    last = log[-1]
    caption = "Every round matches inside of a gate and adjusts; the gate follows the precision that is predicted then."
    gate = "" if last["gate_px"] is None else f"; the gate ends at {last['gate_px']:.2g} px"
    alt = f"{plural(len(log), 'round')}: {last['matched']} points matched at the end{gate}"
    table = Table("Rounds", columns, rows, source="match.json", folded=len(log) > 12)
    return Section("history", "Gate history", (FigureBlock("gate_history", caption, alt), table))


def settings_section(content: dict[str, Any]) -> Section:
    """The settings by their keys."""
    items = tuple(
        Fact(key, "–" if value is None else str(value).lower() if isinstance(value, bool) else f"{value:g}")
        for key, value in content["settings"].items()
    )
    return Section("settings", "Settings", (Facts(items),))
