"""Approximate exterior orientations and object points of a whole network.

Images without an approximate orientation are resected from control points; tie points are intersected from
oriented images; images that are still without one are resected from intersected points; and so on, best
supported first.  Where points do not suffice, points that are measured on control curves with a given location
join them, with their tangents.  Given coordinates of check points are never used.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.approximation.intersection import Intersections, intersect_points
from splinebba_cli.core.approximation.located_sights import LocatedSights
from splinebba_cli.core.approximation.point_tangent_resection import resect_with_tangents
from splinebba_cli.core.approximation.resection import Resection, ResectionError, resect
from splinebba_cli.core.camera.distortion import corrected_photo_xy
from splinebba_cli.core.camera.rotation import rotation_object_from_photo
from splinebba_cli.core.network import BoolArray, FloatArray, Network

SAFE_POINTS = 4  # with three points up to four orientations fit


@dataclass(frozen=True)
class ApproximateValues:
    """Approximate values of orientations and points; given ones are kept."""

    rotation: FloatArray  # (m, 3, 3) NaN where unresolved
    position: FloatArray  # (m, 3) metres
    xyz: FloatArray  # (n, 3) metres; check points intersected, never as given; NaN where unresolved
    weak_points: BoolArray  # (n,) intersected at a small angle
    resolved: dict[int, Resection]  # images that got their orientation here
    unresolved: dict[int, str]  # images that have none, and why


def corrected_point_observations(network: Network) -> FloatArray:
    """Measured image points freed of principal point and distortion, (k, 2) mm."""
    seen = network.point_observations
    corrected = np.empty_like(seen.photo_xy)
    camera = network.images.camera[seen.image]
    for index in np.unique(camera):
        rows = camera == index
        corrected[rows] = corrected_photo_xy(network.cameras[int(index)], seen.photo_xy[rows])[0]
    return corrected


def approximate_orientations(network: Network) -> ApproximateValues:
    """Exterior orientations of all images and coordinates of all points that the points of the network give.

    Parameters
    ----------
    network : Network
        Orientations that are given (also as a prior) are kept.  Control comes from points of role control or
        partial with three finite coordinates and finite (or zero) standard deviations.

    Returns
    -------
    ApproximateValues
    """
    return _Search(network).run()


class _Search:
    """The state of the alternation between resection and intersection."""

    def __init__(self, network: Network) -> None:
        self.network = network
        self.corrected = corrected_point_observations(network)
        self.rotation, self.position = given_orientations(network)
        self.known = _control_xyz(network)  # (n, 3) NaN where not known (yet)
        self.is_control = np.isfinite(self.known).all(axis=1)
        self.resolved: dict[int, Resection] = {}
        self.reasons: dict[int, str] = {}

    def run(self) -> ApproximateValues:
        missing = ~np.isfinite(self.position).all(axis=1)
        found = self._intersect() if missing.any() else None
        while missing.any():
            if found is not None:
                usable = ~self.is_control & ~found.weak
                self.known[usable] = found.xyz[usable]
            images = np.flatnonzero(missing)
            if not self._resect_best(images) and not self._resect_with_curves(images):
                break
            missing = ~np.isfinite(self.position).all(axis=1)
            found = self._intersect()
        return self._result(self._intersect())

    def _resect_best(self, images: np.ndarray) -> bool:
        """Resect the images that most known points support; whether any succeeded."""
        seen = self.network.point_observations
        usable = np.isfinite(self.known[seen.point]).all(axis=1)
        support = np.bincount(seen.image[usable], minlength=len(self.position))
        enough = images[support[images] >= SAFE_POINTS]
        for image in images:
            if support[image] < 3:
                self.reasons[int(image)] = (
                    f"sees {support[image]} points with known coordinates; a resection needs 3, better 4"
                )
        levels = [enough[support[enough] >= 0.5 * support[enough].max()], enough] if len(enough) else []
        for level in [*levels, images[support[images] >= 3]]:
            done = [self._resect(int(image)) for image in level]
            if any(done):
                return True
        return False

    def _resect_with_curves(self, images: np.ndarray) -> bool:
        """Resect images with located points on control curves too; whether any succeeded."""
        sights = LocatedSights(self.network)
        done = [self._resect_with_sights(int(image), sights) for image in images]
        return any(done)

    def _resect_with_sights(self, image: int, sights: LocatedSights) -> bool:
        rows = self._known_rows(image)
        points = sights.of_image(image, self.corrected[rows], self._xyz_of(rows))
        if points is None:
            return False
        try:
            found = resect_with_tangents(self._principal_distance(image), points)
        except ResectionError as error:
            self.reasons[image] = str(error)
            return False
        what = f"{len(points.object_xyz)} points, {len(points.with_tangent)} with tangents,"
        return self._accept(image, found, f"{what} admit several orientations")

    def _known_rows(self, image: int) -> np.ndarray:
        """Observations of points of known coordinates in an image."""
        seen = self.network.point_observations
        return np.flatnonzero((seen.image == image) & np.isfinite(self.known[seen.point]).all(axis=1))

    def _xyz_of(self, rows: np.ndarray) -> FloatArray:
        return np.asarray(self.known[self.network.point_observations.point[rows]])

    def _principal_distance(self, image: int) -> float:
        return self.network.cameras[int(self.network.images.camera[image])].principal_distance_mm

    def _accept(self, image: int, found: Resection, ambiguity: str) -> bool:
        """Keep an orientation that is the only one."""
        if found.ambiguous:
            self.reasons[image] = ambiguity
            return False
        self.rotation[image], self.position[image] = found.rotation, found.position
        self.resolved[image] = found
        self.reasons.pop(image, None)
        return True

    def _resect(self, image: int) -> bool:
        rows = self._known_rows(image)
        try:
            found = resect(self._principal_distance(image), self.corrected[rows], self._xyz_of(rows))
        except ResectionError as error:
            self.reasons[image] = str(error)
            return False
        return self._accept(
            image, found, f"{len(rows)} points with known coordinates admit several orientations"
        )

    def _intersect(self) -> Intersections:
        network, seen = self.network, self.network.point_observations
        distance = np.array([camera.principal_distance_mm for camera in network.cameras])
        return intersect_points(
            seen.point,
            len(network.points.ids),
            distance[network.images.camera[seen.image]],
            self.corrected,
            self.rotation[seen.image],
            self.position[seen.image],
        )

    def _result(self, found: Intersections) -> ApproximateValues:
        points = self.network.points
        check = np.array([role == "check" for role in points.role], dtype=bool)
        given = np.isfinite(points.xyz).all(axis=1) & ~check
        return ApproximateValues(
            rotation=self.rotation,
            position=self.position,
            xyz=np.where(given[:, None], points.xyz, found.xyz),
            weak_points=found.weak & ~given,
            resolved=self.resolved,
            unresolved=self.reasons,
        )


def given_orientations(network: Network) -> tuple[FloatArray, FloatArray]:
    """Copies of the given orientations; a complete prior serves where there is no approximate value."""
    images = network.images
    rotation, position = images.rotation.copy(), images.position.copy()
    prior = ~images.has_orientation & np.isfinite(images.prior).all(axis=1)
    for i in np.flatnonzero(prior):
        rotation[i] = rotation_object_from_photo(images.prior[i, :3], images.sequence[i])
        position[i] = images.prior[i, 3:]
    incomplete = ~(images.has_orientation | prior)
    rotation[incomplete], position[incomplete] = np.nan, np.nan
    return rotation, position


def _control_xyz(network: Network) -> FloatArray:
    """Coordinates of points that may orient an image, NaN elsewhere, (n, 3)."""
    points = network.points
    role = np.array([r in ("control", "partial") for r in points.role], dtype=bool)
    usable = role & np.isfinite(points.xyz).all(axis=1) & np.isfinite(points.sigma).all(axis=1)
    return np.where(usable[:, None], points.xyz, np.nan)
