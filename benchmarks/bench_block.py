"""The synthetic aerial block of the benchmark, as a network.

The generator writes photo coordinates in millimetres, object coordinates in metres, angles in radians; its
frames, rotation sequence and uniform knot parameters are ours.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from splinebba_cli.core.camera.rotation import rotation_object_from_photo
from splinebba_cli.core.network import (
    Camera,
    Curve,
    CurveObservations,
    FloatArray,
    Images,
    IntArray,
    Network,
    PointObservations,
    Points,
    Role,
    RotationSequence,
)

FORMAT_MM = (230.0, 230.0)


def network_from_npz(path: str | Path) -> Network:
    """The network of an ``out.npz`` of the block generator.

    Control splines are fixed; all others have every knot weighted about its start (role partial).
     Exterior orientations start at ``eop0`` and are weighted about ``eop_prior``.

    Parameters
    ----------
    path : path of the archive

    Returns
    -------
    Network
        Local origin 0; locations start at segment + t0.
    """
    with np.load(path) as archive:
        data: dict[str, FloatArray] = {name: archive[name] for name in archive.files}
    distance, sigma_mm = float(data["f"]), float(data["sigma"])
    camera = Camera(
        "camera", distance, np.zeros(2), np.zeros(3), np.zeros(2), np.zeros(2), format_mm=FORMAT_MM
    )
    points, point_observations = _points(data, sigma_mm)
    image = _indices(data["img"])
    return Network(
        origin=np.zeros(3),
        cameras=(camera,),
        images=_images(data),
        points=points,
        curves=_curves(data),
        point_observations=point_observations,
        curve_observations=CurveObservations(
            image=image,
            curve=_indices(data["spl"]),
            photo_xy=np.asarray(data["xy"], dtype=np.float64),
            sigma=np.full((len(image), 2), sigma_mm),
            location=np.asarray(data["seg"] + data["t0"], dtype=np.float64),
            segment=np.full(len(image), -1, dtype=np.int64),
        ),
    )


def _indices(column: FloatArray) -> IntArray:
    return np.asarray(column, dtype=np.int64)


def _images(data: dict[str, FloatArray]) -> Images:
    start = data["eop0"]
    count = len(start)
    sequence: RotationSequence = "omega-phi-kappa"
    return Images(
        ids=tuple(str(i) for i in range(count)),
        camera=np.zeros(count, dtype=np.int64),
        rotation=rotation_object_from_photo(start[:, :3]),
        position=start[:, 3:].copy(),
        sequence=(sequence,) * count,
        prior=data["eop_prior"],
        prior_sigma=np.tile(data["eop_sigma"], (count, 1)),
    )


def _curves(data: dict[str, FloatArray]) -> tuple[Curve, ...]:
    knot_sigma = float(data["knot_sigma"])
    return tuple(
        Curve(
            id=str(i),
            role="control" if fixed else "partial",
            family="natural_cubic",
            values=knots,
            sigma=np.full(knots.shape, 0.0 if fixed else knot_sigma),
            parameterization="uniform",
        )
        for i, (knots, fixed) in enumerate(zip(data["knots0"], data["fixed"], strict=True))
    )


def _points(data: dict[str, FloatArray], sigma_mm: float) -> tuple[Points, PointObservations]:
    start, image = data["tie0"].reshape(-1, 3), _indices(data["tie_img"])
    role: tuple[Role, ...] = tuple("tie" for _ in start)
    points = Points(
        ids=tuple(str(i) for i in range(len(start))),
        role=role,
        xyz=start,
        sigma=np.full(start.shape, np.inf),
        check_sigma=np.full(start.shape, np.nan),
    )
    observations = PointObservations(
        image=image,
        point=_indices(data["tie_pt"]),
        photo_xy=data["tie_xy"].reshape(-1, 2),
        sigma=np.full((len(image), 2), sigma_mm),
    )
    return points, observations
