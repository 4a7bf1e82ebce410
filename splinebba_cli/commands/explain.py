"""``splinebba explain``: what an error code means, and what to do about it."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Annotated

import typer

from splinebba_cli.commands.console import expected_errors, print_json, rich_console
from splinebba_cli.commands.options import FormatOption, OutputFormat
from splinebba_cli.errors import ERROR_CODES, UsageError

if TYPE_CHECKING:
    from splinebba_cli.explanations import Explanation

ALL = "all"
NEAR = 3  # codes that are suggested


def _completed(incomplete: str) -> list[tuple[str, str]]:
    """Codes and their titles for the completion of the shell, written as the user writes them."""
    known = {ALL: "lists the codes", **ERROR_CODES}
    if incomplete[:1].isdigit():
        known = {code.removeprefix("SBB"): title for code, title in ERROR_CODES.items()}
    elif incomplete and incomplete == incomplete.lower():
        known = {code.lower(): title for code, title in known.items()}
    return [(code, title) for code, title in known.items() if code.startswith(incomplete)]


def explain(
    code: Annotated[
        str,
        typer.Argument(
            metavar="CODE",
            help="Code such as SBB301, sbb301 or 301; `all` lists them.",
            autocompletion=_completed,
        ),
    ] = ALL,
    format: FormatOption = OutputFormat.text,
) -> None:
    """Explain an error code: cause, example, cure."""
    as_json = format is OutputFormat.json
    with expected_errors(as_json=as_json):
        if code.lower() == ALL:
            _print_codes(as_json)
            return
        known = _known(code)
        from splinebba_cli.explanations import explanation_of

        _print_page(explanation_of(known), as_json)


def _code_of(text: str) -> str:
    """The code that is meant: ``sbb301`` and ``301`` are SBB301."""
    text = text.strip().upper()
    return f"SBB{text}" if text[:1].isdigit() else text


def _known(text: str) -> str:
    """The registered code that is meant.

    Raises
    ------
    UsageError
        SBB900, with near codes.
    """
    code = _code_of(text)
    if code in ERROR_CODES:
        return code
    near = _near(code)
    help = "`splinebba explain all` lists the codes"
    if near:
        help = f"near ones: {', '.join(f'{each} ({ERROR_CODES[each]})' for each in near)}; {help}"
    raise UsageError("SBB900", f"no error code `{text}`", help)


def _near(code: str) -> list[str]:
    """Codes with the nearest numbers; of a word, those whose titles hold it."""
    number = code.removeprefix("SBB")
    if number.isdecimal():
        return sorted(ERROR_CODES, key=lambda known: abs(int(known[3:]) - int(number)))[:NEAR]
    return [known for known, title in ERROR_CODES.items() if code.lower() in title.lower()][:NEAR]


def _print_codes(as_json: bool) -> None:
    if as_json:
        print_json({"codes": [{"code": code, "title": title} for code, title in ERROR_CODES.items()]})
    else:
        print("\n".join(f"{code}  {title}" for code, title in ERROR_CODES.items()))


def _print_page(page: Explanation, as_json: bool) -> None:
    """Laid out on a terminal; the Markdown as it is elsewhere."""
    if as_json:
        sections = {name.lower().replace(" ", "_"): text for name, text in page.sections.items()}
        print_json({"code": page.code, "title": page.title, **sections})
    elif sys.stdout.isatty():
        from rich.markdown import Markdown

        console = rich_console()
        console.print(
            Markdown(page.text, code_theme="ansi_dark", hyperlinks=False), width=min(console.width, 100)
        )
    else:
        print(page.text, end="")
