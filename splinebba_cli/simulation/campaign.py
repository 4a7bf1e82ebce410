"""One run of a campaign: a realization adjusted and compared with the truth; and where wrong starts lead.

Run i has the seed of the campaign plus i, so that ``simulate TARGET --seed S`` writes a single run as a project.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.network import Network
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.errors import NotSolvableError
from splinebba_cli.simulation.dropping import Dropped
from splinebba_cli.simulation.noise import Noise
from splinebba_cli.simulation.realization import Design, realize
from splinebba_cli.simulation.run_errors import (
    Reference,
    given_locations,
    largest,
    reference_of_result,
    reference_of_truth,
    run_errors,
)
from splinebba_cli.simulation.run_record import (
    Failure,
    Places,
    RunRecord,
    StudyOutcome,
    StudyPoint,
    failed_record,
    solved_record,
)
from splinebba_cli.simulation.truth import at_truth

SAME_SOLUTION = (
    0.01  # σ of every orientation element, point coordinate, place across a curve and given location
)


@dataclass(frozen=True)
class Campaign:
    """The task of every run; picklable.

    With a `study`, every run is adjusted from the truth, and once more for every factor: from starts whose errors are
    those of `noise`, multiplied by the factor.
    """

    design: Design
    noise: Noise
    seed: int
    study: tuple[float, ...] = ()

    def __call__(self, run: int) -> RunRecord:
        """The record of one run."""
        made = realize(self.design, self.noise, self.seed + run)
        network = at_truth_with_control(made) if self.study else made.network
        result, failure = attempt(network)
        if result is None:
            return failed_record(run, failure or Failure("SBB502", ""))
        study = self._study(run, reference_of_result(result))
        return self.record(run, made, result, study)

    def record(
        self, run: int, made: Dropped, result: AdjustmentResult, study: tuple[StudyPoint, ...] = ()
    ) -> RunRecord:
        """What is kept of a realization that was solved."""
        return solved_record(
            run, result, reference_of_truth(made.network, made.truth), self._places(made), study
        )

    def options(self) -> dict[str, Any]:
        """What the runs depend on, besides the design."""
        return {"seed": self.seed, "noise": asdict(self.noise), "study": list(self.study)}

    def _places(self, made: Dropped) -> Places:
        whole = self.design.network
        given = given_locations(whole)
        own = np.searchsorted(given, made.measured[given_locations(made.network)])
        return Places(made.points, len(whole.points.ids), made.curves, len(whole.curves), own, len(given))

    def _study(self, run: int, reference: Reference) -> tuple[StudyPoint, ...]:
        points = []
        for factor in self.study:
            network = realize(self.design, self.noise.with_starts(factor), self.seed + run).network
            result, failure = attempt(network)
            if result is None:
                points.append(StudyPoint(factor, "failed", float("nan"), 0, failure))
                continue
            deviation = largest(run_errors(result, reference))
            outcome: StudyOutcome = "same" if deviation <= SAME_SOLUTION else "other minimum"
            points.append(StudyPoint(factor, outcome, deviation, len(result.iterations)))
        return tuple(points)


def attempt(network: Network) -> tuple[AdjustmentResult | None, Failure | None]:
    """The adjustment of a network, or the reason why it has none.

    An unexpected error is a reason, too: it is counted and shown as SBB970, and does not end the campaign.
    """
    try:
        return adjust(network), None
    except NotSolvableError as error:
        return None, Failure(error.code, error.message)
    except (ArithmeticError, ValueError, IndexError, KeyError, np.linalg.LinAlgError) as error:
        return None, Failure("SBB970", f"{type(error).__name__}: {error}")


def at_truth_with_control(made: Dropped) -> Network:
    """A realization that starts at the truth; given values of control and priors keep their errors."""
    network, start = made.network, at_truth(made.network, made.truth)
    known = np.isfinite(network.points.sigma) | np.isfinite(network.points.check_sigma)
    curves = tuple(
        replace(true, values=np.where(np.isfinite(own.sigma), own.values, true.values))
        for own, true in zip(network.curves, start.curves, strict=True)
    )
    xyz = np.where(known, network.points.xyz, start.points.xyz)
    return replace(start, points=replace(start.points, xyz=xyz), curves=curves)
