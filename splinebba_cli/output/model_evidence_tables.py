"""Tables of tests of groups and of systematic effects, where there are any."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.evidence import GroupTest, SystematicEffect
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.output.columns import Column, Table

_NUMBER = "%.6g"
_COMPONENTS = 3


def model_evidence_tables(result: AdjustmentResult) -> tuple[Table, ...]:
    """``group_tests`` and ``systematic_effects``, those that have rows."""
    tables = (group_tests_table(result.evidence.groups), systematic_table(result.evidence.systematic))
    return tuple(table for table in tables if len(table))


def group_tests_table(tests: tuple[GroupTest, ...]) -> Table:
    """One row a group: estimated common error (across, or X, Y, Z) in its unit, test, detectable error."""
    estimate, sigma = np.full((2, len(tests), _COMPONENTS), np.nan)
    for row, test in enumerate(tests):
        estimate[row, : len(test.estimate)] = test.estimate
        sigma[row, : len(test.sigma)] = test.sigma
    columns = [
        Column("kind", [test.kind for test in tests]),
        Column("group", [test.name for test in tests]),
        Column("model", [test.model for test in tests]),
        Column("unit", [test.unit for test in tests]),
        Column("observations", np.array([test.observations for test in tests], dtype=np.int64)),
    ]
    for k in range(_COMPONENTS):
        columns += [
            Column(f"estimate_{k + 1}", estimate[:, k], _NUMBER),
            Column(f"sigma_{k + 1}", sigma[:, k], _NUMBER),
        ]
    columns += [
        Column("freedom", np.array([test.parameters for test in tests], dtype=np.int64)),
        Column("statistic", np.array([test.statistic for test in tests]), _NUMBER),
        Column("critical", np.array([test.critical for test in tests]), _NUMBER),
        Column("passed", ["true" if test.passed else "false" for test in tests]),
        Column("minimal_detectable", np.array([test.minimal_detectable for test in tests]), _NUMBER),
    ]
    return Table("group_tests", tuple(columns))


def systematic_table(effects: tuple[SystematicEffect, ...]) -> Table:
    """One row a test."""
    columns = (
        Column("kind", [effect.kind for effect in effects]),
        Column("subject", [effect.subject for effect in effects]),
        Column("estimate", np.array([effect.estimate for effect in effects]), _NUMBER),
        Column("unit", [effect.unit for effect in effects]),
        Column("observations", np.array([effect.observations for effect in effects], dtype=np.int64)),
        Column("statistic", np.array([effect.statistic for effect in effects]), _NUMBER),
        Column("critical", np.array([effect.critical for effect in effects]), _NUMBER),
        Column("significant", ["true" if effect.significant else "false" for effect in effects]),
        Column("shown", np.array([effect.shown for effect in effects]), _NUMBER),
        Column("detail", [effect.detail for effect in effects]),
    )
    return Table("systematic_effects", columns)
