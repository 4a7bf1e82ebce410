"""The values that the adjustment improves, and the prepared form of a network."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from splinebba_cli.core.camera.distortion import corrected_photo_xy
from splinebba_cli.core.chains import Chains
from splinebba_cli.core.curves.basis import CurveBasis
from splinebba_cli.core.curves.curve_set import CurveSet
from splinebba_cli.core.curves.registry import basis_of
from splinebba_cli.core.curves.shape_forms import retracted
from splinebba_cli.core.measured_rays import MeasuredRays
from splinebba_cli.core.network import BoolArray, Curve, FloatArray, IntArray, Network
from splinebba_cli.core.tracks import Tracks

EXTENSION = 0.5  # how far beyond its ends an open curve may be measured, in end segments


@dataclass(frozen=True)
class State:
    """Current values of all unknowns."""

    rotation: FloatArray  # (m, 3, 3) object from photo
    position: FloatArray  # (m, 3) metres
    coefficients: FloatArray  # (C, 3) metres
    xyz: FloatArray  # (n, 3) metres
    location: FloatArray  # (n_curve_observations,) u


@dataclass(frozen=True)
class ImageRays:
    """Image points freed of interior orientation, with their whitening.

    ``whitening`` W turns a residual of corrected coordinates into measured residuals over their sigma:
    W = diag(1/sigma) (d corrected / d measured)^-1.
    """

    xy: FloatArray  # (n, 2) mm, corrected
    whitening: FloatArray  # (n, 2, 2) 1/mm


@dataclass(frozen=True)
class ScalarMeasurements:
    """Measured lengths (mm) or directions (rad) carried into the corrected photo frame, with their sigma there."""

    value: FloatArray  # (q,)
    sigma: FloatArray  # (q,)
    rate: FloatArray  # (q,) d corrected / d measured


@dataclass(frozen=True)
class Prepared:
    """A network with everything that does not change during the iterations."""

    network: Network
    curves: CurveSet
    principal_distance: FloatArray  # (m,) mm, per image
    point_rays: ImageRays
    curve_rays: ImageRays
    arc_lengths: ScalarMeasurements
    tangents: ScalarMeasurements
    chains: Chains  # measured curve points that arc lengths and tangents link

    @cached_property
    def tracks(self) -> Tracks:
        """Measured curve points by curve and image."""
        return Tracks.of(self.network.curve_observations)

    @cached_property
    def rays_by_component(self) -> MeasuredRays:
        """Measured curve points, component by component."""
        return MeasuredRays.of(self.curve_rays.xy, self.curve_rays.whitening)

    @cached_property
    def corners(self) -> BoolArray:
        """Segments that begin at a corner of their curve, (S,)."""
        out = np.zeros(len(self.curves.left), dtype=bool)
        for number, curve in enumerate(self.network.curves):
            if curve.breaks:
                out[self.curves.segment_start[number] + np.array(curve.breaks)] = True
        return out

    @cached_property
    def location_bounds(self) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest allowed location of every measured curve point, (n,) each."""
        observed, curves = self.network.curve_observations, self.curves
        curve = observed.curve
        first_segment, last_segment = curves.segment_start[curve], curves.segment_start[curve + 1] - 1
        low = curves.first[curve] - EXTENSION * curves.length[first_segment]
        high = curves.last[curve] + EXTENSION * curves.length[last_segment]
        low = np.where(curves.closed[curve], -np.inf, low)
        high = np.where(curves.closed[curve], np.inf, high)
        bound = observed.segment >= 0
        segment = np.clip(first_segment + observed.segment, first_segment, last_segment)
        low = np.where(bound, curves.left[segment], low)
        high = np.where(bound, curves.left[segment] + curves.length[segment], high)
        single = ~curves.has_location[curve]
        return np.where(single, 0.0, low), np.where(single, 0.0, high)


