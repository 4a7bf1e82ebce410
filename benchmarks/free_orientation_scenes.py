"""Networks whose images have no orientation and whose curves no labels, with what is true of them."""

from __future__ import annotations

import gzip
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from splinebba_cli.core.network import (
    Camera,
    Curve,
    CurveObservations,
    FloatArray,
    Images,
    IntArray,
    Network,
    PointObservations,
    Points,
    UnlabelledPoints,
)

PIXEL_MM = 0.005
SYNTHETIC_FOCAL_PX = (2900.4032342559799, 2900.2454199096264)
SYNTHETIC_CENTRE_PX = (249.80449516746715, -205.3632271924675)
WRONG_LENGTH = (0.15, 0.6)  # of wrong chains, over the width of what the right ones cover


@dataclass(frozen=True)
class FreeScene:
    """A network without orientations, and the truth."""

    network: Network
    rotation: FloatArray  # (m, 3, 3)
    position: FloatArray  # (m, 3)
    label: IntArray  # (n,) curve of every unlabelled point, -1: of none


def synthetic_curves(
    folder: Path, seed: int, noise_px: float = 0.5, wrong_share: float = 0.3, cut: bool = False
) -> FreeScene:
    """20 views of 35 curves (Fabbri & Kimia, IJCV 2016, CC-BY); metres; the four tiny curves at the origin left out.

    Parameters
    ----------
    wrong_share : of the chains of an image, that belong to no curve
    cut : whether every chain shows a random 60 to 100 % of its curve
    """
    rng = np.random.default_rng(seed)
    xyz, ids = 1e-3 * _table(folder / "crv-3D-pts.txt.gz"), np.loadtxt(folder / "crv-ids.txt").astype(int)
    used = [k for k in np.unique(ids) if k > 3]
    curves = tuple(_control_curve(str(k), xyz[ids == k]) for k in used)
    axes = [np.loadtxt(folder / f"frame_{k:04d}.extrinsic") for k in range(20)]
    rotation = np.array([rows[:3].T @ np.diag([1.0, -1.0, -1.0]) for rows in axes])
    position = 1e-3 * np.array([rows[3] for rows in axes])
    chains: list[tuple[int, int, FloatArray]] = []
    for image in range(20):
        pixel = _table(folder / f"frame_{image:04d}-pts-2D.txt.gz")
        photo = PIXEL_MM * (pixel - SYNTHETIC_CENTRE_PX) * np.array([1.0, -1.0])
        right = [(image, number, photo[ids == k]) for number, k in enumerate(used)]
        chains += right + [(image, -1, xy) for xy in wrong_chains(rng, [xy for *_, xy in right], wrong_share)]
    fx, fy = SYNTHETIC_FOCAL_PX
    camera = Camera(
        "c", PIXEL_MM * fy, np.zeros(2), np.zeros(3), np.zeros(2), np.array([fy / fx - 1.0, 0.0]), PIXEL_MM
    )
    return free_scene(rng, camera, curves, rotation, position, chains, noise_px * PIXEL_MM, cut)


def free_scene(
    rng: np.random.Generator,
    camera: Camera,
    curves: tuple[Curve, ...],
    rotation: FloatArray,
    position: FloatArray,
    chains: list[tuple[int, int, FloatArray]],
    sigma_mm: float,
    cut: bool = False,
    noise: bool = True,
) -> FreeScene:
    """A scene of chains (image, curve, points) in random order and sense; `noise` is for points that are exact."""
    order = rng.permutation(len(chains))
    parts, image, label, number = [], [], [], []
    for row, k in enumerate(order):
        i, curve, xy = chains[k]
        xy = _cut(rng, xy) if cut else xy
        xy = xy[::-1] if rng.random() < 0.5 else xy
        parts.append(xy + rng.normal(0.0, sigma_mm if noise else 0.0, xy.shape))
        image += [i] * len(xy)
        label += [curve] * len(xy)
        number += [row] * len(xy)
    count = len(image)
    points = UnlabelledPoints(
        np.array(image), np.vstack(parts), np.full((count, 2), sigma_mm), np.array(number),
        np.full(count, np.nan), tuple(str(k) for k in range(len(chains))),
    )  # fmt: skip
    network = without_orientations(camera, curves, len(rotation), points)
    return FreeScene(network, rotation, position, np.array(label))


