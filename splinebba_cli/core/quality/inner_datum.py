"""A free network: its datum spread over chosen features by inner constraints, and the S-transformation to it.

    B'(x - x0) = 0,   B the rows of G_V (datum.py) of the chosen coordinates, zero elsewhere

is the least squares fit of the chosen features to their approximate values x0 by the similarities that nothing
determines; their dispersion then has the smallest trace of all datums.  From the cofactors Q of any minimal
constraint,

    Q_inner = S Q S',    S = I - G (B'G)^-1 B',
            = Q - G H' - H G',    H = Q B M' - 1/2 G M (B'Q B) M',   M = (B'G)^-1 .

Residuals, redundancy numbers and sigma0 are the same in every datum.  Of curves the knots are chosen, so that
B_c = V'V G_c with V the linear map from coefficients to knots.  (Baarda 1973; Koch 1999, section 3.3)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.estimation.datum import free_directions
from splinebba_cli.core.estimation.parameters import ParameterLayout, layout_of
from splinebba_cli.core.estimation.similarity import (
    SimilarityDirections,
    moved_by,
    reduced_rows,
    similarity_directions,
)
from splinebba_cli.core.network import BoolArray, DatumFeatures, FloatArray, IntArray, Network
from splinebba_cli.core.quality.observation_effects import Effects, EquationColumns, ObservationEffects
from splinebba_cli.core.result import Problem
from splinebba_cli.core.state import Prepared, State
from splinebba_cli.errors import SingularNetworkError

FEWEST_POINTS = 3
FITTING_STEPS = 20
NEGLIGIBLE = 1e-13  # of the extent
CARRIED = 1e-12  # smallest over largest eigenvalue of B'G: a lever of a millionth of the extent


@dataclass(frozen=True)
class DatumColumns:
    """B over all unknowns, and the directions G that it fixes."""

    orientation: FloatArray  # (m, 6, d)
    coefficients: FloatArray  # (C, 3, d)
    point: FloatArray  # (n, 3, d)
    directions: SimilarityDirections

    @property
    def inverse(self) -> FloatArray:
        """M = (B'G)^-1, (d, d)."""
        return np.asarray(np.linalg.inv(self.onto(self.directions)))

    def onto(self, other: SimilarityDirections | Effects) -> FloatArray:
        """B' times columns over all unknowns."""
        return np.asarray(
            np.einsum("mid,mik->dk", self.orientation, other.orientation)
            + np.einsum("cid,cik->dk", self.coefficients, other.coefficients)
            + np.einsum("nid,nik->dk", self.point, other.point)
        )


def datum_columns(prepared: Prepared, state: State) -> DatumColumns:
    """B of the network's datum features at a state.

    Raises
    ------
    SingularNetworkError
        If the chosen features do not carry the datum.
    """
    layout = layout_of(prepared)
    free = free_directions(prepared, layout, state)
    points, images, curves = _chosen(prepared.network)
    orientation = np.zeros_like(free.orientation)
    orientation[:, 3:] = free.orientation[:, 3:] * images[:, None, None]
    coefficients = np.zeros_like(free.coefficients)
    for number in np.flatnonzero(curves):
        basis, start = prepared.curves.bases[number], int(prepared.curves.coefficient_start[number])
        rows = slice(start, start + basis.coefficient_count)
        knots = basis.break_points[:-1] if basis.closed else basis.break_points
        to_knots = basis.evaluate(knots, np.eye(basis.coefficient_count))
        coefficients[rows] = np.einsum("kc,ke,eid->cid", to_knots, to_knots, free.coefficients[rows])
    point = free.point * (points[:, None] * layout.point_mask)[:, :, None]
    columns = DatumColumns(orientation, coefficients, point, free)
    _require_carried(columns, (int(points.sum()), int(images.sum()), int(curves.sum())))
    return columns


def _require_carried(columns: DatumColumns, chosen: tuple[int, int, int]) -> None:
    """Refuse features that some free similarity leaves where they are: B'G (positive semidefinite) is singular."""
    size = np.linalg.eigvalsh(columns.onto(columns.directions))
    if not len(size):
        return
    missing = int((size <= CARRIED * size[-1]).sum()) if size[-1] > 0.0 else len(size)
    if missing:
        named = ", ".join(
            f"{count} {name}{'' if count == 1 else 's'}"
            for count, name in zip(chosen, ("measured point", "image", "spline"), strict=True)
            if count
        )
        problem = Problem(
            "SBB523",
            "error",
            f"the datum features ({named or 'none of them is measured'}) do not carry the datum: {missing} of "
            f"{len(size)} free directions of shift, rotation and scale stay free",
            "datum",
            "`adjustment: {datum_features: …}` needs at least three points, images or knots that are not in one line",
        )
        raise SingularNetworkError([problem])


def _chosen(network: Network) -> tuple[BoolArray, BoolArray, BoolArray]:
    """Whether points, images and curves carry the datum."""
    features = network.settings.datum_features
    measured = np.zeros(len(network.points.ids), dtype=bool)
    measured[network.point_observations.point] = True
    if features is None:
        few = int(measured.sum()) < FEWEST_POINTS
        features = DatumFeatures(points=() if few else None, images=None if few else ())
    curve_ids = tuple(curve.id for curve in network.curves)
    points = _members(network.points.ids, features.points) & measured
    return points, _members(network.images.ids, features.images), _members(curve_ids, features.curves)


def _members(ids: tuple[str, ...], chosen: tuple[str, ...] | None) -> BoolArray:
    if chosen is None:
        return np.ones(len(ids), dtype=bool)
    wanted = set(chosen)
    return np.array([one in wanted for one in ids], dtype=bool)


def fitted_state(prepared: Prepared, state: State, reference: State) -> State:
    """The state moved by the free similarities so that the datum features fit their reference best."""
    for _ in range(FITTING_STEPS):
        columns = datum_columns(prepared, state)
        if not columns.orientation.shape[2]:
            return state
        gap = Effects(
            orientation=np.concatenate(
                [np.zeros((len(state.position), 3, 1)), (reference.position - state.position)[:, :, None]],
                axis=1,
            ),
            coefficients=(reference.coefficients - state.coefficients)[:, :, None],
            point=(reference.xyz - state.xyz)[:, :, None],
        )
        step = columns.inverse @ columns.onto(gap)[:, 0]
        whole = similarity_directions(prepared, state)
        weights = _weights(columns.directions, whole)
        state = moved_by(prepared, state, whole, weights @ step)
        if np.abs(step).max() <= NEGLIGIBLE * whole.extent:
            break
    return state


def _weights(part: SimilarityDirections, whole: SimilarityDirections) -> FloatArray:
    """V of G_V = G V, (7, d), from the rows of the images."""
    size = whole.orientation.shape[2]
    return np.asarray(
        np.linalg.lstsq(
            whole.orientation.reshape(-1, size), part.orientation.reshape(-1, part.orientation.shape[2])
        )[0]
    )


@dataclass(frozen=True)
class STransformation:
    """G and H of Q_inner = Q - G H' - H G' over all unknowns, and what is needed for single columns."""

    columns: DatumColumns
    partner: Effects  # H
    image_mask: FloatArray  # (m, 6) unknowns that are free in the inner datum
    inverse: FloatArray  # M

    @classmethod
    def at(cls, prepared: Prepared, effects: ObservationEffects) -> STransformation:
        """From the minimal datum of a solution to the network's inner datum."""
        columns = datum_columns(prepared, effects.at.state)
        layout, count = effects.assembler.layout, columns.orientation.shape[2]
        sides = EquationColumns(
            reduced_rows(layout, columns.orientation, columns.coefficients, columns.point)
            * layout.reduced_mask()[:, None],
            columns.point * (layout.node_of_point < 0)[:, None, None],
        )
        found = effects.of(sides, np.ones(count))  # Q B
        inverse, free = columns.inverse, columns.directions
        half = 0.5 * inverse @ columns.onto(found) @ inverse.T
        partner = Effects(
            orientation=found.orientation @ inverse.T - free.orientation @ half,
            coefficients=found.coefficients @ inverse.T - free.coefficients @ half,
            point=found.point @ inverse.T - free.point @ half,
        )
        return cls(columns, partner, layout_of(prepared).image_mask, inverse)

    def of_images(self, blocks: FloatArray) -> FloatArray:
        """Cofactors of the orientations in the inner datum, (m, 6, 6)."""
        return blocks - _both(self.columns.directions.orientation, self.partner.orientation)

    def of_coefficients(self, blocks: FloatArray, columns: IntArray) -> FloatArray:
        """Cofactors of windows of coefficients, (G, 3 w, 3 w)."""
        count = self.inverse.shape[0]
        g = self.columns.directions.coefficients[columns].reshape(len(columns), -1, count)
        h = self.partner.coefficients[columns].reshape(len(columns), -1, count)
        return blocks - _both(g, h)

    def of_points(self, blocks: FloatArray) -> FloatArray:
        """Cofactors of the points, (n, 3, 3)."""
        return blocks - _both(self.columns.directions.point, self.partner.point)

    def of_points_together(self, cofactors: FloatArray, points: IntArray) -> FloatArray:
        """Cofactors of the coordinates of some points together, (3 k, 3 k)."""
        rows = (
            each.point[points].reshape(len(cofactors), -1) for each in (self.columns.directions, self.partner)
        )
        return cofactors - _both(*rows)

    def of_points_with_images(self, blocks: FloatArray, image: IntArray, point: IntArray) -> FloatArray:
        """Cofactors of images with the points that they see, (n_obs, 6, 3)."""
        free, partner = self.columns.directions, self.partner
        out = blocks - np.matmul(free.orientation[image], partner.point[point].transpose(0, 2, 1))
        out -= np.matmul(partner.orientation[image], free.point[point].transpose(0, 2, 1))
        return np.asarray(out)

    def of_reduced(self, cofactors: FloatArray, layout: ParameterLayout) -> FloatArray:
        """The whole matrix of cofactors of the reduced unknowns, (N, N)."""
        return cofactors - _both(*self.on_reduced(layout))

    def on_reduced(self, layout: ParameterLayout) -> tuple[FloatArray, FloatArray]:
        """Rows of G and H of the reduced unknowns, (N, d) each."""
        h = self.partner
        rows = reduced_rows(layout, h.orientation, h.coefficients, h.point)
        return self.columns.directions.reduced(layout), rows

    def of_effects(self, effects: Effects) -> Effects:
        """S times columns over all unknowns."""
        amount, free = self.inverse @ self.columns.onto(effects), self.columns.directions
        return Effects(
            orientation=effects.orientation - free.orientation @ amount,
            coefficients=effects.coefficients - free.coefficients @ amount,
            point=effects.point - free.point @ amount,
        )


def s_transformed(dispersion: FloatArray, directions: FloatArray, datum: FloatArray) -> FloatArray:
    """A full dispersion matrix in another datum, S C S'.

    Parameters
    ----------
    dispersion : (N, N)
    directions : (N, d) G, the directions that nothing determines
    datum : (N, d) B of the new datum

    References
    ----------
    Baarda (1973), S-transformations and criterion matrices.
    """
    s = np.eye(len(dispersion)) - directions @ np.linalg.solve(datum.T @ directions, datum.T)
    return np.asarray(s @ dispersion @ s.T)


def _both(g: FloatArray, h: FloatArray) -> FloatArray:
    """G H' + H G' of blocks (..., p, d)."""
    product = np.matmul(g, np.swapaxes(h, -1, -2))
    return np.asarray(product + np.swapaxes(product, -1, -2))
