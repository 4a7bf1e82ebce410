"""The experiments of W. H. Lee (2008), chapter 5, as designs: Lee's geometry, Lee's initial values, a known truth.

The measurements were never published.  The truth is the published geometry (orientations of table 5.3, or the estimates
of table 5.12 for the three images of Greenland; segments of the natural splines through the published points), and
every image measures the segments at the published estimates of the locations.  Approximate values are Lee's initial
ones.  The gauge conditions refer to the true segments, so that figures along the curve can be compared.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from splinebba_cli.core.camera.rotation import rotation_object_from_photo
from splinebba_cli.core.curves.natural_cubic import natural_cubic_basis
from splinebba_cli.core.network import (
    Camera,
    Curve,
    CurveObservations,
    FloatArray,
    Images,
    Network,
    PointObservations,
    Points,
    RotationSequence,
    Settings,
)
from splinebba_cli.simulation import dissertation_tables as printed
from splinebba_cli.simulation.block_geometry import LEE_TABLE_5_3
from splinebba_cli.simulation.dissertation_tables import PrintedTable
from splinebba_cli.simulation.linked_observations import with_arc_lengths
from splinebba_cli.simulation.realization import Design, exact_network
from splinebba_cli.simulation.truth import Truth

SegmentRole = Literal["control", "partial", "tie"]
Geometry = Literal["synthetic", "greenland"]
ORIGIN_GREENLAND = np.array([535_000.0, 7_672_000.0, 0.0])
PHOTO_SIGMA_MM = {"synthetic": 0.005, "greenland": 0.012}  # Lee: 5 µm noise; one pixel of 12 µm


@dataclass(frozen=True)
class Segment:
    """One free cubic segment of an experiment: a0..a3 as rows, metres in the user's frame."""

    id: str
    role: SegmentRole
    true: FloatArray  # (4, 3)
    start: FloatArray  # (4, 3)
    locations: FloatArray  # (m, points) true places of measurement
    location_start: FloatArray  # (m, points)


@dataclass(frozen=True)
class Experiment:
    """One experiment with Lee's counts."""

    name: str  # folder
    title: str
    geometry: Geometry
    known_orientations: bool
    segments: tuple[Segment, ...]
    orientation_start: FloatArray | None  # (m, 6) X0, Y0, Z0 (m), omega, phi, kappa (deg)
    arcs: bool
    lee_equations: int
    lee_unknowns: int
    published: PrintedTable

    @property
    def lee_redundancy(self) -> int:
        """Equations - unknowns."""
        return self.lee_equations - self.lee_unknowns


def segments_through(knots: FloatArray) -> list[FloatArray]:
    """a0..a3 (4, 3) of the segments of the natural cubic spline through knots, one unit of u a segment."""
    basis = natural_cubic_basis(np.arange(float(len(knots))))
    origin = knots[0]
    coefficients = basis.coefficients_from_values(knots - origin)
    found = np.einsum("skw,swd->skd", basis.power, coefficients[basis.columns])
    found[:, 0] += origin
    return list(found)


FIRST, SECOND = segments_through(printed.SYNTHETIC_KNOTS)
GREENLAND = segments_through(printed.GREENLAND_KNOTS)[1]


def _segment(
    id: str, role: SegmentRole, true: FloatArray, table: PrintedTable, start: FloatArray | None = None
) -> Segment:
    """A segment measured at the printed estimates of its locations; known rows start at the truth."""
    places = table.locations["control" if role == "control" else "tie"]
    begin = true if start is None else np.where(np.isnan(start), true, start)
    return Segment(id, role, true, begin, places.estimate, places.start)


def _section_5_3() -> tuple[Segment, ...]:
    """Two segments whose start points are known; the deviations of the starts are those of table 5.5 for both."""
    assert printed.TABLE_5_5.coefficients is not None
    deviation = np.nan_to_num(printed.TABLE_5_5.coefficients.start - SECOND)
    table = PrintedTable(locations={"tie": printed.TABLE_5_7.locations["control"]})
    return (
        _segment("first", "partial", FIRST, table, FIRST + deviation),
        _segment("second", "partial", SECOND, table, SECOND + deviation),
    )


