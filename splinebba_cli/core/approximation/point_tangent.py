"""Exterior orientation from two points with tangents: all solutions, many pairs at once.

Two rays d_i with depths l_i > 0 see two points X_i at the distance L.  In the plane of the rays, e1 along d_2 - d_1
and e2 along d_1 + d_2, the photo sees the chord X_2 - X_1 in the direction

    e(theta) = cos(theta) e1 + sin(theta) e2,    l_2 + l_1 = L cos(theta) / cos(w),    l_2 - l_1 = L sin(theta) / sin(w)

w is half the angle between -d_1 and d_2, and |theta| < w says that both points lie before the camera.  What remains is
the turn psi about the chord.  A tangent T_i with components (a, y, z) along and across the chord lies in the plane of
its ray and of the measured direction, whose normal is m_i = (p, q, r) in the frame e1, e2, e1 x e2:

    f_i = a h + g (y cos psi - z sin psi) + r (y sin psi + z cos psi) = 0,
    h = p cos(theta) + q sin(theta),    g = q cos(theta) - p sin(theta)

Both equations are linear in cos psi and sin psi; their elimination leaves a trigonometric polynomial of degree four in
theta, hence at most eight solutions.  Its roots inside (-w, w) are polished, with psi, by Newton steps on f.

References
----------
Fabbri, Giblin and Kimia (2012), Camera pose estimation using first-order curve differential geometry, ECCV, for the
problem and its number of solutions.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.curves.bernstein import basis_values, value_and_slope
from splinebba_cli.core.curves.rising_roots import rising_roots
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

ALONG_CHORD = 1e-6  # sine between tangent and chord, below which the tangent says nothing
SETTLED = 1e-9  # |f| of a solution, unit vectors
ROUNDING = 1e-15  # |f| that no step makes smaller
TOUCHES = 1e-5  # of the polynomial: an extremum so near to 0 may be one root, or two
VANISHES = 1e-13  # of the polynomial: its solutions are not isolated
PARALLEL = 0.2  # sine of the angle of two equations in psi that count as nearly parallel
NEWTON_STEPS = 7
CHUNK = 8_000  # pairs that are solved together: arrays that stay in the cache
NODES = np.cos(np.pi * (np.arange(9) + 0.5) / 9.0)
BERNSTEIN_OF_VALUES = np.linalg.inv(basis_values(8, 0.5 * (1.0 + NODES)))


@dataclass(frozen=True)
class PointTangentSolutions:
    """Every solution of every pair, one row a solution."""

    pair: IntArray  # (s,) index of the pair
    rotation: FloatArray  # (s, 3, 3) object from photo
    position: FloatArray  # (s, 3) metres
    same_sense: BoolArray  # (s, 2) the tangent is seen in the sense of the measured direction, not against it


@dataclass(frozen=True)
class ChordFrame:
    """Pairs in the frames of their chords, (k,) or (k, 2) each; see the head of the file."""

    e: FloatArray  # (k, 3, 3) columns e1, e2, n in the photo frame
    b: FloatArray  # (k, 3, 3) rows: chord and two directions across it in the object frame
    length: FloatArray  # L
    width: FloatArray  # w
    m: FloatArray  # (k, 2, 3) p, q, r
    t: FloatArray  # (k, 2, 3) a, y, z

    def rows(self, rows: IntArray) -> ChordFrame:
        """Some of the pairs."""
        return ChordFrame(
            self.e[rows], self.b[rows], self.length[rows], self.width[rows], self.m[rows], self.t[rows]
        )


def orient_from_point_tangents(
    rays: FloatArray, directions: FloatArray, object_xyz: FloatArray, tangents: FloatArray
) -> PointTangentSolutions:
    """All exterior orientations that see two points along two rays, and their tangents in two directions.

    Parameters
    ----------
    rays : (k, 2, 3) float
        Pair, point, coordinate: directions (x, y, -c) in the photo frame, any length.
    directions : (k, 2, 2) float
        Of the projected tangents in the photo, any length; known up to half a turn (see `same_sense`).
    object_xyz : (k, 2, 3) float, metres
    tangents : (k, 2, 3) float
        In the object frame, any length.

    Returns
    -------
    PointTangentSolutions
        Both points lie in front of the camera.  A pair has none where a tangent runs along the chord or the ray, or
        where its solutions are not isolated.
    """
    parts = [
        _solve(rays[first:last], directions[first:last], object_xyz[first:last], tangents[first:last], first)
        for first, last in ((n, n + CHUNK) for n in range(0, len(rays), CHUNK))
    ]
    if not parts:
        return PointTangentSolutions(
            np.zeros(0, np.int64), np.zeros((0, 3, 3)), np.zeros((0, 3)), np.zeros((0, 2), bool)
        )
    return PointTangentSolutions(
        np.concatenate([part.pair for part in parts]),
        np.concatenate([part.rotation for part in parts]),
        np.concatenate([part.position for part in parts]),
        np.concatenate([part.same_sense for part in parts]),
    )


def _solve(
    rays: FloatArray, directions: FloatArray, object_xyz: FloatArray, tangents: FloatArray, first: int
) -> PointTangentSolutions:
    unit = rays / np.linalg.norm(rays, axis=2, keepdims=True)
    frame, usable = chord_frames(unit, directions, object_xyz, tangents)
    kept = np.flatnonzero(usable)
    frame = frame.rows(kept)
    pair, theta = _roots(frame)
    rows, psi = _turns(frame.rows(pair), theta)
    pair, theta = pair[rows], theta[rows]
    theta, psi, settled = _polish(frame.rows(pair), theta, psi)
    settled &= np.abs(theta) < frame.width[pair]
    settled[settled] = _first_of_equals(pair[settled], theta[settled], psi[settled])
    pair, theta, psi = pair[settled], theta[settled], psi[settled]
    own = frame.rows(pair)
    rotation = _rotation(own, theta, psi)
    which = kept[pair]
    near = 0.5 * own.length * (np.cos(theta) / np.cos(own.width) - np.sin(theta) / np.sin(own.width))
    position = object_xyz[which, 0] - near[:, None] * np.einsum("sij,sj->si", rotation, unit[which, 0])
    seen = np.einsum("sji,spj->spi", rotation, tangents[which])
    ray = rays[which]
    flow = seen[:, :, :2] - ray[:, :, :2] / ray[:, :, 2:] * seen[:, :, 2:]
    same = np.sum(flow * directions[which], axis=2) > 0.0
    return PointTangentSolutions((first + which).astype(np.int64), rotation, position, same)


def chord_frames(
    unit: FloatArray, directions: FloatArray, object_xyz: FloatArray, tangents: FloatArray
) -> tuple[ChordFrame, BoolArray]:
    """Frames of pairs, and which pairs can have isolated solutions; unit rays."""
    with np.errstate(invalid="ignore", divide="ignore"):
        e1 = _normalized(unit[:, 1] - unit[:, 0])
        e2 = _normalized(unit[:, 1] + unit[:, 0])
        e = np.stack([e1, e2, np.cross(e1, e2)], axis=2)
        chord = object_xyz[:, 1] - object_xyz[:, 0]
        length = np.linalg.norm(chord, axis=1)
        along = chord / length[:, None]
        across = _normalized(np.cross(along, np.eye(3)[np.argmin(np.abs(along), axis=1)]))
        b = np.stack([along, across, np.cross(along, across)], axis=1)
        flat = np.concatenate([directions, np.zeros((*directions.shape[:2], 1))], axis=2)
        m = _normalized(np.cross(unit, flat))
        t = _normalized(tangents)
        frame = ChordFrame(
            e, b, length, np.arctan2(np.linalg.norm(unit[:, 1] + unit[:, 0], axis=1),
                                     np.linalg.norm(unit[:, 1] - unit[:, 0], axis=1)),
            np.einsum("kji,kpj->kpi", e, m), np.einsum("kij,kpj->kpi", b, t),
        )  # fmt: skip
        usable = np.isfinite(frame.m).all(axis=(1, 2)) & np.isfinite(frame.t).all(axis=(1, 2))
        usable &= (np.hypot(frame.t[:, :, 1], frame.t[:, :, 2]) > ALONG_CHORD).all(axis=1)
    return frame, np.asarray(usable)


def _normalized(vectors: FloatArray) -> FloatArray:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))


def _linear_forms(frame: ChordFrame, theta: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """C, S, K of C cos psi + S sin psi + K = 0, (2, k, q) each, at theta (k, q)."""
    cosine, sine = np.cos(theta), np.sin(theta)
    p, q, r = (frame.m[:, :, i].T[:, :, None] for i in range(3))
    a, y, z = (frame.t[:, :, i].T[:, :, None] for i in range(3))
    g = q * cosine - p * sine
    return y * g + z * r, y * r - z * g, a * (p * cosine + q * sine)


def _eliminated(frame: ChordFrame, theta: FloatArray) -> FloatArray:
    """The trigonometric polynomial F(theta), (k, q)."""
    c, s, k = _linear_forms(frame, theta)
    cosine, sine = k[1] * s[0] - k[0] * s[1], k[0] * c[1] - k[1] * c[0]
    return np.asarray(cosine**2 + sine**2 - (c[0] * s[1] - c[1] * s[0]) ** 2)


def _roots(frame: ChordFrame) -> tuple[IntArray, FloatArray]:
    """Pairs and values of theta, one row a root of F inside (-w, w); where F touches 0 one, or two next to each other.

    With s = tan(theta/2) = sigma tan(w/2), (1 + s^2)^4 F is a polynomial of degree eight in sigma, whose roots inside
    (-1, 1) are wanted.  It is interpolated in Bernstein's form, whose roots are found where its sign changes; extrema
    next to 0 are roots too, which rounding or noise may have parted.
    """
    s = np.tan(0.5 * frame.width)[:, None] * NODES
    value = (1.0 + s * s) ** 4 * _eliminated(frame, 2.0 * np.arctan(s))
    b = BERNSTEIN_OF_VALUES @ value.T
    size = np.abs(b).max(axis=0)
    usable = np.flatnonzero(size > VANISHES)
    b = b[:, usable]
    column, t = _where_it_changes(b)
    more = np.flatnonzero(
        np.count_nonzero(np.diff(np.sign(b), axis=0), axis=0) > np.bincount(column, minlength=len(usable))
    )
    turning, extremum = _where_it_changes(np.diff(b[:, more], axis=0))
    height, _ = value_and_slope(b[:, more[turning]], extremum)
    touching = np.abs(height) < TOUCHES * size[usable[more[turning]]]
    pair = usable[np.concatenate([column, more[turning[touching]]])]
    sigma = 2.0 * np.concatenate([t, extremum[touching]]) - 1.0
    theta = 2.0 * np.arctan(sigma * np.tan(0.5 * frame.width[pair]))
    return pair.astype(np.int64), theta


def _where_it_changes(b: FloatArray) -> tuple[IntArray, FloatArray]:
    """Polynomials (d + 1, k) in Bernstein's form and their roots in (0, 1), one row a change of sign."""
    roots = rising_roots(np.concatenate([b, -b], axis=1))
    return roots.column % max(b.shape[1], 1), roots.t


