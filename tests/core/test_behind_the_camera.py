"""Approximate values that put the object behind the images are named, in every stage, and are no internal error."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.network import KnotPolicy
from splinebba_cli.errors import NotSolvableError
from splinebba_cli.simulation.six_image_block import simulate_block


@pytest.mark.parametrize("kind", ["six-image", "six-image-mixed"])
@pytest.mark.parametrize(
    "knots", [KnotPolicy(), KnotPolicy(spacing_m=60.0, drop=True)], ids=["kept", "spaced"]
)
def test_cameras_below_the_ground_are_refused(kind: str, knots: KnotPolicy) -> None:
    network, _ = simulate_block(kind, seed=1)
    position = network.images.position - np.array([0.0, 0.0, 2000.0])
    network = replace(
        network,
        images=replace(network.images, position=position),
        settings=replace(network.settings, knots=knots),
    )
    with pytest.raises(NotSolvableError) as refused:
        adjust(network)
    assert refused.value.code in {"SBB503", "SBB505", "SBB521"}
