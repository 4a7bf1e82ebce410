"""How unlabelled points are matched: the choices of the user."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class MatchSettings:
    """What is known before matching, and how strict it is.

    Attributes
    ----------
    position_sigma_m, angle_sigma_rad : float, optional
        Standard deviation, per coordinate and per angle, of given orientations that have no prior: how far they
        may be off.  None: found from the measurements, or taken from a prior of the image.
    alpha : float
        Share of right points that a gate may lose (innovation test, chi-square).
    wrong_share : float
        Largest share of points that belong to no curve of the project, for robust estimates.
    direction_tolerance_rad : float
        Beyond which the direction of an edge contradicts that of a projected curve.
    new_curves : bool
        Whether curves are built from chains that no curve of the project explains.
    knot_tolerance : float
        Largest distance of a built curve from its points, in their sigma, before a knot is inserted.
    orient_freely : bool
        Whether images without an approximate orientation are searched for one.
    rounds : int
        Most rounds of matching and adjustment.
    seed : int
        Of all random choices.
    """

    position_sigma_m: float | None = None
    angle_sigma_rad: float | None = None
    alpha: float = 0.001
    wrong_share: float = 0.3
    direction_tolerance_rad: float = 0.35
    new_curves: bool = False
    knot_tolerance: float = 3.0
    orient_freely: bool = True
    rounds: int = 30
    seed: int = 1
