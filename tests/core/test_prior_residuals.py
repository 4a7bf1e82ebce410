"""Columns of residuals of priors and conditions: rows, units, groups."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.prior_residuals import PriorResidual, PriorResiduals

ROWS = (
    PriorResidual("eop prior", "7", "omega", 1e-4, 1e-3, 0.9, 0.1, 4e-3, 1.3),
    PriorResidual("control point", "a", "x", 0.01, 0.02, 0.5, 0.7, 0.1, 4.1),
    PriorResidual("eop prior", "7", "x", 0.02, 0.1, 0.8, 0.2, 0.4, 2.0),
    PriorResidual("gauge", "road", "knot 1 along the curve", 0.0, 0.5, 0.1),
    PriorResidual("eop prior", "8", "kappa", 2e-4, 1e-3, 0.7, 0.2, 4e-3, 2.7),
)


def test_rows_come_back_as_they_went_in() -> None:
    found = PriorResiduals.of_rows(ROWS)
    assert len(found) == len(ROWS)
    for single, each, row in zip((found[k] for k in range(len(ROWS))), found, ROWS, strict=True):
        for name in PriorResidual.__dataclass_fields__:
            np.testing.assert_equal(getattr(single, name), getattr(row, name))
            np.testing.assert_equal(getattr(each, name), getattr(row, name))


def test_groups_in_the_order_of_appearance() -> None:
    found = PriorResiduals.of_rows(ROWS)
    assert found.angular.tolist() == [True, False, False, False, True]
    groups = [(kind, angular, rows.tolist()) for kind, angular, rows in found.groups()]
    assert groups == [
        ("eop prior", True, [0, 4]),
        ("control point", False, [1]),
        ("eop prior", False, [2]),
        ("gauge", False, [3]),
    ]


def test_nothing_at_all() -> None:
    none = PriorResiduals.of_rows(())
    assert not len(none) and not list(none) and not none.groups() and not len(none.angular)
