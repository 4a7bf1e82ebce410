"""A network of random configurations: tilted images, distorted cameras, curves of every family, free points."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from splinebba_cli.core.camera.rotation import rotation_object_from_photo
from splinebba_cli.core.curves.registry import FAMILIES, basis_of
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
)
from splinebba_cli.core.state import Prepared, State, initial_coefficients, prepare

IMAGES = 24
POINTS = 25
PER_CURVE = 24


@dataclass(frozen=True)
class Case:
    """Network and state at which Jacobians are compared; residuals are anything."""

    prepared: Prepared
    state: State
    generator: np.random.Generator


# curves with options of their families; like these, every option should be compared
VARIANTS: dict[str, dict[str, Any]] = {
    "closed": {"family": "natural_cubic", "closed": True},
    "corner": {"family": "natural_cubic", "breaks": (2, 4)},
    "unjoined": {"family": "polynomial_3", "knot_parameters": np.array([0.0, 1.0, 2.5, 3.0])},
    "joined_c0": {"family": "free_cubic", "continuity": 0, "knot_parameters": np.array([0.0, 1.0, 2.5, 3.0])},
    "joined_c1": {"family": "polynomial_3", "continuity": 1},
    "joined_c2": {"family": "free_cubic", "continuity": 2, "knot_parameters": np.array([0.0, 1.0, 2.5, 3.0])},
    "natural_ends": {"family": "free_cubic", "continuity": 2, "natural_ends": True},
    "parabolas_c1": {"family": "polynomial_2", "continuity": 1},
    "lines_c0": {"family": "polynomial_1", "continuity": 0},
    "tense": {"family": "cardinal", "tension": 0.4},
    "tense_closed": {"family": "cardinal", "tension": -0.3, "closed": True},
    "bspline_1_closed": {"family": "bspline_1", "closed": True},
    "bspline_2_closed": {"family": "bspline_2", "closed": True, "parameterization": "uniform"},
    "bspline_3_closed": {"family": "bspline_3", "closed": True},
    "arc": {"family": "conic", "knot_parameters": np.array([-1.0, 2.5])},
    "circular_arc": {"family": "circle", "knot_parameters": np.array([0.5, 1.5])},
}
NAMES = (*FAMILIES, *VARIANTS)
SEGMENTS = 3  # of polynomials with options


def curve_of(name: str, generator: np.random.Generator) -> Curve:
    """A curve about 60 m long near the origin: a family, or a family with options (:data:`VARIANTS`)."""
    options = VARIANTS.get(name, {"family": name})
    family = FAMILIES[options["family"]]
    if family.rows == "harmonics":
        values = harmonics(options["family"], generator)
    elif family.rows == "powers":
        segments = SEGMENTS if name in VARIANTS else 1
        values = np.vstack([segment_rows(family.degree, k, generator) for k in range(segments)])
        values = (
            values
            if segments == 1
            else 0.4 * values - np.where(family.positions(len(values)), 40.0, 0.0)[:, None]
        )
    elif family.most == 2:
        values = np.array([[-20.0, 5.0, 0.0], [30.0, -10.0, 6.0]]) + generator.normal(0.0, 4.0, (2, 3))
    else:
        angle = np.linspace(0.0, 5.5, 7)
        values = 40.0 * np.column_stack([np.cos(angle), np.sin(angle), 0.2 * np.sin(3 * angle)])
        values = values + generator.normal(0.0, 4.0, values.shape)
    curve = Curve(name, "tie", values=values, sigma=np.full_like(values, np.inf), **options)
    basis = basis_of(curve)
    if basis.coefficient_count < len(values):  # values that fulfil the continuity
        values = basis.values_from_coefficients(basis.coefficients_from_values(values))
    return replace(curve, values=values)


def segment_rows(degree: int, segment: int, generator: np.random.Generator) -> FloatArray:
    """a_0 .. a_d of one segment of a chain."""
    rows = 40.0 * 0.6 ** np.arange(degree + 1)[:, None] * np.ones(3) + 10.0 * segment
    return np.asarray(rows + generator.normal(0.0, 4.0, rows.shape))


def harmonics(family: str, generator: np.random.Generator) -> FloatArray:
    """Centre and harmonics; of a circle the radius vectors are equally long and normal to each other."""
    first = generator.normal(0.0, 1.0, (3, 2))
    plane = np.linalg.qr(first)[0].T
    if family == "circle":
        return np.vstack([generator.normal(0.0, 4.0, 3), 25.0 * plane])
    rows = [generator.normal(0.0, 4.0, 3), 30.0 * plane[0], 20.0 * plane[1] + 5.0 * plane[0]]
    more = 4 if family == "fourier" else 0
    return np.vstack([*rows, *generator.normal(0.0, 3.0, (more, 3))])


def camera_of(number: int, generator: np.random.Generator) -> Camera:
    """Distortion of several millimetres at the edge of the format."""
    return Camera(
        id=str(number),
        principal_distance_mm=float(generator.uniform(20.0, 160.0)),
        principal_point_mm=generator.normal(0.0, 0.5, 2),
        radial=generator.normal(0.0, 1.0, 3) * [3e-5, 1e-8, 1e-12],
        decentring=generator.normal(0.0, 2e-5, 2),
        affinity=generator.normal(0.0, 2e-3, 2),
    )


def images_of(generator: np.random.Generator) -> Images:
    """Stations some 300 m above, tilted by up to half a radian, any azimuth; priors in both sequences."""
    angles = np.column_stack(
        [generator.uniform(-0.5, 0.5, (IMAGES, 2)), generator.uniform(-3.0, 3.0, IMAGES)]
    )
    rotation = rotation_object_from_photo(angles)
    position = rotation[:, :, 2] * generator.uniform(250.0, 400.0, (IMAGES, 1))
    names: tuple[RotationSequence, RotationSequence] = ("omega-phi-kappa", "phi-omega-kappa")
    sigma = generator.uniform(0.5, 2.0, (IMAGES, 6)) * [1e-4, 1e-4, 1e-4, 0.1, 0.1, 0.1]
    sigma[3, 1], sigma[4, 3:], sigma[5] = np.inf, np.inf, np.inf
    return Images(
        ids=tuple(str(i) for i in range(IMAGES)),
        camera=np.arange(IMAGES) % 3,
        rotation=rotation,
        position=position,
        sequence=tuple(names[i % 2] for i in range(IMAGES)),
        prior=np.column_stack([generator.normal(0.0, 0.4, (IMAGES, 3)), position + 0.1]),
        prior_sigma=sigma,
    )


def seen_everywhere(things: int, each: int) -> tuple[FloatArray, FloatArray]:
    """Columns image and thing, every thing in `each` images."""
    thing = np.repeat(np.arange(things), each)
    return (np.arange(len(thing)) * 7) % IMAGES, thing


def random_case(seed: int = 5) -> Case:
    """One large network: at least 20 random configurations of every kind of observation and every family."""
    generator = np.random.default_rng(seed)
    curves = tuple(curve_of(name, generator) for name in NAMES)
    image, curve = seen_everywhere(len(curves), PER_CURVE)
    bases = [basis_of(one) for one in curves]
    ends = np.array([[basis.break_points[0], basis.break_points[-1]] for basis in bases])[curve]
    location = ends[:, 0] + generator.uniform(-0.05, 1.05, len(curve)) * (ends[:, 1] - ends[:, 0])
    closed = np.array([basis.closed for basis in bases])[curve]
    location = np.where(closed, np.clip(location, ends[:, 0], ends[:, 1] - 1e-6), location)
    point_image, point = seen_everywhere(POINTS, 4)
    xyz = generator.uniform(-40.0, 40.0, (POINTS, 3))
    free = np.full((POINTS, 3), np.inf)
    network = Network(
        origin=np.zeros(3),
        cameras=tuple(camera_of(k, generator) for k in range(3)),
        images=images_of(generator),
        points=Points(tuple(str(i) for i in range(POINTS)), ("tie",) * POINTS, xyz, free, free),
        curves=curves,
        point_observations=PointObservations(point_image, point, *measured(len(point), generator)),
        curve_observations=CurveObservations(
            image, curve, *measured(len(curve), generator), location, np.full(len(curve), -1)
        ),
    )
    prepared = prepare(network)
    state = State(
        network.images.rotation, network.images.position, initial_coefficients(prepared), xyz, location
    )
    return Case(prepared, state, generator)


def measured(count: int, generator: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Photo coordinates and their sigma, different in x and y, mm."""
    return generator.uniform(-15.0, 15.0, (count, 2)), generator.uniform(0.003, 0.02, (count, 2))
