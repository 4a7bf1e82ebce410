"""Given orientations that do not fit the measurements are named, whatever fails because of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.approximation.misfit import misfit_of_given
from splinebba_cli.core.budget import budget
from splinebba_cli.core.camera.rotation import rotation_from_vector
from splinebba_cli.core.network import FloatArray, Network
from splinebba_cli.errors import NotSolvableError
from splinebba_cli.starters import aerial
from splinebba_cli.starters.measured_scene import measured


@pytest.fixture(scope="module")
def network() -> Network:
    return measured(aerial.scene().design(), 1, 0.8, 0.0)


def turned(network: Network, angle_deg: float, numbers: slice = slice(None)) -> Network:
    """Images turned about their axes of view."""
    images = network.images
    turn: FloatArray = rotation_from_vector(np.array([[0.0, 0.0, np.radians(angle_deg)]]))
    rotation = images.rotation.copy()
    rotation[numbers] = rotation[numbers] @ turn
    return replace(network, images=replace(images, rotation=rotation))


def test_what_fits_is_not_mentioned(network: Network) -> None:
    assert misfit_of_given(network) == ()
    assert misfit_of_given(turned(network, 2.0)) == ()
    assert "SBB506" not in {each.code for each in budget(network).problems}


def test_images_that_do_not_fit_are_named(network: Network) -> None:
    """The second strip, flown in the other direction, as if 200 gon had been read as 180 degrees."""
    (found,) = misfit_of_given(turned(network, -18.0, slice(4, 8)))
    assert (found.code, found.severity) == ("SBB506", "warning")
    assert "`0202`, `0203`" in found.message
    assert "`0102`" not in found.message


def test_images_that_look_the_other_way(network: Network) -> None:
    images = network.images
    up = replace(network, images=replace(images, rotation=images.rotation @ np.diag([1.0, -1.0, -1.0])))
    (found,) = misfit_of_given(up)
    assert "behind the image" in found.message


def test_rough_positions_of_tie_points_say_nothing(network: Network) -> None:
    ties = np.array(network.points.role) == "tie"
    xyz = network.points.xyz.copy()
    xyz[ties] = 500.0
    assert misfit_of_given(replace(network, points=replace(network.points, xyz=xyz))) == ()


def test_it_follows_what_has_failed(network: Network) -> None:
    with pytest.raises(NotSolvableError) as caught:
        adjust(turned(network, 90.0))
    codes = [each.code for each in caught.value.problems]
    assert codes[-1] == "SBB506"
    assert codes[0] != "SBB506"
    assert caught.value.code == codes[0]
