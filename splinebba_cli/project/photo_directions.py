"""Directions in image coordinates as directions in the photo frame, x right and y up."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.project.build_cameras import PhotoFrame
from splinebba_cli.project.build_images import ImageRows
from splinebba_cli.project.scalars import ImageCoordinates

PIXELS = ("pixel_corner", "pixel_centre", "pixel_one")


class InImageCoordinates(Protocol):
    """A group of observations that may declare its own frame."""

    @property
    def image_coordinates(self) -> ImageCoordinates | None:
        """Frame of its values; None: that of the camera."""


def frames_of_rows(
    group: InImageCoordinates, image: IntArray, images: ImageRows, frames: list[PhotoFrame]
) -> list[tuple[IntArray, PhotoFrame, str]]:
    """Rows of every camera with its frame and the frame of the group's values."""
    cameras = np.array(
        [*images.cameras, -1, -1], dtype=np.int64
    )  # the last two: of images that are not known
    camera = cameras[image]
    return [
        (np.flatnonzero(camera == k), frames[k], group.image_coordinates or frames[k].image_coordinates)
        for k in np.unique(camera[camera >= 0])
    ]


def directions_in_photo(
    direction: FloatArray,
    group: InImageCoordinates,
    image: IntArray,
    images: ImageRows,
    frames: list[PhotoFrame],
) -> FloatArray:
    """Directions of a group in the photo frame (y up), (n,) rad."""
    out = direction.copy()
    for rows, frame, wanted in frames_of_rows(group, image, images, frames):
        if wanted in PIXELS:
            width, height = frame.pixel_size_mm if frame.pixel_size_mm is not None else (1.0, 1.0)
            out[rows] = np.arctan2(-height * np.sin(direction[rows]), width * np.cos(direction[rows]))
    return out
