"""Fragments sampled from known curves, as chains of oriented images would give them: noise, links, pieces."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from splinebba_cli.core.camera.collinearity import project_with_jacobian
from splinebba_cli.core.matching.fragments.fragment import Fragment
from splinebba_cli.core.network import FloatArray, IntArray, Network
from splinebba_cli.core.observations.location_search import search_locations
from splinebba_cli.core.state import Prepared, State, image_rays, initial_coefficients, prepare


def state_of(network: Network) -> tuple[Prepared, State]:
    """The labelled network at its given values, with foot points."""
    prepared = prepare(network)
    state = State(
        network.images.rotation, network.images.position, initial_coefficients(prepared), network.points.xyz,
        network.curve_observations.location,
    )  # fmt: skip
    return prepared, search_locations(prepared, state)


def sampled_fragments(
    network: Network, order: IntArray, generator: np.random.Generator, *, gap: float = np.inf
) -> list[Fragment]:
    """One fragment for every curve and reference image, cut where locations jump.

    Parameters
    ----------
    network : labelled, at values that fit the measurements
    order : (n,) curve observation of every unlabelled row
    gap : metres between neighbouring places beyond which a fragment is cut
    """
    prepared, state = state_of(network)
    observed = network.curve_observations
    location = state.location[order]
    curve, image = observed.curve[order], observed.image[order]
    fragments = []
    for k in range(len(network.curves)):
        own = np.flatnonzero(curve == k)
        for reference in np.unique(image[own]):
            places = own[image[own] == reference]
            places = places[np.argsort(location[places], kind="stable")]
            if len(places) < 4:
                continue
            xyz = prepared.curves.evaluate(state.coefficients, curve[places], location[places])[0]
            dispersion = place_dispersion(network, prepared, state, order[places], own_images(image[own]))
            noise = np.linalg.cholesky(dispersion + 1e-12 * np.eye(3)) @ generator.normal(
                size=(len(places), 3, 1)
            )
            fragments += list(
                _pieces(
                    xyz + noise[:, :, 0],
                    dispersion,
                    location[places],
                    own,
                    location[own],
                    gap,
                    int(reference),
                )
            )
    return fragments


def own_images(image: IntArray) -> IntArray:
    """Images that see a curve."""
    return np.unique(image)


def place_dispersion(
    network: Network, prepared: Prepared, state: State, rows: IntArray, images: IntArray
) -> FloatArray:
    """Of places on the rays of measured points, with one equation across from every other image, (k, 3, 3)."""
    observed = network.curve_observations
    curve, u = observed.curve[rows], state.location[rows]
    xyz, tangent = prepared.curves.evaluate(state.coefficients, curve, u, (0, 1))
    normal = np.zeros((len(rows), 3, 3))
    sigma = observed.sigma[rows[0], 0]
    for k in images:
        each = np.full(len(rows), k)
        _, jacobian = project_with_jacobian(
            prepared.principal_distance[each], state.rotation[each], state.position[each], xyz
        )
        a = jacobian.object_xyz / sigma
        if k == observed.image[rows[0]]:
            normal += np.einsum("nri,nrj->nij", a, a)
            continue
        b = np.einsum("nri,ni->nr", a, tangent)
        n = np.stack([-b[:, 1], b[:, 0]], axis=1) / np.linalg.norm(b, axis=1, keepdims=True)
        g = np.einsum("nr,nri->ni", n, a)
        normal += g[:, :, None] * g[:, None, :]
    return np.asarray(
        np.linalg.inv(normal + 1e-4 * np.trace(normal, axis1=1, axis2=2)[:, None, None] * np.eye(3) / 3.0)
    )


def _pieces(
    xyz: FloatArray, dispersion: FloatArray, u: FloatArray, row: IntArray, row_u: FloatArray, gap: float, image: int
) -> Iterator[Fragment]:  # fmt: skip
    cuts = [0, *(np.flatnonzero(np.diff(u) > gap) + 1).tolist(), len(u)]
    for first, stop in pairwise(cuts):
        if stop - first < 4:
            continue
        inside = (row_u >= u[first]) & (row_u <= u[stop - 1])
        place = np.interp(row_u[inside], u[first:stop], np.arange(stop - first))
        rows = row[inside]
        by_row = np.argsort(rows)
        yield Fragment(
            xyz[first:stop], dispersion[first:stop], np.full(stop - first, 4), np.zeros(stop - first, dtype=bool),
            rows[by_row], place[by_row], False, image,
        )  # fmt: skip


def corrected(network: Network) -> FloatArray:
    """Corrected coordinates of the unlabelled points, (n, 2) mm."""
    points = network.unlabelled
    return image_rays(network, points.image, points.photo_xy, points.sigma).xy
