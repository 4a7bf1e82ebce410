"""Trends of the residuals over the image format, over all images of a camera, and over the order of the images.

    image mean         b = (1, 0), (0, 1)                                of one image
    radial trend       b = rho (x, y) / r, rho^3 (x, y) / r              rho = r / r_max of the camera
    tangential trend   b = rho (-y, x) / r, rho^3 (-y, x) / r
    drift              b = t (1, 0), t (0, 1)                            t from -1 (first image) to 1 (last)

Every one is a bias of the measured photo coordinates and is tested with its exact distribution (bias_tests.py): what
orientations, points and curves take up of it is accounted for.  The residuals of a shift of one image are nearly all
taken up by its orientation; a radial trend of third order is not.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from splinebba_cli.core.evidence import SystematicEffect
from splinebba_cli.core.network import FloatArray, IntArray, Network
from splinebba_cli.core.quality.bias_tests import BiasTest, TestFamily, bias_tests
from splinebba_cli.core.quality.photo_rows import PhotoRows
from splinebba_cli.core.quality.residual_projector import ResidualProjector
from splinebba_cli.core.result import Statistics
from splinebba_cli.core.row_groups import split_by

FEWEST = 10  # rows of an image or a camera
FEWEST_IMAGES = 5  # of a drift
UM = 1e3
BOTH = np.eye(2)[None]


def image_means(
    projector: ResidualProjector, rows: PhotoRows, statistics: Statistics
) -> list[SystematicEffect]:
    """Tests of the mean residual vector of every image, or of those with the largest ones."""
    network = projector.assembler.prepared.network
    count = np.bincount(rows.image, minlength=len(network.images.ids))
    images = np.flatnonzero(count >= FEWEST)
    family = _family(network, statistics, len(images))
    number = projector.affordable // 2
    if len(images) > number:
        size = _largest_means(rows, len(count))[images]
        images = images[np.sort(np.argsort(-size, kind="stable")[:number])]
    order = np.argsort(rows.image, kind="stable")
    bounds = np.searchsorted(rows.image[order], np.stack([images, images + 1]))
    members = [order[begin:end] for begin, end in bounds.T.tolist()]
    blocks = [rows.directions(own, np.repeat(BOTH, len(own), axis=0)) for own in members]
    found = []
    tests = bias_tests(projector, blocks, family)
    for k, own, test in zip(images.tolist(), members, tests, strict=True):
        if test.freedom:
            subject = f"image `{network.images.ids[k]}`"
            text = f"mean residual ({_signed(-UM * test.plain[0])}, {_signed(-UM * test.plain[1])}) µm"
            estimate = UM * float(np.hypot(*test.plain))
            found.append(_effect("image mean", subject, estimate, test, family, len(own), text))
    return found


def lens_trends(
    projector: ResidualProjector, rows: PhotoRows, statistics: Statistics
) -> list[SystematicEffect]:
    """Tests of radial and tangential trends of every camera."""
    network = projector.assembler.prepared.network
    cameras = split_by(rows.camera, len(network.cameras))
    chosen = [(number, own) for number, own in enumerate(cameras) if len(own) >= FEWEST]
    family = _family(network, statistics, 2 * len(chosen))
    blocks = [block for _, own in chosen for block in _lens_directions(rows, own)]
    tests = bias_tests(projector, blocks, family)
    found = []
    for k, (number, own) in enumerate(chosen):
        radial, cubic, tangential, turned = tests[4 * k : 4 * k + 4]
        largest = _largest_radius(rows, own)
        subject = f"camera `{network.cameras[number].id}`"
        if radial.freedom:
            text = f"{_estimate(cubic)} at r = {largest:.0f} mm"
            if cubic.freedom:
                text += f"; K1 = {-cubic.estimate[0] / largest**3:.2g} mm⁻²".replace("-", "−")
            estimate = UM * _first(cubic)
            found.append(_effect("radial trend", subject, estimate, radial, family, len(own), text))
        if tangential.freedom:
            text = f"{_estimate(turned)} at r = {largest:.0f} mm, from x towards y"
            estimate = UM * _first(turned)
            found.append(_effect("tangential trend", subject, estimate, tangential, family, len(own), text))
    return found


def drifts(projector: ResidualProjector, rows: PhotoRows, statistics: Statistics) -> list[SystematicEffect]:
    """Tests of a shift that grows with the order of the images, camera by camera."""
    network = projector.assembler.prepared.network
    blocks, subjects, counts = [], [], []
    for camera, own in zip(network.cameras, split_by(rows.camera, len(network.cameras)), strict=True):
        images = np.unique(rows.image[own])
        if len(images) >= FEWEST_IMAGES:
            time = np.linspace(-1.0, 1.0, len(images))[np.searchsorted(images, rows.image[own])]
            blocks.append(rows.directions(own, time[:, None, None] * BOTH))
            subjects.append(f"camera `{camera.id}`")
            counts.append(len(own))
    family = _family(network, statistics, len(blocks))
    found = []
    for subject, count, test in zip(subjects, counts, bias_tests(projector, blocks, family), strict=True):
        if test.freedom:
            text = f"residuals of ({_signed(-UM * test.plain[0])}, {_signed(-UM * test.plain[1])}) µm in the last image"
            found.append(
                _effect("drift", subject, UM * float(np.hypot(*test.plain)), test, family, count, text)
            )
    return found


def _family(network: Network, statistics: Statistics, tests: int) -> TestFamily:
    return TestFamily.of(statistics, network.settings.testing, network.settings.alpha, max(tests, 1))


def _lens_directions(rows: PhotoRows, own: IntArray) -> list[sparse.csc_array]:
    """Radial of both orders, of the third, tangential of both orders, of the third."""
    xy = rows.xy[own] / _largest_radius(rows, own)
    across = np.stack([-xy[:, 1], xy[:, 0]], axis=1)
    square = np.sum(xy**2, axis=1)[:, None]
    out = []
    for vector in (xy, across):
        both = np.stack([vector, vector * square], axis=1)
        out += [rows.directions(own, both), rows.directions(own, both[:, 1:])]
    return out


def _largest_radius(rows: PhotoRows, own: IntArray) -> float:
    return float(np.hypot(rows.xy[own, 0], rows.xy[own, 1]).max())


def _largest_means(rows: PhotoRows, count: int) -> FloatArray:
    """Size of C'v over that of C, of the two directions of every image, (count,)."""
    square = np.zeros(count)
    for axis in range(2):
        moment = np.bincount(rows.image, rows.sensitivity[:, axis] * rows.residual, minlength=count)
        size = np.bincount(rows.image, rows.sensitivity[:, axis] ** 2, minlength=count)
        square += moment**2 / np.maximum(size, 1e-300)
    return np.asarray(np.sqrt(square))


def _effect(
    kind: str, subject: str, estimate: float, test: BiasTest, family: TestFamily, observations: int, text: str
) -> SystematicEffect:
    critical = family.critical(test.freedom)
    return SystematicEffect(
        kind=kind,  # type: ignore[arg-type]
        subject=subject,
        estimate=estimate,
        unit="µm",
        statistic=test.statistic,
        critical=critical,
        significant=bool(test.statistic > critical),
        observations=observations,
        detail=text,
        shown=test.shown,
        probability=family.of_all(test.probability),
    )


def _first(test: BiasTest) -> float:
    return float(test.estimate[0]) if test.freedom else float("nan")


def _estimate(test: BiasTest) -> str:
    if not test.freedom:
        return "a trend of third order is taken up: none"
    return f"{_signed(UM * test.estimate[0])} µm (σ {UM * test.sigma[0]:.2g} µm)"


def _signed(value: float) -> str:
    return f"{value:+.2g}".replace("-", "−")
