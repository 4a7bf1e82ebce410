"""S-transformation of differences of orientations to the datum of the mean of their perspective centres.

With d the differences (angles, positions) of m images and G (6m x 7) what small shifts, rotations and a change of scale
of the frame do to them,

    d' = S d,   C' = S C S',   S = I - G (G_p'G_p)^-1 G_p'

G_p has the rows of the positions only.  d' is what a similarity fitted to the perspective centres leaves, and C' does
not depend on the datums of the two adjustments.  (Baarda 1973, S-transformations and criterion matrices)
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.camera.rotation import angle_jacobian, cross_matrix
from splinebba_cli.core.network import FloatArray, RotationSequence
from splinebba_cli.core.quality.inner_datum import s_transformed

DATUM = 7  # shift 3, rotation 3, scale


def datum_matrix(
    rotation: FloatArray, angles: FloatArray, position: FloatArray, sequences: list[RotationSequence]
) -> FloatArray:
    """G: d(angles, X0) / d(shift, rotation, scale) about the mean of the positions, (6 m, 7).

    A rotation e of the object frame turns photos by R'e in their own frames.
    """
    about = position - position.mean(axis=0)
    found = np.zeros((len(position), 6, DATUM))
    for k, sequence in enumerate(sequences):
        found[k, :3, 3:6] = np.linalg.pinv(angle_jacobian(angles[k], sequence)) @ rotation[k].T
        found[k, 3:, 3:6] = -cross_matrix(about[k])
    found[:, 3:, :3] = np.eye(3)
    found[:, 3:, 6] = about
    return found.reshape(-1, DATUM)


def centred_dispersion(dispersion: FloatArray, datum: FloatArray) -> FloatArray:
    """C' = S C S' of differences (6 m, 6 m), C' of the same shape."""
    size = np.linalg.norm(datum, axis=0)
    scaled = datum / size
    positions = scaled.reshape(-1, 6, DATUM).copy()
    positions[:, :3] = 0.0
    fixed = positions.reshape(-1, DATUM)
    return s_transformed(dispersion, scaled, fixed)
