"""Where the images of a simulated block are taken from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.camera.collinearity import project
from splinebba_cli.core.camera.rotation import angles_from_rotation, rotation_object_from_photo
from splinebba_cli.core.network import BoolArray, FloatArray

# Lee (2008), table 5.3: X0, Y0, Z0 (m), omega, phi, kappa (deg); legible in full
LEE_TABLE_5_3 = np.array(
    [
        [3000.0, 4002.0, 503.0, 0.1146, 0.0573, 5.7296],
        [3305.0, 4005.0, 499.0, 0.1432, 0.0859, -5.7296],
        [3610.0, 3995.0, 505.0, 0.1719, 0.4584, 2.8648],
        [3613.0, 4613.0, 507.0, 0.2865, -0.0573, 185.6383],
        [3303.0, 4617.0, 493.0, -0.1432, 0.4011, 173.0333],
        [2997.0, 4610.0, 509.0, -0.1833, -0.2865, 181.6276],
    ]
)


@dataclass(frozen=True)
class BlockGeometry:
    """Exterior orientations and the one camera of a block."""

    eop: FloatArray  # (m, 6) omega, phi, kappa (rad), X0, Y0, Z0 (m)
    principal_distance_mm: float
    format_mm: tuple[float, float]  # width, height
    origin: FloatArray  # (3,) of the local frame, metres
    pixel_size_mm: float | None = None

    @property
    def image_count(self) -> int:
        """Number of images."""
        return len(self.eop)

    def photo_xy(self, image: int, xyz: FloatArray) -> FloatArray:
        """Exact photo coordinates (n, 2) mm of points in one image, NaN behind the camera."""
        rotation = rotation_object_from_photo(self.eop[image, :3])
        return project(
            np.full(len(xyz), self.principal_distance_mm),
            np.broadcast_to(rotation, (len(xyz), 3, 3)),
            self.eop[image, None, 3:],
            xyz,
        )

    def inside_format(self, image: int, photo_xy: FloatArray) -> BoolArray:
        """Whether photo coordinates lie inside the format, (n,)."""
        return inside(self.format_mm, photo_xy)


def inside(format_mm: tuple[float, float], photo_xy: FloatArray) -> BoolArray:
    """Whether photo coordinates lie inside a format (width, height) about their origin, (n,)."""
    with np.errstate(invalid="ignore"):
        return np.asarray((np.abs(photo_xy) <= 0.5 * np.asarray(format_mm)).all(axis=1))


def six_image_block(format_mm: tuple[float, float] = (230.0, 230.0)) -> BlockGeometry:
    """The two strips of three images of Lee (2008), table 5.3.

    c = 150 mm and the exterior orientations are Lee's.  The format is not given there; 230 mm yields the 60 %
    forward and 20 % side overlap of the text, at about 470 m above ground.
    """
    eop = np.column_stack([np.radians(LEE_TABLE_5_3[:, 3:]), LEE_TABLE_5_3[:, :3]])
    return BlockGeometry(eop, 150.0, format_mm, np.zeros(3))


def four_images(base_m: float = 300.0, height_m: float = 500.0) -> BlockGeometry:
    """Four nearly vertical views from the corners of a square about the origin, c = 150 mm, 1 : 3300."""
    corners = 0.5 * base_m * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    tilt = np.radians([[1.0, -0.5, 3.0], [0.5, 1.0, 92.0], [-1.0, 0.5, 181.0], [-0.5, -1.0, -88.0]])
    heights = height_m + np.array([2.0, -3.0, 1.0, -1.0])
    return BlockGeometry(np.column_stack([tilt, corners, heights]), 150.0, (230.0, 230.0), np.zeros(3))


def ring(
    images: int = 10, radius_m: float = 2.2, heights_m: tuple[float, float] = (1.0, 1.9)
) -> BlockGeometry:
    """Convergent views from a circle around the origin at two heights, c = 24 mm, every other one on its side."""
    generator = np.random.default_rng(59)
    azimuth = 2.0 * np.pi * (np.arange(images) + generator.uniform(-0.1, 0.1, images)) / images
    height = np.where(np.arange(images) % 2 == 0, *heights_m)
    position = np.column_stack([radius_m * np.cos(azimuth), radius_m * np.sin(azimuth), height])
    eop = np.empty((images, 6))
    eop[:, 3:] = position
    for k in range(images):
        backwards = (position[k] - [0.0, 0.0, 0.3]) / np.linalg.norm(position[k] - [0.0, 0.0, 0.3])
        right = np.cross([0.0, 0.0, 1.0], backwards)
        right /= np.linalg.norm(right)
        axes = np.column_stack([right, np.cross(backwards, right), backwards])
        if k % 2:
            axes = axes[:, [1, 0, 2]] * [1.0, -1.0, 1.0]
        eop[k, :3] = angles_from_rotation(axes, "omega-phi-kappa")
    return BlockGeometry(eop, 24.0, (36.0, 36.0), np.zeros(3))


def strip(
    images: int = 5,
    base_m: float = 300.0,
    height_m: float = 500.0,
    tilt_deg: float = 1.0,
    origin: tuple[float, float, float] = (7_672_000.0, 512_000.0, 0.0),
) -> BlockGeometry:
    """One strip along X with nearly vertical views; the origin is as large as real coordinates are.

    Parameters
    ----------
    images : number of images
    base_m : distance of neighbouring stations
    height_m : height of the stations above the zero of the local frame
    tilt_deg : standard deviation of omega, phi and kappa; positions vary by a hundredth of the height
    """
    generator = np.random.default_rng(53)
    eop = np.empty((images, 6))
    eop[:, :3] = generator.normal(0.0, np.radians(tilt_deg), (images, 3))
    eop[:, 3:] = generator.normal(0.0, 0.01 * height_m, (images, 3))
    eop[:, 3] += base_m * np.arange(images)
    eop[:, 5] += height_m
    return BlockGeometry(eop, 150.0, (230.0, 230.0), np.asarray(origin))
