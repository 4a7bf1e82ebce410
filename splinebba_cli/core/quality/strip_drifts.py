"""Shift and drift of the prior positions (GNSS) of flight strips.

Images in the order of the project make a strip while they fly on: a new one begins where the direction from station to
station turns by more than 45 degrees, or where the step is more than three times the median one.  In every strip

    b = (1, t) (x, y, z),   t from -1 (first image) to 1 (last)

is a bias of six of its prior coordinates, tested with its exact distribution (bias_tests.py).  The usual model of
GNSS-supported aerial triangulation has such unknowns in every strip (Ackermann 1994).
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from splinebba_cli.core.evidence import SystematicEffect
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.quality.bias_tests import BiasTest, TestFamily, bias_tests
from splinebba_cli.core.quality.residual_projector import ResidualProjector
from splinebba_cli.core.result import Statistics

FEWEST_IMAGES = 3
TURN = np.cos(np.radians(45.0))
GAP = 3.0
WORTH = 4  # times the work of other families


def strips_of(position: FloatArray) -> list[IntArray]:
    """Numbers of the images of every strip, from perspective centres (m, 3) in their order."""
    if len(position) < 2:
        return [np.arange(len(position))]
    step = np.diff(position[:, :2], axis=0)
    length = np.linalg.norm(step, axis=1)
    unit = step / np.maximum(length, 1e-12)[:, None]
    begins, direction = [0], None
    for k in range(len(step)):
        turned = direction is not None and float(unit[k] @ direction) < TURN
        if turned or length[k] > GAP * np.median(length):
            begins.append(k + 1)
            direction = None
        else:
            direction = unit[k]
    return list(np.split(np.arange(len(position)), begins[1:]))


def strip_drifts(projector: ResidualProjector, statistics: Statistics) -> list[SystematicEffect]:
    """Tests of the strips of at least three images with prior positions, or of as many as are affordable."""
    network, at = projector.assembler.prepared.network, projector.solution.linearization
    q, c = np.nonzero(at.orientation_priors.active)
    positions = np.flatnonzero(c >= 3)
    positions = positions[np.argsort(at.orientation_priors.image[q[positions]], kind="stable")]
    image = at.orientation_priors.image[q[positions]]
    strips, blocks = [], []
    for strip in strips_of(at.state.position):
        own = slice(*np.searchsorted(image, [strip[0], strip[-1] + 1]).tolist()) if len(strip) else slice(0)
        known = np.unique(image[own])
        if len(known) >= FEWEST_IMAGES:
            strips.append(known)
            rows = positions[own]
            blocks.append(_directions(projector, rows, image[own], c[rows] - 3))
    settings = network.settings
    family = TestFamily.of(statistics, settings.testing, settings.alpha, max(len(blocks), 1))
    chosen = _worst(projector, blocks)
    strips, blocks = [strips[k] for k in chosen], [blocks[k] for k in chosen]
    tests = bias_tests(projector, blocks, family)
    ids = network.images.ids
    return [
        _effect(
            test, family, block.nnz // 2, f"prior positions of images `{ids[strip[0]]}` to `{ids[strip[-1]]}`"
        )
        for strip, block, test in zip(strips, blocks, tests, strict=True)
        if test.freedom
    ]


def _worst(projector: ResidualProjector, blocks: list[sparse.csc_array]) -> list[int]:
    """All strips, or as many as are affordable: those whose residuals have the largest sizes in the directions."""
    most = WORTH * projector.affordable // 6
    if len(blocks) <= most:
        return list(range(len(blocks)))
    residual = projector.design.residual
    size = [float(np.sum((block.T @ residual) ** 2 / block.power(2).sum(axis=0))) for block in blocks]
    return sorted(int(k) for k in np.argsort(-np.array(size), kind="stable")[:most])


def _directions(
    projector: ResidualProjector, rows: IntArray, image: IntArray, axis: IntArray
) -> sparse.csc_array:
    """Whitened biases (rows, 6) of one metre: shift in X, Y, Z, then drift."""
    sigma = projector.assembler.prepared.network.images.prior_sigma[image, 3 + axis]
    known = np.unique(image)
    time = np.linspace(-1.0, 1.0, len(known))[np.searchsorted(known, image)]
    place = projector.design.ranges.priors + rows
    values = np.concatenate([1.0 / sigma, time / sigma])
    columns = np.concatenate([axis, 3 + axis])
    shape = (projector.design.ranges.count, 6)
    return sparse.csc_array(sparse.coo_array((values, (np.tile(place, 2), columns)), shape=shape))


def _effect(test: BiasTest, family: TestFamily, observations: int, subject: str) -> SystematicEffect:
    critical = family.critical(test.freedom)
    shift, drift = (_text(test.estimate[part]) for part in (slice(0, 3), slice(3, 6)))
    return SystematicEffect(
        kind="strip",
        subject=subject,
        estimate=float(np.nanmax(np.abs(test.estimate), initial=0.0)),
        unit="m",
        statistic=test.statistic,
        critical=critical,
        significant=bool(test.statistic > critical),
        observations=observations,
        detail=f"shift ({shift}) m, drift to the last image ({drift}) m",
        shown=test.shown,
        probability=family.of_all(test.probability),
    )


def _text(values: FloatArray) -> str:
    return ", ".join("?" if np.isnan(v) else f"{v:+.2g}".replace("-", "−") for v in values)
