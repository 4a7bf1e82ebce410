"""What people call single observations."""

from __future__ import annotations

from splinebba_cli.core.network import Network


def image_point_name(network: Network, row: int) -> str:
    """An image point of a point: ``image `3` of point `p12` ``."""
    seen = network.point_observations
    return f"image `{network.images.ids[seen.image[row]]}` of point `{network.points.ids[seen.point[row]]}`"


def curve_point_name(network: Network, row: int) -> str:
    """An image point on a curve: ``image `3` on spline `road` ``."""
    seen = network.curve_observations
    return f"image `{network.images.ids[seen.image[row]]}` on spline `{network.curves[seen.curve[row]].id}`"


def distance_name(network: Network, row: int) -> str:
    """A distance: ``distance from point `a` to point `b` ``."""
    given = network.distances
    ends = [
        f"{'image' if image else 'point'} `{(network.images if image else network.points).ids[k]}`"
        for k, image in zip(given.station[row], given.is_image[row], strict=True)
    ]
    return f"distance from {ends[0]} to {ends[1]}"
