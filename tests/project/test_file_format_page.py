"""The page about the project file says what the models say."""

from __future__ import annotations

import pytest

from docs.build_file_format import PAGE, page, type_text


def test_page_is_up_to_date() -> None:
    """To renew: python -m docs.build_file_format."""
    assert PAGE.read_text(encoding="utf-8") == page()


@pytest.mark.parametrize(
    ("field", "text"),
    [
        ({"type": ["number", "string"]}, "number"),
        ({"type": ["integer", "string"]}, "whole number"),
        ({"type": ["string", "number", "boolean"]}, "text"),
        ({"enum": ["fixed", "free"]}, "`fixed`, `free`"),
        ({"$ref": "#/$defs/Camera"}, "[Camera](#camera)"),
        ({"anyOf": [{"$ref": "#/$defs/Held"}, {"type": "null"}]}, "[Held](#held)"),
        (
            {"type": "array", "minItems": 2, "maxItems": 2, "items": {"type": ["number", "string"]}},
            "list of 2: number",
        ),
    ],
)
def test_types_in_words(field: dict[str, object], text: str) -> None:
    assert type_text(field) == text
