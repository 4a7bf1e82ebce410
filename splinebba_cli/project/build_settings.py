"""From the settings of a project to those of the core."""

from __future__ import annotations

from splinebba_cli.core.network import DatumFeatures, KnotPolicy, Settings
from splinebba_cli.core.settings import LocalTesting, OutlierPolicy, WeightPolicy
from splinebba_cli.project.model_adjustment import Adjustment


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


def _datum_features(adjustment: Adjustment) -> DatumFeatures | None:
    features = adjustment.datum_features
    if features is None:
        return None
    named = (features.points, features.images, features.splines)
    return DatumFeatures(*(None if names == "all" else tuple(names) for names in named))
