"""Small networks that use everything at once, and their equations in dense form."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.approximation.starting_values import starting_state
from splinebba_cli.core.estimation.conditioned_solution import ConditionedSolution
from splinebba_cli.core.estimation.design_matrix import DesignMatrix, design_matrix
from splinebba_cli.core.estimation.gauss_markov import solve
from splinebba_cli.core.estimation.normal_equations import Assembler, Linearization
from splinebba_cli.core.estimation.parameters import layout_of
from splinebba_cli.core.network import (
    CurveObservations,
    Distances,
    FloatArray,
    IntArray,
    Network,
    RotationSequence,
)
from splinebba_cli.core.observations.coefficient_rows import concatenate_rows, gauge_rows
from splinebba_cli.core.observations.location_search import search_locations
from splinebba_cli.core.observations.shape_conditions import control_rows
from splinebba_cli.core.state import State, prepare
from splinebba_cli.simulation.six_image_block import simulate_block
from splinebba_cli.simulation.truth import Truth


def select_curve_points(network: Network, rows: IntArray) -> Network:
    """The network with some of its points measured on curves."""
    seen = network.curve_observations
    chosen = CurveObservations(
        seen.image[rows], seen.curve[rows], seen.photo_xy[rows], seen.sigma[rows], seen.location[rows],
        seen.segment[rows],
    )  # fmt: skip
    return replace(network, curve_observations=chosen)


def mixed_network(seed: int = 1, noise_um: float = 5.0) -> tuple[Network, Truth]:
    """Six images, points and curves, and everything that can be known about them.

    Control, tie and check points (one height held), partial control splines (held and weighted knots), tie splines
    open, closed and with a corner, prior orientations in both rotation sequences, one orientation wholly fixed, one
    fixed in Z0 alone; three curve points whose locations are held at joints; distances between points and images.
    """
    network, truth = simulate_block(
        "six-image-mixed", seed, noise_um, start_position_m=0.5, start_angle_deg=0.1
    )
    network = select_curve_points(network, np.arange(0, len(network.curve_observations), 3))
    sequences: list[RotationSequence] = ["omega-phi-kappa"] * 6
    sequences[1] = "phi-omega-kappa"
    prior, sigma = np.full((6, 6), np.nan), np.full((6, 6), np.inf)
    for image in (0, 1):
        prior[image] = np.concatenate(
            [angles_of(truth.rotation[image], sequences[image]), truth.eop[image, 3:]]
        )
        sigma[image] = [2e-4, 2e-4, 3e-4, 0.05, 0.05, 0.08]
    sigma[0, 4] = np.inf
    prior[2], sigma[2] = truth.eop[2], 0.0
    prior[3, 5], sigma[3, 5] = truth.eop[3, 5], 0.0
    position, rotation = network.images.position.copy(), network.images.rotation.copy()
    position[2], rotation[2] = truth.eop[2, 3:], truth.rotation[2]
    position[3, 2] = truth.eop[3, 5]
    images = replace(
        network.images,
        sequence=tuple(sequences),
        prior=prior,
        prior_sigma=sigma,
        position=position,
        rotation=rotation,
    )
    point_sigma, xyz = network.points.sigma.copy(), network.points.xyz.copy()
    point_sigma[0, 2], xyz[0, 2] = 0.0, truth.points[0, 2]
    points = replace(network.points, sigma=point_sigma, xyz=xyz)
    curves = list(network.curves)
    weights = curves[1].sigma.copy()
    weights[3], weights[4, 2] = 0.1, 0.0
    values = curves[1].values.copy()
    values[3], values[4, 2] = truth.curves[1][3] + 0.03, truth.curves[1][4, 2]
    curves[1] = replace(curves[1], role="partial", sigma=weights, values=values)
    curves[2] = replace(curves[2], breaks=(3,))
    network = replace(network, images=images, points=points, curves=tuple(curves))
    network = replace(network, distances=distances_of(truth))
    return beyond_the_joint(network, truth.locations[::3]), truth


def distances_of(truth: Truth) -> Distances:
    """Points (one with a fixed height), bases (one to a fixed image), and from images to points; 2 cm wrong."""
    station = np.array([[0, 5], [5, 9], [0, 4], [1, 2], [3, 7], [11, 3]])
    is_image = np.array(
        [[False, False], [False, False], [True, True], [True, True], [True, False], [False, True]]
    )
    ends = np.where(is_image[:, :, None], truth.eop[np.minimum(station, 5), 3:], truth.points[station])
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    return Distances(station, is_image, length + 0.02 * np.array([1, -1, 1, -1, 1, -1]), np.full(6, 0.03))


def beyond_the_joint(network: Network, location: FloatArray) -> Network:
    """The three points next to inner joints bound to the wrong side of them, where their locations are held."""
    seen = network.curve_observations
    last = np.array([len(curve.values) - 1 for curve in network.curves])[seen.curve]
    joint = np.clip(np.round(location), 1, last - 1)
    rows = np.argsort(np.abs(location - joint))[:3]
    segment, sigma = seen.segment.copy(), seen.sigma.copy()
    segment[rows] = np.where(location < joint, joint, joint - 1)[rows]
    sigma[rows] = 0.2
    return replace(network, curve_observations=replace(seen, segment=segment, sigma=sigma))


def angles_of(rotation: FloatArray, sequence: RotationSequence) -> FloatArray:
    """Angles by the definition of the sequence, independent of the package's formulas."""
    from scipy.spatial.transform import Rotation

    if sequence == "omega-phi-kappa":
        return np.asarray(Rotation.from_matrix(rotation).as_euler("XYZ"))
    phi, omega, kappa = Rotation.from_matrix(rotation).as_euler("YXZ")
    return np.array([omega, phi, kappa])