def prepare(network: Network) -> Prepared:
    """Curve tables and corrected, whitened image points of a network."""
    c = np.array([camera.principal_distance_mm for camera in network.cameras])
    points, curves = network.point_observations, network.curve_observations
    curve_rays = image_rays(network, curves.image, curves.photo_xy, curves.sigma)
    return Prepared(
        network=network,
        curves=CurveSet.of([basis_of(curve) for curve in network.curves]),
        principal_distance=c[network.images.camera],
        point_rays=image_rays(network, points.image, points.photo_xy, points.sigma),
        curve_rays=curve_rays,
        arc_lengths=_corrected_lengths(network, curve_rays),
        tangents=_corrected_directions(network, curve_rays),
        chains=Chains.of(network),
    )


def _corrected_lengths(network: Network, rays: ImageRays) -> ScalarMeasurements:
    """Arc lengths in the corrected frame: scaled as the chord between their measured ends."""
    arcs, measured = network.arc_lengths, network.curve_observations.photo_xy
    before = np.linalg.norm(measured[arcs.second] - measured[arcs.first], axis=1)
    after = np.linalg.norm(rays.xy[arcs.second] - rays.xy[arcs.first], axis=1)
    scale = np.divide(after, before, out=np.ones_like(before), where=before > 0.0)
    return ScalarMeasurements(scale * arcs.length, scale * arcs.sigma, scale)


def _corrected_directions(network: Network, rays: ImageRays) -> ScalarMeasurements:
    """Directions in the corrected frame: turned by M = d corrected / d measured, d angle = det M / |M d|^2."""
    tangents, observed = network.tangents, network.curve_observations
    scaled = rays.whitening[tangents.point] * observed.sigma[tangents.point][:, :, None]
    correction = np.linalg.inv(scaled)
    direction = np.stack([np.cos(tangents.direction), np.sin(tangents.direction)], axis=1)
    turned = np.matmul(correction, direction[:, :, None])[:, :, 0]
    rate = np.abs(np.linalg.det(correction)) / np.sum(turned**2, axis=1)
    return ScalarMeasurements(np.arctan2(turned[:, 1], turned[:, 0]), tangents.sigma * rate, rate)


def image_rays(network: Network, image: IntArray, photo_xy: FloatArray, sigma: FloatArray) -> ImageRays:
    """Corrected image points with their whitening, of measured ones in given images."""
    camera_of = network.images.camera[image]
    xy = np.empty_like(photo_xy)
    whitening = np.empty((len(photo_xy), 2, 2))
    for number, camera in enumerate(network.cameras):
        rows = np.flatnonzero(camera_of == number)
        if not len(rows):
            continue
        xy[rows], jacobian = corrected_photo_xy(camera, photo_xy[rows])
        whitening[rows] = np.linalg.inv(jacobian) / sigma[rows][:, :, None]
    return ImageRays(xy, whitening)


def initial_coefficients(prepared: Prepared) -> FloatArray:
    """Coefficients of the approximate curves, (C, 3), with held values and shape conditions exact."""
    parts = [
        _starting_coefficients(basis, curve)
        for basis, curve in zip(prepared.curves.bases, prepared.network.curves, strict=True)
    ]
    return on_shape(prepared, np.vstack(parts)) if parts else np.zeros((0, 3))


def _starting_coefficients(basis: CurveBasis, curve: Curve) -> FloatArray:
    """Of one curve, (m, 3); a held value that is a coefficient is exact also where continuity binds the others."""
    coefficients = basis.coefficients_from_values(curve.values)
    if basis.coefficient_count < len(curve.values) and (curve.sigma == 0.0).any():
        rows, columns, factor = basis.pure_values()
        held = curve.sigma[rows] == 0.0
        exact = curve.values[rows] / factor[:, None]
        coefficients[columns] = np.where(held, exact, coefficients[columns])
    return coefficients


def on_shape(prepared: Prepared, coefficients: FloatArray) -> FloatArray:
    """Coefficients of all curves (C, 3) moved to where shape conditions are exact; curves of known shape stay."""
    found = coefficients
    for k in prepared.curves.shaped:
        rows = slice(*(int(n) for n in prepared.curves.coefficient_start[k : k + 2]))
        forms = prepared.curves.bases[k].shape_forms
        touched = np.abs(forms).sum(axis=(0, 1)) > 0.0
        if (prepared.network.curves[k].sigma[touched] != 0.0).any():
            found = found.copy() if found is coefficients else found
            found[rows] = retracted(forms, coefficients[rows])
    return found
