"""JSON as people like to read it."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinebba_cli.output import json_text as module
from splinebba_cli.output.json_text import json_text

NUMBERS = st.one_of(st.integers(-(10**9), 10**9), st.floats(allow_nan=False, allow_infinity=False), st.none())
SCALARS = st.one_of(NUMBERS, st.booleans(), st.text(max_size=9))
LISTS = st.lists(st.one_of(NUMBERS, st.lists(NUMBERS, max_size=6)), max_size=40)
VALUES = st.recursive(
    st.one_of(SCALARS, LISTS),
    lambda inner: st.one_of(
        st.lists(inner, max_size=5), st.dictionaries(st.text(max_size=5), inner, max_size=5)
    ),
    max_leaves=20,
)


@given(VALUES)
def test_what_is_written_reads_back(value: Any) -> None:
    assert json.loads(json_text(value)) == value


@given(VALUES)
def test_lists_of_numbers_look_like_all_others(value: Any) -> None:
    """The quick way of lists of numbers gives the text of the general one."""
    with pytest.MonkeyPatch.context() as patch:
        found = json_text(value)
        patch.setattr(module, "_of_numbers", lambda *_: None)
        assert json_text(value) == found


def test_rows_of_numbers_stand_on_lines_of_their_own() -> None:
    rows = [[float(k), None, -1e-7] for k in range(12)]
    lines = json_text({"rows": rows}).splitlines()
    assert lines[2] == "    [0.0, null, -1e-07],"
    assert len(lines) == 16


def test_keys_of_different_kinds_are_not_mixed_up() -> None:
    assert json_text({1: "a", "x": 2}) == '{"1": "a", "x": 2}\n'
    assert json_text({True: "a"}) == '{"True": "a"}\n'


def test_numbers_that_json_does_not_have() -> None:
    with pytest.raises(ValueError, match="not JSON compliant"):
        json_text([float("nan"), 1.0])
