"""Cofactors of chains: redundancy numbers and location cofactors against a dense system with all locations in it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from splinebba_cli.core.estimation.normal_equations import Linearization
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.observations.along_curve import along_rows
from splinebba_cli.core.quality.cofactors import Cofactors
from splinebba_cli.core.quality.linked_cofactors import linked_cofactors
from splinebba_cli.core.quality.location_precision import location_cofactors
from splinebba_cli.core.quality.redundancy import redundancy_numbers
from splinebba_cli.simulation.linked_observations import with_arc_lengths, with_tangents
from splinebba_cli.simulation.truth import Truth
from tests.core.small_networks import dense_system, mixed_network, solved

TOLERANCE = (
    1e-7  # of 1: the condition of the system (1e7) times rounding, squared by the normal equations at most
)


@cache
def system() -> tuple[Cofactors, FloatArray, Linearization]:
    """Cofactors of the mixed network with some arcs and tangents left out, and its dense inverse."""
    network, truth = mixed_network()
    truth = replace(truth, locations=truth.locations[::3])
    network = linked(network, truth)
    found = solved(network)
    at = found.solution.linearization
    return Cofactors(found.assembler, found.solution), dense_system(found.assembler, at).inverse, at


def linked(network, truth: Truth):  # type: ignore[no-untyped-def]
    """Arcs of every chain but for gaps, tangents at every third point, both rules, both senses."""
    generator = np.random.default_rng(7)
    network = with_arc_lengths(network, truth, 0.007, generator)
    network = with_tangents(network, truth, 0.01, generator)
    arcs, tangents = network.arc_lengths, network.tangents
    keep = np.arange(len(arcs)) % 7 != 3
    some = np.arange(len(tangents)) % 3 == 1
    return replace(
        network,
        arc_lengths=replace(
            arcs,
            **{name: getattr(arcs, name)[keep] for name in ("first", "second", "length", "sigma", "simpson")},
        ),
        tangents=replace(
            tangents,
            **{name: getattr(tangents, name)[some] for name in ("point", "direction", "sigma", "directed")},
        ),
    )


def test_redundancy_numbers_sum_to_the_redundancy() -> None:
    cofactors, _, at = system()
    numbers = redundancy_numbers(cofactors, linked_cofactors(cofactors))
    network = cofactors.assembler.prepared.network
    design_rows = dense_system(cofactors.assembler, at).design
    used = (np.abs(design_rows).sum(axis=1) > 0.0).sum()
    assert abs(numbers.total - (used - design_rows.shape[1])) < TOLERANCE * used
    assert (numbers.arc_lengths > 0.0).all() and (numbers.arc_lengths < 1.0).all()
    assert len(numbers.tangents) == len(network.tangents)


def test_leverages_and_locations_against_all_unknowns_at_once() -> None:
    cofactors, inverse, at = system()
    found = linked_cofactors(cofactors)
    for window in at.linked_windows:
        rows, chains = window.batch.rows, window.batch.chains
        for chain in range(len(chains)):
            unknowns = np.unique(window.unknowns[chain])
            length = int((chains.points[chain] >= 0).sum())
            blocks, places = [], []
            for kind, jacobian, slopes in (
                ("along", rows.along, rows.along_slope),
                ("tangent", rows.tangent, rows.tangent_slope),
            ):
                for i in range(length):
                    b = np.zeros(length)
                    b[i] = slopes[chain, i]
                    blocks.append(np.concatenate([spread(window, chain, jacobian[chain, i]), b]))
                    places.append((kind, i))
            for i in range(length - 1):
                b = np.zeros(length)
                b[i : i + 2] = rows.arc_slopes[chain, i]
                blocks.append(np.concatenate([spread(window, chain, rows.arc[chain, i]), b]))
                places.append(("arc", i))
            matrix = np.array(blocks)
            j, b = matrix[:, :-length], matrix[:, -length:]
            free = np.abs(b).sum(axis=0) > 0.0
            inner = np.linalg.inv(b[:, free].T @ b[:, free])
            s = inner @ b[:, free].T @ j
            q = inverse[np.ix_(unknowns, unknowns)]
            location = inner + s @ q @ s.T
            full = np.block([[q, -q @ s.T], [-s @ q, location]])
            whole = np.hstack([j, b[:, free]])
            leverage = np.einsum("ij,jk,ik->i", whole, full, whole)
            for (kind, i), value in zip(places, leverage, strict=True):
                table, place = {
                    "along": (found.along, chains.points[chain, i]),
                    "tangent": (found.tangent, chains.tangents[chain, i]),
                    "arc": (found.arc, chains.arcs[chain, min(i, chains.arcs.shape[1] - 1)]),
                }[kind]
                if place >= 0:
                    assert abs(table[place] - value) < TOLERANCE
            points = chains.points[chain, :length][free]
            np.testing.assert_allclose(found.location[points], np.diag(location), rtol=1e-6)


def spread(window, chain: int, row: FloatArray) -> FloatArray:  # type: ignore[no-untyped-def]
    """A row over the distinct unknowns of its chain, removed ones zero."""
    values = row[:-1] * window.mask[chain]
    unknowns = np.unique(window.unknowns[chain])
    out = np.zeros(len(unknowns))
    np.add.at(out, np.searchsorted(unknowns, window.unknowns[chain]), values)
    return out


def test_location_cofactors_of_single_points() -> None:
    """The equation along the curve gives the location: its variance by the dense inverse; none where it is held."""
    cofactors, inverse, at = system()
    prepared, layout = cofactors.assembler.prepared, cofactors.assembler.layout
    variance = location_cofactors(cofactors, linked_cofactors(cofactors))
    single = np.flatnonzero(~prepared.chains.linked)
    free = np.setdiff1d(single, at.held)
    assert len(free) >= 5 and (variance[np.intersect1d(single, at.held)] == 0.0).all()
    along = along_rows(prepared, at.state, free)
    image = prepared.network.curve_observations.image[free]
    unknown = layout.unknown_of_coefficient[prepared.curves.columns[along.segment]]
    for k, point in enumerate(free):
        row = np.zeros(len(inverse))
        row[6 * image[k] + np.arange(6)] = along.orientation[k]
        np.add.at(row, unknown[k][:, None] + np.arange(3), along.coefficients[k])
        expected = (1.0 + row @ inverse @ row) / along.slope[k] ** 2
        assert variance[point] == pytest.approx(expected, rel=1e-6)
