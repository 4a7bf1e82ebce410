"""match(network): orientations, labels and shapes for points that nobody has labelled, in order."""

from __future__ import annotations

import logging
import time
from dataclasses import replace

import numpy as np

from splinebba_cli.core.curves.registry import basis_of, lasting_parameters
from splinebba_cli.core.estimation.gauss_markov import Observer
from splinebba_cli.core.matching.free_orientation.orient_freely import orient_freely
from splinebba_cli.core.matching.known_curves.finishing import Known
from splinebba_cli.core.matching.known_curves.loop import match_known_curves
from splinebba_cli.core.matching.labelled_network import with_labels
from splinebba_cli.core.matching.matches import MatchResult
from splinebba_cli.core.matching.new_curves import WithNewCurves, with_new_curves
from splinebba_cli.core.matching.second_edges_of_given import given_with_two_edges
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.network import Curve, FloatArray, Network
from splinebba_cli.core.quality.orientation_dispersion import eop_dispersion
from splinebba_cli.core.result import Problem
from splinebba_cli.core.state import prepare

_log = logging.getLogger(__name__)


def match(
    network: Network, settings: MatchSettings | None = None, *, observer: Observer | None = None
) -> MatchResult:
    """Match the unlabelled points of a network.

    Parameters
    ----------
    settings : MatchSettings, optional
    observer : called after every iteration of the adjustments inside

    Returns
    -------
    MatchResult
    """
    settings = settings or MatchSettings()
    begin = time.perf_counter()
    oriented, unoriented = _oriented(network, settings)
    timings = {"free_orientation_s": time.perf_counter() - begin}
    begin = time.perf_counter()
    _log.info("matching against given curves")
    known = match_known_curves(oriented, settings, observer=observer)
    improved = _improved(oriented, known)
    timings["known_curves_s"] = time.perf_counter() - begin
    found = WithNewCurves(improved, known.matches, (), ())
    if settings.new_curves:
        _log.info("building curves")
        begin = time.perf_counter()
        found = with_new_curves(improved, known.state, known.matches, settings)
        timings["new_curves_s"] = time.perf_counter() - begin
    return MatchResult(
        network=with_labels(found.network, found.matches.curve, found.matches.location),
        given=network,
        matches=found.matches,
        oriented=known.oriented,
        eop_dispersion=_dispersion(improved, known),
        history=known.history,
        built=found.built,
        problems=(
            *unoriented,
            *known.problems,
            *given_with_two_edges(improved, known.state, known.matches),
            *found.problems,
        ),
        timings=timings,
    )


def _oriented(network: Network, settings: MatchSettings) -> tuple[Network, tuple[Problem, ...]]:
    """The network with orientations of images that have none, and why some stay without."""
    if not settings.orient_freely or network.images.has_orientation.all():
        return network, ()
    _log.info("searching for orientations")
    found = orient_freely(network, settings)
    return found.apply(network), found.problems


def _improved(network: Network, known: Known) -> Network:
    """The network with better approximate orientations and shapes."""
    images, given = network.images, network.images.has_orientation | known.oriented
    rotation = np.where(given[:, None, None], known.state.rotation, images.rotation)
    position = np.where(given[:, None], known.state.position, images.position)
    curves = network.curves
    if known.improved_curves.any():
        prepared = prepare(network)
        start = prepared.curves.coefficient_start
        curves = tuple(
            _with_shape(curve, known.state.coefficients[start[k] : start[k + 1]])
            if known.improved_curves[k]
            else curve
            for k, curve in enumerate(network.curves)
        )
    return replace(network, images=replace(images, rotation=rotation, position=position), curves=curves)


def _with_shape(curve: Curve, coefficients: FloatArray) -> Curve:
    """A curve with other approximate values; the reference of its gauge conditions stays."""
    basis = basis_of(curve)
    values = np.where(np.isinf(curve.sigma), basis.values_from_coefficients(coefficients), curve.values)
    reference = curve.values if curve.reference is None else curve.reference
    return replace(
        curve, values=values, reference=reference, knot_parameters=lasting_parameters(curve, basis)
    )


def _dispersion(network: Network, known: Known) -> FloatArray:
    """Dispersions (m, 6, 6) of omega, phi, kappa, X0, Y0, Z0; NaN where not estimated."""
    found = np.full((len(known.oriented), 6, 6), np.nan)
    if known.oriented.any():
        blocks = np.where(known.oriented[:, None, None], known.dispersion, 0.0)
        rotation = np.where(np.isfinite(network.images.rotation), network.images.rotation, np.eye(3))
        turned = eop_dispersion(network.images, rotation, blocks)
        found[known.oriented] = turned[known.oriented]
    return found