def solved(network: Network, gauge_sigma_m: float | None = None) -> ConditionedSolution:
    """A network adjusted with all gauge conditions in one stage."""
    prepared = prepare(network)
    layout = layout_of(prepared)
    control = control_rows(prepared, layout.coefficient_mask)
    gauge = gauge_rows(prepared, layout.coefficient_mask, gauge_sigma_m)
    rows = concatenate_rows([control, gauge], prepared.curves.support)
    assembler = Assembler(prepared, layout, rows)
    state, _ = starting_state(prepared)
    solution = solve(assembler, state, max_iterations=60, stage="joint", damping=1e-3)
    assert solution.converged, solution.termination
    return ConditionedSolution(assembler, solution, np.arange(len(gauge)))


def start_of(network: Network) -> State:
    """Approximate values with foot points."""
    prepared = prepare(network)
    return search_locations(prepared, starting_state(prepared)[0])


@dataclass(frozen=True)
class DenseSystem:
    """The whole system in dense form: design, residuals, inverse, in full width (reduced unknowns, then points)."""

    design: FloatArray  # (rows, free unknowns)
    residual: FloatArray  # (rows,)
    unknown: IntArray  # (free unknowns,)
    width: int

    @property
    def inverse(self) -> FloatArray:
        """(A'A)^-1 by QR of the design with columns of unit length; zero for removed unknowns, (width, width)."""
        scale = np.linalg.norm(self.design, axis=0)
        triangle = np.linalg.qr(self.design / scale, mode="r")
        root = np.linalg.inv(triangle) / scale[:, None]
        full = np.zeros((self.width, self.width))
        full[np.ix_(self.unknown, self.unknown)] = root @ root.T
        return full

    @property
    def redundancy_numbers(self) -> FloatArray:
        """1 - diag(A (A'A)^-1 A'), (rows,)."""
        q = np.linalg.qr(self.design / np.linalg.norm(self.design, axis=0))[0]
        return np.asarray(1.0 - np.sum(q * q, axis=1))


def dense_system(assembler: Assembler, at: Linearization) -> DenseSystem:
    """All equations of a linearisation, locations eliminated, points not."""
    made: DesignMatrix = design_matrix(assembler, at)
    residual = np.concatenate(
        [
            at.curve.residual,
            at.points.residual.ravel(),
            at.distances.residual,
            at.orientation_priors.residual[at.orientation_priors.active],
            at.point_prior_residual[assembler.point_inverse_sigma > 0.0],
            at.coefficient_residual,
        ]
    )
    width = int(assembler.layout.node_starts[-1]) + assembler.layout.point_mask.size
    return DenseSystem(made.matrix, residual, made.unknown, width)