def without_orientations(
    camera: Camera, curves: tuple[Curve, ...], images: int, points: UnlabelledPoints
) -> Network:
    """A network of unlabelled points in images of which nothing is known."""
    none, two, three = np.zeros(0, dtype=np.int64), np.zeros((0, 2)), np.zeros((0, 3))
    unknown = Images(
        tuple(str(k) for k in range(images)), np.zeros(images, dtype=np.int64), np.full((images, 3, 3), np.nan),
        np.full((images, 3), np.nan), ("omega-phi-kappa",) * images, np.full((images, 6), np.nan),
        np.full((images, 6), np.inf),
    )  # fmt: skip
    observed = CurveObservations(none, none, two, two, np.zeros(0), none)
    return Network(
        np.zeros(3), (camera,), unknown, Points((), (), three, three, three), curves,
        PointObservations(none, none, two, two), observed, unlabelled=points,
    )  # fmt: skip


def wrong_chains(rng: np.random.Generator, right: list[FloatArray], share: float) -> list[FloatArray]:
    """Lines and arcs at random places among right chains, so many that they are a share of all."""
    everything = np.vstack(right)
    low, high = everything.min(axis=0), everything.max(axis=0)
    width = float((high - low).max())
    step = float(np.median([np.linalg.norm(np.diff(xy, axis=0), axis=1).mean() for xy in right]))
    chains = []
    for _ in range(round(len(right) * share / (1.0 - share))):
        length = width * rng.uniform(*WRONG_LENGTH)
        place = np.linspace(-0.5, 0.5, max(int(length / step), 8)) * length
        bend = rng.normal(0.0, 1.5) / length * (rng.random() < 0.6)
        heading = rng.uniform(0.0, 2.0 * np.pi) + bend * place
        xy = np.cumsum(np.column_stack([np.cos(heading), np.sin(heading)]), axis=0) * (length / len(place))
        chains.append(xy - xy.mean(axis=0) + rng.uniform(low, high))
    return chains


def orientation_errors(
    scene: FreeScene, image: int, rotation: FloatArray, position: FloatArray
) -> tuple[float, float]:
    """Angle (degrees) and distance of the perspective centre (metres) from the truth."""
    turn = scene.rotation[image].T @ rotation
    angle = np.arccos(np.clip(0.5 * (np.trace(turn) - 1.0), -1.0, 1.0))
    return float(np.degrees(angle)), float(np.linalg.norm(position - scene.position[image]))


def _control_curve(name: str, xyz: FloatArray) -> Curve:
    """A fixed natural spline through samples (of about 40 of them)."""
    step = np.linalg.norm(np.diff(xyz, axis=0), axis=1)
    closed = bool(np.linalg.norm(xyz[-1] - xyz[0]) < 1.5 * np.median(step))
    straight = np.linalg.svd(xyz - xyz.mean(axis=0), compute_uv=False)[1] < 1e-9
    if straight:
        return Curve(name, "control", "straight_line", xyz[[0, -1]], np.zeros((2, 3)))
    rows = np.unique(np.linspace(0, len(xyz) - 1, min(len(xyz), 60)).round().astype(int))
    rows = rows[:-1] if closed and len(rows) == 60 else rows
    return Curve(name, "control", "natural_cubic", xyz[rows], np.zeros((len(rows), 3)), closed=closed)


def _cut(rng: np.random.Generator, xy: FloatArray) -> FloatArray:
    count = max(int(len(xy) * rng.uniform(0.6, 1.0)), 3)
    start = rng.integers(0, len(xy) - count + 1)
    return xy[start : start + count]


def _table(path: Path) -> FloatArray:
    with gzip.open(path, "rt") as file:
        return np.loadtxt(file)
