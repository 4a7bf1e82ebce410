"""Fenced blocks of a page, and the comments that say what a test does with them.

A comment of HTML stands on a line of its own before the block that it belongs to; readers do not see it.

    <!-- not run: REASON -->             the block is shown only
    <!-- exit code: 3 -->                the last command of the block ends so
    <!-- smaller: A -> B -->             the test runs B where the page says A
    <!-- edit: FILE -->                  the following `diff` block is applied to the file
    <!-- file: FILE -->                  the following block is the content of the file
    <!-- printed -->                     the following block are lines that the last command printed
    <!-- folder: NAME from PATH -->      a copy of a folder of the repository lies there
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

RUN = ("sh", "console", "python")
_FENCE = re.compile(r"^( *)```(\w*)\s*$")
_COMMENT = re.compile(r"^\s*<!-- (not run|exit code|smaller|edit|file|printed|folder)(?:: (.*?))? -->$")


@dataclass(frozen=True)
class Block:
    """A block of a page with its comments."""

    page: str
    line: int  # of its first fence, counted from 1
    language: str
    text: str
    marks: tuple[tuple[str, str], ...]  # what comments say: word, rest

    def mark(self, word: str) -> str | None:
        """What the comment of this kind says; None where there is none."""
        return next((rest for key, rest in self.marks if key == word), None)

    @property
    def concerned(self) -> bool:
        """Whether a test has anything to do with it."""
        return bool(self.marks) or self.language in RUN

    @property
    def runs(self) -> bool:
        """Whether it has commands that are run."""
        return self.language in RUN and self.mark("not run") is None and self.mark("file") is None


def blocks_of(page: str, text: str) -> list[Block]:
    """All fenced blocks of a page, with the comments before them.

    Raises
    ------
    ValueError
        If a comment has no block, or a block no end.
    """
    found: list[Block] = []
    marks: list[tuple[str, str]] = []
    lines = enumerate(text.splitlines(), start=1)
    for number, line in lines:
        comment, fence = _COMMENT.match(line), _FENCE.match(line)
        if comment and comment[1] == "folder":
            found.append(Block(page, number, "", "", (("folder", comment[2]),)))
        elif comment:
            marks.append((comment[1], comment[2] or ""))
        elif fence:
            body = []
            for _, inner in lines:
                if inner.strip() == "```":
                    break
                body.append(inner.removeprefix(fence[1]))
            else:
                raise ValueError(f"{page}:{number}: block without an end")
            found.append(Block(page, number, fence[2], "\n".join(body) + "\n", tuple(marks)))
            marks = []
        elif line.strip() and marks:
            raise ValueError(f"{page}:{number}: a comment {marks} without a block")
    return found


def commands_of(block: Block) -> list[str]:
    """Commands of a block of a shell; of a console session the lines behind `$`."""
    smaller = block.mark("smaller")
    text = block.text
    if smaller is not None:
        shown, _, run = smaller.partition(" -> ")
        if shown not in text:
            raise ValueError(f"{block.page}:{block.line}: no {shown!r} to be made smaller")
        text = text.replace(shown, run)
    lines = text.replace("\\\n", " ").splitlines()
    if block.language == "console":
        lines = [line[2:] for line in lines if line.startswith("$ ")]
    return [line.strip() for line in lines if line.strip() and not line.lstrip().startswith("#")]


def edited(text: str, diff: str) -> str:
    """A text in which the lines of a diff are replaced: `-` goes, `+` comes, others stay.

    Raises
    ------
    ValueError
        If what the diff shows does not stand in the text, or more than once.
    """
    rows = [(line[:1], line[1:]) for line in diff.splitlines()]
    old = [line for sign, line in rows if sign in ("-", " ")]
    new = [line for sign, line in rows if sign in ("+", " ")]
    lines = text.splitlines()
    if not old:
        return "\n".join([*lines, *new, ""])
    places = [i for i in range(len(lines)) if lines[i : i + len(old)] == old]
    if len(places) != 1:
        raise ValueError(f"stands {len(places)} times in the file, not once: {old}")
    return "\n".join([*lines[: places[0]], *new, *lines[places[0] + len(old) :], ""])


def pages(root: Path) -> dict[str, str]:
    """Pages with commands: path in the repository, text.

    Sessions in explanations of error codes are run by their own test, with the projects that they show.
    """
    paths = [root / "README.md", *sorted(root.glob("docs/**/*.md"))]
    left_out = ("docs/errors/",)  # copies of the explanations, made by the site
    names = {path.relative_to(root).as_posix(): path for path in paths}
    return {
        name: path.read_text(encoding="utf-8")
        for name, path in names.items()
        if not name.startswith(left_out) and not name.endswith((".words.md", ".intro.md"))
    }
