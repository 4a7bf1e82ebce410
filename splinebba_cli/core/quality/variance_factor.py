"""The variance of unit weight by which cofactors become dispersions, and what is known about it.

A quadratic form d'C^-1 d of k components with C = s^2 Q is chi-square of k degrees of freedom where s is known, and
k times F of (k, r) where s^2 is estimated from the redundancy r and independent of d.
"""

from __future__ import annotations

from dataclasses import dataclass

from scipy.special import chdtri, fdtri

from splinebba_cli.core.network import Settings
from splinebba_cli.core.result import CheckTest, Statistics


@dataclass(frozen=True)
class VarianceFactor:
    """Factor of cofactors and the redundancy behind it; None: known beforehand."""

    scale: float
    degrees: float | None

    def critical(self, alpha: float, dimensions: float) -> float:
        """Largest accepted d'C^-1 d of so many components (or effective ones) at the significance alpha."""
        if self.degrees is None:
            return float(chdtri(dimensions, alpha))
        return float(dimensions * fdtri(dimensions, self.degrees, 1.0 - alpha))

    def test(self, statistic: float, alpha: float, dimensions: float) -> CheckTest:
        """Test of a quadratic form d'C^-1 d."""
        critical = self.critical(alpha, dimensions)
        return CheckTest(statistic, dimensions, critical, bool(statistic <= critical))


def variance_degrees(settings: Settings, statistics: Statistics) -> float | None:
    """Degrees of freedom of the variance by which dispersions are scaled; None where it is the a-priori one."""
    if not settings.scale_dispersion or statistics.redundancy < 1:
        return None
    return float(statistics.redundancy)
