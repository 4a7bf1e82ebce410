"""What a person should know about a finished adjustment, before the figures."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.quality.curve_columns import CurveColumns
from splinebba_cli.core.quality.length_text import length_text
from splinebba_cli.core.result import AdjustmentResult, GlobalTest, Problem

LITTLE = 0.02  # share of the redundancy that conditions may take without a word
WEAK_RATIO = 3.0  # larger lateral semi-axis over its median in the network
WORTH_A_WORD = 0.05  # share of a curve's length
NAMED = 5  # weak curves, the weakest first


def findings(result: AdjustmentResult) -> tuple[Problem, ...]:
    """Problems and suggestions, errors first."""
    found = [*_global(result), *_curves(result), *_correlations(result)]
    rank = {"error": 0, "warning": 1, "info": 2}
    return tuple(sorted(found, key=lambda problem: rank[problem.severity]))


def _global(result: AdjustmentResult) -> list[Problem]:
    statistics = result.statistics
    found = []
    test = statistics.global_test
    if test is None:
        found.append(
            Problem(
                "SBB530",
                "warning",
                "there is no redundancy: nothing is checked, the variance is the a-priori one",
                "adjustment",
                "measure more features or give more control",
            )
        )
    elif not test.passed and not (_small(test) and result.network.settings.outliers.reweights):
        small = _small(test)
        found.append(
            Problem(
                "SBB531",
                "warning",
                f"the global test fails: σ̂₀ = {statistics.sigma0:.4g} is too {'small' if small else 'large'} "
                f"for σ₀ = {statistics.sigma0_prior:.4g}",
                "adjustment",
                "the given σ of the observations are too large"
                if small
                else "look at the largest residuals for gross errors; then at the model (distortion, knots too far "
                "apart); then raise the σ of the observations",
            )
        )
    share = statistics.condition_redundancy / max(statistics.redundancy, 1)
    if share > LITTLE:
        found.append(
            Problem(
                "SBB532",
                "info",
                f"the gauge conditions take {statistics.condition_redundancy:.1f} of the redundancy "
                f"of {statistics.redundancy} and {statistics.condition_cost:.3g} of v'Pv",
                "adjustment",
                "use fewer knots where the measurements do not determine them",
            )
        )
    return found


def _small(test: GlobalTest) -> bool:
    """Whether it fails because the residuals are small; reduced weights alone make them so."""
    return test.statistic < test.lower


def _curves(result: AdjustmentResult) -> list[Problem]:
    """Curves with stretches much weaker across the curve than is usual in this network."""
    columns = CurveColumns.of(result.curves)
    across, bounds = columns.sample_across, columns.sample_bounds
    given = result.network.curves
    own = np.array([curve.role != "control" for curve in given], dtype=bool)
    tied = np.flatnonzero(own & (np.diff(bounds) > 0))
    if not len(tied):
        return []
    major = across[np.repeat(own, np.diff(bounds)), 0]
    usual = float(np.median(major))
    count = np.diff(bounds)[tied]
    first = np.cumsum(count) - count
    share = np.add.reduceat((major > WEAK_RATIO * usual).astype(float), first) / count
    largest = np.maximum.reduceat(major, first)
    chosen = np.flatnonzero((share > WORTH_A_WORD) & (usual > 0.0))
    weak = [(float(largest[k]), float(share[k]), given[tied[k]].id) for k in chosen.tolist()]
    weak.sort(key=lambda one: (-one[0], one[2]))
    more = f" (and {len(weak) - NAMED} more)" if len(weak) > NAMED else ""
    return [
        Problem(
            "SBB533",
            "info",
            f"spline `{name}`: {100 * share:.0f} % of its length is weak across the curve "
            f"(σ up to {length_text(largest)}, usual in this network {length_text(usual)})"
            + (more if number == NAMED - 1 else ""),
            f"spline `{name}`",
            "the images see these parts from directions that lie in one plane with the curve: add images from "
            "another side, or do not use the weak direction",
        )
        for number, (largest, share, name) in enumerate(weak[:NAMED])
    ]


def _correlations(result: AdjustmentResult) -> list[Problem]:
    diagonal = np.sqrt(np.maximum(np.einsum("mii->mi", result.images.dispersion), 1e-300))
    correlation = np.abs(result.images.dispersion / (diagonal[:, :, None] * diagonal[:, None, :]))
    off = correlation * (1.0 - np.eye(6))
    high = np.flatnonzero((off > result.network.settings.correlation_threshold).any(axis=(1, 2)))
    if not len(high):
        return []
    names = ", ".join(f"`{result.network.images.ids[k]}`" for k in high[:6])
    more = f" and {len(high) - 6} more" if len(high) > 6 else ""
    images = "image" if len(high) == 1 else "images"
    return [
        Problem(
            "SBB534",
            "info",
            f"orientation unknowns of {images} {names}{more} are correlated by more than "
            f"{100 * result.network.settings.correlation_threshold:g} %",
            "images",
            "usual for narrow angles over flat ground; positions and angles are good only together",
        )
    ]
