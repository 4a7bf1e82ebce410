"""Lightest vertex separators of many graphs at once, by maximum flow.

Every group of nodes has been put into a line (by a coordinate or by distance in the graph).  Its
first nodes are the source, its last ones the sink; among the sets of nodes whose removal
separates the two, the lightest is wanted:

    min Σ w(v) over separators  =  maximum flow through the network with, for
                                   each node v:       v_in → v_out of capacity w(v)
                                   each edge {u, v}:  u_out → v_in and v_out → u_in, no limit

Between source and sink a band of nodes may go to either side, so that the separator finds the
weak place near the middle.  The groups are not connected with each other: one flow serves them
all.

References
----------
Schild, A., Sommer, C. (2015): On balanced separators in road networks. SEA 2015 (inertial flow).
Even, S. (1979): Graph Algorithms, chapter 6 (vertex connectivity as flow).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_array

from splinebba_cli.core.estimation.block_matrix import IntArray

FIRST, SECOND, SEPARATOR = 0, 1, 2


def vertex_separators(
    weights: IntArray, edges: IntArray, fraction: npt.NDArray[np.float64], band: float
) -> IntArray:
    """Split each group of nodes into two sides and the separator between them.

    Parameters
    ----------
    weights : (n,) int
        Weight of each node (its unknowns), at least 1; their sum below 2³⁰.
    edges : (2, e) int
        Coupled nodes, each pair once; none between two groups.
    fraction : (n,) float
        Place of each node in its group, 0 (first) to 1 (last), by weight.
    band : float
        Nodes with |fraction − 1/2| ≤ band may go to either side.

    Returns
    -------
    (n,) int
        FIRST, SECOND or SEPARATOR; no edge connects FIRST with SECOND.
    """
    core = np.where(fraction < 0.5 - band, -1, np.where(fraction > 0.5 + band, 1, 0))
    side = np.where(fraction < 0.5, FIRST, SECOND).astype(np.int64)
    u, v = edges
    open_edges = core[u] * core[v] != 1
    if not np.any(open_edges):
        return side
    nodes, ends = np.unique(edges[:, open_edges], return_inverse=True)
    ends = ends.reshape(2, -1)
    core = core[nodes]
    reached_in, reached_out = _source_side(weights[nodes], ends, core)
    inner = np.where(reached_in & ~reached_out, SEPARATOR, np.where(reached_out, FIRST, SECOND))
    side[nodes] = inner
    return side


def _source_side(
    weights: IntArray, edges: IntArray, core: IntArray
) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
    """Which v_in and v_out the source still reaches when the maximum flow runs."""
    from scipy.sparse.csgraph import breadth_first_order, maximum_flow  # not at start-up: it takes its time

    n = len(weights)
    source, sink = 2 * n, 2 * n + 1
    u, v = edges
    first, last = np.flatnonzero(core < 0), np.flatnonzero(core > 0)
    tails = np.concatenate([np.arange(n), n + u, n + v, np.full(len(first), source), n + last])
    heads = np.concatenate([n + np.arange(n), v, u, first, np.full(len(last), sink)])
    unlimited = int(weights.sum()) + 1
    capacity = np.full(len(tails), unlimited, dtype=np.int32)
    capacity[:n] = weights
    network = csr_array((capacity, (tails, heads)), shape=(2 * n + 2, 2 * n + 2))
    network.indices = network.indices.astype(np.int32, copy=False)
    network.indptr = network.indptr.astype(np.int32, copy=False)
    flow = maximum_flow(network, source, sink).flow
    residual = csr_array(network - flow)
    residual.eliminate_zeros()
    reached = np.zeros(2 * n + 2, dtype=bool)
    reached[breadth_first_order(residual, source, return_predecessors=False)] = True
    return reached[:n], reached[n : 2 * n]
