"""How blocks of pages are read, before anything of them is run."""

from __future__ import annotations

import pytest

from tests.docs.page_blocks import blocks_of, commands_of, edited
from tests.docs.page_runner import missing_lines

PAGE = """\
Words.

<!-- exit code: 2 -->
```sh
splinebba check a \\
    --quiet
# nothing
splinebba check b
```

- item

  <!-- not run: needs a network -->
  ```console
  $ curl x
  answer
  ```

<!-- folder: mine from sample_projects/six_image_block -->
```yaml
a: 1
```
"""


def test_blocks_and_their_marks() -> None:
    shell, console, folder, yaml = blocks_of("p", PAGE)
    assert (shell.line, shell.language, shell.mark("exit code"), shell.runs) == (4, "sh", "2", True)
    assert commands_of(shell) == ["splinebba check a      --quiet", "splinebba check b"]
    assert (console.runs, console.mark("not run")) == (False, "needs a network")
    assert commands_of(console) == ["curl x"]
    assert folder.mark("folder") == "mine from sample_projects/six_image_block"
    assert not yaml.concerned


@pytest.mark.parametrize("text", ["```sh\nls\n", "<!-- printed -->\nwords\n```text\n```\n"])
def test_what_is_left_open_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="p:"):
        blocks_of("p", text)


def test_smaller_commands() -> None:
    (block,) = blocks_of(
        "p", "<!-- smaller: --runs 500 -> --runs 2 -->\n```sh\nsplinebba simulate x --runs 500\n```\n"
    )
    assert commands_of(block) == ["splinebba simulate x --runs 2"]


def test_edits() -> None:
    assert edited("a\nb\nc\n", " a\n-b\n+d\n") == "a\nd\nc\n"
    assert edited("a\n", "+b\n") == "a\nb\n"
    for text in ("a\n", "b\nb\n", "ab\n"):
        with pytest.raises(ValueError, match="times"):
            edited(text, "-b\n+c\n")


def test_printed_lines() -> None:
    printed = "one 1.20\n  two   2\nthree (x)\n"
    assert missing_lines(printed, "one 1.21\n…\nthree …\n") == []
    assert missing_lines(printed, "two 5\nthree (x)\n") == ["two 5"]
    assert missing_lines(printed, "two 2\none 1.20\n") == ["one 1.20"]


def test_printed_numbers() -> None:
    """Rounding is allowed, other counts and other values beside `…` are not."""
    printed = "8 images, rank 644, σ 0.9526 of 1\n"
    assert missing_lines(printed, "8 images, rank 644, σ 0.9525 …") == []
    for other in ("9 images, rank 644, …", "8 images, rank 645, …", "8 images, … σ 0.9515 of 1"):
        assert missing_lines(printed, other) == [other]
