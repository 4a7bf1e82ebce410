"""Simulated blocks with truth: Lee's six images, a strip, and a circle in four images.

Geometry and places of measurement are the same for every seed; the seed draws noise and wrong starts.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from splinebba_cli.core.curves.basis import harmonic_row
from splinebba_cli.core.network import Distances, FloatArray, Network, Role, Settings
from splinebba_cli.simulation.assembly import NOMINAL_SIGMA_MM, scene_design
from splinebba_cli.simulation.block_geometry import (
    BlockGeometry,
    four_images,
    ring,
    six_image_block,
    strip,
)
from splinebba_cli.simulation.feature_geometry import (
    Feature,
    PointFeatures,
    check_spline,
    circle_rows,
    control_spline,
    partial_control_spline,
    road,
    scattered_points,
    shore,
    tie_spline,
)
from splinebba_cli.simulation.noise import Noise
from splinebba_cli.simulation.realization import Design, realize
from splinebba_cli.simulation.street_block import street_features, street_images
from splinebba_cli.simulation.truth import Truth
from splinebba_cli.simulation.unlabelling import ChainStyle

KINDS: dict[str, str] = {
    "six-image": "Lee's six images (table 5.3): control, partial control and tie splines of several segments",
    "six-image-mixed": "the same images: control, tie and check points with partial, tie and check splines",
    "six-image-singular": "the same images and one control segment (table 5.7): cannot be determined",
    "circle-three-ways": "one circle in four images, measured as a circle, a closed natural spline and a Fourier curve",
    "strip": "five images with observed orientations, control, ties; coordinates of millions of metres",
    "edge-chains": "a street from a drone: edges traced without names, wrong ones among them, some of unknown shape",
    "close-range-ring": "ten convergent images around an object of a metre: points, splines, two scale bars",
}

# Lee (2008), second segment of the spline of tables 5.4 and 5.7: a0..a3, b0..b3, c0..c3 as columns X, Y, Z
LEE_SEGMENT = np.array(
    [[3335.0, 4343.0, 52.0], [70.5, 63.0, 8.0], [-48.75, -28.5, -39.0], [16.25, 9.5, 13.0]]
)


@dataclass(frozen=True)
class Scene:
    """A block, what lies on the ground, and how it is measured."""

    block: BlockGeometry
    features: tuple[Feature, ...]
    points: PointFeatures
    points_per_curve: int  # measured points for every curve and image that sees it
    eop_sigma: FloatArray | None = None  # (6,) of observed exterior orientations (rad, m); None: not observed
    settings: Settings = field(default_factory=Settings)
    bars: tuple[tuple[str, str], ...] = ()  # points at the ends of scale bars
    bar_sigma_m: float = 5e-5


def simulate_block(
    kind: str,
    seed: int = 1,
    noise_um: float = 5.0,
    start_position_m: float = 3.0,
    start_angle_deg: float = 1.0,
    start_knots_m: float = 1.5,
) -> tuple[Network, Truth]:
    """A network with measurements and wrong starts, and what it was made from.

    Parameters
    ----------
    kind : a key of :data:`KINDS`
    seed : int
        Of the noise and the starts.
    noise_um : float
        Standard deviation of measured photo coordinates.  0 makes all measurements and given values exact;
        the network then still states 5 µm.
    start_position_m, start_angle_deg, start_knots_m : float
        Largest error of an approximate perspective centre, angle and knot, in every coordinate; lengths are those
        of a block from the air and scaled by :data:`START_SCALE`.

    Returns
    -------
    network : Network
        Gauge conditions refer to the true knots, so that the truth is a solution of noise-free measurements.
    truth : Truth

    Raises
    ------
    KeyError
        If the kind is unknown; names the known ones.
    """
    angle = float(np.radians(start_angle_deg))
    scale = START_SCALE.get(kind, 1.0)
    noise = Noise(1e-3 * noise_um, scale * start_position_m, angle, scale * start_knots_m)
    made = realize(kind_design(kind, noise.image_mm or NOMINAL_SIGMA_MM), noise, seed)
    return made.network, made.truth


def kind_design(kind: str, sigma_mm: float) -> Design:
    """The design of a kind of block; `sigma_mm` is stated for all measured coordinates.

    Raises
    ------
    KeyError
        If the kind is unknown; names the known ones.
    """
    if kind not in SCENES:
        raise KeyError(f"unknown kind of block {kind!r}; known are {', '.join(SCENES)}")
    scene = SCENES[kind]()
    design = scene_design(
        scene.block, scene.features, scene.points, scene.points_per_curve, scene.eop_sigma, sigma_mm
    )
    network = replace(design.network, settings=scene.settings, distances=_scale_bars(scene, design))
    return replace(design, network=network)


def _scale_bars(scene: Scene, design: Design) -> Distances:
    """True lengths of the bars of a scene."""
    if not scene.bars:
        return Distances.none()
    number = {name: k for k, name in enumerate(design.network.points.ids)}
    station = np.array([[number[a], number[b]] for a, b in scene.bars])
    xyz = design.truth.points
    length = np.linalg.norm(xyz[station[:, 1]] - xyz[station[:, 0]], axis=1)
    sigma = np.full(len(station), scene.bar_sigma_m)
    return Distances(station, np.zeros(station.shape, dtype=bool), length, sigma)


# every free feature lies where at least two images see it; the lake in the overlap of both strips
TIE_1 = road((2985.0, 3860.0), (3255.0, 4400.0), 7, 25.0)
TIE_2 = road((3610.0, 3850.0), (3370.0, 4400.0), 7, -25.0)
TIE_3 = road((3225.0, 4800.0), (2990.0, 4440.0), 5, 20.0)
LAKE = shore((3235.0, 4315.0), 80.0, 8)
NORTH_EAST = road((3390.0, 4430.0), (3600.0, 4820.0), 5, 20.0)


def _six_image() -> Scene:
    """Two control splines across the block, a partial control spline, three tie splines and a closed one."""
    features = (
        control_spline("control-1", road((2780.0, 4330.0), (3840.0, 4290.0), 9, 40.0)),
        control_spline("control-2", road((3330.0, 3760.0), (3270.0, 4860.0), 9, 35.0)),
        partial_control_spline("partial-1", NORTH_EAST),
        tie_spline("tie-1", TIE_1),
        tie_spline("tie-2", TIE_2),
        tie_spline("tie-3", TIE_3),
        tie_spline("lake", LAKE, closed=True),
    )
    return Scene(six_image_block(), features, PointFeatures(), 30)


def _six_image_mixed() -> Scene:
    """Control, tie and check points together with partial control, tie and check splines."""
    features = (
        partial_control_spline("partial-1", road((2985.0, 4350.0), (3620.0, 4270.0), 7, 35.0)),
        tie_spline("tie-1", TIE_1),
        tie_spline("tie-2", TIE_2),
        tie_spline("lake", LAKE, closed=True),
        check_spline("check-1", NORTH_EAST),
    )
    control = np.array([[2990, 3800], [3620, 3790], [3615, 4810], [2985, 4820], [3300, 4300], [3305, 3990]])
    points = scattered_points((2960.0, 3700.0, 3640.0, 4910.0), control.astype(float), 40, 6, 0.02)
    return Scene(six_image_block(), features, points, 30)


def _six_image_singular() -> Scene:
    """Lee's table 5.7: six free orientations, one fixed segment, four measured points an image.

    24 equations across the curve against 36 unknown orientation elements.  The format is widened to 260 mm:
    the segment lies beyond the corner of a 230 mm one in some images.
    """
    feature = Feature("control-1", "control", LEE_SEGMENT, np.zeros_like(LEE_SEGMENT), family="free_cubic")
    return Scene(six_image_block((260.0, 260.0)), (feature,), PointFeatures(), 4)


def _strip() -> Scene:
    """Five images with observed orientations, one control spline at one end, ties across the strip.

    No road runs along the strip: a line in the direction of the bases has no depth.
    """
    features = (
        control_spline("control-1", road((-150.0, 180.0), (60.0, -220.0), 6, 25.0)),
        tie_spline("tie-1", road((10.0, -200.0), (400.0, 210.0), 7, 25.0)),
        tie_spline("tie-2", road((480.0, 210.0), (860.0, -200.0), 7, -25.0)),
        tie_spline("tie-3", road((920.0, -190.0), (1190.0, 210.0), 6, 20.0)),
    )
    control = np.array([[1210.0, 190.0], [1190.0, -210.0]])
    points = scattered_points((-30.0, -230.0, 1220.0, 230.0), control, 25, 3, 0.02)
    sigma = np.array([*np.radians([0.005, 0.005, 0.008]), 0.05, 0.05, 0.08])
    return Scene(strip(), features, points, 30, sigma)


def _circle_three_ways() -> Scene:
    """One circle, measured three times: as a circle, as a closed natural spline and as a Fourier curve.

    A closed natural spline of eight knots only approximates a circle: adjusted to exact measurements it keeps within
    7e-4 of the radius (rms 4e-4), here 3 and 2 mm, while noise of 5 µm leaves a standard deviation across of 10 mm.
    """
    circle = tie_spline(
        "as-circle", circle_rows((20.0, -10.0, 30.0), 5.0, (0.15, -0.1, 1.0)), family="circle"
    )
    u = np.linspace(0.0, 2.0 * np.pi, 9)[:-1]
    knots = harmonic_row(u, 0, 3) @ circle.values
    rows = np.vstack([circle.values, np.zeros((2, 3))])
    features = (
        circle,
        replace(tie_spline("as-spline", knots, closed=True), really=circle),
        tie_spline("as-fourier", rows, family="fourier"),
    )
    control = np.array([[-140.0, -130.0], [150.0, -140.0], [140.0, 150.0], [-150.0, 140.0], [0.0, 10.0]])
    points = scattered_points((-160.0, -160.0, 160.0, 160.0), control, 25, 3, 0.01)
    # knots of a spline slide freely along a circle: all of its conditions are needed
    settings = Settings(gauge_conditions="all")
    return Scene(four_images(), features, points, 40, settings=settings)


def _close_range_ring() -> Scene:
    """A rim, two edges and targets on an object of a metre, seen from all sides; two scale bars across it."""
    angle = np.linspace(0.0, 2.0 * np.pi, 11)[:-1]
    rim = np.column_stack([0.42 * np.cos(angle), 0.36 * np.sin(angle), 0.62 + 0.05 * np.sin(3.0 * angle)])
    share = np.linspace(0.0, 1.0, 7)
    edges = [
        np.column_stack([side * (0.5 - 0.15 * share), -0.45 + 0.9 * share, 0.1 + 0.35 * np.sin(2.5 * share)])
        for side in (-1.0, 1.0)
    ]
    features = (
        tie_spline("rim", rim, closed=True),
        tie_spline("edge-1", edges[0]),
        tie_spline("edge-2", edges[1]),
    )
    generator = np.random.default_rng(73)
    xyz = generator.uniform([-0.55, -0.55, 0.0], [0.55, 0.55, 0.7], (24, 3))
    control = np.array([[-0.6, -0.6, 0.0], [0.6, -0.6, 0.05], [0.6, 0.6, 0.0], [-0.6, 0.6, 0.1]])
    ids = [f"gcp-{k + 1}" for k in range(len(control))] + [f"target-{k + 1}" for k in range(len(xyz))]
    kinds: tuple[tuple[Role, int], ...] = (("control", len(control)), ("tie", len(xyz)))
    role = tuple(name for name, count in kinds for _ in range(count))
    sigma = np.where(np.array(role)[:, None] == "tie", np.inf, 2e-4) * np.ones(3)
    points = PointFeatures(tuple(ids), role, np.vstack([control, xyz]), sigma)
    bars = (("target-1", "target-2"), ("target-3", "target-4"))
    # gently bent edges let their knots slide far: all conditions stay
    return Scene(ring(), features, points, 25, settings=Settings(gauge_conditions="all"), bars=bars)


def _street() -> Scene:
    """Kerbs on the map, edges that are not: measured along chains."""
    return Scene(street_images(), street_features(), PointFeatures(), 40)


SCENES: dict[str, Callable[[], Scene]] = {
    "six-image": _six_image,
    "six-image-mixed": _six_image_mixed,
    "six-image-singular": _six_image_singular,
    "strip": _strip,
    "circle-three-ways": _circle_three_ways,
    "edge-chains": _street,
    "close-range-ring": _close_range_ring,
}
START_SCALE = {
    "close-range-ring": 0.01,
    "edge-chains": 1.0 / 3.0,
}  # of the errors of approximate positions and knots
CHAINS = {"edge-chains": ChainStyle(points=20, wrong_share=0.2, hides_ties=True)}  # written without labels
MATCHING: dict[str, dict[str, Any]] = {
    "edge-chains": {"position_sigma_m": 0.6, "angle_sigma_deg": 0.6, "new_curves": True}
}  # section of the written project
