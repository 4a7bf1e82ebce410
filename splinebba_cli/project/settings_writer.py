"""The section `adjustment` of a written project: settings that differ from the defaults, and those people look for."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from splinebba_cli.core.network import DatumFeatures, Settings

ALWAYS = ("datum", "max_iterations", "alpha", "sigma0_prior", "gauge_sigma_m", "scale_dispersion", "staged")
WHERE_CHANGED = ("gauge_conditions", "confidence", "correlation_threshold")


def adjustment_section(settings: Settings) -> dict[str, Any]:
    """Settings as the project file has them."""
    usual = Settings()
    out: dict[str, Any] = {
        key: getattr(settings, key) for key in ALWAYS if getattr(settings, key) is not None
    }
    out |= {
        key: getattr(settings, key) for key in WHERE_CHANGED if getattr(settings, key) != getattr(usual, key)
    }
    policy = {key: value for key, value in asdict(settings.knots).items() if value}
    if policy:
        out["knots"] = policy
    for key, chosen, default in (
        ("local_tests", settings.testing, usual.testing),
        ("outliers", settings.outliers, usual.outliers),
    ):
        changed = {k: v for k, v in asdict(chosen).items() if v != asdict(default)[k]}
        if changed:
            out[key] = changed
    if settings.weights.variance_components:
        out["variance_components"] = True
    if settings.datum_features is not None:
        out["datum_features"] = _features(settings.datum_features)
    return out


def _features(features: DatumFeatures) -> dict[str, Any]:
    named = {"points": features.points, "images": features.images, "splines": features.curves}
    return {key: "all" if value is None else list(value) for key, value in named.items() if value != ()}
