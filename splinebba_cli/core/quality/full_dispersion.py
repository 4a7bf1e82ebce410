"""The full dispersion matrix, on request, for small networks: columns of the inverse by solves."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.estimation.blas_threads import one_thread
from splinebba_cli.core.quality.cofactors import Cofactors
from splinebba_cli.core.quality.orientation_dispersion import eop_transform
from splinebba_cli.core.result import DispersionBlocks

EOP = ("omega", "phi", "kappa", "x", "y", "z")
LARGEST = 5000  # unknowns


def dispersion_blocks(cofactors: Cofactors, scale: float) -> DispersionBlocks:
    """Dispersion of all orientations and all values of curves, with names of rows (rad, m).

    Raises
    ------
    ValueError
        If the network is too large for a full matrix.
    """
    assembler, solution = cofactors.assembler, cofactors.solution
    layout, network = assembler.layout, assembler.prepared.network
    size = int(layout.node_starts[-1])
    if size > LARGEST:
        raise ValueError(f"a full dispersion of {size} unknowns is too large: the limit is {LARGEST}")
    if solution.factor is None:
        raise ValueError("no factor")
    mask = assembler.mask
    inverse = solution.factor.solve(np.eye(size)) * mask[:, None] * mask[None, :]
    if cofactors.datum is not None:
        inverse = cofactors.datum.of_reduced(inverse, layout)
    names, rows = [], []
    transform = eop_transform(network.images, solution.state.rotation)
    for k, id_ in enumerate(network.images.ids):
        block = np.zeros((6, size))
        block[:, 6 * k : 6 * k + 6] = transform[k]
        rows.append(block)
        names += [f"image {id_} {name}" for name in EOP]
    unknown = layout.unknown_of_coefficient
    for k, curve in enumerate(network.curves):
        basis, start = assembler.prepared.curves.bases[k], int(assembler.prepared.curves.coefficient_start[k])
        block = np.zeros((len(basis.value_columns), 3, size))
        for row in range(len(block)):
            for slot in range(basis.value_columns.shape[1]):
                place = unknown[start + basis.value_columns[row, slot]]
                block[row, range(3), place + np.arange(3)] += basis.value_weights[row, slot]
            names += [f"spline {curve.id} value {row} {axis}" for axis in "xyz"]
        rows.append(block.reshape(-1, size))
    linear = np.vstack(rows) if rows else np.zeros((0, size))
    with one_thread():  # the same digits with any number of them
        matrix = linear @ inverse @ linear.T * scale
    return DispersionBlocks(tuple(names), matrix)
