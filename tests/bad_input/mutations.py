"""Ways to break a project: bytes, characters and lines of its files, and the data of its YAML."""

from __future__ import annotations

import random
import re
from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

import yaml

NUMBER = re.compile(rb"(?<![\w.])-?\d+(?:\.\d+)?(?:e-?\d+)?(?![\w.])")
WORD = re.compile(rb"[A-Za-z_][\w-]*")
ODD_NUMBERS = (
    b"nan", b"inf", b"-inf", b"1e308", b"-1e308", b"1e-308", b"-0", b"", b"0", b"-1", b"99999999999999999999", b"1e9",
    b"0.5", b"-", b"fixed", b"free", b"1_000", b"0x10", b"1,5", b"1e", b"+1", b".5", b"null", b"~", b"true",
)  # fmt: skip
ODD_TEXTS = (
    b"\0", b"\x1b[2J", b"\xff", b"\xc3", "é".encode(), "e\u0301".encode(), "\u2028".encode(), "\u202e".encode(),
    "\ufeff".encode(), b"\x85", b"\r", b"\t", b'"', b"'", b"#", b"=", b"@", b"::", b"<b>", b"{", b"]", b"*a", b"&a ",
    b"!!python/object:x ", b"<<: ", b"---\n", b"%", b"|\n", b"- ", b": ", b"\\", b"\x7f", "😀".encode(),
)  # fmt: skip
SEPARATORS = (b",", b";", b"\t", b" ", b"|")

Files = dict[str, bytes]


@dataclass(frozen=True)
class NumberChange:
    """A number of a file that was replaced by another number."""

    file: str
    line: int
    old: float
    new: float


def changed_number(files: Files, name: str, chance: random.Random) -> NumberChange | None:
    """Replace one number by another plain one."""
    found = [one for one in NUMBER.finditer(files[name]) if float(one[0])]
    if not found:
        return None
    one = chance.choice(found)
    old = float(one[0])
    new = round(old * chance.choice((1.01, 2.0, -1.0)) + chance.choice((0.0, 0.001, 1.0, 100.0)), 6)
    new = old + 1.0 if new == old else new
    content = files[name]
    files[name] = content[: one.start()] + repr(new).encode() + content[one.end() :]
    return NumberChange(name, content.count(b"\n", 0, one.start()) + 1, old, new)


def odd_number(content: bytes, chance: random.Random) -> bytes:
    """Replace one number by a special one, or by something that looks like one."""
    return _replaced(content, NUMBER, ODD_NUMBERS, chance)


def other_word(content: bytes, chance: random.Random) -> bytes:
    """Replace one word by another of the same file."""
    words = WORD.findall(content)
    return _replaced(content, WORD, words or [b"word"], chance)


def _replaced(content: bytes, what: re.Pattern[bytes], by: Any, chance: random.Random) -> bytes:
    found = list(what.finditer(content))
    if not found:
        return content
    one = chance.choice(found)
    return content[: one.start()] + chance.choice(by) + content[one.end() :]


def flipped_bit(content: bytes, chance: random.Random) -> bytes:
    """Flip one bit."""
    if not content:
        return content
    place = chance.randrange(len(content))
    return content[:place] + bytes([content[place] ^ 1 << chance.randrange(8)]) + content[place + 1 :]


def inserted(content: bytes, chance: random.Random) -> bytes:
    """Insert an odd text somewhere."""
    place = chance.randint(0, len(content))
    return content[:place] + chance.choice(ODD_TEXTS) + content[place:]


def cut(content: bytes, chance: random.Random) -> bytes:
    """Cut the end off."""
    return content[: chance.randint(0, len(content))]


def without_a_part(content: bytes, chance: random.Random) -> bytes:
    """Remove some bytes."""
    place = chance.randint(0, len(content))
    return content[:place] + content[place + chance.choice((1, 2, 5, 40)) :]


def spliced(content: bytes, chance: random.Random) -> bytes:
    """Copy a part of the file to another place."""
    begin = chance.randint(0, len(content))
    part = content[begin : begin + chance.choice((3, 30, 300))]
    place = chance.randint(0, len(content))
    return content[:place] + part + content[place:]


def without_a_line(content: bytes, chance: random.Random) -> bytes:
    """Delete a line."""
    lines = content.split(b"\n")
    del lines[chance.randrange(len(lines))]
    return b"\n".join(lines)


