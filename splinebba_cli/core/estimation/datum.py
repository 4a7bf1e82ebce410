"""The datum of a network without enough control: what nothing determines, held by minimal constraints.

The seven directions G of a similarity move no image measurement.  Control, prior orientations and distances see some of
them: with D the rows of all that is not invariant (removed unknowns too), the defect is the null space V of D G, and

    G_V = G V,    D G_V = 0

are the d directions that a datum must take away.  A minimal constraint holds d orientation unknowns whose rows of G_V
are independent (an S-basis; Baarda 1973): all six of the image farthest out where shift and rotation are free, and
coordinates of perspective centres.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.linalg

from splinebba_cli.core.estimation.parameters import ParameterLayout, layout_of
from splinebba_cli.core.estimation.similarity import SimilarityDirections, similarity_directions
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.observations.coefficient_rows import GAUGE
from splinebba_cli.core.observations.distances import linearize_distances
from splinebba_cli.core.observations.orientation_priors import linearize_orientation_priors
from splinebba_cli.core.observations.shape_conditions import control_rows
from splinebba_cli.core.result import Problem
from splinebba_cli.core.state import Prepared, State
from splinebba_cli.errors import SingularNetworkError

UNSEEN = 1e-8  # singular value of rows of unit length below which a direction is not determined

_NO_MINIMAL_DATUM = Problem(
    "SBB523",
    "error",
    "a minimal datum holds the orientations of two images, but all images stand at one place",
    "datum",
    "give control, or a distance between points",
)


def free_directions(prepared: Prepared, layout: ParameterLayout, state: State) -> SimilarityDirections:
    """The similarity directions that no control, prior or distance determines, d columns.

    Parameters
    ----------
    layout : with all unknowns that the user left free
    """
    directions = similarity_directions(prepared, state)
    rows = _datum_rows(prepared, layout, state, directions)
    length = np.linalg.norm(rows, axis=1)
    rows = rows[length > 0.0] / length[length > 0.0, None]
    _, singular, right = np.linalg.svd(np.vstack([rows, np.zeros((7, 7))]), full_matrices=False)
    return directions.combined(right[singular <= UNSEEN * max(float(singular[0]), 1.0)].T)


def _datum_rows(
    prepared: Prepared, layout: ParameterLayout, state: State, directions: SimilarityDirections
) -> FloatArray:
    """All rows D G that are not invariant, (q, 7)."""
    network = prepared.network
    priors = linearize_orientation_priors(network.images, state)
    weighted = np.isfinite(network.points.sigma) & (network.points.sigma > 0.0)
    control = control_rows(prepared, layout.coefficient_mask)
    values = np.flatnonzero(control.component < GAUGE)
    of_values = np.einsum(
        "qwd,qwdk->qk", control.jacobian[values], directions.coefficients[control.columns[values]]
    )
    distances = linearize_distances(network.distances, state)
    of_ends = np.zeros((len(network.distances), 7))
    for end in range(2):
        image = network.distances.is_image[:, end]
        station = network.distances.station[:, end]
        moved = np.empty((len(station), 3, 7))
        moved[image], moved[~image] = (
            directions.orientation[station[image], 3:],
            directions.point[station[~image]],
        )
        of_ends += np.einsum("qd,qdk->qk", distances.jacobian[:, end], moved)
    prior_rows = np.einsum("qrc,qck->qrk", priors.jacobian, directions.orientation[priors.image])
    return np.vstack(
        [
            prior_rows[priors.active],
            directions.point[weighted],
            of_values,
            of_ends,
            directions.orientation[layout.image_mask == 0.0],
            directions.coefficients[layout.coefficient_mask == 0.0],
            directions.point[layout.point_mask == 0.0],
        ]
    )


def datum_layout(prepared: Prepared, state: State) -> ParameterLayout:
    """The layout of a network with the datum in which it is solved."""
    layout = layout_of(prepared)
    return layout if prepared.network.settings.datum == "control" else minimal_datum(prepared, layout, state)


def minimal_datum(prepared: Prepared, layout: ParameterLayout, state: State) -> ParameterLayout:
    """The layout with as many orientation unknowns held as nothing determines.

    Raises
    ------
    SingularNetworkError
        If the orientations cannot carry the datum: all perspective centres are at one place.
    """
    free = free_directions(prepared, layout, state)
    mask = layout.image_mask.copy()
    rows = free.orientation * mask[:, :, None]
    defect = rows.shape[2]
    if not defect:
        return layout
    whole = np.flatnonzero((mask > 0.0).all(axis=1))
    if defect >= 6 and len(whole):
        away = np.linalg.norm(state.position - free.centre, axis=1)
        first = int(whole[np.argmax(away[whole])])
        rest = scipy.linalg.null_space(rows[first], rcond=UNSEEN)
        if rest.shape[1] == defect - 6:
            mask[first] = 0.0
            rows = (rows * mask[:, :, None]) @ rest
            defect -= 6
    rows[:, :3] *= 1e-3  # attitudes only where perspective centres do not do
    flat = rows.reshape(mask.size, -1)
    if defect:
        triangle, pivots = scipy.linalg.qr(flat.T, mode="r", pivoting=True)
        size = np.abs(np.diag(triangle[:, :defect])) if triangle.shape[1] >= defect else np.zeros(1)
        if size.min() <= UNSEEN * size.max() or size.max() == 0.0:
            raise SingularNetworkError([_NO_MINIMAL_DATUM])
        mask.reshape(-1)[pivots[:defect]] = 0.0
    return replace(layout, image_mask=mask)
