"""Images whose matched curves say less about some direction of the orientation than the assumed prior (theory, 6).

With the prior dispersion S and the one after the adjustment Q, the eigenvalues of S^-1/2 Q S^-1/2 are the shares of
the prior variances that are left: near 1 where the measurements say nothing.  A straight line gives two of the six
elements, parallel lines leave the shift along them, a plane curve seen from afar hardly tells a tilt from a shift.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.estimation.null_names import ORIENTATION
from splinebba_cli.core.matching.known_curves.loop_context import LoopContext, Progress
from splinebba_cli.core.network import BoolArray, FloatArray
from splinebba_cli.core.quality.orientation_dispersion import eop_transform
from splinebba_cli.core.result import Problem

LEFT = 0.5  # share of a prior variance beyond which the measurements decide nothing
LARGE = 0.5  # of the largest component of a direction: elements that are named


def undetermined_images(context: LoopContext, progress: Progress) -> tuple[BoolArray, tuple[Problem, ...]]:
    """Images (m,) with labelled points that do not determine them, and what is not determined."""
    network, prior = context.network, context.start.prior
    count = len(network.images.ids)
    seen = np.bincount(network.unlabelled.image[progress.labels.rows], minlength=count) > 0
    weak = np.zeros(count, dtype=bool)
    problems: list[Problem] = []
    transform = eop_transform(network.images, progress.state.rotation)
    for image in np.flatnonzero(seen & prior.known & prior.assumed.any(axis=1)).tolist():
        left, direction = _left(prior.dispersion[image], progress.uncertainty.eop[image])
        weak[image] = left > LEFT
        if weak[image]:
            problems.append(
                _problem(network.images.ids[image], transform[image] @ direction, prior.sigma[image], left)
            )
    return weak, tuple(problems)


def determined_by_labels(context: LoopContext, progress: Progress) -> BoolArray:
    """Images (m,) whose labelled points determine their orientation better than the prior in every direction."""
    prior = context.start.prior
    rows = progress.labels.rows
    seen = np.bincount(context.network.unlabelled.image[rows], minlength=len(prior.known)) > 0
    determined = seen & prior.known
    for image in np.flatnonzero(determined).tolist():
        after = progress.uncertainty.inflation * progress.uncertainty.eop[image]
        determined[image] = _left(prior.dispersion[image], after)[0] <= LEFT
    return determined


def _left(prior: FloatArray, after: FloatArray) -> tuple[float, FloatArray]:
    """Largest share of a prior variance that is left, and its direction (6,) in theta, X0."""
    value, vector = np.linalg.eigh(prior)
    free = value > 1e-12 * value.max()
    if not free.any():
        return 0.0, np.zeros(6)
    root = vector[:, free] * np.sqrt(value[free])
    inverse = vector[:, free] / np.sqrt(value[free])
    share, direction = np.linalg.eigh(inverse.T @ after @ inverse)
    return float(share[-1]), np.asarray(root @ direction[:, -1])


def _problem(name: str, direction: FloatArray, sigma: FloatArray, left: float) -> Problem:
    """A warning that names the elements of a direction (6,) of omega, phi, kappa, X0, Y0, Z0."""
    relative = np.abs(direction) / np.where(sigma > 0.0, sigma, np.inf)
    named = [ORIENTATION[k] for k in np.flatnonzero(relative > LARGE * relative.max())]
    elements = named[0] if len(named) == 1 else ", ".join(named[:-1]) + " and " + named[-1]
    return Problem(
        "SBB580",
        "warning",
        f"image `{name}`: the curves matched in it do not determine {elements} "
        f"({100.0 * np.sqrt(min(left, 1.0)):.0f} % of the assumed standard deviation is left); "
        "its orientation stays as given",
        f"image `{name}`",
        "match or measure more curves in it that run in other directions, control points, or give a prior orientation",
    )
