"""Designs whose coverage is measured, each with the errors of its measurements and starts.

- regular experiments of Lee (2008), chapter 5, from Lee's starts: orientations are known, and locations on a known
  segment (tables 5.6, 5.11) or the shape of a tie segment (tables 5.4, 5.5, 5.10) are sought
- four curves of the six-image block, with arc lengths, with tangents, with both
- every family of curves in the six-image block: orientations free, points as control
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from splinebba_cli.core.curves.registry import FAMILIES
from splinebba_cli.core.network import Network
from splinebba_cli.core.observations.arc_lengths import arc_lengths_at
from splinebba_cli.core.state import prepare
from splinebba_cli.simulation.assembly import NOMINAL_SIGMA_MM, scene_design
from splinebba_cli.simulation.block_geometry import six_image_block
from splinebba_cli.simulation.campaign import Campaign
from splinebba_cli.simulation.dissertation import design_of, experiment
from splinebba_cli.simulation.feature_geometry import Feature, scattered_points
from splinebba_cli.simulation.linked_observations import with_arc_lengths, with_tangents
from splinebba_cli.simulation.noise import Noise
from splinebba_cli.simulation.observation_kinds import select
from splinebba_cli.simulation.realization import Design
from splinebba_cli.simulation.six_image_block import SCENES, kind_design
from splinebba_cli.simulation.targets import BLOCK_NOISE
from splinebba_cli.simulation.truth import Truth, true_state
from tests.core.family_features import WITH_OPTIONS, of_family
from tests.core.free_curves import CONTROL_XY

ARC_SIGMA_MM = 0.005
TANGENT_SIGMA_RAD = 1e-3
SIMPSON_ERROR_MM = 2.5e-4  # of Lee's rule, up to which points are close enough for it: σ / 20
LINKED_STARTS = 0.25  # of the starts of the block: 0.75 m, 0.25 degrees, 0.4 m
FOUR_CURVES = ("control-1", "control-2", "tie-1", "lake")
LEE_EXPERIMENTS = ("table_5_4", "table_5_5", "table_5_6", "table_5_10", "table_5_11")  # regular
OPTIONS = ("closed", "cubics-3-natural", "bspline_3-closed", "arc", "circular-arc")
FAMILY_NOISE = Noise(5e-3, 0.5, 1e-3, 0.3)


@dataclass(frozen=True)
class Case:
    """One campaign by name."""

    name: str
    title: str
    make: Callable[[int], Campaign]  # of a seed
    curve_by_curve: bool = False  # lateral coverage as a line for every curve


def lee_experiment(name: str, seed: int) -> Campaign:
    """An experiment of the dissertation; starts are the printed ones."""
    return Campaign(design_of(experiment(name)), Noise(), seed)


def six_image(seed: int) -> Campaign:
    """The whole block without arc lengths and tangents."""
    return Campaign(kind_design("six-image", NOMINAL_SIGMA_MM), BLOCK_NOISE, seed)


def four_curves(seed: int, *, arcs: str | None = None, tangents: bool = False) -> Campaign:
    """Four curves of the block with further observations along them.

    Parameters
    ----------
    arcs : "gauss-legendre": between all points that follow each other; "simpson": where these are close enough
    """
    scene = SCENES["six-image"]()
    features = tuple(feature for feature in scene.features if feature.id in FOUR_CURVES)
    points = 20 if arcs == "gauss-legendre" else scene.points_per_curve
    made = scene_design(scene.block, features, scene.points, points, None, NOMINAL_SIGMA_MM)
    network = made.network
    if arcs is not None:
        network = with_arc_lengths(network, made.truth, ARC_SIGMA_MM, None, simpson=arcs == "simpson")
        network = close_enough(network, made.truth)
    if tangents:
        network = with_tangents(network, made.truth, TANGENT_SIGMA_RAD, None)
    return Campaign(replace(made, network=network), BLOCK_NOISE.with_starts(LINKED_STARTS), seed)


def close_enough(network: Network, truth: Truth) -> Network:
    """The network with the arc lengths whose rule of integration is right to a twentieth of σ."""
    prepared = prepare(network)
    arcs = network.arc_lengths
    by_rule = arc_lengths_at(prepared, true_state(prepared, truth), np.arange(len(arcs)))
    right = np.flatnonzero(np.abs(by_rule - arcs.length) <= SIMPSON_ERROR_MM)
    return replace(network, arc_lengths=select(arcs, right))


def family_features() -> tuple[Feature, ...]:
    """A tie curve of every family, and of closed curves, natural joined cubics and arcs."""
    options = tuple(feature for feature in WITH_OPTIONS if feature.id in OPTIONS)
    return (*(of_family(name) for name in FAMILIES), *options)


def families(seed: int) -> Campaign:
    """Curves of all families together, 12 points an image and curve, from six control points and 20 tie points."""
    points = scattered_points((2960.0, 3700.0, 3640.0, 4910.0), CONTROL_XY.astype(float), 20, 0, 0.02)
    made: Design = scene_design(six_image_block(), family_features(), points, 12, None, NOMINAL_SIGMA_MM)
    return Campaign(made, FAMILY_NOISE, seed)


CASES: tuple[Case, ...] = (
    *(Case(name, experiment(name).title, partial(lee_experiment, name)) for name in LEE_EXPERIMENTS),
    Case("six-image", "six-image block", six_image),
    Case("families", "every family in the six-image block", families, curve_by_curve=True),
    Case("tangents", "four curves, tangents", lambda seed: four_curves(seed, tangents=True)),
    Case("arcs", "four curves, arc lengths", lambda seed: four_curves(seed, arcs="gauss-legendre")),
    Case("arcs-simpson", "four curves, arc lengths, Simpson", lambda seed: four_curves(seed, arcs="simpson")),
    Case(
        "both",
        "four curves, arc lengths and tangents",
        lambda seed: four_curves(seed, arcs="gauss-legendre", tangents=True),
    ),
    Case(
        "both-simpson",
        "four curves, arc lengths, Simpson, and tangents",
        lambda seed: four_curves(seed, arcs="simpson", tangents=True),
    ),
)


def case(name: str) -> Case:
    """One case by its name.

    Raises
    ------
    KeyError
        If there is none of this name.
    """
    return {each.name: each for each in CASES}[name]
