"""Put what the program says today into the examples of the explanation pages.

python -m tests.regenerate_explanations
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from tests.explanations.examples import PAGES, example_of, printed


def main() -> None:
    """Run every example that can be run."""
    for page in sorted(PAGES.glob("SBB*.md")):
        example = example_of(page)
        if example is None:
            continue
        with tempfile.TemporaryDirectory() as folder:
            output = printed(example, Path(folder))
        if not output:
            print(f"{page.name}: its example does not give {example.code}")
        elif output != example.output:
            text = page.read_text(encoding="utf-8")
            old = f"$ {example.command}\n" + (f"{example.output}\n" if example.output else "")
            assert text.count(old + "```") == 1, page.name
            page.write_text(
                text.replace(old + "```", f"$ {example.command}\n{output}\n```"), encoding="utf-8"
            )
            print(f"{page.name}: renewed")


if __name__ == "__main__":
    main()
