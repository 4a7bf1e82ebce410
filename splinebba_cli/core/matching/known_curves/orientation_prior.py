"""How far the given orientations may be off: priors of the user, assumed standard deviations where there are none.

In the frame of the solver, theta (photo frame, rad) and X0 (m):  S = T diag(sigma^2) T',  theta = J d(angles).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.approximation.orientation import given_orientations
from splinebba_cli.core.camera.rotation import angle_jacobian
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.network import BoolArray, FloatArray, Images, Network, RotationSequence
from splinebba_cli.core.quality.orientation_dispersion import eop_values

NEARLY_SINGULAR = 0.8  # sine of the second rotation
GUESSED_ANGLE = 0.0035  # rad, where nobody says how far orientations are off: the first of growing guesses


@dataclass(frozen=True)
class OrientationPrior:
    """Given orientations with their dispersion; NaN where an image has none."""

    rotation: FloatArray  # (m, 3, 3)
    position: FloatArray  # (m, 3) metres
    sigma: FloatArray  # (m, 6) of omega, phi, kappa, X0, Y0, Z0
    assumed: BoolArray  # (m, 6) not stated by the network as a prior: no measurement
    guessed: BoolArray  # (m,) neither stated by the settings
    dispersion: FloatArray  # (m, 6, 6) of theta, X0

    @property
    def known(self) -> BoolArray:
        """Images that have an orientation, (m,)."""
        return np.asarray(np.isfinite(self.position).all(axis=1))

    def widened(self, image: int, factor: float, images: Images) -> OrientationPrior:
        """The same with other assumed standard deviations of one image, where they are guesses."""
        if not self.guessed[image]:
            return self
        sigma = self.sigma.copy()
        sigma[image] = np.where(self.assumed[image], factor * sigma[image], sigma[image])
        return replace(self, sigma=sigma, dispersion=_dispersion(images, self.rotation, sigma, self.assumed))


def orientation_prior(network: Network, settings: MatchSettings, distance: FloatArray) -> OrientationPrior:
    """Priors of all images.

    Parameters
    ----------
    distance : (m,) metres, of every image from what it sees: a guess of the position follows from that of the angles
    """
    images = network.images
    rotation, position = given_orientations(network)
    angle, shift = settings.angle_sigma_rad, settings.position_sigma_m
    guess = np.empty((len(images.ids), 6))
    guess[:, :3] = GUESSED_ANGLE if angle is None else angle
    guess[:, 3:] = (GUESSED_ANGLE * distance)[:, None] if shift is None else shift
    assumed = ~np.isfinite(images.prior_sigma)
    sigma = np.where(assumed, guess, images.prior_sigma)
    unstated = np.column_stack(
        [np.full((len(sigma), 3), angle is None), np.full((len(sigma), 3), shift is None)]
    )
    return OrientationPrior(
        rotation=rotation,
        position=position,
        sigma=sigma,
        assumed=assumed,
        guessed=(assumed & unstated).any(axis=1),
        dispersion=_dispersion(images, rotation, sigma, assumed),
    )


def _dispersion(images: Images, rotation: FloatArray, sigma: FloatArray, assumed: BoolArray) -> FloatArray:
    """Dispersions (m, 6, 6); angles that are all assumed are off by the same amount about every axis."""
    dispersion = solver_dispersion(images, rotation, sigma)
    turned = np.flatnonzero(assumed[:, :3].all(axis=1))
    dispersion[turned, :3, :3] = np.eye(3) * sigma[turned, :1, None] ** 2
    return dispersion


def solver_dispersion(images: Images, rotation: FloatArray, sigma: FloatArray) -> FloatArray:
    """Dispersion (m, 6, 6) of (theta, X0) of independent angles and coordinates with standard deviations (m, 6)."""
    transform = np.zeros((len(images.ids), 6, 6))
    transform[:, [3, 4, 5], [3, 4, 5]] = 1.0
    values = eop_values(images, np.nan_to_num(rotation), np.zeros((len(images.ids), 3)))
    for sequence in set(images.sequence):
        rows = np.flatnonzero([s == sequence for s in images.sequence])
        transform[rows, :3, :3] = angle_jacobian(values[rows, :3], sequence)
    return np.asarray(np.einsum("mij,mj,mkj->mik", transform, sigma**2, transform))


def with_prior(network: Network, prior: OrientationPrior, held: BoolArray) -> Network:
    """The network with all priors as measurements, assumed ones too; some images held at the prior.

    Parameters
    ----------
    held : (m,) images that stay as they are
    """
    images = replace(network.images, sequence=_regular_sequences(network.images, prior))
    known = prior.known
    values = eop_values(images, np.nan_to_num(prior.rotation), np.nan_to_num(prior.position))
    value = np.where(prior.assumed, values, images.prior)
    sigma = np.where((held | ~known)[:, None], 0.0, prior.sigma)
    value = np.where((held | ~known)[:, None], values, value)
    return replace(network, images=replace(images, prior=value, prior_sigma=sigma))


def without_assumed(network: Network, prior: OrientationPrior, kept: BoolArray) -> Network:
    """The same network with assumed priors as measurements in some images only.

    Parameters
    ----------
    kept : (m,) images that keep them
    """
    held = np.where(kept[:, None] | ~prior.assumed, network.images.prior_sigma, np.inf)
    fixed = (network.images.prior_sigma == 0.0).all(axis=1)[:, None]
    return replace(network, images=replace(network.images, prior_sigma=np.where(fixed, 0.0, held)))


def _regular_sequences(images: Images, prior: OrientationPrior) -> tuple[RotationSequence, ...]:
    """The rotation sequences, another one where angles are assumed and the second rotation is near a right angle."""
    other: dict[RotationSequence, RotationSequence] = {
        "omega-phi-kappa": "phi-omega-kappa",
        "phi-omega-kappa": "omega-phi-kappa",
    }
    angles = eop_values(images, np.nan_to_num(prior.rotation), np.zeros((len(images.ids), 3)))
    second = np.where([s == "omega-phi-kappa" for s in images.sequence], angles[:, 1], angles[:, 0])
    turn = (np.abs(np.sin(second)) > NEARLY_SINGULAR) & prior.assumed[:, :3].all(axis=1)
    return tuple(other[s] if t else s for s, t in zip(images.sequence, turn, strict=True))
