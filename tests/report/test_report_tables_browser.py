"""Tables of the page: sorting, filtering and paging work on all rows, with the mouse and with the keyboard."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from splinebba_cli.output.result_json import result_to_dict
from splinebba_cli.report.blocks import Column, Facts, LazyRows, Report, Section, Table, Verdict
from splinebba_cli.report.build import rendered
from splinebba_cli.report.result_data import ResultData
from tests.output.factory import make_result
from tests.report.browser import PageOf

expect = pytest.importorskip("playwright.sync_api", reason="playwright is not installed").expect

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Locator, Page

COLUMNS = (
    Column("Point", numeric=False),
    Column("Role", numeric=False),
    Column("X", "m", 3),
    Column("σ X", "mm", 1),
    Column("Rays"),
    Column("Size", numeric=False),
)
SIZES = ("9.35 mm", "31.8 µm", "–", "2 m")


def _row(number: int) -> tuple[str | float | int | None, ...]:
    """P0, P1, …; X falls with the number; every tenth has no σ; sizes in three units."""
    sigma = None if number % 10 == 0 else (number * 7 % 97) / 10 - 4.0
    role = "control" if number % 100 == 7 else "tie"
    return (f"P{number}", role, 1000.0 - 0.5 * number, sigma, number % 6, SIZES[number % 4])


@pytest.fixture(scope="module", params=[90, 5000])
def count(request: pytest.FixtureRequest) -> int:
    """A table whose rows stand in the page, and one whose rows are made by the script."""
    return int(request.param)


@pytest.fixture(scope="module")
def file(count: int, tmp_path_factory: pytest.TempPathFactory) -> Path:
    table = Table("Points", COLUMNS, LazyRows(count, _row), frozenset({3, count - 1}), source="points.csv")
    report = Report("Tables", "", Verdict("good", "Fine", ""), Facts(()), (Section("s", "S", (table,)),))
    path = tmp_path_factory.mktemp("tables") / "report.html"
    path.write_text(rendered(report, ResultData(result_to_dict(make_result())), "html"), encoding="utf-8")
    return path


def _cells(page: Page, column: int) -> list[str]:
    return page.locator(f"tbody tr > :nth-child({column + 1})").all_inner_texts()


def _heading(page: Page, name: str) -> Locator:
    return page.get_by_role("columnheader", name=name, exact=True).get_by_role("button")


def _filter(page: Page, text: str, column: str = "all columns") -> str:
    page.get_by_role("combobox").select_option(label=column)
    page.get_by_role("searchbox").fill(text)
    page.get_by_role("searchbox").press("Enter")  # else the page waits for the end of typing
    return page.locator("output").inner_text()


def test_all_rows_are_sorted_missing_ones_last(page_of: PageOf, file: Path, count: int) -> None:
    page = page_of(file)
    before = _cells(page, 0)
    _heading(page, "X [m]").click()
    assert _cells(page, 0)[:3] == [f"P{count - 1}", f"P{count - 2}", f"P{count - 3}"]
    assert page.locator("th[aria-sort]").all_inner_texts() == ["X [m]"]
    assert page.locator("th[aria-sort=ascending]").count() == 1
    _heading(page, "σ X [mm]").click()
    _heading(page, "σ X [mm]").click()
    assert page.locator("th[aria-sort=descending]").count() == 1
    largest = max(sigma for i in range(count) if isinstance(sigma := _row(i)[3], float))
    assert _cells(page, 3)[0] == f"{largest:.1f}"
    if page.locator(".pager").count():
        page.get_by_role("button", name="Last page").click()
    assert _cells(page, 3)[-1] == "–"
    _heading(page, "σ X [mm]").click()
    assert page.locator("th[aria-sort]").count() == 0
    assert _cells(page, 0) == before


def test_names_are_sorted_by_their_numbers_sizes_by_their_units(page_of: PageOf, file: Path) -> None:
    page = page_of(file)
    _heading(page, "Point").click()
    assert _cells(page, 0)[:12] == [f"P{i}" for i in range(12)]
    _heading(page, "Size").click()
    assert _cells(page, 5)[0] == "31.8 µm"
    _heading(page, "Size").click()
    assert _cells(page, 5)[0] == "2 m"


def test_words_and_comparisons_filter_all_rows(page_of: PageOf, file: Path, count: int) -> None:
    page = page_of(file)
    rows = [_row(i) for i in range(count)]

    def expected(number: int) -> str:
        return f"{number} of {count} rows" if number < count else f"{count} rows"

    controls = sum(row[1] == "control" for row in rows)
    assert _filter(page, "CONTROL") == expected(controls)
    assert set(_cells(page, 1)) == {"control"}
    assert _filter(page, "tie P8") == expected(sum("P8" in str(row[0]) and row[1] == "tie" for row in rows))
    sigmas = [row[3] for row in rows if isinstance(row[3], float)]
    assert _filter(page, "> 3", "σ X [mm]") == expected(sum(sigma > 3 for sigma in sigmas))
    assert _filter(page, "|x| >= 3.5", "σ X [mm]") == expected(sum(abs(sigma) >= 3.5 for sigma in sigmas))
    assert _filter(page, "σ X <= -3,9") == expected(sum(sigma <= -3.9 for sigma in sigmas))
    assert _filter(page, "Rays = 5") == expected(sum(row[4] == 5 for row in rows))
    assert "Choose the column" in _filter(page, "> 3")
    assert _filter(page, "no such thing") == expected(0)
    assert _cells(page, 0) == []
    assert _filter(page, "") == expected(count)


COMPARED = """(typed) => {
  const values = [-2, 3, null, 3.5];
  const rows = { value: (row) => values[row] };
  const asked = tableFilter(typed, ["σ X [mm]"], [true], 0);
  return values.flatMap((value, row) => (asked.matches(rows, row) ? [value] : []));
}"""


@pytest.mark.parametrize("count", [90], indirect=True)
def test_every_comparison(page_of: PageOf, file: Path, count: int) -> None:
    page = page_of(file)
    found = {
        "< 3": [-2], "<= 3": [-2, 3], "≤3": [-2, 3], "> 3": [3.5], ">= 3": [3, 3.5], "≥ 3": [3, 3.5],
        "= 3": [3], "!= 3": [-2, 3.5], "≠ 3": [-2, 3.5], "x > −2": [3, 3.5], "|x| = 2": [-2],
        "|σ x| < 3,1": [-2, 3], "σ x [mm] > 3.1e0": [3.5],
    }  # fmt: skip
    assert {typed: page.evaluate(COMPARED, typed) for typed in found} == found


def test_marked_rows_alone(page_of: PageOf, file: Path, count: int) -> None:
    page = page_of(file)
    only = page.get_by_role("button", name="Only marked (2)")
    only.click()
    assert _cells(page, 0) == ["P3", f"P{count - 1}"]
    assert page.locator("tbody tr.marked").count() == 2
    only.click()
    assert len(_cells(page, 0)) == min(count, 90 if count == 90 else 50)


def test_the_same_cells_in_the_page_and_by_script(page_of: PageOf, file: Path, count: int) -> None:
    page = page_of(file)
    before = page.locator("tbody tr").all_inner_texts()
    markup = page.locator("tbody tr").nth(3).evaluate('tr => tr.innerHTML.replace(/ data-v="[^"]*"/g, \'\')')
    _heading(page, "Point").click()
    for _ in range(2):
        _heading(page, "Point").click()
    assert page.locator("tbody tr").all_inner_texts() == before
    again = page.locator("tbody tr").nth(3).evaluate('tr => tr.innerHTML.replace(/ data-v="[^"]*"/g, \'\')')
    assert again == markup


def test_pages(page_of: PageOf, file: Path, count: int) -> None:
    page = page_of(file)
    rows = page.locator("tbody tr")
    if count == 90:
        assert rows.count() == 90
        assert page.locator(".pager").count() == 0
        return
    assert rows.count() == 50
    assert page.locator(".pager").inner_text().split("\n")[2] == f"Rows 1–50 of {count}"
    assert page.get_by_role("button", name="Previous page").is_disabled()
    page.get_by_role("button", name="Next page").click()
    assert _cells(page, 0)[0] == "P50"
    assert rows.first.get_attribute("aria-rowindex") == "52"
    page.get_by_role("button", name="Last page").click()
    assert _cells(page, 0)[-1] == f"P{count - 1}"
    assert page.get_by_role("button", name="Next page").is_disabled()
    _filter(page, "P4999")  # from the last page to the only one
    assert _cells(page, 0) == ["P4999"]
    assert "Rows 1–1 of 1" in page.locator(".pager").inner_text()


def test_keyboard_alone(page_of: PageOf, file: Path, count: int) -> None:
    page = page_of(file)
    _heading(page, "X [m]").focus()
    page.keyboard.press("Enter")
    assert _cells(page, 0)[0] == f"P{count - 1}"
    page.keyboard.press("Space")
    assert page.locator("th[aria-sort=descending]").count() == 1
    outline = page.evaluate("getComputedStyle(document.activeElement).outlineStyle")
    assert outline == "solid"
    page.get_by_role("searchbox").focus()
    page.keyboard.type("P77")
    expect(page.locator("output")).to_contain_text(" of ")
    assert _cells(page, 0)[0] == "P77"


def test_copy_takes_all_rows_that_are_found(page_of: PageOf, file: Path) -> None:
    page = page_of(file)
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    _filter(page, "> 990.8", "X [m]")
    page.get_by_role("button", name="Copy as CSV: Points").click()
    expect(page.locator("output")).to_contain_text("Copied 19 rows")
    lines = page.evaluate("navigator.clipboard.readText()").splitlines()
    assert lines[0] == "Point,Role,X [m],σ X [mm],Rays,Size"
    assert lines[1].startswith("P0,tie,1000.000,–,0,9.35 mm")
    assert len(lines) == 20


def test_without_script_the_first_rows_and_where_all_are(browser: Browser, file: Path, count: int) -> None:
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto(file.as_uri())
    assert page.locator("tbody tr").count() == (90 if count == 90 else 50)
    notes = page.locator(".table .note").all_inner_texts()
    assert notes == ([] if count == 90 else ["Rows 1–50 of 5000.", "All 5000 rows are in points.csv, too."])
    context.close()
