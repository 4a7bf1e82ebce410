"""The report of a matching: what it says, what it draws, and that it is as safe as the others."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from splinebba_cli.core.matching.matches import MatchResult
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.output.match_json import match_content
from splinebba_cli.output.provenance import provenance
from splinebba_cli.project.loading import LoadedProject, load_project
from splinebba_cli.report.blocks import FigureBlock, Table
from splinebba_cli.report.match_headline import match_facts, match_verdict, percent
from splinebba_cli.report.match_panels import POINTS, SHOWN, panels_of
from splinebba_cli.report.match_panels_svg import CROWDED, match_images
from splinebba_cli.report.match_report import write_match_reports
from splinebba_cli.report.match_sections import REASONS, build_match_report
from splinebba_cli.report.match_summary import MatchSummary
from splinebba_cli.report.projected_curves import SAMPLES, ProjectedCurves
from tests.labelled_chains import LOST, known_matching, street


@pytest.fixture(scope="module")
def loaded(tmp_path_factory: pytest.TempPathFactory) -> LoadedProject:
    return load_project(street(tmp_path_factory.mktemp("street")), "matching")


@pytest.fixture(scope="module")
def result(loaded: LoadedProject) -> MatchResult:
    return known_matching(loaded)


def content_of(loaded: LoadedProject, result: MatchResult, smallest: float | None = None) -> dict[str, Any]:
    return match_content(result, MatchSettings(), provenance(loaded), smallest)


@pytest.fixture(scope="module")
def content(loaded: LoadedProject, result: MatchResult) -> dict[str, Any]:
    return content_of(loaded, result)


def drawn_page(result: MatchResult, images: list[dict[str, Any]]) -> str:
    return match_images(panels_of(result, images), images, new=True)


def test_every_reason_has_words() -> None:
    from splinebba_cli.core.matching.matches import Reason
    from splinebba_cli.project.matched_tables import reason_word

    assert set(REASONS) == {reason_word(reason) for reason in Reason if reason}


def test_a_lost_image_is_the_headline(content: dict[str, Any]) -> None:
    opinion = match_verdict(content)
    assert opinion.tone == "warning" and "in 1 image" in opinion.detail


def test_verdicts(loaded: LoadedProject) -> None:
    whole = known_matching(loaded, lost="")
    assert match_verdict(content_of(loaded, whole)).tone == "good"
    assert match_verdict(content_of(loaded, whole, 0.3)).headline == "Matched and accepted"
    refused = match_verdict(content_of(loaded, whole, 0.99))
    assert refused.tone == "bad" and "at least 99.0 %" in refused.detail


@pytest.mark.parametrize(
    ("share", "text"),
    [(1.0, "100.0 %"), (0.99999, "> 99.9 %"), (0.0, "0.0 %"), (1e-5, "< 0.1 %"), (None, "–")],
)
def test_shares_are_not_rounded_to_all_or_nothing(share: float | None, text: str) -> None:
    assert percent(share) == text


def test_sections_and_tables(content: dict[str, Any]) -> None:
    report = build_match_report(content)
    ids = [section.id for section in report.sections]
    assert ids == ["problems", "unmatched", "images", "splines", "ambiguity", "new-splines", "history", "settings",
                   "provenance"]  # fmt: skip
    tables = {
        block.caption: block
        for section in report.sections
        for block in section.blocks
        if isinstance(block, Table)
    }
    images = tables["Images"]
    assert [images.rows[k][0] for k in sorted(images.marked)] == [LOST]
    assert tables["Weak parts"].rows[0][0] == "kerb-8"
    assert sum(row[2] for row in tables["Reasons"].rows) == sum(content["reasons"].values())


def test_the_page_draws_chains_curves_gate_and_ambiguity(
    loaded: LoadedProject, result: MatchResult, content: dict[str, Any], tmp_path: Path
) -> None:
    write_match_reports(tmp_path, result, content, ["text", "html"])
    page = (tmp_path / "match.html").read_text(encoding="utf-8")
    assert page.count('<div class="panel">') == len(loaded.network.images.ids)
    assert 'class="chain chain-matched"' in page and 'class="chain chain-new"' in page
    assert 'class="chain chain-unmatched"' in page and 'class="projected"' in page and 'class="weak"' in page
    for title in ("Half width of the gate [px]", "Matched points", "distance from the chosen spline"):
        assert title in page
    assert "script-src 'sha256-" in page and "Matching of chains" in page
    text = (tmp_path / "match.txt").read_text(encoding="utf-8")
    assert "MATCHED, BUT NOT IN EVERY IMAGE" in text and "Gate history" in text


def test_little_matched_asks_whether_that_is_right(content: dict[str, Any]) -> None:
    little = {**content, "counts": {**content["counts"], "share": 0.1}}
    assert "not as declared" in match_verdict(little).detail
    assert "not as declared" not in match_verdict(content).detail
    every = [{**image, "in_matched_project": True} for image in content["images"]]
    opinion = match_verdict({**little, "images": every})
    assert (opinion.tone, opinion.headline) == ("warning", "Little was matched")


def test_splines_found_are_those_of_the_project(content: dict[str, Any]) -> None:
    """One of the eight kerbs plays a new spline."""
    (fact,) = [item for item in match_facts(content).items if item.label == "Splines found"]
    assert (fact.value, fact.note) == ("7", "of 7 of the project")


def test_of_many_images_those_with_the_smallest_share_are_shown(
    content: dict[str, Any], result: MatchResult
) -> None:
    order = re.findall(r"Image <strong>(\w+)</strong>", drawn_page(result, content["images"]))
    share = {image["id"]: image["share"] for image in content["images"]}
    assert order == sorted(order, key=lambda id: share[id]) and order[0] == LOST and len(order) <= SHOWN


def test_unmatched_chains_lie_below_all_else(content: dict[str, Any], result: MatchResult) -> None:
    for panel in panels_of(result, content["images"]):
        kinds = [stroke.kind for stroke in panel.strokes]
        below = kinds.count("unmatched")
        assert set(kinds[:below]) <= {"unmatched"}
        assert kinds[below:] == sorted(kinds[below:], key=lambda kind: kind in ("matched", "new"))


def test_dense_chains_are_drawn_with_the_points_that_can_be_seen(
    loaded: LoadedProject, content: dict[str, Any], result: MatchResult
) -> None:
    """Every point of one image moved together to a thousandth: a drawing of dots, one of each chain."""
    points = loaded.network.unlabelled
    near = replace(points, photo_xy=points.photo_xy * 1e-3)
    dense = replace(result, given=replace(result.given, unlabelled=near))
    panel = panels_of(dense, content["images"])[-1]
    drawn = [stroke for stroke in panel.strokes if stroke.kind in ("matched", "new", "unmatched")]
    assert drawn and all(stroke.path.count("L") <= 1 for stroke in drawn)


def test_crowds_of_unmatched_chains_are_thin(content: dict[str, Any], result: MatchResult) -> None:
    panels = panels_of(result, content["images"])
    assert "map crowded" not in match_images(panels, content["images"], new=True)
    stroke = next(s for s in panels[0].strokes if s.kind == "unmatched")
    crowd = replace(panels[0], strokes=(stroke,) * (CROWDED + 1))
    assert match_images([crowd], content["images"], new=True).count("map crowded") == 1


def test_reasons_and_splines_are_in_an_order_that_helps(content: dict[str, Any]) -> None:
    mixed = {**content, "reasons": {"chain": 2, "far": 70, "taken": 8}}
    (table,) = [
        b
        for s in build_match_report(mixed).sections
        for b in s.blocks
        if getattr(b, "caption", "") == "Reasons"
    ]
    assert isinstance(table, Table) and [row[0] for row in table.rows] == ["far", "taken", "chain"]
    shown = next(table for table in MatchSummary(content)._tables() if table.caption == "Matched splines")
    names = {spline["id"]: spline for spline in content["splines"]}
    order = [(names[str(row[0])]["new"], names[str(row[0])]["points"]) for row in shown.rows]
    assert order == sorted(order) and {new for new, _ in order} == {False, True}


def test_images_in_which_next_to_nothing_was_matched_are_marked(content: dict[str, Any]) -> None:
    names = [image["id"] for image in content["images"]]
    poor = [{**image, "share": 0.01 if image["id"] == "5" else image["share"]} for image in content["images"]]

    def marked(before: int) -> set[str]:
        counts = {**content["counts"], "labelled_before": before}
        report = build_match_report({**content, "images": poor, "counts": counts})
        table = next(b for s in report.sections for b in s.blocks if getattr(b, "caption", "") == "Images")
        assert isinstance(table, Table) and "next to nothing" in table.note
        return {names[row] for row in table.marked}

    assert marked(0) == {LOST, "5"} and marked(100) == {LOST}


def test_the_caption_says_of_how_many_images_drawings_are(content: dict[str, Any]) -> None:
    def caption(points: int, copies: int) -> str:
        images = [{**image, "points": points} for image in content["images"] for _ in range(copies)]
        report = build_match_report({**content, "images": images})
        blocks = (b for s in report.sections for b in s.blocks)
        return next(b.caption for b in blocks if isinstance(b, FigureBlock) and b.figure == "match_images")

    few, many = caption(100, 1), caption(100, 2)
    assert "of every image" in few and "first" not in few
    assert "of every image" in many and f"the {SHOWN} images" in many
    large = caption(POINTS, 2)
    assert f"the {SHOWN} images with the smallest matched share (of 12)" in large


def test_names_of_the_user_are_escaped(loaded: LoadedProject) -> None:
    hostile = "<script>alert(1)</script>"
    points = replace(
        loaded.network.unlabelled,
        chain_ids=tuple(f"{hostile}/{k}" for k in range(len(loaded.network.unlabelled.chain_ids))),
    )
    named = replace(loaded, network=replace(loaded.network, unlabelled=points))
    given = known_matching(loaded)
    result = replace(given, given=named.network)
    curves = tuple(replace(curve, id=f"{hostile}{curve.id}") for curve in given.network.curves)
    result = replace(result, network=replace(given.network, curves=curves))
    drawn = drawn_page(result, content_of(loaded, given)["images"])
    assert "<script" not in drawn and "&lt;script" in drawn


def test_projected_curves_pass_through_their_points(loaded: LoadedProject, result: MatchResult) -> None:
    """At the true orientation every matched point lies on its projected curve within its noise and the chords."""
    curves = ProjectedCurves.of(result.network)
    half = np.array([27.0, 18.0])
    lines = curves.lines(0, half)
    points, found = result.given.unlabelled, result.matches
    rows = np.flatnonzero((points.image == 0) & (found.curve >= 0))
    chord = 0.02  # mm: sagitta of 12 pieces a segment, far below
    for row in rows[::7]:
        places = [xy for curve, _, xy in lines if curve == found.curve[row]]
        assert places
        distance = min(_distance(points.photo_xy[row], xy) for xy in places)
        assert distance < 5.0 * 0.005 + chord, row
    assert len(curves.curve) == sum((len(c.values) - 1) * (SAMPLES + 1) for c in result.network.curves)


def _distance(point: np.ndarray, line: np.ndarray) -> float:
    """Distance from a polyline."""
    a, b = line[:-1], line[1:]
    along = b - a
    square = np.maximum(np.einsum("ij,ij->i", along, along), 1e-30)  # samples meet at knots
    t = np.clip(np.einsum("ij,ij->i", point - a, along) / square, 0.0, 1.0)
    return float(np.linalg.norm(a + t[:, None] * along - point, axis=1).min())


def test_weak_parts_are_drawn_as_such(result: MatchResult) -> None:
    lines = ProjectedCurves.of(result.network, result.built).lines(0, np.array([27.0, 18.0]))
    assert {curve for curve, weak, _ in lines if weak} <= {7}
    every = [
        ProjectedCurves.of(result.network, result.built).lines(k, np.array([27.0, 18.0])) for k in range(6)
    ]
    assert any(weak for lines in every for _, weak, _ in lines)
