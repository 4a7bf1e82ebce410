"""The complete rows of the rank table of theory.md, section 6: with arc lengths and with continuity.

Arc lengths and continuity between free segments are no observations of the program yet, so that their equations are
written here: every derivative, of image points and arc lengths alike, by the complex step over the package's
projection.  Free cubic segments by their twelve numbers, locations as ordinary unknowns, nothing eliminated.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from splinebba_cli.core.camera.collinearity import photo_frame_xyz
from splinebba_cli.core.camera.rotation import angles_from_rotation, rotation_object_from_photo
from splinebba_cli.core.network import FloatArray, Network
from splinebba_cli.simulation.feature_geometry import Feature
from splinebba_cli.simulation.six_image_block import LEE_SEGMENT
from tests.core.free_curves import CUBIC
from tests.core.test_rank_table import FIRST_SEGMENT, curve, design, started

STEP = 1e-30
NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)
ZERO = 1e-13  # of the largest singular value, columns of unit length; table 5.7 is regular with 1e-11


@dataclass(frozen=True)
class Layout:
    """Unknowns: orientations of all images, coefficients of all curves, locations; those held are left out."""

    network: Network

    def start(self) -> FloatArray:
        images = self.network.images
        eop = np.column_stack([angles_from_rotation(images.rotation), images.position])
        coefficients = np.concatenate([c.values.ravel() for c in self.network.curves])
        return np.concatenate([eop.ravel(), coefficients, self.network.curve_observations.location])

    def free(self) -> np.ndarray:
        images = self.network.images
        held = np.concatenate([c.sigma.ravel() for c in self.network.curves]) == 0.0
        locations = np.ones(len(self.network.curve_observations), dtype=bool)
        return np.concatenate([images.prior_sigma.ravel() != 0.0, ~held, locations])


def image_speed_and_place(network: Network, unknowns: np.ndarray, rows: np.ndarray, t: np.ndarray):  # type: ignore[no-untyped-def]
    """Photo coordinates and speed |dp/dt| at t of the curves and images of measured points, complex."""
    observed = network.curve_observations
    image_count = len(network.images.ids)
    eop = unknowns[: 6 * image_count].reshape(-1, 6)[observed.image[rows]]
    a = unknowns[6 * image_count : 6 * image_count + 12 * len(network.curves)].reshape(-1, 4, 3)[
        observed.curve[rows]
    ]
    powers = t[:, None] ** np.arange(4)
    slopes = np.arange(4) * t[:, None] ** np.maximum(np.arange(4) - 1, 0)
    rotation = rotation_object_from_photo(eop[:, :3])
    p = photo_frame_xyz(rotation, eop[:, 3:], np.einsum("nk,nkd->nd", powers, a))
    d = np.einsum("nji,nj->ni", rotation, np.einsum("nk,nkd->nd", slopes, a))
    c = network.cameras[0].principal_distance_mm
    xy = -c * p[:, :2] / p[:, 2:]
    speed = -c * (d[:, :2] / p[:, 2:] - p[:, :2] * d[:, 2:] / p[:, 2:] ** 2)
    return xy, np.sqrt(speed[:, 0] ** 2 + speed[:, 1] ** 2)


def consecutive(network: Network) -> np.ndarray:
    """Pairs of measured points that follow each other on one curve in one image, (q, 2)."""
    observed = network.curve_observations
    order = np.lexsort((observed.location, observed.curve, observed.image))
    same = (np.diff(observed.image[order]) == 0) & (np.diff(observed.curve[order]) == 0)
    return np.stack([order[:-1][same], order[1:][same]], axis=1)


def equations(network: Network, unknowns: np.ndarray, arcs: bool) -> np.ndarray:
    observed = network.curve_observations
    every = np.arange(len(observed))
    t = unknowns[-len(observed) :]
    parts = [image_speed_and_place(network, unknowns, every, t)[0].ravel()]
    if arcs:
        first, second = consecutive(network).T
        half, middle = 0.5 * (t[second] - t[first]), 0.5 * (t[second] + t[first])
        speeds = [image_speed_and_place(network, unknowns, first, middle + x * half)[1] for x in NODES]
        parts.append(half * np.tensordot(WEIGHTS, np.array(speeds), axes=1))
    return np.concatenate(parts)


def jacobian(network: Network, arcs: bool) -> FloatArray:
    layout = Layout(network)
    start, columns = layout.start(), np.flatnonzero(layout.free())
    rows = []
    for column in columns:
        moved = start.astype(complex)
        moved[column] += 1j * STEP
        rows.append(equations(network, moved, arcs).imag / STEP)
    return np.array(rows).T


def rank(matrix: FloatArray) -> int:
    singular = np.linalg.svd(matrix / np.linalg.norm(matrix, axis=0), compute_uv=False)
    gap = singular[singular > ZERO * singular[0]].min() / singular[0]
    assert gap > 30.0 * ZERO, "the rank is not clear"
    return int((singular > ZERO * singular[0]).sum())


def counted(
    *features: Feature, each: int, known: bool, arcs: bool = True, images: int = 6
) -> tuple[int, int, int]:
    matrix = jacobian(design(*features, each=each, known=known, images=images), arcs)
    return matrix.shape[0], matrix.shape[1], rank(matrix)


ROWS = {
    "5.4": (([curve("free", LEE_SEGMENT)], 2, True, 6), (30, 24, 22)),
    "5.5": (([started("free", LEE_SEGMENT)], 2, True, 6), (30, 21, 20)),
    "5.7": (([curve("control", LEE_SEGMENT, 0.0)], 4, False, 6), (66, 60, 60)),
    "section 5.3": (
        ([started("first", FIRST_SEGMENT), started("second", LEE_SEGMENT)], 4, False, 6),
        (132, 102, 97),
    ),
    "5.8": (([curve("control", FIRST_SEGMENT, 0.0), curve("tie", LEE_SEGMENT)], 3, False, 6), (96, 84, 82)),
    "5.10": (([curve("tie", LEE_SEGMENT)], 3, True, 3), (24, 21, 19)),
}


@pytest.mark.parametrize("row", list(ROWS))
def test_complete_row(row: str) -> None:
    (features, each, known, images), expected = ROWS[row]
    assert counted(*features, each=each, known=known, images=images) == expected


def test_table_5_6_has_no_arc_lengths() -> None:
    assert counted(curve("control", LEE_SEGMENT, 0.0), each=3, known=True, arcs=False) == (36, 18, 18)


def test_arc_lengths_remove_no_null_of_a_free_segment() -> None:
    """Lee's claim that they do is wrong (theory, section 6)."""
    network = design(curve("free", CUBIC), each=8, known=True)
    without, with_arcs = jacobian(network, arcs=False), jacobian(network, arcs=True)
    assert without.shape[1] - rank(without) == 2
    assert with_arcs.shape[1] - rank(with_arcs) == 2


