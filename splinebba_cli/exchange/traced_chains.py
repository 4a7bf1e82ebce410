"""Chains of a tracing tool in image coordinates: GeoJSON, labelme, tables of points or segments."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path, PureWindowsPath
from typing import Any

from splinebba_cli.core.network import FloatArray
from splinebba_cli.exchange.file_text import JSON_SUFFIXES, text_of
from splinebba_cli.exchange.json_file import NoJsonError, json_of
from splinebba_cli.project.diagnostics import Collector, Place

_IMAGE_FORMAT = re.compile(r"\.(jpe?g|tiff?|png|bmp|webp|jp2|dng|nef|cr[23]|arw|raw|pgm)$", re.IGNORECASE)


@dataclass(frozen=True)
class TracedChain:
    """Points of one chain in the order of tracing."""

    image: str
    id: str  # empty where the file gives none
    xy: FloatArray  # (n, 2) image coordinates as the file has them, x right
    place: Place


@dataclass(frozen=True)
class TracingOptions:
    """How files of a tracing tool are read."""

    columns: tuple[str, ...] | None = (
        None  # of a table: names in the header's place, `-` for one that is not used
    )
    image_suffix: str = ""  # behind names of images that are those of files


def read_traced_chains(path: Path, options: TracingOptions, collector: Collector) -> list[TracedChain]:
    """Chains of one file; errors and warnings go to the collector.

    Parameters
    ----------
    path : Path
        ``.geojson`` and ``.json`` are GeoJSON or labelme, everything else is a table.
    """
    from splinebba_cli.exchange.chains_table import chains_from_table

    text = text_of(path, collector, "convert its chains in parts")
    if text is None:
        return []
    image = image_name(path.name, options)
    if path.suffix.lower() not in JSON_SUFFIXES:
        return chains_from_table(text, str(path), image, options, collector)
    try:
        data = json_of(text, str(path), "SBB332", collector)
    except NoJsonError:
        return []
    return _chains_of_json(data, str(path), image, options, collector)


def image_name(file: str, options: TracingOptions) -> str:
    r"""The image that the name of a file stands for: without folders and endings, as either system writes them.

    ``DSC_1.geojson``, ``DSC_1.JPG.json`` and ``..\images\DSC_1.JPG`` are all ``DSC_1``.
    """
    name = PureWindowsPath(file).name
    if not _IMAGE_FORMAT.search(name):
        name = PureWindowsPath(name).stem
    return _IMAGE_FORMAT.sub("", name) + options.image_suffix


def warn_of_others(kinds: Sequence[str], file: str, collector: Collector) -> None:
    """SBB333: parts of a file that are no lines, by the words of the file."""
    if kinds:
        counted = ", ".join(f"{number} {kind}" for kind, number in sorted(Counter(kinds).items()))
        collector.warning("SBB333", f"left out, since they are no lines: {counted}", Place(file))


def _chains_of_json(
    data: Any, file: str, image: str, options: TracingOptions, collector: Collector
) -> list[TracedChain]:
    from splinebba_cli.exchange.chains_geojson import chains_from_geojson
    from splinebba_cli.exchange.chains_labelme import chains_from_labelme

    if isinstance(data, dict) and "shapes" in data:
        return chains_from_labelme(data, file, image, options, collector)
    return chains_from_geojson(data, file, image, collector)
