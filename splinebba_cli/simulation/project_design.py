"""The design of a project: what it measures, at which places, and the truth that is simulated.

Truth is ``truth.json`` beside the project where there is one, else the approximate values of the project.  Where the
project has observations, they say which image measures which feature and where: the location of a measured curve
point is its foot point on the true curve.  Kinds without observations are placed inside the formats of the images.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from splinebba_cli.core.approximation.starting_values import starting_state
from splinebba_cli.core.camera.rotation import angles_from_rotation
from splinebba_cli.core.network import BoolArray, Curve, FloatArray, IntArray, Network
from splinebba_cli.core.observations.location_search import search_locations, squared_distance
from splinebba_cli.core.state import prepare
from splinebba_cli.errors import SimulationError
from splinebba_cli.project.loading import LoadedProject
from splinebba_cli.project.model_simulation import Simulation
from splinebba_cli.simulation.dropping import leave_out_unseen
from splinebba_cli.simulation.noise import Noise
from splinebba_cli.simulation.observation_kinds import KINDS
from splinebba_cli.simulation.placing import place_curve_points, place_points
from splinebba_cli.simulation.realization import Design, exact_network
from splinebba_cli.simulation.truth import Truth, shape_of, true_state, with_fixed_parameters
from splinebba_cli.simulation.truth_file import TRUTH_FILE, read_truth

CHECK_SAMPLES = 60
NEAR = (
    10.0  # σ along the curve from the foot point within which a given true location is that of a measurement
)


@dataclass(frozen=True)
class ProjectDesign:
    """The design of a project, and what had to be left out of it."""

    design: Design
    left_out: tuple[str, ...]  # "tie spline `a`": placed, but seen by too few images
    true_file: bool  # whether the truth comes from truth.json


def noise_of(settings: Simulation | None) -> Noise:
    """The sizes of errors that a project asks for."""
    if settings is None:
        return Noise()
    angle = settings.start_angle_deg
    return Noise(
        image_mm=None if settings.image_sigma_um is None else 1e-3 * settings.image_sigma_um,
        start_position_m=settings.start_position_m,
        start_angle_rad=None if angle is None else float(np.radians(angle)),
        start_knots_m=settings.start_knots_m,
        blunder_share=settings.blunder_share,
        blunder_size=settings.blunder_size_sigma,
        missing_point_share=settings.missing_point_share,
        missing_pair_share=settings.missing_pair_share,
        given_values=settings.given_errors,
    )


def project_design(loaded: LoadedProject, image_sigma_mm: float | None = None) -> ProjectDesign:
    """The design of a project that was loaded for simulation.

    Parameters
    ----------
    image_sigma_mm : σ of image points that are placed here; default: simulation.image_sigma_um of the project

    Raises
    ------
    SimulationError
        SBB701, SBB702: a truth of another project; or not enough is known, every lacking thing named.
    NotSolvableError
        If approximate values are missing and cannot be computed from the observations.
    """
    settings = loaded.model.simulation or Simulation()
    network = loaded.network
    file = loaded.path.with_name(TRUTH_FILE)
    truth = read_truth(file, network) if file.exists() else approximate_truth(network)
    network = replace(
        network,
        curves=tuple(
            _true_curve(curve, values) for curve, values in zip(network.curves, truth.curves, strict=True)
        ),
    )
    truth = replace(truth, locations=_foot_points(network, truth))
    sigma = image_sigma_mm
    if sigma is None and settings.image_sigma_um:
        sigma = 1e-3 * settings.image_sigma_um
    placed = False
    if network.curves and not len(network.curve_observations):
        network, truth = place_curve_points(network, truth, settings, sigma)
        placed = True
    if network.points.ids and not len(network.point_observations):
        network, placed = place_points(network, truth, sigma), True
    left_out: tuple[str, ...] = ()
    if placed:
        dropped = leave_out_unseen(network, truth)
        network, truth, left_out = dropped.network, dropped.truth, dropped.left_out
    network = exact_network(network, truth)
    _require_finite(network)
    return ProjectDesign(Design(network, truth), left_out, file.exists())


def approximate_truth(network: Network) -> Truth:
    """The approximate values of a network as truth; orientations and points from the measurements where not given.

    Raises
    ------
    SimulationError
        SBB702, naming what has no approximate value and no observations to compute it from.
    """
    images, points = network.images, network.points
    rotation, position, xyz = images.rotation, images.position, points.xyz
    oriented = images.has_orientation
    known: BoolArray = np.asarray(np.isfinite(points.xyz).all(axis=1))
    if not (oriented.all() and known.all()):
        if not len(network.point_observations):
            lacking = [f"image `{images.ids[k]}`" for k in np.flatnonzero(~oriented)]
            lacking += [f"point `{points.ids[k]}`" for k in np.flatnonzero(~known)]
            raise SimulationError("SBB702", f"no approximate values of {_listed(lacking)}", "give them")
        state, _ = starting_state(prepare(network))
        rotation = np.where(oriented[:, None, None], rotation, state.rotation)
        position = np.where(oriented[:, None], position, state.position)
        xyz = np.where(known[:, None], xyz, state.xyz)
    angles = np.array(
        [angles_from_rotation(r[None], s)[0] for r, s in zip(rotation, images.sequence, strict=True)]
    )
    return Truth(
        eop=np.hstack([angles.reshape(-1, 3), position]),
        curves=tuple(curve.values for curve in network.curves),
        points=xyz,
        locations=np.full(len(network.curve_observations), np.nan),
        sequence=images.sequence,
    )


def _true_curve(curve: Curve, values: FloatArray) -> Curve:
    """The curve with the parameters of its true values; conditions and checks refer to the true curve."""
    curve = with_fixed_parameters(curve, values)
    if curve.role == "check":
        basis, coefficients = shape_of(curve, values)
        u = np.linspace(basis.break_points[0], basis.break_points[-1], CHECK_SAMPLES)
        curve = replace(curve, check_values=basis.evaluate(u, coefficients))
    if curve.role == "control" or curve.reference is not None:
        return curve
    return replace(curve, reference=values)


def _foot_points(network: Network, truth: Truth) -> FloatArray:
    """Locations of all measured curve points: as the truth has them, else the foot points on the true curves."""
    if not len(network.curve_observations):
        return truth.locations
    prepared = prepare(network)
    given = true_state(prepared, truth)
    unknown = np.full(len(truth.locations), np.nan)
    found = search_locations(prepared, replace(given, location=unknown))
    known = np.isfinite(given.location)
    if not known.any():
        return found.location
    tried = replace(given, location=np.where(known, given.location, found.location))
    near = squared_distance(prepared, tried) <= squared_distance(prepared, found) + NEAR**2
    return np.where(known & near, tried.location, found.location)


def _require_finite(network: Network) -> None:
    """Nothing that is measured lies behind its image."""
    for kind in KINDS:
        group = kind.of(network)
        values: FloatArray = getattr(group, kind.value)
        bad = np.unique(np.argwhere(~np.isfinite(values))[:, 0])
        if len(bad):
            name = network.images.ids[_images_of(network, group)[bad[0]]]
            message = (
                f"the truth puts {len(bad)} measured points behind their images, the first one: `{name}`"
            )
            raise SimulationError("SBB702", message, "check signs, units and rotation sequence of the truth")


def _images_of(network: Network, group: Any) -> IntArray:
    """Image of every observation of a kind, (n,); arc lengths and tangents lie where their measured points do."""
    if hasattr(group, "image"):
        return np.asarray(group.image)
    point = group.first if hasattr(group, "first") else group.point
    return np.asarray(network.curve_observations.image[point])


def _listed(names: list[str]) -> str:
    more = f" and {len(names) - 5} more" if len(names) > 5 else ""
    return ", ".join(names[:5]) + more
