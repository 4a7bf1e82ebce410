"""The text of a file that another program wrote."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from splinebba_cli.project.diagnostics import Collector, Place, suggestion
from splinebba_cli.project.file_content import NoContentError, TooLargeError, file_content, names_in
from splinebba_cli.project.text_position import decoded

JSON_SUFFIXES = (".geojson", ".json")


def text_of(path: Path, collector: Collector, smaller: str) -> str | None:
    """The text of a file; None where it cannot be read, and the collector holds SBB103, SBB401 or SBB409.

    Parameters
    ----------
    smaller : str
        Help for files that are too large: what people can do with a part of it.
    """
    try:
        content = file_content(path, may_be_pipe=True)
    except TooLargeError as reason:
        collector.error("SBB409", f"`{path}` is too large: {reason}", Place(str(path)), smaller)
        return None
    except NoContentError as reason:
        near = suggestion(path.name, names_in(path.parent))
        collector.error("SBB401", f"`{path}` cannot be read: {reason}", Place(str(path)), near)
        return None
    return decoded(content, str(path), partial(collector.error, "SBB103"))
