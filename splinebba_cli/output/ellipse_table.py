"""error_ellipses.csv: standard ellipses, ellipsoids and confidence figures of every position."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.evidence import Precision
from splinebba_cli.output.columns import Column, Table

_SIGMA = "%.6g"
_RATIO = "%.6f"


def error_ellipse_tables(precision: Precision | None) -> tuple[Table, ...]:
    """One row an image and a point; metres, degrees; none where the precision is not known."""
    if precision is None:
        return ()
    both = (precision.images, precision.points)
    semi_axes = np.concatenate([part.semi_axes_m for part in both])
    ellipsoid = np.concatenate([part.ellipsoid_m for part in both])
    axes = np.concatenate([part.ellipsoid_axes for part in both])
    columns = [
        Column("kind", ["image"] * len(both[0]) + ["point"] * len(both[1])),
        Column("id", [*both[0].ids, *both[1].ids]),
        Column("semi_major_m", semi_axes[:, 0], _SIGMA),
        Column("semi_minor_m", semi_axes[:, 1], _SIGMA),
        Column("azimuth_deg", np.degrees(np.concatenate([part.azimuth_rad for part in both])), "%.4f"),
        Column("horizontal_m", np.concatenate([part.horizontal_m for part in both]), _SIGMA),
        Column("vertical_m", np.concatenate([part.vertical_m for part in both]), _SIGMA),
    ]
    for k in range(3):
        columns.append(Column(f"ellipsoid_{k + 1}_m", ellipsoid[:, k], _SIGMA))
        columns += [
            Column(f"ellipsoid_{k + 1}_{axis}", axes[:, k, i], _RATIO) for i, axis in enumerate("xyz")
        ]
    return (Table("error_ellipses", tuple(columns)),)
