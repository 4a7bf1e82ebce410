"""Images whose prior leaves several curves to many points, aligned to the curves one by one."""

from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np

from splinebba_cli.core.matching.candidates.search import find_candidates
from splinebba_cli.core.matching.known_curves.image_alignment import Alignment, align_image
from splinebba_cli.core.matching.known_curves.image_view import ImageView
from splinebba_cli.core.matching.known_curves.image_views import ImageViews
from splinebba_cli.core.matching.known_curves.loop_context import LoopContext, Progress
from splinebba_cli.core.matching.known_curves.search_effort import QUICK, THOROUGH
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.network import BoolArray, FloatArray
from splinebba_cli.core.result import Problem

_log = logging.getLogger(__name__)

LOOKED_AT = 100  # points that decide whether an image is aligned
DOUBTFUL = 0.1  # share of points with several curves inside the prior
WIDE = 0.1  # of the extent of the points of an image: a gate beyond which the nearest curve says nothing
GATE = 3.3  # standard deviations
WIDENINGS = (1.0 / 16.0, 0.25, 1.0, 4.0, 16.0)  # of guessed standard deviations
ENOUGH = 0.7  # share of the points that should follow a curve, for the first guesses to be taken
CAUTION = 4.0  # times the variances of an alignment


def aligned(
    context: LoopContext, progress: Progress, images: BoolArray
) -> tuple[LoopContext, Progress, tuple[Problem, ...]]:
    """Images aligned where that is needed.

    Parameters
    ----------
    images : (m,) that are looked at

    Returns
    -------
    context : with guessed priors as wide as that took; points of images that fit in no clear way are not usable
    progress : with their orientations
    problems : about these images
    """
    scene = context.scene(progress.state)
    views = ImageViews.of(context, scene)
    generator = np.random.default_rng(context.settings.seed)
    problems: list[Problem] = []
    prior = context.start.prior
    state, eop = progress.state, progress.uncertainty.eop * progress.uncertainty.inflation
    rotation, position = state.rotation.copy(), state.position.copy()
    orientations = replace(progress.uncertainty, shape=0.0 * context.start.shape_sigma, cofactors=None)
    spread = orientations.largest_in_photo(scene)
    wanted = images & (_doubtful(context, scene, spread) | _wide(context, scene, spread) | prior.guessed)
    blocked = context.blocked & ~images
    for image in np.unique(scene.image[context.oriented & wanted[scene.image]]).tolist():
        found, widening = _best(context, views, image, float(spread[image]), eop[image], generator)
        name = context.network.images.ids[image]
        if found is None or not found.clear:
            blocked[image] = True
            problems += [] if found is None else [_unclear(name, found)]
            continue
        rotation[image], position[image] = found.pose.rotation, found.pose.position
        eop[image] = CAUTION * found.dispersion
        prior = prior.widened(image, max(widening, 1.0), context.network.images)
        _log.info("image %s aligned: %d of %d points follow curves", name, found.inliers, found.points)
    state = replace(state, rotation=rotation, position=position)
    context = replace(context, start=context.start.with_prior(prior), blocked=blocked)
    uncertainty = replace(progress.uncertainty, eop=eop, inflation=1.0)
    return context, replace(progress, state=state, uncertainty=uncertainty), tuple(problems)


def _doubtful(context: LoopContext, scene: Scene, spread: FloatArray) -> BoolArray:
    """Images (m,) in which the prior leaves several curves to many points.

    Parameters
    ----------
    spread : (m,) mm, standard deviation of projected curves
    """
    images = len(spread)
    usable = np.flatnonzero(context.oriented)
    order = usable[np.argsort(scene.image[usable], kind="stable")]
    count = np.bincount(scene.image[order], minlength=images)
    number = np.arange(len(order)) - np.repeat(np.cumsum(count) - count, count)
    points = order[number % np.repeat(np.maximum(count // LOOKED_AT, 1), count) == 0]
    directions = context.traced.directions
    near = find_candidates(scene, GATE * np.hypot(spread[scene.image], scene.noise), np.sort(points))
    angle, along = directions.angle[near.point], near.tangent
    sine = np.abs(np.cos(angle) * along[:, 1] - np.sin(angle) * along[:, 0])
    agrees = ~(sine > np.sin(context.settings.direction_tolerance_rad))
    curves = len(context.network.curves)
    pairs = np.unique(near.point[agrees] * curves + near.curve[agrees]) // curves
    several = np.bincount(pairs, minlength=len(scene.image))[points] > 1
    share = np.bincount(scene.image[points[several]], minlength=images)
    return np.asarray(share > DOUBTFUL * np.bincount(scene.image[points], minlength=images))


def _wide(context: LoopContext, scene: Scene, spread: FloatArray) -> BoolArray:
    """Images (m,) whose curves may be seen so far away that rounds from the prior would lead anywhere.

    Parameters
    ----------
    spread : (m,) mm, standard deviation of projected curves
    """
    image, xy = scene.image[context.oriented], scene.xy[context.oriented]
    low, high = np.full((len(spread), 2), np.inf), np.full((len(spread), 2), -np.inf)
    np.minimum.at(low, image, xy)
    np.maximum.at(high, image, xy)
    extent = np.maximum(high - low, 0.0).max(axis=1)
    return np.asarray((extent > 0.0) & (GATE * spread > WIDE * extent))


def _best(
    context: LoopContext, views: ImageViews, image: int, spread: float, dispersion: FloatArray,
    generator: np.random.Generator,
) -> tuple[Alignment | None, float]:  # fmt: skip
    """The alignment inside the prior, and how much wider that was made.

    Of a guessed prior the first alignment that is clear, with growing guesses.
    """
    if not context.start.prior.guessed[image]:
        return _thoroughly(views.view(image, spread), dispersion, generator), 1.0
    best: Alignment | None = None
    taken = 1.0
    for widening in WIDENINGS:
        wide = context.start.prior.widened(image, widening, context.network.images)
        view = views.view(image, widening * spread)
        found = align_image(view, wide.dispersion[image], generator, QUICK)
        if found is not None and (best is None or found.gain > best.gain):
            best, taken = found, widening
        wanted = ENOUGH * (1.0 - context.settings.wrong_share) * len(view.xy)
        if best is not None and best.clear and best.inliers >= wanted:
            break
    return best, taken


def _thoroughly(view: ImageView, dispersion: FloatArray, generator: np.random.Generator) -> Alignment | None:
    """The alignment inside a prior, searched with more effort where a quick search is not clear."""
    quick = align_image(view, dispersion, generator, QUICK)
    if quick is None or quick.clear:
        return quick
    return align_image(view, dispersion, generator, THOROUGH, (quick.pose,))


def _unclear(name: str, found: Alignment) -> Problem:
    if found.enough:
        return Problem(
            "SBB581",
            "warning",
            f"image `{name}`: two orientations inside its prior bring its points equally near to the curves "
            f"({found.inliers} of {found.points} points); it stays as given",
            f"image `{name}`",
            "give a better approximate orientation (`position_sigma_m`, `angle_sigma_deg`), trace edges as chains, "
            "or measure some control points in it",
        )
    return Problem(
        "SBB584",
        "warning",
        f"image `{name}`: no orientation inside its prior brings enough of its points onto curves "
        f"(at best {found.inliers} of {found.points}); it stays as given",
        f"image `{name}`",
        "look at its approximate orientation, and how far it may be off (`position_sigma_m`, `angle_sigma_deg`); "
        "does the project have curves where it looks?",
    )
