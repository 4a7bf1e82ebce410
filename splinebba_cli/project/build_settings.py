"""From the settings of a project to those of the core."""

from __future__ import annotations

import math

from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.network import DatumFeatures, KnotPolicy, Settings
from splinebba_cli.core.settings import LocalTesting, OutlierPolicy, WeightPolicy
from splinebba_cli.project.model_adjustment import Adjustment
from splinebba_cli.project.model_matching import Matching


def settings_of(adjustment: Adjustment) -> Settings:
    """Settings of the core."""
    return Settings(
        datum=adjustment.datum,
        datum_features=_datum_features(adjustment),
        sigma0_prior=adjustment.sigma0_prior,
        alpha=adjustment.alpha,
        max_iterations=adjustment.max_iterations,
        gauge_sigma_m=adjustment.gauge_sigma_m,
        gauge_conditions=adjustment.gauge_conditions,
        scale_dispersion=adjustment.scale_dispersion,
        staged=adjustment.staged,
        knots=KnotPolicy(
            spacing_m=adjustment.knots.spacing_m,
            insert=adjustment.knots.insert,
            drop=adjustment.knots.drop,
        ),
        testing=LocalTesting(**adjustment.local_tests.model_dump()),
        outliers=OutlierPolicy(**adjustment.outliers.model_dump()),
        weights=WeightPolicy(variance_components=adjustment.variance_components),
        confidence=adjustment.confidence,
        correlation_threshold=adjustment.correlation_threshold,
    )


def match_settings_of(matching: Matching) -> MatchSettings:
    """Settings of matching; angles in radians."""
    angle = matching.angle_sigma_deg
    return MatchSettings(
        position_sigma_m=matching.position_sigma_m,
        angle_sigma_rad=None if angle is None else math.radians(angle),
        alpha=matching.alpha,
        wrong_share=matching.wrong_share,
        direction_tolerance_rad=math.radians(matching.direction_tolerance_deg),
        new_curves=matching.new_curves,
        knot_tolerance=matching.knot_tolerance_sigma,
        orient_freely=matching.orient_freely,
        rounds=matching.rounds,
        seed=matching.seed,
    )


def _datum_features(adjustment: Adjustment) -> DatumFeatures | None:
    features = adjustment.datum_features
    if features is None:
        return None
    named = (features.points, features.images, features.splines)
    return DatumFeatures(*(None if names == "all" else tuple(names) for names in named))
