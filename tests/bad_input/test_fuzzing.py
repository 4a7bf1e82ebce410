"""Some hundred cases of the fuzzer, and texts and data that hypothesis makes up.

``python -m tests.bad_input.fuzz --cases 20000`` is the long version.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from splinebba_cli.errors import ProjectError
from splinebba_cli.project.diagnostics import Collector, Place, render_text
from splinebba_cli.project.loading import load_project
from splinebba_cli.project.tables import TableUnreadableError, table_from_text
from splinebba_cli.project.yaml_source import parse_yaml
from tests.bad_input.fuzz import one_case, project_files, run
from tests.bad_input.other_inputs import case_of_points, case_of_results

SEED = 20
QUICK = settings(
    max_examples=60,
    derandomize=True,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
SCALARS = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=12),
    st.sampled_from(["fixed", "free", "tie"]),
)
DATA = st.recursive(
    SCALARS,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=6), inner, max_size=4),
    max_leaves=8,
)
SECTIONS: dict[str, Any] = yaml.safe_load(project_files("inline")["project.yaml"])


def test_broken_projects() -> None:
    found = run(range(150), lambda number, folder: one_case(SEED, number, folder, share_adjusted=0.03))
    assert not found.bugs, found.report()
    assert sum(count for name, count in found.outcomes.items() if name.startswith("refused")) > 50
    assert (
        sum(count for name, count in found.outcomes.items() if name.startswith(("accepted", "adjusted"))) > 10
    )


def test_broken_points() -> None:
    found = run(range(40), lambda number, folder: case_of_points(SEED, number, folder))
    assert not found.bugs, found.report()


def test_broken_results() -> None:
    found = run(range(12), lambda number, folder: case_of_results(SEED, number, folder))
    assert not found.bugs, found.report()


def test_the_fuzzer_sees_a_bug() -> None:
    def case(number: int, folder: Path) -> str:
        raise KeyError(number)

    assert "KeyError" in run(range(1), case).bugs[0]


@pytest.mark.parametrize("section", sorted(SECTIONS))
def test_any_data_in_a_section(section: str, tmp_path: Path) -> None:
    """Data of any shape is refused with diagnostics, or means something."""

    @QUICK
    @given(data=DATA)
    def any_data(data: Any) -> None:
        path = tmp_path / "project.yaml"
        path.write_text(yaml.safe_dump({**SECTIONS, section: data}), encoding="utf-8", errors="surrogatepass")
        said = "a project"
        try:
            load_project(path)
        except ProjectError as error:
            said = render_text(error.diagnostics)
        assert said

    any_data()


@QUICK
@given(text=st.one_of(st.text(), st.text(alphabet="a1:-[]{},&*!|>'\"%#?@ \n\t")))
def test_any_yaml(text: str) -> None:
    collector = Collector()
    source = parse_yaml(text, "p.yaml", collector)
    assert source is not None or collector.has_errors
    for item in collector.finished():
        assert item.line is not None and item.column is not None
        assert 1 <= item.line <= max(1, len(text.splitlines()) + 1)


@QUICK
@given(text=st.one_of(st.text(), st.text(alphabet='ab1.,;\t \n"#-e')))
def test_any_table(text: str) -> None:
    collector = Collector()
    try:
        table = table_from_text(
            text, file="t.csv", collector=collector, columns=("a", "b"), declared_at=Place("p")
        )
    except TableUnreadableError:
        assert collector.has_errors
        return
    numbers = table.numbers("b")
    assert len(table.texts("a")) == len(numbers) == table.rows
    assert np.isfinite(numbers).all()
    for item in collector.finished():
        if item.line is not None and item.snippet:
            assert item.column is not None and item.column <= len(item.snippet) + 1
