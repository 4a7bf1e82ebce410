"""How observations are tested, revised and weighted: the choices of quality control."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Multiplicity = Literal["none", "sidak", "bonferroni"]
TestStatistic = Literal["w", "tau"]
OutlierMethod = Literal["none", "snooping", "huber", "cauchy", "tukey", "danish"]
OutlierStart = Literal["least_squares", "high_breakdown"]


@dataclass(frozen=True)
class LocalTesting:
    """Tests of single observations (Baarda 1968, Pope 1976)."""

    alpha: float = 0.001  # of one test, or of all together where multiplicity is not "none"
    multiplicity: Multiplicity = "none"
    power: float = 0.8  # 1 - beta, of the minimal detectable bias
    statistic: TestStatistic = "w"  # w: sigma0 is known; tau: it is estimated


@dataclass(frozen=True)
class OutlierPolicy:
    """What is done with gross errors."""

    method: OutlierMethod = "none"
    start: OutlierStart = "least_squares"
    max_share: float = 0.1  # of the observations that snooping may reject
    max_rounds: int = 200
    at_once: int = 1  # rejections in one round, of different images and features

    @property
    def reweights(self) -> bool:
        """Whether residuals reduce weights: sigma0 is then smaller than the noise of all observations together."""
        return self.method not in ("none", "snooping")


@dataclass(frozen=True)
class WeightPolicy:
    """Whether the variances of the observation groups are estimated."""

    variance_components: bool = False
    max_rounds: int = 20
