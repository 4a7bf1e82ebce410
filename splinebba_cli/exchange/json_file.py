"""Files of JSON that other programs wrote."""

from __future__ import annotations

import json
from typing import Any

from splinebba_cli.project.diagnostics import Collector, Place


class NoJsonError(Exception):
    """The text is not JSON; the collector holds the reason."""


def json_of(text: str, file: str, code: str, collector: Collector) -> Any:
    """The content of a JSON text.

    Parameters
    ----------
    code : str
        Of the error where it is none.

    Raises
    ------
    NoJsonError
    """
    try:
        return json.loads(text)
    except json.JSONDecodeError as error:
        lines = text.splitlines()
        line = lines[error.lineno - 1] if error.lineno <= len(lines) else ""
        place = Place(file, error.lineno, error.colno, 1, line)
        collector.error(code, f"not JSON: {error.msg}", place)
    except RecursionError:
        collector.error(code, "nested too deeply", Place(file))
    raise NoJsonError
