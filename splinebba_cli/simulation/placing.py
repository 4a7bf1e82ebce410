"""Where the images of a project would measure its features: inside their formats, in front of them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from splinebba_cli.core.camera.collinearity import project
from splinebba_cli.core.camera.distortion import corrected_photo_xy, measured_photo_xy
from splinebba_cli.core.network import BoolArray, Camera, FloatArray, Network
from splinebba_cli.errors import SimulationError
from splinebba_cli.project.model_simulation import Simulation
from splinebba_cli.simulation.block_geometry import inside
from splinebba_cli.simulation.measuring import measure_curves, measure_points
from splinebba_cli.simulation.truth import Truth, shape_of

PLACES_SEED = 19  # the places of measurement belong to the design, not to the noise
BEYOND = 1.2  # times the corrected format: farther out the distortion model says nothing


@dataclass(frozen=True)
class NetworkViews:
    """What the images of a network see at the truth."""

    network: Network
    truth: Truth

    @property
    def image_count(self) -> int:
        """Number of images."""
        return len(self.network.images.ids)

    @cached_property
    def _rotation(self) -> FloatArray:
        return self.truth.rotation

    def camera(self, image: int) -> Camera:
        """The camera of an image."""
        return self.network.cameras[int(self.network.images.camera[image])]

    def photo_xy(self, image: int, xyz: FloatArray) -> FloatArray:
        """Exact measured coordinates (n, 2) mm of points in one image, NaN behind it and far outside of it."""
        camera = self.camera(image)
        rotation = np.broadcast_to(self._rotation[image], (len(xyz), 3, 3))
        c = np.full(len(xyz), camera.principal_distance_mm)
        xy = project(c, rotation, self.truth.eop[image, None, 3:], xyz)
        with np.errstate(invalid="ignore"):
            near = (np.abs(xy) <= BEYOND * _largest_corrected(camera)).all(axis=1)
        out = np.full_like(xy, np.nan)
        if near.any():
            out[near] = measured_photo_xy(camera, xy[near])
        return out

    def inside_format(self, image: int, photo_xy: FloatArray) -> BoolArray:
        """Whether measured coordinates lie inside the format of the camera, (n,)."""
        return inside(_format(self.camera(image)), photo_xy)


def place_curve_points(
    network: Network, truth: Truth, settings: Simulation, sigma_mm: float | None
) -> tuple[Network, Truth]:
    """The network with points measured on its curves, evenly over what each image sees; the truth with their places."""
    _require(network, sigma_mm)
    shapes = [shape_of(curve, values) for curve, values in zip(network.curves, truth.curves, strict=True)]
    places = np.random.default_rng(PLACES_SEED)
    seen, locations = measure_curves(
        NetworkViews(network, truth), shapes, settings.points_per_spline, places, settings.least_visible_share
    )
    seen = replace(seen, sigma=np.full_like(seen.photo_xy, sigma_mm))
    return replace(network, curve_observations=seen), replace(truth, locations=locations)


def place_points(network: Network, truth: Truth, sigma_mm: float | None) -> Network:
    """The network with its points measured in every image that sees them."""
    _require(network, sigma_mm)
    seen = measure_points(NetworkViews(network, truth), truth.points)
    return replace(network, point_observations=replace(seen, sigma=np.full_like(seen.photo_xy, sigma_mm)))


def _require(network: Network, sigma_mm: float | None) -> None:
    if not sigma_mm:
        help = "`simulation: {image_sigma_um: …}`, or --noise-um"
        raise SimulationError("SBB702", "no σ for the observations that are to be placed", help)
    for camera in network.cameras:
        _format(camera)


def _format(camera: Camera) -> tuple[float, float]:
    if camera.format_mm is None:
        help = "give its format_mm, or image_size_px and pixel_size_mm"
        raise SimulationError("SBB702", f"camera `{camera.id}` has no format", help)
    return camera.format_mm


def _largest_corrected(camera: Camera) -> FloatArray:
    """Largest |x| and |y| of the corrected corners of the format, (2,) mm."""
    half = 0.5 * np.asarray(_format(camera))
    corners = half * np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])
    return np.asarray(np.abs(corrected_photo_xy(camera, corners)[0]).max(axis=0))
