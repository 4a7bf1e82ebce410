"""Images whose prior leaves several curves to many points, aligned to the curves one by one."""

from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from splinebba_cli.core.matching.chain_directions import ChainOrder, Directions, chain_directions
from splinebba_cli.core.matching.curve_samples import CurveSamples
from splinebba_cli.core.matching.image_alignment import Alignment, align_image
from splinebba_cli.core.matching.image_view import ImageView, Pose
from splinebba_cli.core.matching.loop_context import LoopContext, Progress
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.result import Problem

_log = logging.getLogger(__name__)

POINTS = 600  # of an image that take part
SAMPLES = 4_000  # of curves in one image, about
ROUGHLY = 50_000  # samples of all curves that tell which of them an image sees
LOOKED_AT = 100  # points that decide whether an image is aligned
DOUBTFUL = 0.1  # share of points with several curves inside the prior
GATE = 3.3  # standard deviations
SPACING = 3.0  # sigma of a point, between samples of a curve
WIDENINGS = (1.0, 4.0, 16.0)  # of guessed standard deviations
MARGIN = 0.5  # of the extent of the points, around them
ENOUGH = 0.25  # share of the points of an image that follow a curve, for a guess to be taken
CAUTION = 4.0  # times the variances of an alignment


def aligned(context: LoopContext, progress: Progress) -> tuple[Progress, tuple[Problem, ...]]:
    """Progress with images aligned where that is needed, and what is ambiguous."""
    scene = context.scene(progress.state)
    directions = chain_directions(scene, ChainOrder.of(scene.chain))
    generator = np.random.default_rng(context.settings.seed)
    problems: list[Problem] = []
    state, eop = progress.state, progress.uncertainty.eop.copy()
    rotation, position = state.rotation.copy(), state.position.copy()
    spread = progress.uncertainty.largest_in_photo(scene)
    rough = _rough_samples(context, scene)
    for image in np.unique(scene.image[context.usable]).tolist():
        rows = np.flatnonzero((scene.image == image) & context.usable)
        view = _view(context, scene, directions, rows, image, float(spread[image]), rough)
        guessed = bool(context.start.prior.guessed[image])
        if not len(view.samples) or not (guessed or _doubtful(view, scene, image, float(spread[image]))):
            continue
        start = Pose(rotation[image], position[image])
        found = _best(context, view, start, eop[image], image, generator)
        if found is None:
            continue
        name = context.network.images.ids[image]
        if not found.clear:
            problems.append(_ambiguous(name, found))
            continue
        rotation[image], position[image] = found.pose.rotation, found.pose.position
        eop[image] = CAUTION * found.dispersion
        _log.info("image %s aligned: %d of %d points", name, found.inliers, len(view.xy))
    state = replace(state, rotation=rotation, position=position)
    return replace(progress, state=state, uncertainty=replace(progress.uncertainty, eop=eop)), tuple(problems)


def _view(
    context: LoopContext, scene: Scene, directions: Directions, rows: IntArray, image: int, spread: float,
    samples: CurveSamples,
) -> ImageView:  # fmt: skip
    """Some points of an image, and the curves near them."""
    if len(rows) > POINTS:
        rows = rows[np.linspace(0, len(rows) - 1, POINTS).astype(np.int64)]
    sigma = 1.0 / np.sqrt(np.abs(np.linalg.det(scene.whitening[rows])))
    view = ImageView(
        float(scene.principal_distance[image]), scene.xy[rows], sigma, directions.angle[rows],
        directions.sigma[rows], samples, context.start.shape_sigma[samples.curve],
        context.settings.direction_tolerance_rad,
    )  # fmt: skip
    pose = Pose(scene.rotation[image], scene.position[image])
    near = _near(view, pose, spread)
    if not len(near):
        return replace(view, samples=samples.select(near), shape_sigma=np.zeros(0))
    depth = float(np.median(np.linalg.norm(samples.xyz[near] - pose.position, axis=1)))
    finest = SPACING * float(np.median(sigma)) * depth / view.principal_distance
    spacing = max(finest, samples.spacing * len(near) / SAMPLES)
    keep = np.zeros(len(scene.curves.bases), dtype=bool)
    keep[samples.curve[near]] = True
    view = replace(view, samples=CurveSamples.of(scene.curves, scene.coefficients, keep, spacing))
    chosen = view.samples.select(_near(view, pose, spread))
    return replace(view, samples=chosen, shape_sigma=context.start.shape_sigma[chosen.curve])


