"""YAML with positions."""

from __future__ import annotations

import time

import pytest

from splinebba_cli.project.diagnostics import Collector
from splinebba_cli.project.yaml_source import YamlSource, parse_yaml


def parsed(text: str | bytes) -> tuple[YamlSource | None, Collector]:
    collector = Collector()
    return parse_yaml(text, "p.yaml", collector), collector


def test_scalars_stay_texts() -> None:
    source, collector = parsed("a: 0101\nb: 12:30\nc: no\nd: 1e-6\ne: ~\nf: 0x10\ng: 2020-01-01\nh: ''\ni:\n")
    assert source is not None and not collector.items
    assert source.data == {
        "a": "0101",
        "b": "12:30",
        "c": "no",
        "d": "1e-6",
        "e": "~",
        "f": "0x10",
        "g": "2020-01-01",
        "h": "",
        "i": None,
    }


def test_positions_of_keys_and_values() -> None:
    source, _ = parsed("a:\n  - bc: [1, 23]\n")
    assert source is not None
    value = source.place(("a", 0, "bc", 1))
    assert (value.line, value.column, value.length, value.snippet) == (2, 13, 2, "  - bc: [1, 23]")
    key = source.place(("a", 0, "bc"), key=True)
    assert (key.line, key.column, key.length) == (2, 5, 2)
    parent = source.place(("a", 0, "missing", "deeper"))
    assert parent.line == 2


def test_columns_count_characters_not_bytes() -> None:
    source, _ = parsed("{ärger: ö, b: x}\n".encode())
    assert source is not None
    assert source.place(("b",)).column == 15


def test_byte_order_mark_is_passed_over() -> None:
    source, collector = parsed(b"\xef\xbb\xbfa: 1\n")
    assert source is not None and not collector.items
    assert source.data == {"a": "1"}
    assert source.place(("a",)).column == 4


def test_first_line_of_a_block_scalar() -> None:
    source, _ = parsed("x: 1\ndata: |\n\n  1 2\n  3 4\n")
    assert source is not None
    assert source.data["data"] == "\n1 2\n3 4\n"
    assert source.blocks[("data",)] == 2


def test_anchors_are_resolved() -> None:
    source, collector = parsed("a: &c {k: 1}\nb: *c\n")
    assert source is not None and not collector.items
    assert source.data == {"a": {"k": "1"}, "b": {"k": "1"}}


@pytest.mark.parametrize(
    ("text", "code", "line", "column"),
    [
        ("a: 1\nb: 2\na: 3\n", "SBB104", 3, 1),
        ("x: {a: 1, a: 2}\n", "SBB104", 1, 11),
        ("a: [1,\n", "SBB102", 1, 4),
        ("a:\n\tb: 1\n", "SBB102", 2, 1),
        ("a: b: c\n", "SBB102", 1, 5),
        (b"a: 1\nb: \xe9\n", "SBB103", 2, 4),
        ("a: 1\n".encode("utf-16"), "SBB103", 1, 1),
        ("a: &x [1, *x]\n", "SBB105", 1, 4),
        ("<<: {a: 1}\n", "SBB107", 1, 1),
        ("a: !secret 1\n", "SBB107", 1, 4),
        ("--- {a: 1}\n--- {a: 1}\n", "SBB102", 2, 1),
        ("? [1]\n: 2\n", "SBB108", 1, 3),
        ("", "SBB106", 1, 1),
        ("a: \x00\n", "SBB102", 1, 4),
        ("[" * 100, "SBB105", 1, 65),
    ],
)
def test_errors_with_positions(text: str | bytes, code: str, line: int, column: int) -> None:
    _, collector = parsed(text)
    first = collector.finished()[0]
    assert (first.code, first.line, first.column) == (code, line, column)


def test_a_duplicate_key_names_the_first_one() -> None:
    _, collector = parsed("a: 1\nb: 2\na: 3\n")
    assert "line 1, column 1" in collector.finished()[0].help


def test_alias_bomb_ends_soon() -> None:
    text = "a: &a [1,1,1,1,1,1,1,1,1,1]\n" + "".join(
        f"{chr(98 + i)}: &{chr(98 + i)} [{','.join(['*' + chr(97 + i)] * 10)}]\n" for i in range(12)
    )
    start = time.perf_counter()
    _, collector = parsed(text)
    assert [d.code for d in collector.finished()] == ["SBB105"]
    assert time.perf_counter() - start < 10.0


def test_a_long_text_that_aliases_repeat_is_a_bomb_too() -> None:
    text = f"a: &a {'x' * 50_000}\nb: [{','.join(['*a'] * 1000)}]\n"
    _, collector = parsed(text)
    assert [d.code for d in collector.finished()] == ["SBB105"]
    _, collector = parsed(text.replace("x" * 50_000, "x"))
    assert not collector.has_errors


def test_deep_nesting_does_not_end_the_interpreter() -> None:
    _, collector = parsed("- " * 200_000 + "a")
    assert collector.finished()[0].code == "SBB105"
