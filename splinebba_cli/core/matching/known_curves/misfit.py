"""Whether matched points fit their curves as they should, and whether another principal distance would fit better.

An image moves so as to hide a wrong principal distance c: over a flat object a change of height does the same.  What
is left speaks of c all the same.  With residuals d across held curves, A = d d / d(theta, X0) and g = d d / dc, all
whitened, the part of g that no orientation explains is

    r = g - A (A'A)^-1 A'g      image by image,      dc = r'd / r'r,      sigma^2 = s^2 / r'r,

summed over the images of a camera: the estimate that an adjustment with c among its unknowns gives from these points.
Errors of a traced chain go together, so that a share of its points counts as independent (runs.py).
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.camera.collinearity import project_with_jacobian
from splinebba_cli.core.matching.known_curves.loop_context import LoopContext, Progress
from splinebba_cli.core.matching.known_curves.round_adjustment import Round
from splinebba_cli.core.matching.known_curves.runs import EFFECTIVE
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.result import Problem

FEWEST = 12  # points of an image
CERTAIN = 4.0  # sigma
NOTICEABLE = (
    0.1  # sigma of points: root mean square of the residuals that another principal distance takes away
)


def misfits(context: LoopContext, progress: Progress, solved: Round | None) -> list[Problem]:
    """Warnings about points that fit their curves badly, and about principal distances.

    Parameters
    ----------
    progress : after the last adjustment, with the labels that took part in it
    """
    if solved is None:
        return []
    return [*_worse_than_stated(solved), *_principal_distances(context, progress)]


def _worse_than_stated(solved: Round) -> list[Problem]:
    fit = solved.fit
    if fit.noise <= 1.0:
        return []
    return [
        Problem(
            "SBB593",
            "warning",
            f"the matched points fit their splines worse than their σ says: σ̂₀ {fit.sigma0:.2f}, by chance at most "
            f"{fit.largest:.2f}",
            "matching",
            "look at the σ of the chains, at the camera (principal distance, distortion, pixel size), and at the "
            "shapes of splines whose points are far away (table of splines)",
        )
    ]


def _principal_distances(context: LoopContext, progress: Progress) -> list[Problem]:
    """Cameras whose principal distance the points on held curves contradict."""
    labels, network = progress.labels, context.network
    rows = labels.rows[context.start.held[labels.curve[labels.rows]]]
    rows = rows[np.argsort(context.network.unlabelled.image[rows], kind="stable")]
    d, a, g = _equations(context, progress, rows)
    image = network.unlabelled.image[rows]
    bounds = np.flatnonzero(np.diff(image, prepend=-1, append=-1))
    problems = []
    for number, camera in enumerate(network.cameras):
        left = np.zeros(len(rows))
        for first, last in zip(bounds[:-1].tolist(), bounds[1:].tolist(), strict=True):
            if network.images.camera[image[first]] == number and last - first >= FEWEST:
                left[first:last] = _unexplained(a[first:last], g[first:last])
        taken = np.flatnonzero(left)
        square = float(left @ left)
        if not square:
            continue
        found = float(left @ d) / square
        chained = float(np.mean(network.unlabelled.chain[rows[taken]] >= 0))
        size = max(1.0, float(np.sqrt(np.mean(d[taken] ** 2)))) / np.sqrt(1.0 - (1.0 - EFFECTIVE) * chained)
        sigma = size / np.sqrt(square)
        if abs(found) > CERTAIN * sigma and abs(found) * np.sqrt(square / len(taken)) > NOTICEABLE:
            problems.append(_problem(camera.id, camera.principal_distance_mm, found, sigma))
    return problems


def _equations(
    context: LoopContext, progress: Progress, rows: IntArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Whitened distances of points across their curves (k,), derivatives by theta, X0 (k, 6) and by c (k,)."""
    scene, labels = context.scene(progress.state), progress.labels
    image, distance = scene.image[rows], scene.principal_distance[scene.image[rows]]
    xyz, rate = scene.curves.evaluate(scene.coefficients, labels.curve[rows], labels.location[rows], (0, 1))
    xy, jacobian = project_with_jacobian(distance, scene.rotation[image], scene.position[image], xyz)
    whitening = scene.whitening[rows]
    along = np.einsum("kij,kjl,kl->ki", whitening, jacobian.object_xyz, rate)
    normal = np.column_stack([-along[:, 1], along[:, 0]]) / np.linalg.norm(along, axis=1, keepdims=True)
    across = np.einsum("ki,kij->kj", normal, whitening)
    d = np.sum(across * (scene.xy[rows] - xy), axis=1)
    return d, np.einsum("ki,kij->kj", across, jacobian.orientation), np.sum(across * xy, axis=1) / distance


def _unexplained(a: FloatArray, g: FloatArray) -> FloatArray:
    """Part (k,) of g that no combination of the columns of a (k, 6) gives."""
    scaled = a / np.maximum(np.linalg.norm(a, axis=0), 1e-300)
    return np.asarray(g - scaled @ np.linalg.lstsq(scaled, g, rcond=1e-10)[0])


def _problem(name: str, declared: float, found: float, sigma: float) -> Problem:
    digits = max(0, 1 - int(np.floor(np.log10(sigma))))
    return Problem(
        "SBB585",
        "warning",
        f"camera `{name}`: the matched points ask for a principal distance of {declared + found:.{digits}f} ± "
        f"{sigma:.{digits}f} mm; {declared:g} mm are declared",
        f"camera `{name}`",
        "compare the principal distance, the pixel size and the distortion with the calibration of the camera; "
        "resampled images have another one",
    )
