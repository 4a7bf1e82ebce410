"""Gauge conditions that go along with a free network.

A condition keeps an anchor near its place on the reference curve, which lies in the frame of the approximate values.
Where nothing fixes the frame, the adjusted network may lie elsewhere, and conditions would pull it back by an amount
that depends on the datum.  So the reference curves are moved by the similarity that takes the approximate stations and
points onto the adjusted ones: residuals are then the same in every datum.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.curves.registry import FAMILIES
from splinebba_cli.core.network import Curve, FloatArray
from splinebba_cli.core.quality.similarity_fit import Similarity, fit_similarity
from splinebba_cli.core.state import Prepared, State, prepare


def with_moved_references(prepared: Prepared, start: State, state: State) -> Prepared:
    """The network with its reference curves moved as from `start` (the approximate values) to `state`."""
    similarity = fit_similarity(_stations(prepared, start), _stations(prepared, state))
    if similarity is None:
        return prepared
    curves = tuple(_moved(curve, similarity) for curve in prepared.network.curves)
    return prepare(replace(prepared.network, curves=curves))


def _stations(prepared: Prepared, state: State) -> FloatArray:
    """Perspective centres and points with a place, one below the other."""
    seen = np.zeros(len(state.xyz), dtype=bool)
    seen[prepared.network.point_observations.point] = True
    return np.vstack([state.position, state.xyz[seen]])


def _moved(curve: Curve, similarity: Similarity) -> Curve:
    """Positions among the values are moved, vectors among them turned and scaled."""
    reference = curve.reference if curve.reference is not None else curve.values
    positions = FAMILIES[curve.family].positions(len(reference))[:, None]
    turned = similarity.scale * reference @ similarity.rotation.T
    return replace(curve, reference=np.where(positions, similarity.apply(reference), turned))
