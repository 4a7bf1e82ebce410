"""Settings of a loaded project that a command overrides."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

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


def with_matching(loaded: LoadedProject, **changes: Any) -> LoadedProject:
    """The project with other settings of matching; None leaves one as it is."""
    wanted = {key: value for key, value in changes.items() if value is not None}
    matching = loaded.model.matching.model_copy(update=wanted)
    matching.model_fields_set.update(wanted)
    model = loaded.model.model_copy(update={"matching": matching})
    model.model_fields_set.add("matching")
    return replace(loaded, model=model)
