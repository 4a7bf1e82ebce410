"""Files of tracing tools as one table of chains (image, chain, x, y), which a project reads."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.errors import ChainsFileError
from splinebba_cli.exchange.chain_names import named_chains, renumbered
from splinebba_cli.exchange.chain_thinning import thinned, without_repeats
from splinebba_cli.exchange.traced_chains import TracedChain, TracingOptions, read_traced_chains
from splinebba_cli.project.diagnostics import Collector, Diagnostic, Place
from splinebba_cli.project.network_tables import csv_text, number

LARGEST_PIXEL = 200_000.0  # no image has so many columns; map coordinates have
NEGATIVE = 0.5  # share of negative coordinates from which another origin is likely
COLUMNS = ("image", "chain", "x", "y")


@dataclass(frozen=True)
class ConversionOptions:
    """How chains become a table.

    Attributes
    ----------
    tracing : TracingOptions
    spacing_px : float, optional
        Points of a chain are so far apart at least; None: all stay.
    min_points : int
        Chains with fewer points are left out; counted before they are thinned.
    y_up_from : float, optional
        Where y points up: the value of y, in the file, at the upper edge of the image; it becomes 0, and y points down.
    renumber : bool
        Whether names of chains in the files are passed over.
    """

    tracing: TracingOptions = field(default_factory=TracingOptions)
    spacing_px: float | None = None
    min_points: int = 2
    y_up_from: float | None = None
    renumber: bool = False


@dataclass(frozen=True)
class ImageCount:
    """Chains and points of one image: those of the files, and those of the table."""

    image: str
    chains_read: int
    points_read: int
    chains: int
    points: int


@dataclass(frozen=True)
class ConvertedChains:
    """The chains of the table, what became of those of the files, and warnings."""

    chains: tuple[TracedChain, ...]
    counts: tuple[ImageCount, ...]
    warnings: tuple[Diagnostic, ...]

    def csv_text(self) -> str:
        """The table, chain by chain, the chains of an image together."""
        return csv_text(COLUMNS, self._rows())

    def _rows(self) -> Iterator[tuple[str, str, str, str]]:
        of_image: dict[str, list[TracedChain]] = {count.image: [] for count in self.counts}
        for chain in self.chains:
            of_image[chain.image].append(chain)
        for image, chains in of_image.items():
            for chain in chains:
                for x, y in chain.xy.tolist():
                    yield image, chain.id, number(x), number(y)


def converted_chains(files: Sequence[Path], options: ConversionOptions) -> ConvertedChains:
    """Read files of tracing tools.

    Raises
    ------
    ChainsFileError
        With every error of all files.
    """
    collector = Collector()
    read = [chain for file in files for chain in read_traced_chains(file, options.tracing, collector)]
    _check_coordinates(read, collector)
    if not read and not collector.has_errors:
        for file in files:
            collector.error("SBB332", "there are no chains in the file", Place(str(file)))
    if collector.has_errors:
        raise ChainsFileError(collector.finished())
    turned = [replace(chain, xy=_pointing_down(chain.xy, options.y_up_from)) for chain in read]
    _check_signs(turned, collector)
    named = named_chains(renumbered(turned) if options.renumber else turned, collector)
    kept = [chain for each in named if (chain := _selected(each, options)) is not None]
    if not kept and not collector.has_errors:
        longest = max(len(chain.xy) for chain in read)
        message = f"none of the {len(read)} chains has {options.min_points} points; the longest has {longest}"
        collector.error("SBB332", message, Place(str(files[0])), "a smaller `--min-points`")
    if collector.has_errors:
        raise ChainsFileError(collector.finished())
    return ConvertedChains(tuple(kept), _counts(read, kept), collector.finished())


def _pointing_down(xy: FloatArray, top: float | None) -> FloatArray:
    return xy if top is None else np.array([0.0, top]) + xy * np.array([1.0, -1.0])


def _selected(chain: TracedChain, options: ConversionOptions) -> TracedChain | None:
    """A chain as it stands in the table; None of one that is left out."""
    xy = without_repeats(chain.xy)
    if len(xy) < options.min_points:
        return None
    return replace(chain, xy=xy if options.spacing_px is None else thinned(xy, options.spacing_px))


def _counts(read: Sequence[TracedChain], kept: Sequence[TracedChain]) -> tuple[ImageCount, ...]:
    images = list(dict.fromkeys(chain.image for chain in read))
    numbers = {image: [0, 0, 0, 0] for image in images}
    for first, chains in ((0, read), (2, kept)):
        for chain in chains:
            numbers[chain.image][first] += 1
            numbers[chain.image][first + 1] += len(chain.xy)
    return tuple(ImageCount(image, *numbers[image]) for image in images)


def _check_coordinates(chains: Sequence[TracedChain], collector: Collector) -> None:
    """SBB403 where coordinates are no numbers, SBB335 where they are those of a map."""
    for chain in chains:
        name = f"chain `{chain.id}`" if chain.id else "a chain"
        if not np.isfinite(chain.xy).all():
            message = f"{name} has coordinates that are not finite"
            collector.error("SBB403", message, chain.place, kind="coordinates")
        elif len(chain.xy) and (largest := float(np.abs(chain.xy).max())) > LARGEST_PIXEL:
            message = f"{name} has coordinates of {largest:.0f}: no image has so many pixels"
            help = "export the lines in pixels of the image, without a map projection"
            collector.error("SBB335", message, chain.place, help, kind="coordinates of a map")


def _check_signs(chains: Sequence[TracedChain], collector: Collector) -> None:
    """SBB335, once for a file, where most coordinates are negative: pixels count from a corner."""
    by_file: dict[str, list[FloatArray]] = {}
    for chain in chains:
        by_file.setdefault(chain.place.file, []).append(chain.xy)
    for file, parts in by_file.items():
        negative = (np.concatenate(parts) < 0.0).mean(axis=0) if any(map(len, parts)) else np.zeros(2)
        if negative[1] > NEGATIVE and negative[0] <= NEGATIVE:
            help = "`--y-up 0` turns them, if y is 0 at the upper edge of the image and points up"
            collector.warning("SBB335", f"{100 * negative[1]:.0f} % of the y are negative", Place(file), help)
        elif negative.max() > NEGATIVE:
            help = "pixels count from the upper left corner: is this the frame of the project's `image_coordinates`?"
            collector.warning(
                "SBB335", f"{100 * negative.max():.0f} % of the coordinates are negative", Place(file), help
            )
