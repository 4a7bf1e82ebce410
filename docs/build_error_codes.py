"""Write docs/error-codes.md from the codes of the program.

python -m docs.build_error_codes
"""

from __future__ import annotations

from pathlib import Path

from splinebba_cli.errors import ERROR_CODES

PAGE = Path(__file__).with_name("error-codes.md")
EXPLANATIONS = Path(__file__).parents[1] / "splinebba_cli" / "explanations"
INTRODUCTION = """\
# Error codes

<!-- generated: python -m docs.build_error_codes -->

Every message of the program has a code. `splinebba explain SBB301` tells more about one, with an example
and its cure; the pages linked here are the same.
Errors of a project are all reported at once, with file, line and column.
"""
GROUPS = {
    "1": "The text of the project file",
    "2": "The project against its schema",
    "3": "References between the parts, and their meaning",
    "4": "Tables",
    "5": "Adjustment",
    "6": "Output and comparison",
    "7": "Simulation",
    "8": "Several projects, and new ones",
    "9": "The program",
}


def page() -> str:
    """The whole page."""
    parts = [INTRODUCTION]
    for group, title in GROUPS.items():
        codes = sorted(code for code in ERROR_CODES if code[3] == group)
        if codes:
            rows = [f"| {_linked(code)} | {ERROR_CODES[code]} |" for code in codes]
            parts.append("\n".join([f"## {title}", "", "| code | says |", "|---|---|", *rows, ""]))
    return "\n".join(parts)


def _linked(code: str) -> str:
    explained = (EXPLANATIONS / f"{code}.md").exists()
    return f"[{code}](../splinebba_cli/explanations/{code}.md)" if explained else code


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8", newline="\n")
    print(PAGE.name)
