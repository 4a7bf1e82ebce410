"""The log of the search for outliers: every decision with its round, statistic and reason."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from splinebba_cli.core.evidence import Rejection
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.revision.local_statistics import LocalStatistics
from splinebba_cli.core.revision.observation_list import CURVES, KINDS, ObservationList


@dataclass
class _Entry:
    observation: int
    round: int
    reason: str
    statistic: float
    returned: bool = False


@dataclass
class RevisionLog:
    """Decisions in their order; an observation may be rejected, return and be rejected again."""

    listed: ObservationList
    entries: list[_Entry] = field(default_factory=list)

    def reject(self, observations: IntArray, round_: int, reasons: list[str], statistics: FloatArray) -> None:
        """Write rejections down."""
        self.entries += [
            _Entry(int(n), round_, reason, float(value))
            for n, reason, value in zip(observations, reasons, statistics, strict=True)
        ]

    def give_back(self, observations: IntArray, note: str = "") -> None:
        """Mark the last rejection of observations as returned."""
        wanted = {int(n) for n in observations}
        for entry in reversed(self.entries):
            if entry.observation in wanted and not entry.returned:
                entry.returned = True
                entry.reason += f"; {note}" if note else ""
                wanted.discard(entry.observation)

    def rejected(self) -> BoolArray:
        """What is rejected now, (N,)."""
        out = np.zeros(len(self.listed), dtype=bool)
        out[[entry.observation for entry in self.entries if not entry.returned]] = True
        return out

    def count(self) -> int:
        """Number of observations that are rejected now."""
        return int(self.rejected().sum())

    def rejections(
        self, statistics: LocalStatistics, residual: FloatArray, rows: IntArray
    ) -> tuple[Rejection, ...]:
        """The log as plain data.

        Parameters
        ----------
        statistics : against the last solution
        residual : (N,) residual of every entry: mm (across the curve, larger coordinate of a point), rad or m
        rows : (N,) row of every entry in the project's order
        """
        out = []
        for entry in self.entries:
            n = entry.observation
            own = statistics.standardized[n]
            place = int(np.argmax(np.abs(np.nan_to_num(own))))
            out.append(
                Rejection(
                    kind=KINDS[int(self.listed.kind[n])][0],
                    row=int(rows[n]),
                    name=self.listed.name(n),
                    round=entry.round,
                    reason=entry.reason,
                    statistic=entry.statistic,
                    predicted=float(own[place]),
                    residual=float(residual[n]),
                    returned=entry.returned,
                )
            )
        return tuple(out)


def residual_of_entries(listed: ObservationList, statistics: LocalStatistics) -> FloatArray:
    """Residual of every entry in its unit, (N,): across a curve, the larger coordinate of a point, mm, rad or m."""
    network = listed.network
    sigma = np.ones((len(listed), 2))
    points = len(network.point_observations)
    sigma[:points] = network.point_observations.sigma
    observed = network.curve_observations.sigma
    listed.part(sigma, CURVES)[:] = np.sqrt(observed[:, :1] * observed[:, 1:])
    sigma[listed.starts[CURVES + 1] :] = np.concatenate(
        [network.arc_lengths.sigma, network.tangents.sigma, network.distances.sigma]
    )[:, None]
    both = statistics.residual * sigma
    place = np.zeros(len(listed), dtype=np.int64)
    place[:points] = np.argmax(np.abs(statistics.residual[:points]), axis=1)
    return np.asarray(both[np.arange(len(listed)), place])