def continuity(segments: int, order: int, natural: bool) -> FloatArray:
    """Rows of C0..C`order` continuity and of natural ends over the 12 numbers of each segment."""
    ends, starts = np.zeros((3, 4)), np.zeros((3, 4))
    for derivative in range(3):
        for power in range(derivative, 4):
            factor = float(np.prod(np.arange(power, power - derivative, -1)))
            ends[derivative, power] = factor
            starts[derivative, power] = factor if power == derivative else 0.0
    rows = []
    for joint in range(segments - 1):
        for derivative in range(order + 1):
            row = np.zeros((segments, 4))
            row[joint], row[joint + 1] = ends[derivative], -starts[derivative]
            rows.append(row.ravel())
    if natural:
        first, last = np.zeros((segments, 4)), np.zeros((segments, 4))
        first[0], last[-1] = starts[2], ends[2]
        rows += [first.ravel(), last.ravel()]
    scalar = np.array(rows).reshape(-1, 4 * segments)
    return np.kron(scalar, np.eye(3))


def smooth_segments(count: int) -> list[FloatArray]:
    """Consecutive segments of one generic natural cubic spline in the block, by their a0..a3."""
    from scipy.interpolate import CubicSpline

    knots = np.array(
        [[3100, 4200, 10], [3190, 4290, 31], [3300, 4310, 18], [3390, 4220, 35], [3420, 4100, 12.0]]
    )
    spline = CubicSpline(np.arange(count + 1), knots[: count + 1], bc_type="natural")
    return [spline.c[::-1, k] for k in range(count)]


@pytest.mark.parametrize("segments", [2, 3, 4])
@pytest.mark.parametrize(
    ("order", "natural", "nullities"),
    [
        (-1, False, (4, 6, 8)),
        (0, False, (3, 4, 5)),
        (1, False, (2, 2, 2)),
        (2, False, (1, 0, 0)),
        (2, True, (0, 0, 0)),
    ],
    ids=["none", "C0", "C1", "C2", "natural"],
)
def test_continuity_removes_the_gauge_step_by_step(
    segments: int, order: int, natural: bool, nullities: tuple[int, int, int]
) -> None:
    features = [curve(f"segment-{k}", values) for k, values in enumerate(smooth_segments(segments))]
    network = design(*features, each=12, known=True)
    measured = jacobian(network, arcs=False)
    rows = continuity(segments, order, natural)
    conditions = np.hstack([rows, np.zeros((len(rows), measured.shape[1] - rows.shape[1]))])
    scaled = np.vstack([measured / np.abs(measured).max(), conditions])
    assert measured.shape[1] - rank(scaled) == nullities[segments - 2]
