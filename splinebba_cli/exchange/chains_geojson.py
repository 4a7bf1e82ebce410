"""Chains in GeoJSON whose coordinates are those of an image: lines that were digitised over it in a GIS program.

The image is the property ``image`` of a feature, else it has the name of the file; the name of a chain is the property
``chain``, ``id`` or ``name``, or the id of the feature.  Rings of polygons are chains that end where they begin.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from splinebba_cli.exchange.geojson_geometry import NotGeojsonError, named_lines, property_of
from splinebba_cli.exchange.traced_chains import TracedChain, warn_of_others
from splinebba_cli.project.diagnostics import Collector, Place

IMAGE_PROPERTIES = ("image",)
CHAIN_PROPERTIES = ("chain", "id", "name")


def chains_from_geojson(data: Any, file: str, image: str, collector: Collector) -> list[TracedChain]:
    """Chains of the data of a GeoJSON file; errors go to the collector.

    Parameters
    ----------
    image : str
        Of features without the property ``image``.
    """
    place = Place(file)
    try:
        chains, passed_over = _chains(data, place, image)
    except NotGeojsonError as error:
        help = "files that end in .json are GeoJSON or those of labelme; tables end in .csv or .txt"
        collector.error("SBB332", f"neither GeoJSON nor labelme: {error}", place, help)
        return []
    warn_of_others(passed_over, file, collector)
    return chains


def _chains(data: Any, place: Place, image: str) -> tuple[list[TracedChain], list[str]]:
    chains: list[TracedChain] = []
    passed_over: list[str] = []
    for line in named_lines(data, CHAIN_PROPERTIES, passed_over):
        xy = np.array([row[:2] for row in line.positions], dtype=float).reshape(-1, 2)
        own = property_of(line.feature, IMAGE_PROPERTIES) or image
        chains.append(TracedChain(own, line.name, xy, place))
    return chains, passed_over
