"""A coastline as one natural cubic spline of many knots, and the strip of images that follows it.

    heading_i = heading_(i-1) + bends_i - pull heading_(i-1),    knot_(i+1) = knot_i + spacing (cos, sin) heading_i

an autoregressive heading: a coast that winds but keeps its direction.  Images stand above the curve at equal
numbers of knots, their x axis along the strip; each sees the knots of its footprint.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.camera.collinearity import project
from splinebba_cli.core.camera.rotation import (
    angles_from_rotation,
    rotation_from_vector,
    rotation_object_from_photo,
)
from splinebba_cli.core.curves.registry import basis_of
from splinebba_cli.core.network import (
    Camera,
    Curve,
    CurveObservations,
    FloatArray,
    Images,
    IntArray,
    Network,
    PointObservations,
    Points,
    Role,
)

PRINCIPAL_DISTANCE_MM = 153.0
FORMAT_MM = 230.0
HEIGHT_M = 1530.0
SPACING_M = 85.0  # of the knots, along the coast
BEND, PULL = 0.22, 0.08  # rad a knot, share a knot
NOISE_MM = 0.005
POSITION_SIGMA_M, ANGLE_SIGMA = 0.05, 1e-4  # GNSS/INS
KNOT_SIGMA_M = {"partial": 1.0, "tie": 0.5}  # of the given knots; those of a tie spline are only a start


@dataclass(frozen=True)
class Coastline:
    """What is generated."""

    knots: int
    knots_per_image: float = 25.0
    overlap: float = 0.75  # of consecutive images, in knots
    points_per_image: int = 150
    role: Role = "partial"
    seed: int = 1

    @property
    def images(self) -> int:
        """Number of images of the strip."""
        step = self.knots_per_image * (1.0 - self.overlap)
        return max(3, round(self.knots / step))


def coastline_network(coast: Coastline) -> Network:
    """The network of a coastline: knots disturbed, orientations at their priors, no approximate locations."""
    return measured_coastline(coast)[0]


def measured_coastline(coast: Coastline) -> tuple[Network, FloatArray]:
    """The network, and the true location of every measured point, (n,)."""
    rng = np.random.default_rng(coast.seed)
    knots = _coast(coast.knots, rng)
    curve = _curve(coast, knots, rng)
    truth = Curve(
        "truth", "control", "natural_cubic", knots, np.zeros_like(knots), parameterization="uniform"
    )
    centre = np.linspace(0.0, coast.knots - 1.0, coast.images)
    basis = basis_of(truth)
    coefficients = basis.coefficients_from_values(knots)
    rotation, position = _orientations(basis.evaluate(centre, coefficients), rng)
    image, location = _measured(coast, centre, rng)
    xyz = basis.evaluate(location, coefficients)
    c = np.full(len(image), PRINCIPAL_DISTANCE_MM)
    xy = project(c, rotation[image], position[image], xyz)
    inside = np.flatnonzero((np.abs(xy) < FORMAT_MM / 2.0).all(axis=1))
    image, xy = image[inside], xy[inside]
    network = Network(
        origin=np.zeros(3),
        cameras=(_camera(),),
        images=_images(rotation, position, rng),
        points=_no_points(),
        curves=(curve,),
        point_observations=_no_point_observations(),
        curve_observations=CurveObservations(
            image=image,
            curve=np.zeros_like(image),
            photo_xy=xy + rng.normal(0.0, NOISE_MM, xy.shape),
            sigma=np.full(xy.shape, NOISE_MM),
            location=np.full(len(image), np.nan),
            segment=np.full(len(image), -1, dtype=np.int64),
        ),
    )
    return network, location[inside]


def _coast(count: int, rng: np.random.Generator) -> FloatArray:
    """Knots (k, 3) of a winding coast a few metres high."""
    heading = np.zeros(count - 1)
    for i in range(1, count - 1):
        heading[i] = (1.0 - PULL) * heading[i - 1] + rng.normal(0.0, BEND)
    xyz = np.zeros((count, 3))
    xyz[1:, 0] = np.cumsum(SPACING_M * np.cos(heading))
    xyz[1:, 1] = np.cumsum(SPACING_M * np.sin(heading))
    xyz[:, 2] = rng.normal(0.0, 1.0, count)
    return xyz


def _curve(coast: Coastline, knots: FloatArray, rng: np.random.Generator) -> Curve:
    """The coast with disturbed knots: weighted about them, or free."""
    scale = KNOT_SIGMA_M[coast.role]
    disturbed = knots + rng.normal(0.0, scale, knots.shape)
    sigma = np.full(knots.shape, scale if coast.role == "partial" else np.inf)
    return Curve("coast", coast.role, "natural_cubic", disturbed, sigma, parameterization="uniform")


def _orientations(on_coast: FloatArray, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Nearly vertical images above points of the coast, x along the strip."""
    count = len(on_coast)
    rotation = rotation_object_from_photo(rng.normal(0.0, 0.02, (count, 3)))
    position = on_coast + rng.normal(0.0, 20.0, (count, 3)) + [0.0, 0.0, HEIGHT_M]
    return rotation, position


def _measured(coast: Coastline, centre: FloatArray, rng: np.random.Generator) -> tuple[IntArray, FloatArray]:
    """Image and location of the points, at random over the knots that an image sees; none beyond the ends."""
    half = 0.5 * coast.knots_per_image
    image = np.repeat(np.arange(len(centre), dtype=np.int64), coast.points_per_image)
    location = np.repeat(centre, coast.points_per_image) + rng.uniform(-half, half, len(image))
    kept = np.flatnonzero((location > 0.0) & (location < coast.knots - 1.0))
    return image[kept], location[kept]


def _images(rotation: FloatArray, position: FloatArray, rng: np.random.Generator) -> Images:
    """GNSS/INS priors, and starts that are those priors."""
    count = len(position)
    prior_position = position + rng.normal(0.0, POSITION_SIGMA_M, position.shape)
    prior_rotation = rotation @ rotation_from_vector(rng.normal(0.0, ANGLE_SIGMA, (count, 3)))
    prior = np.column_stack([angles_from_rotation(prior_rotation), prior_position])
    sigma = np.array([ANGLE_SIGMA] * 3 + [POSITION_SIGMA_M] * 3)
    return Images(
        ids=tuple(str(i) for i in range(count)),
        camera=np.zeros(count, dtype=np.int64),
        rotation=prior_rotation,
        position=prior_position,
        sequence=("omega-phi-kappa",) * count,
        prior=prior,
        prior_sigma=np.tile(sigma, (count, 1)),
    )


def _camera() -> Camera:
    none = np.zeros(2)
    return Camera(
        "camera", PRINCIPAL_DISTANCE_MM, none, np.zeros(3), none, none, format_mm=(FORMAT_MM, FORMAT_MM)
    )


def _no_points() -> Points:
    three = np.zeros((0, 3))
    return Points((), (), three, three, three)


def _no_point_observations() -> PointObservations:
    none = np.zeros(0, dtype=np.int64)
    return PointObservations(none, none, np.zeros((0, 2)), np.zeros((0, 2)))
