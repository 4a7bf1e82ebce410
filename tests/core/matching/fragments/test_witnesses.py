"""Images that should see a fragment, and do or do not."""

from __future__ import annotations

import numpy as np
import pytest

from splinebba_cli.core.matching.fragments.frames import Frames
from splinebba_cli.core.matching.fragments.views import Views
from splinebba_cli.core.matching.fragments.witnesses import seeing_share, third_image_possible
from tests.core.matching.fragments.small_scenes import vertical_views

PLACES = np.column_stack([np.linspace(-20.0, 20.0, 9), np.zeros(9), np.zeros(9)])


def row_of_images(count: int) -> Views:
    rotation, position = vertical_views(np.column_stack([np.linspace(-300.0, 300.0, count), np.zeros(count)]))
    return Views(rotation, position, np.full(count, 100.0))


def everywhere(count: int) -> Frames:
    return Frames(np.full((count, 2), -60.0), np.full((count, 2), 60.0))


def seen_by(count: int, images: list[int]) -> np.ndarray:
    seen = np.zeros((len(PLACES), count), dtype=bool)
    seen[:, images] = True
    return seen


@pytest.mark.parametrize(
    ("images", "share"),
    [([0, 1, 2], 1.0), ([0, 2, 4], 3 / 5), ([0, 3, 6], 3 / 7), ([6], 1.0), ([], 0.0)],
)
def test_images_between_those_that_see_are_asked(images: list[int], share: float) -> None:
    assert seeing_share(row_of_images(7), everywhere(7), PLACES, seen_by(7, images)) == pytest.approx(share)


def test_images_whose_frame_does_not_hold_the_place_are_not_asked() -> None:
    frames = everywhere(7)
    frames.low[1:3] = frames.high[1:3] = 60.0
    assert seeing_share(row_of_images(7), frames, PLACES, seen_by(7, [0, 3])) == 1.0


def test_a_third_image_is_possible_where_a_frame_holds_the_place() -> None:
    views, frames = row_of_images(3), everywhere(3)
    pair = np.array([True, True, False])
    assert third_image_possible(views, frames, PLACES, pair).all()
    xy = views.project(np.full(len(PLACES), 2), PLACES)
    frames.low[2] = xy.mean(axis=0) - 1e-9
    assert third_image_possible(views, frames, PLACES, pair).sum() < len(PLACES)
    frames.low[2] = 60.0
    assert not third_image_possible(views, frames, PLACES, pair).any()