def _turns(frame: ChordFrame, theta: FloatArray) -> tuple[IntArray, FloatArray]:
    """Rows and starting values of psi that belong to roots theta (s,).

    Where the two equations are nearly parallel, two roots of nearly the same theta differ in psi: then both values that
    the stronger equation admits are starts.
    """
    c, s, k = (form[:, :, 0] for form in _linear_forms(frame, theta[:, None]))
    size = np.hypot(c, s)
    determinant = c[0] * s[1] - c[1] * s[0]
    sign = np.sign(determinant)
    single = np.arctan2(sign * (k[0] * c[1] - k[1] * c[0]), sign * (k[1] * s[0] - k[0] * s[1]))
    parallel = np.flatnonzero(np.abs(determinant) < PARALLEL * size[0] * size[1])
    strong = (np.argmax(size[:, parallel], axis=0), parallel)
    with np.errstate(invalid="ignore", divide="ignore"):
        half = np.arccos(np.clip(-k[strong] / size[strong], -1.0, 1.0))
    middle = np.arctan2(s[strong], c[strong])
    rows = np.concatenate([np.arange(len(theta)), parallel, parallel])
    psi = np.concatenate([single, middle + half, middle - half])
    good = np.isfinite(psi)
    return rows[good].astype(np.int64), psi[good]


