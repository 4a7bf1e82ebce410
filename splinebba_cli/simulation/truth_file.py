"""truth.json: what a simulated project was made from, in the user's frame, metres and degrees."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from splinebba_cli.core.network import FloatArray, Network
from splinebba_cli.errors import SimulationError
from splinebba_cli.project.build_curves import position_rows
from splinebba_cli.simulation.truth import Truth

TRUTH_FORMAT = "splinebba-truth/1"
TRUTH_FILE = "truth.json"
_EOP = ("omega", "phi", "kappa", "x", "y", "z")


def truth_content(
    network: Network,
    truth: Truth,
    simulation: Mapping[str, Any],
    labels: Sequence[tuple[str, str, str]] | None = None,
) -> dict[str, Any]:
    """The truth as plain data in the layout of result.json: user's frame, metres and degrees.

    Parameters
    ----------
    simulation : how the project was simulated, for readers
    labels : image, chain and spline (empty: none) of every chain, where the project has chains without labels
    """
    chains = {} if labels is None else {"chains": [_label(*each) for each in labels]}
    eop = truth.eop.copy()
    eop[:, :3] = np.remainder(np.degrees(eop[:, :3]) + 180.0, 360.0) - 180.0  # as results are given
    eop[:, 3:] += network.origin
    return {
        "format": TRUTH_FORMAT,
        "simulation": dict(simulation),
        "images": [
            {"id": id, **dict(zip(_EOP, row, strict=True))}
            for id, row in zip(network.images.ids, eop.tolist(), strict=True)
        ],
        "splines": [
            {
                "id": curve.id,
                "family": curve.family,
                "closed": curve.closed,
                "values": _shifted(values, position_rows(curve), network.origin).tolist(),
            }
            for curve, values in zip(network.curves, truth.curves, strict=True)
        ],
        "points": [
            {"id": id, **dict(zip("xyz", row, strict=True))}
            for id, row in zip(network.points.ids, (truth.points + network.origin).tolist(), strict=True)
        ],
        "locations": [None if np.isnan(u) else u for u in truth.locations.tolist()],
        **chains,
    }


def _label(image: str, chain: str, spline: str) -> dict[str, str | None]:
    return {"image": image, "chain": chain, "spline": spline or None}


def truth_text(content: Mapping[str, Any]) -> str:
    """The text of truth.json."""
    return json.dumps(content, indent=1, allow_nan=False) + "\n"


def read_truth(path: Path, network: Network) -> Truth:
    """The truth of a project; its ids must be those of the project.

    Parameters
    ----------
    network : the project's; the truth may know more features than it has

    Returns
    -------
    Truth
        Locations are NaN where the file has not as many as the network has points measured on curves.

    Raises
    ------
    SimulationError
        SBB701, if the file is no truth, or not of this project.
    """
    content = _content(path)
    try:
        images, splines, points = (_by_id(content[key]) for key in ("images", "splines", "points"))
        _require(path, "image", network.images.ids, images)
        _require(path, "spline", [curve.id for curve in network.curves], splines)
        _require(path, "point", network.points.ids, points)
        eop = np.array([[images[id][key] for key in _EOP] for id in network.images.ids], dtype=np.float64)
        xyz = [[points[id][axis] for axis in "xyz"] for id in network.points.ids]
        values = [np.array(splines[curve.id]["values"], dtype=np.float64) for curve in network.curves]
        locations = np.array(content.get("locations", []), dtype=np.float64)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise SimulationError("SBB701", f"`{path}` cannot be read as a truth: {error!r}") from error
    for kind, numbers in (
        ("image", eop),
        ("point", np.array(xyz, dtype=np.float64)),
        *(("spline", v) for v in values),
    ):
        if not np.isfinite(numbers).all():
            raise SimulationError("SBB701", f"`{path}` has a {kind} with values that are no finite numbers")
    for curve, rows in zip(network.curves, values, strict=True):
        if rows.shape != curve.values.shape:
            message = f"`{path}`: spline `{curve.id}` has {len(rows)} values, the project {len(curve.values)}"
            raise SimulationError("SBB701", message, "remove the file, or put back the knots of the project")
    eop = eop.reshape(-1, 6)
    eop[:, :3] = np.radians(eop[:, :3])
    eop[:, 3:] -= network.origin
    count = len(network.curve_observations)
    return Truth(
        eop=eop,
        curves=tuple(
            _shifted(rows, position_rows(curve), -network.origin)
            for curve, rows in zip(network.curves, values, strict=True)
        ),
        points=np.array(xyz, dtype=np.float64).reshape(-1, 3) - network.origin,
        locations=locations if len(locations) == count else np.full(count, np.nan),
        sequence=network.images.sequence,
    )


def _content(path: Path) -> dict[str, Any]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise SimulationError("SBB701", f"`{path}` cannot be read: {error}") from error
    if not isinstance(content, dict) or content.get("format") != TRUTH_FORMAT:
        raise SimulationError("SBB701", f"`{path}` is not of format {TRUTH_FORMAT}")
    return content


def _by_id(entries: Sequence[dict[str, Any]]) -> dict[str, dict[str, Any]]:
    return {str(entry["id"]): entry for entry in entries}


def _require(path: Path, kind: str, ids: Sequence[str], known: Mapping[str, Any]) -> None:
    lacking = [id for id in ids if id not in known]
    if lacking:
        more = f" and {len(lacking) - 1} more" if len(lacking) > 1 else ""
        help = (
            f"remove it to simulate from the approximate values of the project; it knows {len(known)} {kind}s"
        )
        raise SimulationError("SBB701", f"`{path}` has no {kind} `{lacking[0]}`{more}", help)


def _shifted(values: FloatArray, positions: Any, shift: FloatArray) -> FloatArray:
    """Values of a curve in another frame: of polynomials only a0 is a position."""
    out = values.copy()
    out[positions] += shift
    return out
