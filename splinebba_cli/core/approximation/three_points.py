"""Exterior orientation from three points: all solutions, many triplets at once.

With unit rays d_i and points X_i the depths l_i > 0 satisfy three quadratic equations

    l' M_ij l = |X_i - X_j|^2,    l' M_ij l = l_i^2 + l_j^2 - 2 (d_i . d_j) l_i l_j

Two combinations D_1, D_2 of the three have no right-hand side.  A member s D_1 + t D_2 of their pencil is
singular at a root of a cubic; it is a pair of planes, and either plane meets another member in two directions
of l.  One cubic and two quadratic equations give the at most four solutions, without the elimination that
makes the classical quartic ill-conditioned for symmetric triangles.

References
----------
Persson and Nordberg (2018), Lambda Twist, ECCV; Grunert (1841) for the equations.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

PAIRS = ((0, 1), (0, 2), (1, 2))


@dataclass(frozen=True)
class ThreePointSolutions:
    """Every solution of every triplet, one row a solution."""

    triplet: IntArray  # (s,) index of the triplet
    rotation: FloatArray  # (s, 3, 3) object from photo
    position: FloatArray  # (s, 3) metres


def orient_from_three_points(rays: FloatArray, object_xyz: FloatArray) -> ThreePointSolutions:
    """All exterior orientations that see three points along three rays.

    Parameters
    ----------
    rays : (k, 3, 3) float
        Triplet, point, coordinate: directions (x, y, -c) in the photo frame, any length.
    object_xyz : (k, 3, 3) float, metres
        Triplet, point, coordinate.

    Returns
    -------
    ThreePointSolutions
        Up to four for each triplet; all points lie in front of the camera.
    """
    unit = rays / np.linalg.norm(rays, axis=2, keepdims=True)
    depths = _depths(unit, object_xyz)  # (k, 4, 3)
    valid = np.isfinite(depths).all(axis=2) & (depths > 0.0).all(axis=2)
    triplet, solution = np.nonzero(valid)
    photo = depths[triplet, solution][:, :, None] * unit[triplet]
    points = object_xyz[triplet]
    rotation = _frame(points) @ np.swapaxes(_frame(photo), 1, 2)
    position = points.mean(axis=1) - np.einsum("sij,sj->si", rotation, photo.mean(axis=1))
    usable = np.isfinite(rotation).all(axis=(1, 2)) & np.isfinite(position).all(axis=1)
    return ThreePointSolutions(triplet[usable].astype(np.int64), rotation[usable], position[usable])


def _depths(unit: FloatArray, object_xyz: FloatArray) -> FloatArray:
    """Depths of the four candidate solutions, (k, 4, 3); NaN where a solution is not real."""
    distance, forms = _quadratic_forms(unit, object_xyz)
    first = forms[:, 0] * distance[:, 2, None, None] - forms[:, 2] * distance[:, 0, None, None]
    second = forms[:, 1] * distance[:, 2, None, None] - forms[:, 2] * distance[:, 1, None, None]
    first = first / np.linalg.norm(first, axis=(1, 2), keepdims=True)
    second = second / np.linalg.norm(second, axis=(1, 2), keepdims=True)
    s, t = _singular_member(first, second)
    singular = s[:, None, None] * first + t[:, None, None] * second
    other = -t[:, None, None] * first + s[:, None, None] * second
    direction = _common_directions(singular, other)
    direction = direction * np.sign(direction.sum(axis=2, keepdims=True))
    size = np.einsum("kni,kpij,knj->kn", direction, forms, direction)
    with np.errstate(invalid="ignore", divide="ignore"):
        scale = np.sqrt(distance.sum(axis=1)[:, None] / size)
    return np.asarray(direction * scale[:, :, None])


def _quadratic_forms(unit: FloatArray, object_xyz: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Squared distances (k, 3) and the matrices M_ij (k, 3, 3, 3) of the pairs 12, 13, 23."""
    forms = np.zeros((len(unit), 3, 3, 3))
    distance = np.empty((len(unit), 3))
    for row, (i, j) in enumerate(PAIRS):
        distance[:, row] = np.sum((object_xyz[:, i] - object_xyz[:, j]) ** 2, axis=1)
        forms[:, row, i, i] = forms[:, row, j, j] = 1.0
        forms[:, row, i, j] = forms[:, row, j, i] = -np.sum(unit[:, i] * unit[:, j], axis=1)
    return distance, forms


