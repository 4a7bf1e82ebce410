"""Rank of the whole network and of its features against an independent design matrix, arc lengths included.

Every derivative, of image points and Simpson arc lengths alike, is taken by the complex step over the package's
projection.  Free cubic segments by their twelve numbers, orientations by their angles, locations as ordinary unknowns,
nothing eliminated.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from splinebba_cli.core.budget import budget
from splinebba_cli.core.camera.collinearity import photo_frame_xyz
from splinebba_cli.core.camera.rotation import angles_from_rotation, rotation_object_from_photo
from splinebba_cli.core.network import ArcLengths, FloatArray, IntArray, Network
from splinebba_cli.simulation.dissertation import experiments
from tests.core.free_curves import CUBIC
from tests.core.test_rank_table import curve, design
from tests.core.test_rank_table_of_the_dissertation import starting_at

STEP = 1e-30
ZERO = 1e-13  # of the largest singular value, columns of unit length


@dataclass(frozen=True)
class Unknowns:
    """Orientations of all images, coefficients of all curves, locations; those held are left out."""

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


def equations(network: Network, unknowns: np.ndarray) -> np.ndarray:
    """Image points, then arc lengths."""
    observed, arcs = network.curve_observations, network.arc_lengths
    t = unknowns[-len(observed) :]
    points = image_speed_and_place(network, unknowns, np.arange(len(observed)), t)[0].ravel()
    begin, end = t[arcs.first], t[arcs.second]
    s1, s12, s2 = (
        image_speed_and_place(network, unknowns, arcs.first, u)[1] for u in (begin, 0.5 * (begin + end), end)
    )
    return np.concatenate([points, (end - begin) / 6.0 * (s1 + 4.0 * s12 + s2)])


def jacobian(network: Network) -> FloatArray:
    """Over all unknowns; columns of held ones are zero."""
    unknowns = Unknowns(network)
    start, free = unknowns.start(), unknowns.free()
    columns = np.zeros((len(start), 2 * len(network.curve_observations) + len(network.arc_lengths)))
    for number in np.flatnonzero(free):
        moved = start.astype(complex)
        moved[number] += 1j * STEP
        columns[number] = equations(network, moved).imag / STEP
    return columns.T


def rank(matrix: FloatArray) -> int:
    length = np.linalg.norm(matrix, axis=0)
    if not length.any():
        return 0
    singular = np.linalg.svd(matrix[:, length > 0.0] / length[length > 0.0], compute_uv=False)
    gap = singular[singular > ZERO * singular[0]].min() / singular[0]
    assert gap > 30.0 * ZERO, "the rank is not clear"
    return int((singular > ZERO * singular[0]).sum())


@pytest.mark.parametrize("start", ["rough", "true"])
@pytest.mark.parametrize("name", [made.name for made in experiments()])
def test_rank_of_the_network(name: str, start: str) -> None:
    network = starting_at(name, start)
    found, matrix = budget(network), jacobian(network)
    assert (found.equations, found.unknowns) == (len(matrix), int(Unknowns(network).free().sum()))
    assert found.rank == rank(matrix)


@pytest.mark.parametrize("name", [made.name for made in experiments()])
def test_rank_of_every_feature_and_image(name: str) -> None:
    """Own equations over own unknowns and locations; over the orientations too; over those of one image."""
    network = starting_at(name, "rough")
    found, matrix = budget(network), jacobian(network)
    observed, images, curves = network.curve_observations, len(network.images.ids), len(network.curves)
    owner = [np.repeat(x, 2) for x in (observed.curve, observed.image)]
    of_curve, of_image = (
        np.concatenate([points, x[network.arc_lengths.first]])
        for points, x in zip(owner, (observed.curve, observed.image), strict=True)
    )
    orientation = slice(0, 6 * images)
    features = slice(6 * images, 6 * images + 12 * curves)
    for k, feature in enumerate(found.features):
        own = matrix[of_curve == k]
        with_orientations = rank(own)
        own[:, orientation] = 0.0
        assert feature.equations == len(own)
        assert feature.rank == rank(own)
        assert feature.orientation_conditions == with_orientations - rank(own)
    for k, image in enumerate(found.images):
        own = matrix[of_image == k]
        own[:, features] = 0.0
        assert (image.equations, image.rank) == (len(own), rank(own))


def test_arc_lengths_remove_no_null_of_a_free_segment() -> None:
    """Lee's claim that they do is wrong (theory, section 6)."""
    network = design(curve("free", CUBIC), each=8, known=True)
    first, second = consecutive(network).T
    count = len(first)
    arcs = ArcLengths(first, second, np.ones(count), np.full(count, 0.005), np.ones(count, dtype=bool))
    measured = replace(network, arc_lengths=arcs)
    assert budget(network).nullity == 2
    found = budget(measured)
    assert found.equations == budget(network).equations + 42
    assert found.nullity == 2 == found.unknowns - rank(jacobian(measured))


def consecutive(network: Network) -> IntArray:
    """Pairs of measured points that follow each other on one curve in one image, (q, 2)."""
    observed = network.curve_observations
    order = np.lexsort((observed.location, observed.curve, observed.image))
    same = (np.diff(observed.image[order]) == 0) & (np.diff(observed.curve[order]) == 0)
    return np.stack([order[:-1][same], order[1:][same]], axis=1)