def experiments() -> tuple[Experiment, ...]:
    """All experiments in the order of the dissertation."""
    t = printed
    c54, c55, c58, c510 = (
        table.coefficients for table in (t.TABLE_5_4, t.TABLE_5_5, t.TABLE_5_8, t.TABLE_5_10)
    )
    o57, o58, o512 = (table.orientations for table in (t.TABLE_5_7, t.TABLE_5_8, t.TABLE_5_12))
    if not (c54 and c55 and c58 and c510 and o57 and o58 and o512):
        raise ValueError("a printed table is not there")
    return (
        Experiment(
            "table_5_4", "Table 5.4: one tie segment, known orientations, two points an image", "synthetic", True,
            (_segment("tie", "tie", SECOND, t.TABLE_5_4, c54.start),), None, True, 30, 24, t.TABLE_5_4,
        ),
        Experiment(
            "table_5_5", "Table 5.5: the same with a known start point", "synthetic", True,
            (_segment("partial", "partial", SECOND, t.TABLE_5_5, c55.start),), None, True, 30, 21, t.TABLE_5_5,
        ),
        Experiment(
            "table_5_6", "Table 5.6: locations on a control segment, known orientations", "synthetic", True,
            (_segment("control", "control", SECOND, t.TABLE_5_6),), None, False, 36, 18, t.TABLE_5_6,
        ),
        Experiment(
            "table_5_7", "Table 5.7: six orientations from one control segment", "synthetic", False,
            (_segment("control", "control", SECOND, t.TABLE_5_7),), o57.start, True, 66, 60, t.TABLE_5_7,
        ),
        Experiment(
            "section_5_3", "Section 5.3: six orientations and two partially known segments", "synthetic", False,
            _section_5_3(), o57.start, True, 132, 102, PrintedTable(),
        ),
        Experiment(
            "table_5_8", "Table 5.8: six orientations, a control and a tie segment", "synthetic", False,
            (
                _segment("control", "control", FIRST, t.TABLE_5_8),
                _segment("tie", "tie", SECOND, t.TABLE_5_8, c58.start),
            ),
            o58.start, True, 96, 84, t.TABLE_5_8,
        ),
        Experiment(
            "table_5_10", "Table 5.10: one tie segment in three images of Greenland, known orientations", "greenland",
            True, (_segment("tie", "tie", GREENLAND, t.TABLE_5_10, c510.start),), None, True, 24, 21, t.TABLE_5_10,
        ),
        Experiment(
            "table_5_11", "Table 5.11: locations on a control segment in three images of Greenland", "greenland", True,
            (_segment("control", "control", GREENLAND, t.TABLE_5_11),), None, False, 12, 6, t.TABLE_5_11,
        ),
        Experiment(
            "table_5_12", "Table 5.12: orientations of three images of Greenland from one control segment", "greenland",
            False, (_segment("control", "control", GREENLAND, t.TABLE_5_12),), o512.start, True, 33, 30, t.TABLE_5_12,
        ),
    )  # fmt: skip


def experiment(name: str) -> Experiment:
    """One experiment by the name of its folder.

    Raises
    ------
    KeyError
        If there is none of this name.
    """
    return {found.name: found for found in experiments()}[name]