def _singular_member(first: FloatArray, second: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(s, t) of unit length with det(s first + t second) = 0.

    The determinant is a cubic in t/s.  Where its leading coefficient is smaller than the constant one, the
    roles of the two matrices are exchanged, so that no root runs to infinity.
    """
    cofactor_first, cofactor_second = _cofactor(first), _cofactor(second)
    c0, c3 = np.linalg.det(first), np.linalg.det(second)
    c1 = np.sum(cofactor_first * second, axis=(1, 2))
    c2 = np.sum(cofactor_second * first, axis=(1, 2))
    swap = np.abs(c3) < np.abs(c0)
    lead, constant = np.where(swap, c0, c3), np.where(swap, c3, c0)
    square, linear = np.where(swap, c1, c2), np.where(swap, c2, c1)
    trivial = np.abs(lead) < 1e-14  # both vanish: t/s = 0 is a root
    safe = np.where(trivial, 1.0, lead)
    root = np.where(trivial, 0.0, _real_cubic_root(square / safe, linear / safe, constant / safe))
    length = np.hypot(1.0, root)
    large, small = root / length, 1.0 / length
    return np.where(swap, large, small), np.where(swap, small, large)


def _cofactor(matrix: FloatArray) -> FloatArray:
    rows = matrix[:, 0], matrix[:, 1], matrix[:, 2]
    return np.stack(
        [np.cross(rows[1], rows[2]), np.cross(rows[2], rows[0]), np.cross(rows[0], rows[1])], axis=1
    )


def _real_cubic_root(square: FloatArray, linear: FloatArray, constant: FloatArray) -> FloatArray:
    """A real root of x^3 + square x^2 + linear x + constant: the best separated one, polished."""
    companion = np.zeros((len(square), 3, 3))
    companion[:, 1, 0] = companion[:, 2, 1] = 1.0
    companion[:, 0, 2], companion[:, 1, 2], companion[:, 2, 2] = -constant, -linear, -square
    roots = np.linalg.eigvals(companion)
    real = np.abs(roots.imag) <= 1e-6 * (1.0 + np.abs(roots))
    slope = np.abs((3.0 * roots + 2.0 * square[:, None]) * roots + linear[:, None])
    choice = np.argmax(np.where(real, slope, -1.0 - np.abs(roots.imag)), axis=1)
    x = roots[np.arange(len(roots)), choice].real
    for _ in range(3):
        derivative = (3.0 * x + 2.0 * square) * x + linear
        value = ((x + square) * x + linear) * x + constant
        x = x - np.where(derivative == 0.0, 0.0, value / np.where(derivative == 0.0, 1.0, derivative))
    return np.asarray(x)


def _common_directions(singular: FloatArray, other: FloatArray) -> FloatArray:
    """Directions l with l' singular l = l' other l = 0, (k, 4, 3); NaN where they are not real."""
    value, vector = np.linalg.eigh(singular)  # ascending: negative, nearly zero, positive
    low = np.sqrt(np.maximum(-value[:, 0], 0.0))[:, None] * vector[:, :, 0]
    high = np.sqrt(np.maximum(value[:, 2], 0.0))[:, None] * vector[:, :, 2]
    axis = vector[:, :, 1]
    out = np.full((len(singular), 4, 3), np.nan)
    for row, normal in enumerate((high + low, high - low)):
        across = np.cross(normal, axis)
        length = np.linalg.norm(across, axis=1, keepdims=True)
        across = across / np.where(length == 0.0, np.nan, length)
        a = np.einsum("ki,kij,kj->k", axis, other, axis)
        b = np.einsum("ki,kij,kj->k", axis, other, across)
        c = np.einsum("ki,kij,kj->k", across, other, across)
        square = b * b - a * c
        double = (square < 0.0) & (square > -1e-12)  # on the dangerous cylinder, up to rounding
        with np.errstate(invalid="ignore"):
            root = np.sqrt(np.where(double, 0.0, square))
        k = -(b + np.where(b < 0.0, -1.0, 1.0) * root)
        out[:, 2 * row] = k[:, None] * axis + a[:, None] * across
        out[:, 2 * row + 1] = c[:, None] * axis + k[:, None] * across
    return out


def _frame(triangle: FloatArray) -> FloatArray:
    """Orthonormal frames of triangles as columns, (s, 3, 3)."""
    first = triangle[:, 1] - triangle[:, 0]
    normal = np.cross(first, triangle[:, 2] - triangle[:, 0])
    with np.errstate(invalid="ignore", divide="ignore"):
        first = first / np.linalg.norm(first, axis=1, keepdims=True)
        normal = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    return np.stack([first, np.cross(normal, first), normal], axis=2)


def triplet_areas(points: FloatArray) -> FloatArray:
    """Twice the area of triangles, (k, 3, 2 or 3) -> (k,)."""
    first, second = points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]
    square = (
        np.sum(first * first, axis=1) * np.sum(second * second, axis=1) - np.sum(first * second, axis=1) ** 2
    )
    return np.asarray(np.sqrt(np.maximum(square, 0.0)))


def spread_ratio(points: FloatArray) -> float:
    """Second over first singular value of centred points: 0 for points on one line."""
    values = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return float(values[1] / values[0]) if values[0] > 0.0 else 0.0


def finite_rows(*arrays: FloatArray) -> BoolArray:
    """Rows that are finite in every array, (n,)."""
    return np.asarray(np.isfinite(np.hstack(arrays)).all(axis=1))
