"""The variance of an innovation against sampling; the share of right points that a gate loses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.camera.rotation import rotation_from_vector
from splinebba_cli.core.matching.candidates.search import find_candidates
from splinebba_cli.core.matching.known_curves.chain_directions import Directions
from splinebba_cli.core.matching.known_curves.gates import Gated, gate_candidates
from splinebba_cli.core.matching.known_curves.loop_context import LoopContext
from splinebba_cli.core.matching.known_curves.uncertainty import Uncertainty
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.matching.settings import MatchSettings
from tests.core.matching.known_curves.one_image import ROADS, SIGMA_MM, control, network, seen

CURVE = control(ROADS[0], "road")
POSITION, ANGLE, SHAPE = 0.05, 1e-4, 0.04
RUNS = 200


def made() -> tuple[Scene, Uncertainty]:
    given = network([CURVE], [], seen(CURVE, 5, 0.2, 0.8))
    context = LoopContext.of(given, MatchSettings(position_sigma_m=POSITION, angle_sigma_rad=ANGLE), None)
    progress = context.begin()
    return context.scene(progress.state), replace(progress.uncertainty, shape=np.array([SHAPE]))


def gated(scene: Scene, uncertainty: Uncertainty, alpha: float) -> Gated:
    count = len(scene.image)
    unknown = Directions(np.full(count, np.nan), np.full(count, np.inf))
    return gate_candidates(scene, uncertainty, unknown, alpha, 0.3)


def distances(scene: Scene, generator: np.random.Generator) -> np.ndarray:
    """Signed distances across with a drawn orientation, shape (a shift of the curve) and noise, (5,)."""
    turn = rotation_from_vector(generator.normal(0.0, ANGLE, (1, 3)))
    coefficients = scene.coefficients + generator.normal(0.0, SHAPE, 3)
    moved = replace(
        scene,
        rotation=scene.rotation @ turn,
        position=scene.position + generator.normal(0.0, POSITION, 3),
        coefficients=coefficients,
        polynomials=scene.curves.segment_polynomials(coefficients),
        xy=scene.xy + generator.normal(0.0, SIGMA_MM, scene.xy.shape),
    )
    near = find_candidates(moved, np.full(5, 1.0))
    first = np.unique(near.point, return_index=True)[1]
    normal = np.column_stack([-near.tangent[first, 1], near.tangent[first, 0]])
    return np.asarray(np.sum(normal * near.offset[first], axis=1))


def test_the_predicted_variance_is_that_of_sampling() -> None:
    """The ratio of variances over 200 runs is inside 1 +- 4.4 sqrt(2 / 200) with 99.99 % for five points."""
    scene, uncertainty = made()
    found = gated(scene, uncertainty, 1e-6)
    generator = np.random.default_rng(1)
    d = np.array([distances(scene, generator) for _ in range(RUNS)])
    ratio = d.var(axis=0) / (found.noise + found.common)
    assert np.abs(ratio - 1.0).max() < 4.4 * np.sqrt(2.0 / RUNS)
    noise = found.noise / SIGMA_MM**2
    np.testing.assert_allclose(noise, 1.0, rtol=1e-9)


def test_the_gate_keeps_what_alpha_says() -> None:
    scene, uncertainty = made()
    generator = np.random.default_rng(2)
    variance = (lambda g: g.noise + g.common)(gated(scene, uncertainty, 1e-6))
    square = np.array([distances(scene, generator) for _ in range(RUNS)]) ** 2 / variance
    assert (
        abs(float(np.mean(square > 3.841)) - 0.05) < 0.03
    )  # points of a run have most of their error in common
