"""Orientations of images of which nothing is known: from labelled points and tangents, from chains, through tie points.

In order: what labelled control gives (:mod:`splinebba_cli.core.approximation.orientation`); single images from their
unlabelled chains before known curves (search.py); images that follow through points which those
found so far intersect.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.approximation.orientation import approximate_orientations
from splinebba_cli.core.approximation.resection import Resection
from splinebba_cli.core.matching.free_orientation.chains import ImageChains, image_chains
from splinebba_cli.core.matching.free_orientation.places import KnownCurves, Places
from splinebba_cli.core.matching.free_orientation.prior import PriorFilter
from splinebba_cli.core.matching.free_orientation.refinement import FittedOrientation
from splinebba_cli.core.matching.free_orientation.search import ImageSearch, SearchResult
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.network import Network
from splinebba_cli.core.result import Problem
from splinebba_cli.core.state import prepare

_log = logging.getLogger(__name__)

WEAK_POSITION = 0.05  # sigma of the perspective centre over its distance from the curves


@dataclass(frozen=True)
class FreeOrientations:
    """What was found for images without an orientation."""

    from_points: dict[int, Resection]  # images oriented from labelled points and tangents
    from_chains: dict[int, FittedOrientation]  # images oriented from unlabelled chains
    problems: tuple[Problem, ...]  # one for every image that stays without

    def apply(self, network: Network) -> Network:
        """The network with these orientations as approximate values."""
        images = network.images
        rotation, position = images.rotation.copy(), images.position.copy()
        found: dict[int, Resection | FittedOrientation] = {**self.from_points, **self.from_chains}
        for number, each in found.items():
            rotation[number], position[number] = each.rotation, each.position
        return replace(network, images=replace(images, rotation=rotation, position=position))


def orient_freely(network: Network, settings: MatchSettings | None = None) -> FreeOrientations:
    """Orientations of images that have none, and no complete prior, from whatever was measured in them.

    Parameters
    ----------
    network : Network
        Curves that are wholly fixed or have standard deviations count as known.  Single elements of a prior (a height,
        two angles) are kept to within five standard deviations.
    settings : MatchSettings, optional
        Its seed and its tolerance of directions are used.

    Returns
    -------
    FreeOrientations
        Never a guess: an image whose best orientation explains too little, or hardly more than another one, stays
        without, with the reason (SBB587, SBB588, SBB589).
    """
    settings = settings or MatchSettings()
    labelled = approximate_orientations(network)
    found = FreeOrientations(labelled.resolved, {}, ())
    reasons: dict[int, Problem] = {}
    if labelled.unresolved:
        chains, reasons = _from_chains(network, settings, sorted(labelled.unresolved))
        found = FreeOrientations(labelled.resolved, chains, ())
        if chains and len(network.point_observations):
            followers = approximate_orientations(found.apply(network)).resolved
            found = replace(found, from_points={**found.from_points, **followers})
    missing = [number for number in sorted(labelled.unresolved) if number not in found.from_chains]
    missing = [number for number in missing if number not in found.from_points]
    return replace(found, problems=tuple(reasons[number] for number in missing))


def _from_chains(
    network: Network, settings: MatchSettings, images: list[int]
) -> tuple[dict[int, FittedOrientation], dict[int, Problem]]:
    """Orientations of single images, and why others have none."""
    known = KnownCurves(prepare(network))
    ends = known.ends(network)
    found: dict[int, FittedOrientation] = {}
    reasons: dict[int, Problem] = {}
    for count, number in enumerate(images, start=1):
        name = network.images.ids[number]
        _log.info("image %s: searching for its orientation (%d of %d)", name, count, len(images))
        chains = image_chains(network, number)
        if chains is None or not len(known.used):
            reasons[number] = _nothing_to_search(network, number, chains is None)
            continue
        result = _search(network, settings, number, chains, known, ends)
        problem = _verdict(network, number, result, known)
        if problem is None and result.best is not None:
            found[number] = result.best
            _log.info("image %s: oriented from %d points", name, result.best.points)
        elif problem is not None:
            reasons[number] = problem
    return found, reasons


def _search(
    network: Network,
    settings: MatchSettings,
    number: int,
    chains: ImageChains,
    known: KnownCurves,
    ends: Places,
) -> SearchResult:
    prior = PriorFilter.of(network, number)
    seed = settings.seed + 1_000_003 * number
    return ImageSearch(chains, known, ends, prior, settings.direction_tolerance_rad, seed).run()


def _verdict(network: Network, number: int, result: SearchResult, known: KnownCurves) -> Problem | None:
    """Why the best orientation of a search is no answer; None where it is one."""
    name, best = network.images.ids[number], result.best
    if best is None or not result.explains:
        share = 0.0 if best is None else best.explained
        message = (
            f"image `{name}`: nowhere do the known curves explain its chains, at best {share:.0%} of them"
        )
        return _problem("SBB588", name, message)
    distance = float(np.median(np.linalg.norm(known.samples(50).xyz - best.position, axis=1)))
    weak = float(best.sigma[3:].max()) / distance
    if not result.unique:
        other = result.second / best.score
        message = (
            f"image `{name}` finds several orientations: another one fits {other:.0%} as well as the best"
        )
        return _problem("SBB589", name, message)
    if weak > WEAK_POSITION:
        message = f"image `{name}`: its chains hold the position to {weak:.0%} of the distance only"
        return _problem("SBB589", name, message)
    return None


def _nothing_to_search(network: Network, number: int, no_chains: bool) -> Problem:
    name = network.images.ids[number]
    what = "chains of unlabelled points" if no_chains else "curves of known shape in the project"
    return _problem(
        "SBB587", name, f"image `{name}` has no orientation, and there are no {what} to find one from"
    )


HELPS = {
    "SBB587": "give an approximate orientation; or control points, or control splines and chains traced along them",
    "SBB588": "give a rough orientation, or a prior of its position or height; or trace more of the control splines",
    "SBB589": "give a prior of its position or height, or more control splines in other directions and heights",
}


def _problem(code: str, name: str, message: str) -> Problem:
    return Problem(code, "warning", message, f"image `{name}`", HELPS[code])
