"""What no measurement and no orientation can be: directions beside the field of view, angles of many turns.

Both say that a unit is not the declared one: pixels or micrometres for millimetres, degrees for radians.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.project.build_cameras import PhotoFrame
from splinebba_cli.project.build_context import Building
from splinebba_cli.project.build_curves import CurveRows, position_rows
from splinebba_cli.project.diagnostics import Place, Severity
from splinebba_cli.project.table import Table

LARGEST_TANGENT = 20.0  # of the angle between a ray and the axis: 87 degrees
SMALLEST_TANGENT = 1e-3  # of the largest such angle of a camera: 0.06 degrees
FULL_TURN = {"deg": 360.0, "gon": 400.0, "rad": 2.0 * np.pi}
LARGEST_TURNS = 2.0
MOST_KNOTS = 100_000  # of one spline
ENOUGH = 10  # measurements of which one at least lies away from the centre


def check_field_of_view(
    photo_xy: FloatArray, camera: IntArray, table: Table, building: Building, frames: list[PhotoFrame]
) -> None:
    """Report measurements that their camera cannot see; all of them together where they are many."""
    counts = np.bincount(camera + 1)[1:]
    for number in np.flatnonzero(counts).tolist():
        frame = frames[number]
        if not frame.allows(frame.image_coordinates):
            continue  # the camera lacks something, which is reported there
        offset = photo_xy - frame.principal_point_mm
        distance = np.hypot(offset[:, 0], offset[:, 1])
        distance[camera != number] = 0.0
        largest = float(distance.max())
        tangent = largest / frame.principal_distance_mm
        if SMALLEST_TANGENT <= tangent <= LARGEST_TANGENT:
            continue
        beyond = np.flatnonzero(distance > LARGEST_TANGENT * frame.principal_distance_mm)
        if 2 * len(beyond) > counts[number]:
            _report_camera("error", largest, number, table, building)
        elif counts[number] >= ENOUGH and tangent < SMALLEST_TANGENT:
            _report_camera("warning", largest, number, table, building)
        else:
            _report_rows(beyond, photo_xy, number, table, building, frames)


def _report_camera(severity: Severity, largest: float, number: int, table: Table, building: Building) -> None:
    """Say, once for a camera, that all that it measures does not fit to its principal distance."""
    if not building.first_time(f"field of view of camera {number}"):
        return
    camera = building.model.cameras[number]
    place = building.source.place(("cameras", number, "principal_distance_mm"))
    how = (
        f"lie up to {largest:,.3g} mm from" if severity == "error" else f"all lie within {largest:.3g} mm of"
    )
    message = (
        f"camera `{camera.id}` has a principal distance of {camera.principal_distance_mm:g} mm, but measurements "
        f"of `{table.file}` {how} its principal point"
    )
    help = (
        "is the distance in mm (`principal_distance_mm`), and are x and y in the unit of `image_coordinates`?"
    )
    building.collector.add(severity, "SBB325", message, place, help)


def _report_rows(
    rows: IntArray,
    photo_xy: FloatArray,
    number: int,
    table: Table,
    building: Building,
    frames: list[PhotoFrame],
) -> None:
    frame = frames[number]
    for row in rows.tolist():
        offset = np.abs(photo_xy[row] - frame.principal_point_mm)
        axis = int(offset[0] <= LARGEST_TANGENT * frame.principal_distance_mm)
        name = building.model.cameras[number].id
        message = (
            f"{'xy'[axis]} lies {offset[axis]:,.5g} mm from the principal point: camera `{name}` "
            f"with a principal distance of {frame.principal_distance_mm:g} mm does not see that far"
        )
        help = "a typing error, or another unit than `image_coordinates` says"
        place = table.place_of(row, "xy"[axis])
        building.collector.error("SBB325", message, place, help, kind="measurements beside the field of view")


def check_angles(angles: FloatArray, find: Callable[[int, int], Place], building: Building) -> None:
    """Report angles of more than two turns, (n, k) in the unit of the project; `find` gets row and column."""
    unit = building.model.project.angle_unit
    if unit is None:
        return  # reported where angles are checked
    limit = LARGEST_TURNS * FULL_TURN[unit]
    for row, column in np.argwhere(np.abs(angles) > limit).tolist():
        message = f"an angle of {angles[row, column]:g} {unit} is more than two full turns"
        help = "is `angle_unit` the unit of the angles?"
        building.collector.error("SBB326", message, find(row, column), help, kind="angles of many turns")


def check_knot_spacing(curves: CurveRows, building: Building) -> None:
    """Knots that the program spaces itself are not more than anything could determine."""
    spacing = building.model.adjustment.knots.spacing_m
    if spacing is None:
        return
    for curve in curves.curves:
        points = curve.values[position_rows(curve)]
        length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
        if curve.role == "tie" and length / spacing > MOST_KNOTS:
            message = (
                f"knots {spacing:g} m apart: spline `{curve.id}` would have {length / spacing:,.0f} of them"
            )
            place = building.source.place(("adjustment", "knots", "spacing_m"))
            help = f"at most {MOST_KNOTS:,}; is the distance in metres?"
            building.collector.error("SBB205", message, place, help, kind="knots too close")
