"""How thoroughly the range of a prior is searched for the orientation of an image."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Effort:
    """Sizes of a search."""

    shift_reach: float  # standard deviations of the prior, of the mean shift of the curves
    shape_reach: float  # the same of what turns and scales the image
    shapes: int  # turned and scaled images, at most: the size of the cells follows
    starts: int  # poses whose gain is looked at
    refined: int  # of these, how many are improved


QUICK = Effort(shift_reach=3.0, shape_reach=2.2, shapes=75, starts=30, refined=6)
THOROUGH = Effort(shift_reach=3.5, shape_reach=3.0, shapes=600, starts=80, refined=16)
