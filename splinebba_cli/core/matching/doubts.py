"""What a result of matching says about the input: image coordinates in a mirrored frame, a σ that is far too large.

A mirrored image fits nowhere, so that little is matched, at random.  Some images are matched again as if they were
mirrored: where that brings many times as many points onto curves, in every one of them, it is no chance.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from splinebba_cli.core.matching.known_curves.loop import match_known_curves
from splinebba_cli.core.matching.matches import MatchResult
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.network import FloatArray, IntArray, UnlabelledPoints
from splinebba_cli.core.result import Problem

_log = logging.getLogger(__name__)
LITTLE = 0.25  # matched share below which frames are doubted, and which another frame has to reach
TIMES = 5.0  # as many points that it has to bring onto curves
IMAGES = 2  # that are matched again
POINTS = 2000  # of each, about
FEWEST = 30  # matched points to judge their σ by
USUAL_MEDIAN = 0.6745  # of |d|/σ where σ is right
SMALL_MEDIAN = 0.2
NO_NOISE = 1e-3  # median of simulated data without noise
MIRRORED = (
    (
        (1.0, -1.0),
        "y mirrored",
        "y seems to point the other way than `image_coordinates` says: pixels count down",
    ),
    ((-1.0, 1.0), "x mirrored", "the images seem to be seen from their back, or x to point left"),
    (
        (-1.0, -1.0),
        "the images turned by half a turn",
        "κ seems to be off by 180°, or the images are upside down",
    ),
)


def doubts(result: MatchResult, settings: MatchSettings) -> tuple[Problem, ...]:
    """Warnings about the input as a whole.

    Parameters
    ----------
    result : MatchResult
    settings : MatchSettings
        With which it was made.

    Returns
    -------
    tuple of Problem
        SBB336 and SBB337.
    """
    return tuple(
        problem for problem in (_mirrored(result, settings), _large_sigma(result)) if problem is not None
    )


def _large_sigma(result: MatchResult) -> Problem | None:
    """SBB337: points lie much nearer to their curves than their σ says."""
    matches = result.matches
    distance = np.abs(matches.distance[(matches.curve >= 0) & (matches.curve < len(result.given.curves))])
    if len(distance) < FEWEST or (matches.curve >= 0).mean() < LITTLE:
        return None  # wide gates of orientations that were not found make distances small
    median = float(np.median(distance))
    if not NO_NOISE < median < SMALL_MEDIAN:
        return None
    return Problem(
        "SBB337",
        "warning",
        f"half of the matched points lie within {median:.2g} σ of their splines, where {USUAL_MEDIAN:.2g} σ is usual: "
        "the σ of the image points is much too large, it seems",
        "matching",
        "a smaller `sigma_px` (`sigma_um`, `sigma_mm`) makes gates narrower, and determines orientations better",
    )


def _mirrored(result: MatchResult, settings: MatchSettings) -> Problem | None:
    """SBB336: in another frame many times as many points would be matched."""
    given, found = result.given, result.matches.curve >= 0
    if not given.curves or len(given.curve_observations) or found.mean() >= LITTLE:
        return None
    chosen = [_some_points(given.unlabelled, image) for image in _largest_images(result)]
    if not chosen:
        return None
    quick = replace(settings, new_curves=False, orient_freely=False)
    for flip, what, help in MIRRORED:
        _log.info("matching %d images again with %s", len(chosen), what)
        counts = list(_counts(result, chosen, np.array(flip), quick))
        if counts:
            here = sum(int(found[rows].sum()) for rows in chosen)
            numbers = f"{sum(counts)} of {sum(map(len, chosen))} points of {len(chosen)} images"
            message = f"with {what} {numbers} would be matched, as given {here}"
            return Problem("SBB336", "warning", message, "matching", help)
    return None


def _counts(
    result: MatchResult, chosen: list[IntArray], flip: FloatArray, settings: MatchSettings
) -> Iterator[int]:
    """Points of every image that are matched in another frame; nothing where one image speaks against it."""
    counts = []
    for rows in chosen:
        network = replace(result.given, unlabelled=_flipped(result.given.unlabelled, rows, flip))
        count = int((match_known_curves(network, settings).matches.curve >= 0).sum())
        if count < LITTLE * len(rows) or count < TIMES * (result.matches.curve[rows] >= 0).sum():
            return
        counts.append(count)
    yield from counts


def _largest_images(result: MatchResult) -> list[int]:
    """Images with an orientation and the most points."""
    images = result.given.images
    number = np.bincount(result.given.unlabelled.image, minlength=len(images.ids)) * images.has_orientation
    order = np.argsort(-number, kind="stable")[:IMAGES]
    return [int(image) for image in order if number[image]]


def _some_points(points: UnlabelledPoints, image: int) -> IntArray:
    """Rows of whole chains of an image, spread over its table."""
    rows = np.flatnonzero(points.image == image)
    chain = points.chain[rows]
    begins = np.concatenate([[True], (chain[1:] != chain[:-1]) | (chain[1:] < 0)])
    every = max(1, round(len(rows) / POINTS))
    return np.asarray(rows[(np.cumsum(begins) - 1) % every == 0])


def _flipped(points: UnlabelledPoints, rows: IntArray, flip: FloatArray) -> UnlabelledPoints:
    """Some points in a mirrored or turned frame."""
    return replace(
        points,
        image=points.image[rows],
        photo_xy=points.photo_xy[rows] * flip,
        sigma=points.sigma[rows],
        chain=points.chain[rows],
        direction=points.direction[rows] * flip.prod(),  # the other way round is the same
        group=None if points.group is None else points.group[rows],
        excluded=None if points.excluded is None else points.excluded[rows],
    )
