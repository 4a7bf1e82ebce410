"""A strand: the places of one edge in order, from one fragment or from several that show the same edge."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.matching.fragments.fragment import Fragment
from splinebba_cli.core.matching.shapes.place_fit import PlaceFit, Places, fit_places
from splinebba_cli.core.matching.shapes.polyline_feet import cumulated_length
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

SMOOTH_TOLERANCE = 1.5  # sigma by which the smooth line of a strand may differ from its places


@dataclass(frozen=True)
class Strand:
    """Places with ascending locations, metres along the strand, and the points linked to them.

    Attributes
    ----------
    xyz : (k, 3) metres, as the fragments give them
    line : (k, 3) metres, the smooth line at the same locations
    dispersion : (k, 3, 3) m^2
    image_count : (k,)
    weak : (k,) the images leave the depth open
    location : (k,) metres
    link_row, link_location : (q,) unlabelled points, each once, and where they are
    period : length of one turn of a closed strand, else 0
    spacing : metres between neighbouring places of one fragment
    """

    xyz: FloatArray
    line: FloatArray
    dispersion: FloatArray
    image_count: IntArray
    weak: BoolArray
    location: FloatArray
    link_row: IntArray
    link_location: FloatArray
    period: float = 0.0
    spacing: float = 0.0

    @property
    def closed(self) -> bool:
        """Whether the end is followed by the begin."""
        return self.period > 0.0

    @property
    def length(self) -> float:
        """Metres from the first place to the last, or around."""
        return self.period or float(self.location[-1] - self.location[0])

    @property
    def places(self) -> Places:
        """What a spline is fitted to."""
        return Places(
            self.location,
            self.xyz,
            self.dispersion,
            self.closed,
            self.period,
            self.spacing,
        )

    def reversed(self) -> Strand:
        """The same in the other sense."""
        back = slice(None, None, -1)
        return replace(
            self,
            xyz=self.xyz[back], line=self.line[back], dispersion=self.dispersion[back],
            image_count=self.image_count[back], weak=self.weak[back], location=-self.location[back],
            link_location=-self.link_location,
        )  # fmt: skip


def strand_of(fragment: Fragment) -> Strand | None:
    """The strand of one fragment; None where it has no length."""
    along = cumulated_length(fragment.xyz, closed=fragment.closed)
    period = float(along[-1]) if fragment.closed else 0.0
    location = along[: len(fragment)]
    if len(fragment) < 2 or location[-1] <= 0.0:
        return None
    spacing = float(np.median(np.diff(location)))
    places = Places(location, fragment.xyz, fragment.dispersion, fragment.closed, period, spacing)
    fit = fit_places(places, SMOOTH_TOLERANCE)
    return on_fit(
        fit,
        Strand(
            fragment.xyz, fragment.xyz, fragment.dispersion, fragment.image_count, fragment.weak, location,
            fragment.link_row, np.interp(fragment.link_place, np.arange(len(along)), along), period, spacing,
        ),
    )  # fmt: skip


def on_fit(fit: PlaceFit, strand: Strand) -> Strand:
    """A strand in the order of its foot points on a fit, with the smooth line of the fit and its arc length."""
    order = np.argsort(fit.location, kind="stable")
    line = fit.evaluate(fit.location[order])
    along = cumulated_length(line, closed=strand.closed)
    location = along[: len(order)]
    period = float(along[-1]) if strand.closed else 0.0
    earlier = np.argsort(strand.location, kind="stable")
    known, new = strand.location[earlier], np.empty(len(order))
    new[order] = location
    carried = carrier(known, np.maximum.accumulate(new[earlier]))
    return replace(
        strand,
        xyz=strand.xyz[order],
        line=line,
        dispersion=strand.dispersion[order],
        image_count=strand.image_count[order],
        weak=strand.weak[order],
        location=location,
        link_location=carried(strand.link_location),
        period=period,
    )


def carrier(before: FloatArray, after: FloatArray) -> Callable[[FloatArray], FloatArray]:
    """Locations carried from one table of ascending places to another, straight on beyond its ends."""
    distinct = np.concatenate([[True], np.diff(before) > 0.0])
    known, new = before[distinct], after[distinct]

    def carried(location: FloatArray) -> FloatArray:
        beyond = np.minimum(location - known[0], 0.0) + np.maximum(location - known[-1], 0.0)
        return np.asarray(np.interp(location, known, new) + beyond)

    return carried
