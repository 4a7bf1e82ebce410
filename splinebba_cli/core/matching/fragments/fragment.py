"""A piece of a curve in space that chains of several images agree upon."""

from __future__ import annotations

from dataclasses import dataclass

from splinebba_cli.core.network import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class Fragment:
    """Places along one edge, in order, and the unlabelled image points that show it.

    Every place lies on the ray of a measured point of the reference image (its two image coordinates fix it across
    that ray) and in the best depth for the chains of the other images, each of which gives one equation across
    itself.  The dispersion is that of the a priori sigmas of the image points; orientations count as known.

    Attributes
    ----------
    xyz : (k, 3) metres, local object frame, in the order of the reference chain
    dispersion : (k, 3, 3) m^2; across the curve it says how well the place is known.  The position along the curve
        is that of the measured point of the reference image and means nothing
    image_count : (k,) images that measured the place, two or more
    weak : (k,) True where the images leave the depth open: the curve runs along the epipolar direction in all pairs
    link_row : (q,) unlabelled points of the network that belong to the fragment, ascending, each once
    link_place : (q,) place along the fragment, 0 <= place <= k - 1: 2.5 lies half way between places 2 and 3
    closed : whether the last place is followed by the first
    reference_image : image whose rays carry the places
    """

    xyz: FloatArray
    dispersion: FloatArray
    image_count: IntArray
    weak: BoolArray
    link_row: IntArray
    link_place: FloatArray
    closed: bool = False
    reference_image: int = -1

    def __len__(self) -> int:
        return len(self.xyz)

    @property
    def two_images(self) -> BoolArray:
        """Places that no third image confirms, (k,)."""
        return self.image_count < 3