def design_of(made: Experiment, *, gauge: Literal["needed", "all"] = "needed") -> Design:
    """Noise-free measurements with their truth; approximate values are Lee's initial ones."""
    origin = ORIGIN_GREENLAND if made.geometry == "greenland" else np.zeros(3)
    true_eop = _local(_true_orientations(made.geometry), origin)
    start_eop = true_eop if made.orientation_start is None else _local(made.orientation_start, origin)
    observed, locations = _observations(made, len(true_eop))
    shift = np.concatenate([[1.0], np.zeros(3)])[:, None] * origin
    network = Network(
        origin=origin,
        cameras=(_camera(made.geometry),),
        images=_images(made, true_eop, start_eop),
        points=Points((), (), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3))),
        curves=tuple(_curve(segment, shift) for segment in made.segments),
        point_observations=_no_points(),
        curve_observations=observed,
        settings=Settings(max_iterations=100, scale_dispersion=False, staged=False, gauge_conditions=gauge),
    )
    truth = Truth(true_eop, tuple(s.true - shift for s in made.segments), np.zeros((0, 3)), locations)
    network = exact_network(network, truth)
    if made.arcs:
        network = with_arc_lengths(network, truth, PHOTO_SIGMA_MM[made.geometry], None, simpson=True)
    start = np.concatenate([s.location_start.ravel() for s in made.segments])
    return Design(
        replace(network, curve_observations=replace(network.curve_observations, location=start)), truth
    )


def _true_orientations(geometry: Geometry) -> FloatArray:
    if geometry == "synthetic":
        return LEE_TABLE_5_3
    assert printed.TABLE_5_12.orientations is not None
    return printed.TABLE_5_12.orientations.estimate


def _local(orientations: FloatArray, origin: FloatArray) -> FloatArray:
    """omega, phi, kappa (rad), X0, Y0, Z0 (m) in the local frame."""
    return np.column_stack([np.radians(orientations[:, 3:]), orientations[:, :3] - origin])


def _camera(geometry: Geometry) -> Camera:
    c, size, pixel = (150.0, 230.0, None) if geometry == "synthetic" else (87.75, 230.0, 0.012)
    none = np.zeros(2)
    return Camera("camera", c, none, np.zeros(3), none, none, pixel, (size, size))


def _images(made: Experiment, true: FloatArray, start: FloatArray) -> Images:
    count = len(true)
    ids = tuple(str(k + 1) for k in range(count)) if made.geometry == "synthetic" else ("762", "764", "766")
    known = made.known_orientations
    sequence: RotationSequence = "omega-phi-kappa"
    return Images(
        ids=ids,
        camera=np.zeros(count, dtype=np.int64),
        rotation=rotation_object_from_photo(start[:, :3]),
        position=start[:, 3:],
        sequence=(sequence,) * count,
        prior=true.copy() if known else np.full((count, 6), np.nan),
        prior_sigma=np.zeros((count, 6)) if known else np.full((count, 6), np.inf),
    )


def _curve(segment: Segment, shift: FloatArray) -> Curve:
    sigma = np.full((4, 3), 0.0 if segment.role == "control" else np.inf)
    if segment.role == "partial":
        sigma[0] = 0.0
    return Curve(
        id=segment.id,
        role=segment.role,
        family="free_cubic",
        values=segment.start - shift,
        sigma=sigma,
        parameterization="uniform",
        reference=None if segment.role == "control" else segment.true - shift,
    )


def _observations(made: Experiment, images: int) -> tuple[CurveObservations, FloatArray]:
    """Which image measures which segment, ordered by segment and image, and the true locations."""
    image, curve, places = [], [], []
    for number, segment in enumerate(made.segments):
        each = segment.locations.shape[1]
        image.append(np.repeat(np.arange(images), each))
        curve.append(np.full(images * each, number))
        places.append(segment.locations.ravel())
    location = np.concatenate(places)
    count, sigma = len(location), PHOTO_SIGMA_MM[made.geometry]
    return (
        CurveObservations(
            np.concatenate(image), np.concatenate(curve), np.zeros((count, 2)), np.full((count, 2), sigma),
            location, np.full(count, -1),
        ),
        location,
    )  # fmt: skip


def _no_points() -> PointObservations:
    none = np.zeros(0, dtype=np.int64)
    return PointObservations(none, none, np.zeros((0, 2)), np.zeros((0, 2)))
