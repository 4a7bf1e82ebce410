"""Places of fragments by weighted least squares: a point of the reference image and lines of the others.

    two equations of the reference image      (x - x_measured) / sigma
    one equation of every other image         n' (x - x_chain) / sigma,   n across its chain
    one equation where the depth is bridged   (depth - depth_interpolated) / sigma

The dispersion is the inverse of the normal matrix, 3 x 3, of the a priori sigmas.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.matching.fragments.hypotheses import on_chain
from splinebba_cli.core.matching.fragments.labelled_points import LabelledPoints
from splinebba_cli.core.matching.fragments.runs import Runs
from splinebba_cli.core.matching.fragments.traced_chains import TracedChains
from splinebba_cli.core.matching.fragments.views import Views
from splinebba_cli.core.network import FloatArray, IntArray

STEPS = 3


def triangulated(
    views: Views, chains: TracedChains, labels: LabelledPoints, runs: Runs, points: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Object points of chain points with a depth.

    Parameters
    ----------
    points : (k,) distinct chain points

    Returns
    -------
    xyz : (k, 3) metres
    dispersion : (k, 3, 3)
    """
    image, ray = chains.image[points], chains.ray[points]
    depth, sigma = runs.depth[points], runs.sigma[points]
    xyz = views.position[image] + depth[:, None] * ray
    number = np.full(len(chains), -1)
    number[points] = np.arange(len(points))
    rows = np.flatnonzero(number[labels.link_point] >= 0)
    place = number[labels.link_point[rows]]
    first = np.minimum(labels.link_place[rows].astype(np.int64), len(chains) - 2)
    fraction = labels.link_place[rows] - first
    there = chains.image[first]
    on_line = chains.xy[first] + fraction[:, None] * (chains.xy[first + 1] - chains.xy[first])
    tangent, _, line_sigma = on_chain(chains, first, fraction)
    normal = np.column_stack([-tangent[:, 1], tangent[:, 0]])
    unit = ray / np.linalg.norm(ray, axis=1, keepdims=True)
    loose = np.where(runs.bridged[points], sigma * np.linalg.norm(ray, axis=1), np.inf)
    held = unit[:, :, None] * unit[:, None, :] / (loose**2)[:, None, None]
    start = xyz
    for _ in range(STEPS):
        xy, jacobian = views.project_with_jacobian(image, xyz)
        scaled = jacobian / chains.sigma[points][:, None, None]
        error = (chains.xy[points] - xy) / chains.sigma[points][:, None]
        information = np.matmul(np.swapaxes(scaled, 1, 2), scaled) + held
        right = np.einsum("kri,kr->ki", scaled, error) + np.einsum("kij,kj->ki", held, start - xyz)
        xy_there, jacobian_there = views.project_with_jacobian(there, xyz[place])
        line = np.einsum("kr,kri->ki", normal, jacobian_there) / line_sigma[:, None]
        miss = np.sum(normal * (on_line - xy_there), axis=1) / line_sigma
        np.add.at(information, place, line[:, :, None] * line[:, None, :])
        np.add.at(right, place, line * miss[:, None])
        xyz = xyz + np.linalg.solve(information, right[:, :, None])[:, :, 0]
    return xyz, np.linalg.inv(information)


def sigmas_across(dispersion: FloatArray, along: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Smallest and largest sigma across unit directions, (k,) metres each."""
    across = np.eye(3) - along[:, :, None] * along[:, None, :]
    value = np.linalg.eigvalsh(np.matmul(across, np.matmul(dispersion, across)))
    sigma = np.sqrt(np.maximum(value, 0.0))
    return sigma[:, 1], sigma[:, 2]
