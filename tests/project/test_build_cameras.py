"""Frames of measured coordinates."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from splinebba_cli.core.network import Network
from splinebba_cli.errors import ProjectError
from splinebba_cli.project.loading import load_project
from tests.project.project_text import changed, written


def network_of(folder: Path, camera: str, group: str = "") -> Network:
    text = changed("    image_coordinates: photo_mm\n", camera)
    text = changed(
        "    - sigma_um: 5\n      columns: [image, point",
        f"    - sigma_um: 5\n{group}      columns: [image, point",
        text,
    )
    return load_project(written(folder, text)).network


def centred(network: Network) -> np.ndarray:
    """Measured coordinates from the principal point, mm."""
    return np.asarray(network.point_observations.photo_xy[0] - network.cameras[0].principal_point_mm)


SIZE = "    image_size_px: [40, 60]\n"
PIXELS = "    image_coordinates: {frame}\n    pixel_size_mm: [0.01, 0.02]\n"


def test_dbat_convention(tmp_path: Path) -> None:
    """x = px col - x0, y = -(py row) + y0 with the centre of the first pixel at (1, 1)."""
    camera = PIXELS.format(frame="pixel_one") + "    principal_point_mm: [0.2, 0.6]\n"
    for text in (camera, camera + SIZE):
        np.testing.assert_allclose(
            centred(network_of(tmp_path, text)), [0.01 * 1 - 0.2, -0.02 * 2 + 0.6], atol=1e-15
        )


@pytest.mark.parametrize("size", ["", SIZE])
@pytest.mark.parametrize("frame", ["pixel_corner", "pixel_centre", "pixel_one"])
def test_principal_point_in_the_frame_of_the_pixels(frame: str, size: str, tmp_path: Path) -> None:
    """In whatever frame: only the difference to the principal point counts."""
    in_px = PIXELS.format(frame=frame) + "    principal_point_px: [20, 30]\n" + size
    in_mm = PIXELS.format(frame=frame) + "    principal_point_mm: [0.2, 0.6]\n" + size
    for camera in (in_px, in_mm):
        np.testing.assert_allclose(
            centred(network_of(tmp_path, camera)), [0.01 * -19, -0.02 * -28], atol=1e-15
        )


@pytest.mark.parametrize(
    ("frame", "shift"), [("pixel_corner", 0.0), ("pixel_centre", 0.5), ("pixel_one", -0.5)]
)
def test_principal_point_from_the_image_centre(frame: str, shift: float, tmp_path: Path) -> None:
    camera = PIXELS.format(frame=frame) + SIZE + "    principal_point_offset_mm: [0.1, 0.3]\n"
    expected = [0.01 * (1 + shift - 20) - 0.1, -0.02 * (2 + shift - 30) - 0.3]
    network = network_of(tmp_path, camera)
    np.testing.assert_allclose(centred(network), expected, atol=1e-15)
    assert network.cameras[0].format_mm == pytest.approx((0.4, 1.2))
    assert network.cameras[0].pixel_size_mm == pytest.approx(np.sqrt(0.0002))


def test_another_frame_for_one_group(tmp_path: Path) -> None:
    camera = PIXELS.format(frame="pixel_corner") + SIZE + "    principal_point_px: [20, 30]\n"
    one = network_of(tmp_path, camera, "      image_coordinates: pixel_one\n")
    np.testing.assert_allclose(centred(one), [0.01 * (0.5 - 20), -0.02 * (1.5 - 30)], atol=1e-15)
    photo = network_of(tmp_path, camera, "      image_coordinates: photo_um\n")
    np.testing.assert_allclose(centred(photo), [0.001, 0.002], atol=1e-15)


def test_photo_coordinates(tmp_path: Path) -> None:
    network = network_of(tmp_path, "    image_coordinates: photo_um\n    principal_point_mm: [0.5, -0.5]\n")
    np.testing.assert_allclose(network.point_observations.photo_xy[0], [0.001, 0.002])
    assert network.cameras[0].principal_point_mm.tolist() == [0.5, -0.5]


@pytest.mark.parametrize(
    ("camera", "group", "code"),
    [
        ("    image_coordinates: photo_mm\n", "      image_coordinates: pixel_one\n", "SBB209"),
        (
            PIXELS.format(frame="pixel_one") + "    principal_point_px: [1, 2]\n",
            "      image_coordinates: photo_mm\n",
            "SBB209",
        ),
        (PIXELS.format(frame="pixel_one"), "", "SBB202"),
        ("    image_coordinates: photo_mm\n    principal_point_px: [1, 2]\n", "", "SBB209"),
        (
            PIXELS.format(frame="pixel_one")
            + "    principal_point_px: [1, 2]\n    principal_point_mm: [1, 2]\n",
            "",
            "SBB209",
        ),
    ],
)
def test_contradictions(camera: str, group: str, code: str, tmp_path: Path) -> None:
    with pytest.raises(ProjectError) as caught:
        network_of(tmp_path, camera, group)
    assert {d.code for d in caught.value.diagnostics} == {code}


def test_measurement_outside_of_the_image(tmp_path: Path) -> None:
    camera = PIXELS.format(frame="pixel_one") + "    image_size_px: [1, 60]\n    principal_point_px: [1, 2]\n"
    text = changed("    image_coordinates: photo_mm\n", camera)
    warnings = load_project(written(tmp_path, text)).diagnostics
    assert [(d.code, d.line) for d in warnings] == [("SBB313", 39), ("SBB313", 41)]
