"""Settings of a loaded project that a command overrides."""

from __future__ import annotations

from dataclasses import replace

from splinebba_cli.core.settings import OutlierMethod
from splinebba_cli.project.build_settings import settings_of
from splinebba_cli.project.loading import LoadedProject


def with_outliers(loaded: LoadedProject, method: OutlierMethod) -> LoadedProject:
    """The project with another treatment of gross errors; its other settings of the search stay."""
    adjustment = loaded.model.adjustment
    outliers = adjustment.outliers.model_copy(update={"method": method})
    outliers.model_fields_set.add("method")
    changed = adjustment.model_copy(update={"outliers": outliers})
    changed.model_fields_set.add("outliers")
    model = loaded.model.model_copy(update={"adjustment": changed})
    model.model_fields_set.add("adjustment")
    return replace(loaded, model=model, network=replace(loaded.network, settings=settings_of(changed)))
