"""Variance of unit weight of every group of observations (Helmert's estimate, from one adjustment).

Whitened, with R_gh the block of R = I - A Q A' of groups g and h, c_g = v_g'v_g and s_g the true over the given
variance of group g,

    E c_g = sum_h M_gh s_h,   M_gh = |R_gh|^2 (sum of squares),   sum_h M_gh = r_g = tr R_gg

so that s = M^-1 c is unbiased whatever weights were used.  With S the diagonal matrix of the s of all observations,

    Cov c = 2 K,   K_gh = |(R S R)_gh|^2,   Cov s = 2 M^-1 K M^-1   (at the true weights K = M)
    f_g = 2 s_g^2 / Var s_g      equivalent degrees of freedom: f_g s_g is about chi-square of f_g degrees,
                                 sigma(s_g^1/2) = (s_g / (2 f_g))^1/2

(Foerstner's estimate c_g / r_g is the same where all s are 1).  M and K are exact for small groups; of large ones
|R_gh z|^2 is averaged over vectors z of random signs, whose mean it is.
(Helmert 1907; Foerstner 1979; Koch 1999, section 3.6; Hutchinson 1990)
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.quality.group_sums import GroupSum
from splinebba_cli.core.quality.residual_projector import ResidualProjector

EXACT = 64  # rows of a group for which M is exact
SAMPLED_ROWS = 8000  # random signs drawn for a large group: its M is good to sqrt(2 / 8000)
FEWEST_SAMPLES = 2
TOO_LITTLE = 1.0  # redundancy of a group whose variance is not separated from the others
BLOCK_ENTRIES = 8_000_000
MATERIAL = 0.3  # of the logarithm of a variance, from which K is not M


@dataclass(frozen=True)
class GroupVariances:
    """Estimates of all groups in their order."""

    variance: FloatArray  # (G,) s, true over given; NaN where nothing is left over
    freedom: FloatArray  # (G,) f
    at_best: FloatArray  # (G,) f if the weights were right: 1 / (M^-1)_gg, whatever the residuals are

    @property
    def sigma(self) -> FloatArray:
        """Square roots of the variances, (G,)."""
        return np.asarray(np.sqrt(self.variance))


def group_variances(projector: ResidualProjector, sums: list[GroupSum]) -> GroupVariances:
    """Helmert's estimate; Foerstner's c / r where a group has too little redundancy, or the first is negative."""
    squares = np.array([each.squares for each in sums])
    redundancy = np.array([each.redundancy for each in sums])
    simple = np.divide(squares, redundancy, out=np.full(len(sums), np.nan), where=redundancy > 1e-6)
    variance, freedom = simple.copy(), np.maximum(redundancy, 0.0)
    active = np.flatnonzero(redundancy >= TOO_LITTLE)
    if not len(active):
        return GroupVariances(variance, freedom, freedom)
    chosen = [sums[k] for k in active]
    matrix = squared_blocks(projector, chosen)
    inverse = np.linalg.pinv(matrix, rcond=1e-6, hermitian=True)
    rest = redundancy[active] - matrix.sum(axis=1)  # of groups left out and of conditions, taken with s = 1
    found = inverse @ (squares[active] - rest)
    found = np.where(found > 0.1 * simple[active], found, simple[active])
    spread = matrix
    if (np.abs(np.log(np.maximum(found, 1e-12))) > MATERIAL).any():
        spread = squared_blocks(projector, chosen, found)
    dispersion = np.diag(inverse @ spread @ inverse)  # half the variance of s
    at_best = freedom.copy()
    at_best[active] = 1.0 / np.maximum(np.diag(inverse), 1.0 / redundancy[active])
    relative = np.divide(dispersion, found**2, out=np.diag(inverse).copy(), where=found > 0.0)
    freedom[active] = 1.0 / np.maximum(relative, 1.0 / redundancy[active])
    variance[active] = found
    return GroupVariances(variance, freedom, at_best)


def squared_blocks(
    projector: ResidualProjector, sums: list[GroupSum], variances: FloatArray | None = None
) -> FloatArray:
    """M of the groups, or K with their variances s (G,); symmetric.

    Of groups with arc lengths or tangents there is only the diagonal, as that of r independent residuals.
    """
    rows = projector.design.ranges.count
    matrix = np.zeros((len(sums), len(sums)))
    for g, own in enumerate(sums):
        if not own.complete:
            matrix[g, g] = own.redundancy * (1.0 if variances is None else variances[g] ** 2)
    complete = [g for g, own in enumerate(sums) if own.complete]
    for probes in _batches(sums, complete, rows):
        errors = np.zeros((rows, sum(probe.signs.shape[1] for probe in probes)))
        owner = np.repeat([probe.group for probe in probes], [probe.signs.shape[1] for probe in probes])
        weight = np.repeat([probe.weight for probe in probes], [probe.signs.shape[1] for probe in probes])
        for probe in probes:
            errors[np.ix_(sums[probe.group].rows, np.flatnonzero(owner == probe.group))] = probe.signs
        shown = projector.project(errors)
        if variances is not None:
            for each, variance in zip(sums, variances, strict=True):
                shown[each.rows] *= variance
            shown = projector.project(shown)
        for h in complete:
            squares = np.einsum("nk,nk->k", shown[sums[h].rows], shown[sums[h].rows]) * weight
            np.add.at(matrix[:, h], owner, squares)
    return 0.5 * (matrix + matrix.T)


@dataclass(frozen=True)
class _Probe:
    """Errors of a group (n, k), with the weight of their squares."""

    group: int
    signs: FloatArray
    weight: float


def _batches(sums: list[GroupSum], groups: list[int], rows: int) -> Iterator[list[_Probe]]:
    """Probes of all groups, as many together as fit."""
    generator, waiting, size = np.random.default_rng(1), list[_Probe](), 0
    for group in groups:
        for signs, weight in _probes(sums[group], rows, generator):
            if (waiting and (size + signs.shape[1]) * rows > BLOCK_ENTRIES) or any(
                p.group == group for p in waiting
            ):
                yield waiting
                waiting, size = [], 0
            waiting.append(_Probe(group, signs, weight))
            size += signs.shape[1]
    if waiting:
        yield waiting


def _probes(own: GroupSum, rows: int, generator: np.random.Generator) -> list[tuple[FloatArray, float]]:
    """Errors of a group in batches (n, k), with the weight of their squares."""
    n = len(own.rows)
    if n <= EXACT:
        return [(np.eye(n), 1.0)]
    samples = max(FEWEST_SAMPLES, -(-SAMPLED_ROWS // n))
    width = max(1, BLOCK_ENTRIES // rows)
    sizes = [min(width, samples - begin) for begin in range(0, samples, width)]
    return [(generator.choice([-1.0, 1.0], size=(n, size)), 1.0 / samples) for size in sizes]
