"""Bundle block adjustment with points and three-dimensional curves."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from splinebba_cli.core.adjustment import adjust as adjust
    from splinebba_cli.core.curves.fitting import fit_spline as fit_spline
    from splinebba_cli.core.matching.match import match as match
    from splinebba_cli.output.comparison import compare as compare
    from splinebba_cli.project.loading import load_project as load_project
    from splinebba_cli.simulation.targets import simulate as simulate

__version__ = "0.1.0"
__all__ = ["__version__", "adjust", "compare", "fit_spline", "load_project", "match", "simulate"]

_PUBLIC = {
    "load_project": "splinebba_cli.project.loading",
    "adjust": "splinebba_cli.core.adjustment",
    "simulate": "splinebba_cli.simulation.targets",
    "match": "splinebba_cli.core.matching.match",
    "fit_spline": "splinebba_cli.core.curves.fitting",
    "compare": "splinebba_cli.output.comparison",
}


def __getattr__(name: str) -> Any:
    """Import the public functions at their first use, so that start-up stays light."""
    if name in _PUBLIC:
        return getattr(import_module(_PUBLIC[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