def tangent_equations(frame: ChordFrame, theta: FloatArray, psi: FloatArray) -> tuple[FloatArray, FloatArray]:
    """f_1, f_2 (s, 2) and their derivatives with respect to theta and psi (s, 2, 2)."""
    p, q, r = (frame.m[:, :, i] for i in range(3))
    a, y, z = (frame.t[:, :, i] for i in range(3))
    cosine, sine = np.cos(theta)[:, None], np.sin(theta)[:, None]
    turned_cosine, turned_sine = np.cos(psi)[:, None], np.sin(psi)[:, None]
    h, g = p * cosine + q * sine, q * cosine - p * sine
    first, second = y * turned_cosine - z * turned_sine, y * turned_sine + z * turned_cosine
    value = a * h + g * first + r * second
    return value, np.stack([a * g - h * first, r * first - g * second], axis=2)


def _polish(
    frame: ChordFrame, theta: FloatArray, psi: FloatArray
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Newton steps in theta and psi, and which of them settled."""
    theta, psi = theta.copy(), psi.copy()
    settled = np.zeros(len(theta), dtype=bool)
    own, part = np.arange(len(theta)), frame
    for step in range(NEWTON_STEPS + 1):
        value, rate = tangent_equations(part, theta[own], psi[own])
        size = np.abs(value).max(axis=1, initial=0.0)
        settled[own] = size < SETTLED
        going = np.flatnonzero(size > ROUNDING)
        if step == NEWTON_STEPS or not len(going):
            break
        own, part, value, rate = own[going], part.rows(going), value[going], rate[going]
        determinant = rate[:, 0, 0] * rate[:, 1, 1] - rate[:, 0, 1] * rate[:, 1, 0]
        with np.errstate(invalid="ignore", divide="ignore"):
            dtheta = (value[:, 0] * rate[:, 1, 1] - value[:, 1] * rate[:, 0, 1]) / determinant
            dpsi = (value[:, 1] * rate[:, 0, 0] - value[:, 0] * rate[:, 1, 0]) / determinant
        good = np.isfinite(dtheta) & np.isfinite(dpsi)
        theta[own] -= np.where(good, np.clip(dtheta, -0.1, 0.1), 0.0)
        psi[own] -= np.where(good, np.clip(dpsi, -0.3, 0.3), 0.0)
    return theta, psi, settled


def _first_of_equals(pair: IntArray, theta: FloatArray, psi: FloatArray) -> BoolArray:
    """Leaves out solutions of a pair that another start has found too, (s,)."""
    first = np.ones(len(pair), dtype=bool)
    if not len(pair):
        return first
    order = np.lexsort((theta, pair))
    for step in range(1, 6):
        a, b = order[:-step], order[step:]
        equal = (pair[a] == pair[b]) & (np.abs(theta[a] - theta[b]) < 1e-7)
        equal &= np.abs(np.sin(0.5 * (psi[a] - psi[b]))) < 1e-7
        first[b[equal]] = False
    return first


def _rotation(frame: ChordFrame, theta: FloatArray, psi: FloatArray) -> FloatArray:
    """Object from photo, (s, 3, 3)."""
    in_plane = np.zeros((len(theta), 3, 3))
    in_plane[:, 0, 0] = in_plane[:, 1, 1] = np.cos(theta)
    in_plane[:, 1, 0] = np.sin(theta)
    in_plane[:, 0, 1] = -in_plane[:, 1, 0]
    in_plane[:, 2, 2] = 1.0
    about_chord = np.zeros_like(in_plane)
    about_chord[:, 0, 0] = 1.0
    about_chord[:, 1, 1] = about_chord[:, 2, 2] = np.cos(psi)
    about_chord[:, 2, 1] = np.sin(psi)
    about_chord[:, 1, 2] = -about_chord[:, 2, 1]
    photo_from_object = frame.e @ in_plane @ about_chord @ frame.b
    return np.asarray(np.swapaxes(photo_from_object, 1, 2))