def _rough_samples(context: LoopContext, scene: Scene) -> CurveSamples:
    """Samples of all curves, about as many as wanted."""
    ends = scene.curves.segment_polynomials(scene.coefficients)[context.start.shaped[scene.curves.owner]]
    chords = np.linalg.norm(ends[:, 1:4].sum(axis=1), axis=1)
    spacing = max(float(np.nansum(chords)) / ROUGHLY, 1e-9)
    return CurveSamples.of(scene.curves, scene.coefficients, context.start.shaped, spacing)


def _near(view: ImageView, pose: Pose, spread: float) -> IntArray:
    """Samples that lie where the image has points, or near there."""
    xy = view.seen(pose).xy
    reach = MARGIN * float(np.ptp(view.xy, axis=0).max()) + GATE * spread
    with np.errstate(invalid="ignore"):
        near = ((xy >= view.xy.min(axis=0) - reach) & (xy <= view.xy.max(axis=0) + reach)).all(axis=1)
    return np.flatnonzero(near)


def _doubtful(view: ImageView, scene: Scene, image: int, spread: float) -> bool:
    """Whether the prior leaves several curves to many points of an image."""
    seen = view.seen(Pose(scene.rotation[image], scene.position[image]))
    visible = np.flatnonzero(np.isfinite(seen.xy).all(axis=1))
    if not len(visible):
        return False
    points = np.linspace(0, len(view.xy) - 1, min(LOOKED_AT, len(view.xy))).astype(np.int64)
    radius = GATE * float(np.hypot(spread, np.median(view.sigma)))
    near = cKDTree(seen.xy[visible]).query_ball_point(view.xy[points], radius)
    several = 0
    for point, found in zip(points.tolist(), near, strict=True):
        rows = visible[np.asarray(found, dtype=np.int64)]
        angle = view.angle[point]
        if np.isfinite(angle) and len(rows):
            along = seen.direction[rows]
            sine = np.abs(np.cos(angle) * along[:, 1] - np.sin(angle) * along[:, 0])
            rows = rows[sine <= np.sin(view.direction_tolerance)]
        several += len(np.unique(view.samples.curve[rows])) > 1
    return several > DOUBTFUL * len(points)


def _best(
    context: LoopContext, view: ImageView, start: Pose, dispersion: FloatArray, image: int,
    generator: np.random.Generator,
) -> Alignment | None:  # fmt: skip
    """The alignment inside the prior; of a guessed prior the first that is clear, with growing guesses."""
    if not context.start.prior.guessed[image]:
        return align_image(view, start, dispersion, generator)
    best: Alignment | None = None
    for widening in WIDENINGS:
        wide = context.start.prior.widened(image, widening, context.network.images)
        found = align_image(view, start, wide.dispersion[image], generator)
        if found is not None and (best is None or found.gain > best.gain):
            best = found
        if best is not None and best.clear and best.inliers >= ENOUGH * len(view.xy):
            return best
    return best


def _ambiguous(name: str, found: Alignment) -> Problem:
    return Problem(
        "SBB581",
        "warning",
        f"image `{name}`: two orientations inside its prior bring its points equally near to the curves "
        f"({found.inliers} points); it stays as given",
        f"image `{name}`",
        "give a better approximate orientation (`position_sigma_m`, `angle_sigma`), trace edges as chains, "
        "or measure some control points in it",
    )
