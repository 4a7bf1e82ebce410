"""Linear equations over the coefficients of one place of a curve: control of its values, and gauge conditions.

    control     (sum_j m_kj P_j - value_k)_d / sigma_kd = v
    gauge       tau_a' (sum_j N_j(u_a) P_j - X0(u_a)) / sigma = v,  tau the unit tangent of the reference curve
    shape       1/2 sum_jl K_jl P_j . P_l = v   (shape_conditions.py): quadratic, linearised at every state

Every row touches at most w coefficients.  (theory, sections 6 and 7)
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.curves.basis import CurveBasis
from splinebba_cli.core.curves.registry import FAMILIES
from splinebba_cli.core.network import Curve, FloatArray, IntArray
from splinebba_cli.core.state import Prepared

GAUGE, SHAPE = 3, 4  # components of conditions
LOOSE = 0.01  # sigma of conditions that fill no exact defect, as a share of the knot distance
HELD_FRACTION = 1e-6  # sigma of a held inner knot, as a share of the knot distance


@dataclass(frozen=True)
class CoefficientRows:
    """Rows J p + 1/2 sum_jl K_jl p_j . p_l = target, whitened; p the coefficients in `columns`, coordinate fastest."""

    curve: IntArray  # (q,)
    row: IntArray  # (q,) row of `values`, or number of the anchor
    component: IntArray  # (q,) 0, 1, 2, or GAUGE (along the tangent), or SHAPE
    columns: IntArray  # (q, w)
    jacobian: FloatArray  # (q, w, 3) of the linear part
    target: FloatArray  # (q,)
    sigma: FloatArray  # (q,) metres
    curvature: FloatArray  # (q, w, w) K; 0 of all but shape conditions

    def __len__(self) -> int:
        return len(self.curve)

    def residual(self, coefficients: FloatArray) -> FloatArray:
        """Whitened residuals, (q,)."""
        found = np.einsum("qwd,qwd->q", self.jacobian, coefficients[self.columns]) - self.target
        shape, own = self._shape(coefficients)
        found[shape] += 0.5 * np.einsum("qjl,qjd,qld->q", self.curvature[shape], own, own)
        return np.asarray(found)

    def jacobian_at(self, coefficients: FloatArray) -> FloatArray:
        """Derivatives of the residuals at coefficients (C, 3), (q, w, 3)."""
        shape, own = self._shape(coefficients)
        if not len(shape):
            return self.jacobian
        found = self.jacobian.copy()
        found[shape] += np.einsum("qjl,qld->qjd", self.curvature[shape], own)
        return found

    def _shape(self, coefficients: FloatArray) -> tuple[IntArray, FloatArray]:
        """The quadratic rows and the coefficients under them."""
        shape = np.flatnonzero(self.component == SHAPE)
        return shape, coefficients[self.columns[shape]]

    def with_sigma_times(self, factor: float) -> CoefficientRows:
        """The same rows with all sigma multiplied."""
        return replace(
            self,
            jacobian=self.jacobian / factor,
            target=self.target / factor,
            sigma=self.sigma * factor,
            curvature=self.curvature / factor,
        )

    def select(self, keep: IntArray) -> CoefficientRows:
        """Some of the rows."""
        return CoefficientRows(
            self.curve[keep],
            self.row[keep],
            self.component[keep],
            self.columns[keep],
            self.jacobian[keep],
            self.target[keep],
            self.sigma[keep],
            self.curvature[keep],
        )


def concatenate_rows(parts: list[CoefficientRows], support: int) -> CoefficientRows:
    """Rows of several kinds one after another; an empty table of the right width for no parts."""
    if not parts:
        none = np.zeros(0, dtype=np.int64)
        return CoefficientRows(
            none,
            none,
            none,
            np.zeros((0, support), dtype=np.int64),
            np.zeros((0, support, 3)),
            np.zeros(0),
            np.zeros(0),
            np.zeros((0, support, support)),
        )
    return CoefficientRows(
        *(np.concatenate([getattr(p, f) for p in parts]) for f in CoefficientRows.__annotations__)
    )


def _pad(array: FloatArray, support: int) -> FloatArray:
    return np.pad(array, ((0, 0), (0, support - array.shape[1])))


def removed_coefficients(prepared: Prepared) -> FloatArray:
    """Mask (C, 3), 0 where a coefficient is fixed and removed, else 1.

    A held value removes its coefficient where it *is* one (end knots, coefficients of free families), and all of a
    curve whose values are all held; other held knots become equations of very large weight.
    """
    curves, given = prepared.curves, prepared.network.curves
    count = np.array([3 * len(curve.sigma) for curve in given], dtype=np.int64)
    held = np.concatenate([np.zeros(0), *(curve.sigma.ravel() for curve in given)]) == 0.0
    held_of = np.bincount(np.repeat(np.arange(len(given)), count)[held], minlength=len(given))
    free = (held_of < count) | (count == 0)
    mask = np.repeat(free.astype(np.float64), np.diff(curves.coefficient_start))[:, None] * np.ones(3)
    for number in np.flatnonzero(free & (held_of > 0)).tolist():
        rows, columns, _ = curves.bases[number].pure_values()
        place, component = np.nonzero(given[number].sigma[rows] == 0.0)
        mask[curves.coefficient_start[number] + columns[place], component] = 0.0
    return mask


def value_rows(prepared: Prepared, removed: FloatArray) -> CoefficientRows:
    """Equations of the weighted (and of the held inner) values of all curves."""
    support = prepared.curves.support
    parts = [_values_of_alike(prepared, removed, alike) for alike in _alike(prepared)]
    rows = concatenate_rows(parts, support)
    return rows.select(np.lexsort((rows.component, rows.row, rows.curve)))


def _alike(prepared: Prepared) -> list[list[int]]:
    """Curves with given values, those of the same basis together."""
    found: dict[int, list[int]] = {}
    for number, curve in enumerate(prepared.network.curves):
        if np.isfinite(curve.sigma).any() and (curve.sigma != 0.0).any():
            found.setdefault(id(prepared.curves.bases[number]), []).append(number)
    return list(found.values())


def _values_of_alike(prepared: Prepared, removed: FloatArray, numbers: list[int]) -> CoefficientRows:
    """Equations of the values of curves that have the same basis."""
    support, basis = prepared.curves.support, prepared.curves.bases[numbers[0]]
    curves = [prepared.network.curves[number] for number in numbers]
    given = np.stack([curve.sigma for curve in curves])
    which, rows, components = np.nonzero(np.isfinite(given))
    sigma = given[which, rows, components]
    if (sigma == 0.0).any():
        held = np.array([HELD_FRACTION * knot_distance(curve) for curve in curves])
        sigma = np.where(sigma == 0.0, held[which], sigma)
    columns = np.tile(basis.value_columns[:, :1], (1, support))
    columns[:, : basis.value_columns.shape[1]] = basis.value_columns
    weights = _pad(basis.value_weights, support)
    number = np.array(numbers)[which]
    under = columns[rows] + prepared.curves.coefficient_start[number][:, None]
    live = np.einsum("qw,qw->q", np.abs(weights[rows]), removed[under, components[:, None]]) > 0.0
    which, rows, components, sigma, number, under = (
        array[live] for array in (which, rows, components, sigma, number, under)
    )
    jacobian = np.zeros((len(rows), support, 3))
    jacobian[np.arange(len(rows)), :, components] = weights[rows] / sigma[:, None]
    values = np.stack([curve.values for curve in curves])[which, rows, components]
    return CoefficientRows(
        number,
        rows,
        components,
        under,
        jacobian,
        values / sigma,
        sigma,
        np.zeros((len(rows), support, support)),
    )


def gauge_rows(prepared: Prepared, removed: FloatArray, gauge_sigma_m: float | None) -> CoefficientRows:
    """Tangential conditions at the anchors of every curve that has a free coefficient."""
    parts: list[CoefficientRows] = []
    support = prepared.curves.support
    for number, curve in enumerate(prepared.network.curves):
        basis = prepared.curves.bases[number]
        start = int(prepared.curves.coefficient_start[number])
        if not len(basis.anchors) or np.isfinite(curve.sigma).all():
            continue  # a single point, or every value is given or weighted: nothing can slide
        reference = curve.values if curve.reference is None else curve.reference
        coefficients = basis.coefficients_from_values(reference)
        sigma = _gauge_sigma(curve, basis, gauge_sigma_m)
        tangent = anchor_tangents(basis.anchors, curve, number, prepared, coefficients)
        segment, t = prepared.curves.locate(np.full(len(basis.anchors), number), basis.anchors)
        weights = prepared.curves.weights(segment, t)
        columns = prepared.curves.columns[segment]
        jacobian = weights[:, :, None] * tangent[:, None, :] / sigma[:, None, None]
        target = np.einsum("qwd,qwd->q", jacobian, coefficients[columns - start])
        live = np.einsum("qwd,qwd->q", np.abs(jacobian), removed[columns]) > 0.0
        rows = np.flatnonzero(live)
        parts.append(
            CoefficientRows(
                np.full(len(rows), number),
                rows,
                np.full(len(rows), GAUGE),
                columns[rows],
                jacobian[rows],
                target[rows],
                sigma[rows],
                np.zeros((len(rows), support, support)),
            )
        )
    return concatenate_rows(parts, support)


def _gauge_sigma(curve: Curve, basis: CurveBasis, given_m: float | None) -> FloatArray:
    """Sigma of the conditions at all anchors, (g,) m; loose ones fill no exact defect and are never tight."""
    distance = knot_distance(curve)
    sigma = np.full(len(basis.anchors), given_m or FAMILIES[curve.family].gauge_fraction * distance)
    if len(basis.loose_anchors):
        sigma = np.where(basis.loose_anchors, np.maximum(sigma, LOOSE * distance), sigma)
    return sigma


def anchor_tangents(
    anchors: FloatArray, curve: Curve, number: int, prepared: Prepared, coefficients: FloatArray
) -> FloatArray:
    """Unit tangents of the reference curve at its anchors, (g, 3); the mean of both sides at a corner."""
    basis = prepared.curves.bases[number]
    step = 1e-6 * np.min(np.diff(basis.break_points))
    after, before = (
        basis.evaluate(anchors + step, coefficients, 1),
        basis.evaluate(anchors - step, coefficients, 1),
    )
    after /= np.maximum(np.linalg.norm(after, axis=1), 1e-300)[:, None]
    before /= np.maximum(np.linalg.norm(before, axis=1), 1e-300)[:, None]
    tangent = after + before
    norm = np.linalg.norm(tangent, axis=1)
    folded = norm < 1e-6
    return np.where(folded[:, None], after, tangent / np.where(folded, 1.0, norm)[:, None])


def knot_distance(curve: Curve) -> float:
    """Mean distance of neighbouring knots, of the ends of polynomial segments, or the mean radius, metres.

    Taken from the reference of the gauge conditions, so that adjusting an adjusted network again changes nothing.
    """
    values = curve.values if curve.reference is None else curve.reference
    family = FAMILIES[curve.family]
    if family.rows == "points":
        return float(np.mean(np.linalg.norm(np.diff(values, axis=0), axis=1)))
    if len(values) == 1:
        return 1.0
    if family.rows == "powers":
        chords = values.reshape(-1, family.degree + 1, 3)[:, 1:].sum(axis=1)
        return max(float(np.mean(np.linalg.norm(chords, axis=1))), 1e-12)
    return max(float(np.sqrt(0.5 * np.sum(values[1:3] ** 2))), 1e-12)
