"""Null directions in the user's words: first what is undetermined inside one feature, then what moves together.

A basis of the null space is arbitrary: the vectors of a decomposition mix features that have nothing to do with
each other.  With orthonormal rows V (k, N) and the columns V_g of one feature, V_g V_g' has the eigenvalue 1 for
every direction that lives in this feature alone; what remains is orthogonal to all of these.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from splinebba_cli.core.estimation.null_names import ORIENTATION, describe
from splinebba_cli.core.estimation.parameters import ORIENTATION_SIZE, ParameterLayout
from splinebba_cli.core.estimation.rank_diagnosis import NullSpace
from splinebba_cli.core.network import FloatArray, IntArray, Network
from splinebba_cli.core.result import Problem

OWN = 1.0 - 1e-6  # eigenvalue from which a direction belongs to one feature alone
MUCH = 0.05  # share of the largest entry that is worth a name


def null_problems(null: NullSpace, layout: ParameterLayout, network: Network) -> tuple[Problem, ...]:
    """What the null directions of a network mean: one problem a feature, in the order of the project.

    Parameters
    ----------
    null : NullSpace
        Vectors over the reduced unknowns, then the points.
    """
    if not len(null.vectors):
        return ()
    vectors = np.linalg.qr(null.vectors.T)[0].T
    left = np.eye(len(vectors))  # projector on the directions without a feature of their own
    problems = []
    for columns in _features(layout, network):
        block = vectors[:, columns]
        eigenvalues, combination = np.linalg.eigh(block @ block.T)
        own = combination[:, eigenvalues > OWN]
        if own.shape[1]:
            left -= own @ own.T
            problems.append(_of_feature(own.T @ vectors, layout, network))
    eigenvalues, combination = np.linalg.eigh(left)
    rest = combination[:, eigenvalues > 0.5].T @ vectors
    if len(rest):
        problems.append(describe(np.sqrt(np.sum(rest**2, axis=0)), layout, network))
    return tuple(problems)


def _features(layout: ParameterLayout, network: Network) -> Iterable[IntArray]:
    """Numbers of the unknowns of every image, curve and point."""
    yield from np.arange(layout.image_mask.size).reshape(-1, ORIENTATION_SIZE)
    curve = np.repeat(layout.node_curve, layout.node_sizes)
    order = np.argsort(curve, kind="stable")
    bounds = np.searchsorted(curve[order], np.arange(len(network.curves) + 1))
    for k in range(len(network.curves)):
        yield order[bounds[k] : bounds[k + 1]]
    yield from layout.unknown_of_point


def _of_feature(own: FloatArray, layout: ParameterLayout, network: Network) -> Problem:
    """The directions (q, N) of one feature as one problem."""
    strength = np.sqrt(np.sum(own**2, axis=0))
    problem = describe(strength, layout, network)
    images = strength[: layout.image_mask.size].reshape(-1, ORIENTATION_SIZE)
    if not images.any() or not images.max() > 0.5:
        return problem
    image = int(np.argmax(images.max(axis=1)))
    named = [
        name
        for name, part in zip(ORIENTATION, images[image], strict=True)
        if part > MUCH * images[image].max()
    ]
    who, parts = f"image `{network.images.ids[image]}`", f"{', '.join(named[:-1])} and {named[-1]}"
    if len(named) == 1:
        message = f"{who}: {named[0]} is not determined by its measurements"
    elif len(own) == 1:
        message = f"{who}: {parts} are not separable by its measurements"
    else:
        message = f"{who}: {len(own)} combinations of {parts} are not determined by its measurements"
    return Problem(problem.code, "error", message, who, problem.help)