def line_twice(content: bytes, chance: random.Random) -> bytes:
    """Repeat a line."""
    lines = content.split(b"\n")
    line = chance.choice(lines)
    lines.insert(chance.randint(0, len(lines)), line)
    return b"\n".join(lines)


def swapped_lines(content: bytes, chance: random.Random) -> bytes:
    """Exchange two lines."""
    lines = content.split(b"\n")
    one, other = chance.randrange(len(lines)), chance.randrange(len(lines))
    lines[one], lines[other] = lines[other], lines[one]
    return b"\n".join(lines)


def indented(content: bytes, chance: random.Random) -> bytes:
    """Move a line by a column or two."""
    lines = content.split(b"\n")
    number = chance.randrange(len(lines))
    lines[number] = chance.choice((b" ", b"  ", b"\t")) + lines[number]
    return b"\n".join(lines)


def other_separators(content: bytes, chance: random.Random) -> bytes:
    """Exchange separators of one line or of all."""
    old, new = chance.sample(SEPARATORS, 2)
    if chance.random() < 0.5:
        return content.replace(old, new)
    lines = content.split(b"\n")
    number = chance.randrange(len(lines))
    lines[number] = lines[number].replace(old, new)
    return b"\n".join(lines)


def other_line_ends(content: bytes, chance: random.Random) -> bytes:
    """Other ends of lines."""
    return content.replace(b"\n", chance.choice((b"\r\n", b"\r", b"\n\n", b"\x0b", "\u2028".encode())))


def other_encoding(content: bytes, chance: random.Random) -> bytes:
    """Another encoding, or a byte order mark."""
    text = content.decode("utf-8", "replace")
    if chance.random() < 0.4:
        return b"\xef\xbb\xbf" + content
    return text.encode(chance.choice(("utf-16", "utf-16-le", "utf-32", "latin-1")), "replace")


OF_BYTES: tuple[Callable[[bytes, random.Random], bytes], ...] = (
    odd_number, odd_number, odd_number, other_word, other_word, flipped_bit, inserted, inserted, cut, without_a_part,
    spliced, without_a_line, line_twice, swapped_lines, indented, other_separators, other_line_ends, other_encoding,
)  # fmt: skip

ODD_VALUES: tuple[Any, ...] = (
    None, "", "x", 0, -1, 1, 2.5, 1e308, -1e-308, 10**30, float("nan"), float("inf"), True, False, [], {}, [[]], [1],
    [1, 2], [1, 2, 3], [1, 2, 3, 4], ["a", "b", "c"], {"a": 1}, {"table": "x.csv"}, {"data": "1 2 3"}, "fixed", "free",
    "all", "control", "tie", "check", "partial", "rad", "photo_um", "pixel_one", "x" * 300, "=1+1", "a\nb",
    [[1, 2, 3], [4, 5, 6]], "1 2 3\n4 5 6\n", {"x": 1, "y": 2, "z": 3}, 1000, 1e6, "C2", "circle", "bspline_3",
    "fourier", "uniform", "huber", "inner",
)  # fmt: skip
ODD_KEYS = (
    "id",
    "table",
    "data",
    "sigma",
    "role",
    "x",
    "knots",
    "family",
    "closed",
    "fixed",
    "columns",
    "held",
    "y",
    "no",
)


def changed_data(content: bytes, chance: random.Random) -> bytes:
    """Change one value, key or item of the YAML data."""
    data = yaml.safe_load(content)
    places = list(_places(data))
    owner, key = chance.choice(places)
    how = chance.random()
    if how < 0.5:
        owner[key] = chance.choice(ODD_VALUES)
    elif how < 0.65:
        del owner[key]
    elif how < 0.8:
        other, other_key = chance.choice(places)
        owner[key] = deepcopy(other[other_key])
    elif isinstance(owner, dict):
        owner[chance.choice((*ODD_KEYS, *(k for o, k in places if isinstance(k, str))))] = chance.choice(
            ODD_VALUES
        )
    else:
        owner.insert(chance.randint(0, len(owner)), chance.choice((*ODD_VALUES, owner[key])))
    try:
        return yaml.safe_dump(data, allow_unicode=True, sort_keys=False).encode()
    except (ValueError, RecursionError):
        return content


def _places(data: Any) -> list[tuple[Any, Any]]:
    """Owner and key of every value."""
    found: list[tuple[Any, Any]] = []
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in items:
        found.append((data, key))
        found += _places(value)
    return found
