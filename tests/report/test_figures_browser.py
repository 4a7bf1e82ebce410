"""Figures in a real browser: they are enlarged by wheel, buttons, keys and drag, and say what is pointed at."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from tests.output.factory import make_result, write_results
from tests.report.browser import PHONE, PageOf

if TYPE_CHECKING:
    from playwright.sync_api import Locator, Page


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A report with nine images: three of them are in the list to choose from."""
    folder = tmp_path_factory.mktemp("figures") / "out"
    write_results(folder, make_result(images=9, point_observations=60))
    return folder / "report.html"


def _plan(page: Page) -> Locator:
    return page.locator("#plan figure").first


def _view(figure: Locator) -> list[float]:
    return [float(x) for x in (figure.locator("svg").get_attribute("viewBox") or "").split()]


def _centre(element: Locator) -> tuple[float, float]:
    element.scroll_into_view_if_needed()
    box = element.bounding_box()
    assert box is not None
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def test_buttons_enlarge_reduce_and_reset(page_of: PageOf, report: Path) -> None:
    figure = _plan(page_of(report))
    whole = _view(figure)
    figure.get_by_role("button", name="Enlarge").click()
    assert _view(figure)[2] == pytest.approx(whole[2] / 1.5)
    figure.get_by_role("button", name="Reduce").click()
    assert _view(figure) == pytest.approx(whole)
    figure.get_by_role("button", name="Enlarge").click()
    figure.get_by_role("button", name="Show all of the figure").click()
    assert _view(figure) == whole


def test_wheel_enlarges_with_ctrl_only_and_keeps_the_place(page_of: PageOf, report: Path) -> None:
    page = page_of(report)
    figure = _plan(page)
    whole = _view(figure)
    x, y = _centre(figure.locator("svg"))
    page.mouse.move(x, y)
    page.mouse.wheel(0, -100)
    page.wait_for_timeout(50)
    assert _view(figure) == whole
    x, y = _centre(figure.locator("svg"))
    page.mouse.move(x, y)
    page.keyboard.down("Control")
    page.mouse.wheel(0, -100)
    page.keyboard.up("Control")
    page.wait_for_timeout(50)
    view = _view(figure)
    assert view[2] < 0.8 * whole[2]
    assert view[0] + view[2] / 2 == pytest.approx(whole[2] / 2, rel=0.01)


def test_marks_and_letters_grow_slowly_and_the_width_is_told(page_of: PageOf, report: Path) -> None:
    figure = _plan(page_of(report))
    mark = figure.locator("use", has=figure.page.locator("title", has_text="image 766 (RMK)")).first
    letters = figure.locator("text", has_text="766").first
    small = [_size(each) for each in (mark, letters)]
    for _ in range(4):
        figure.get_by_role("button", name="Enlarge").click()
    grown = [_size(each) / before for each, before in zip((mark, letters), small, strict=True)]
    assert grown == pytest.approx([1.5] * 2, rel=0.25)  # 5 times enlarged, less its power of 3/4
    bar = figure.locator("[data-metres]")
    metres = float(bar.get_attribute("data-metres") or "nan")
    share = bar.locator("path").evaluate("path => path.getBBox().width") / _view(figure)[2]
    told = float(figure.locator(".zoom span").inner_text().split()[0])
    assert told == pytest.approx(metres / share, rel=0.01)


def _size(element: Locator) -> float:
    box = element.bounding_box()
    assert box is not None
    return box["height"]


def test_keys_enlarge_move_and_reset(page_of: PageOf, report: Path) -> None:
    page = page_of(report)
    figure = _plan(page)
    whole = _view(figure)
    figure.get_by_role("button", name="Enlarge").focus()
    page.keyboard.press("+")
    page.keyboard.press("+")
    left = _view(figure)[0]
    page.keyboard.press("ArrowRight")
    assert _view(figure)[0] > left
    page.keyboard.press("-")
    assert _view(figure)[2] == pytest.approx(whole[2] / 1.5)
    page.keyboard.press("0")
    assert _view(figure) == whole


def test_drag_moves_and_double_click_resets(page_of: PageOf, report: Path) -> None:
    page = page_of(report)
    figure = _plan(page)
    whole = _view(figure)
    figure.get_by_role("button", name="Enlarge").click()
    before = _view(figure)
    x, y = _centre(figure.locator("svg"))
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x - 60, y - 30, steps=4)
    page.mouse.up()
    after = _view(figure)
    assert after[0] > before[0]
    assert after[1] > before[1]
    page.mouse.dblclick(x, y)
    assert _view(figure) == whole


@pytest.mark.parametrize(
    ("section", "words"),
    [
        ("#plan figure >> nth=0", ("image 7", "σ X", "σ ω")),
        ("#orientation figure", ("image 76", "r = ")),
        ("#reliability figure >> nth=0", ("mean r",)),
        ("#residuals .panel >> nth=0", (" µm", "w ")),
    ],
)
def test_pointing_at_something_says_what_it_is(
    page_of: PageOf, report: Path, section: str, words: tuple[str, ...]
) -> None:
    page = page_of(report)
    svg = page.locator(section).locator("svg").first
    x, y = _centre(svg)
    page.mouse.move(x, y)
    page.wait_for_timeout(50)
    place = svg.evaluate(
        """(svg, words) => {
          for (const element of svg.querySelectorAll("[data-tip]")) {
            if (!words.every((word) => element.dataset.tip.includes(word))) continue;
            const box = element.getBoundingClientRect();
            return [box.x + box.width / 2, box.y + box.height / 2];
          }
        }""",
        list(words),
    )
    page.mouse.move(*place)
    tip = page.get_by_role("tooltip")
    tip.wait_for(state="visible")
    assert all(word in tip.inner_text() for word in words)
    assert svg.locator("title").count() == 0
    page.keyboard.press("Escape")
    assert tip.is_hidden()


def test_touch_asks_too(page_of: PageOf, report: Path) -> None:
    page = page_of(report, size=PHONE)
    station = _plan(page).locator("svg title", has_text="image 762 (RMK)").locator("xpath=..").first
    station.scroll_into_view_if_needed()
    station.tap(force=True)
    assert "image 762 (RMK)" in page.get_by_role("tooltip").inner_text()


def test_any_image_can_be_chosen(page_of: PageOf, report: Path) -> None:
    page = page_of(report)
    choice = page.locator("#residuals .choice")
    select = choice.get_by_label("Another image")
    assert select.locator("option").count() == 3
    name = select.locator("option").nth(2).inner_text()
    select.select_option(index=2)
    shown = choice.locator(".panel:visible")
    assert shown.count() == 1
    assert shown.get_by_role("img", name=name).count() == 1


def test_without_script_titles_and_lists_are_there(
    browser: object, report: Path, request: pytest.FixtureRequest
) -> None:
    context = browser.new_context(java_script_enabled=False)  # type: ignore[attr-defined]
    request.addfinalizer(context.close)
    page = context.new_page()
    page.goto(report.as_uri())
    assert page.locator("#residuals .panels svg").count() == 6
    page.locator("#residuals .choice summary").first.click()
    assert page.locator("#residuals .choice .panel:visible").count() == 1
    assert page.locator("#plan svg title").count() > 20
