"""Follow a page of the documentation as its reader does, with the program of this environment.

python -m tests.docs.follow docs/tutorial.md
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

from tests.docs.page_blocks import blocks_of
from tests.docs.page_runner import ROOT, Reader, follow_page, run_in_shell


def main(page: str) -> None:
    """Do all that a page says, in a folder of its own."""
    blocks = blocks_of(page, (ROOT / page).read_text(encoding="utf-8"))
    start = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        follow_page(blocks, Reader(Path(folder), run_in_shell))
    count = sum(block.runs for block in blocks)
    print(f"{page}: {count} blocks of commands run in {time.perf_counter() - start:.0f} s")


if __name__ == "__main__":
    main(sys.argv[1])
