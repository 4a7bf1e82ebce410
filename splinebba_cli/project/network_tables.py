"""Tables (CSV) of a network in the user's frame and units, with all digits of every number."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence

import numpy as np

from splinebba_cli.core.camera.rotation import angles_from_rotation
from splinebba_cli.core.network import (
    Curve,
    CurveObservations,
    FloatArray,
    Images,
    IntArray,
    Network,
    PointObservations,
)
from splinebba_cli.project.build_curves import shifted
from splinebba_cli.project.build_images import ANGLE_FACTORS, SEQUENCES
from splinebba_cli.project.model_images import EOP_KEYS
from splinebba_cli.project.shortest_text import shortest_texts

COMMENT = "#"  # at the beginning of a line, outside of quotation marks


def csv_text(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A CSV table with a header."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    quoting = csv.writer(out, lineterminator="\n", quoting=csv.QUOTE_ALL)
    writer.writerow(columns)
    for row in rows:
        (quoting if row[0].startswith(COMMENT) else writer).writerow(row)
    return out.getvalue()


def number(value: float) -> str:
    """All digits of a number; empty for NaN."""
    return "" if value != value else repr(float(value))


def numbers(values: FloatArray) -> list[str]:
    """All digits of numbers, (n,); empty for NaN."""
    texts = shortest_texts(values)
    missing = np.isnan(values)
    return (
        ["" if gone else text for text, gone in zip(texts, missing, strict=True)] if missing.any() else texts
    )


def sigma(value: float) -> str:
    """A σ as it is written: fixed, free or a number; empty for NaN."""
    return "fixed" if value == 0.0 else "free" if value == np.inf else number(value)


def orientations(images: Images, origin: FloatArray, angle_unit: str) -> FloatArray:
    """Approximate exterior orientations x, y, z, omega, phi, kappa in the user's frame and units, (m, 6)."""
    out = np.full((len(images.ids), 6), np.nan)
    out[:, :3] = images.position + origin
    for sequence in SEQUENCES:
        chosen = np.array([s == sequence for s in images.sequence], dtype=bool)
        chosen &= np.isfinite(images.rotation).all(axis=(1, 2))
        if chosen.any():
            out[chosen, 3:] = angles_from_rotation(images.rotation[chosen], sequence)
    out[:, 3:] /= ANGLE_FACTORS[angle_unit]
    return out


def images_table(network: Network, angle_unit: str) -> str:
    """Table of images: camera, sequence, approximate values, priors, σ."""
    images = network.images
    approximate = orientations(images, network.origin, angle_unit)
    units = np.array([ANGLE_FACTORS[angle_unit]] * 3 + [1.0] * 3)
    order = [3, 4, 5, 0, 1, 2]
    shift = np.concatenate([np.zeros(3), network.origin])
    prior = (images.prior / units + shift)[:, order]
    prior_sigma = (images.prior_sigma / units)[:, order]
    columns = ["image", "camera", "rotation_sequence", *EOP_KEYS]
    has_prior = bool(np.isfinite(prior_sigma).any())
    if has_prior:
        columns += [f"prior_{key}" for key in EOP_KEYS] + [f"sigma_{key}" for key in EOP_KEYS]
    rows = []
    for i, id in enumerate(images.ids):
        row = [id, network.cameras[images.camera[i]].id, images.sequence[i], *map(number, approximate[i])]
        if has_prior:
            row += [*map(number, prior[i]), *map(sigma, prior_sigma[i])]
        rows.append(row)
    return csv_text(columns, rows)


def points_table(network: Network) -> str:
    """Table of points: role, coordinates, σ."""
    points = network.points
    xyz = points.xyz + network.origin
    rows = []
    for i, (id, role) in enumerate(zip(points.ids, points.role, strict=True)):
        own = points.check_sigma[i] if role == "check" else points.sigma[i]
        sigmas = (
            ["", "", ""] if role == "tie" or (role == "check" and not own.any()) else list(map(sigma, own))
        )
        rows.append([id, role, *map(number, xyz[i]), *sigmas])
    return csv_text(["point", "role", "x", "y", "z", "sigma_x", "sigma_y", "sigma_z"], rows)


def curve_tables(curves: Sequence[Curve], origin: FloatArray) -> dict[str, str]:
    """Tables of knots, reference knots and check values, the curves under each other."""
    in_user_frame = [shifted(curve, origin) for curve in curves]
    out = {}
    if in_user_frame:
        columns = ["spline", "x", "y", "z", "sigma_x", "sigma_y", "sigma_z"]
        values = [curve.values for curve in in_user_frame]
        out["knots"] = csv_text(columns, zip(*_rows(curves, values), *_sigmas(curves), strict=True))
    for name, key in (("reference_knots", "reference"), ("check_values", "check_values")):
        found = [c for c in in_user_frame if getattr(c, key) is not None]
        if found:
            rows = _rows(found, [getattr(c, key) for c in found])
            out[name] = csv_text(["spline", "x", "y", "z"], zip(*rows, strict=True))
    return out


def spline_table(curves: Sequence[Curve], origin: FloatArray) -> str:
    """Table of whole splines: knots with σ, and their parameters and reference values if all have them."""
    in_user_frame = [shifted(curve, origin) for curve in curves]
    columns = ["spline", "x", "y", "z", "sigma_x", "sigma_y", "sigma_z"]
    fields = [*_rows(curves, [curve.values for curve in in_user_frame]), *_sigmas(curves)]
    parameters = [curve.knot_parameters for curve in curves if curve.knot_parameters is not None]
    if parameters:
        columns.append("u")
        fields.append(numbers(np.concatenate(parameters)))
    references = [curve.reference for curve in in_user_frame if curve.reference is not None]
    if references:
        columns += ["reference_x", "reference_y", "reference_z"]
        fields += [numbers(column) for column in np.concatenate(references).T]
    return csv_text(columns, zip(*fields, strict=True))


def _rows(curves: Sequence[Curve], values: Sequence[FloatArray]) -> list[list[str]]:
    """Ids and three numbers, one row a value."""
    ids = [curve.id for curve, own in zip(curves, values, strict=True) for _ in range(len(own))]
    return [ids, *(numbers(column) for column in np.concatenate(values).T)]


def _sigmas(curves: Sequence[Curve]) -> list[list[str]]:
    """σ of the values of control and partial curves, empty for others."""
    own = [c.sigma if c.role in ("control", "partial") else np.full_like(c.sigma, np.nan) for c in curves]
    every, number = np.unique(np.concatenate(own), return_inverse=True)
    texts = [sigma(value) for value in every.tolist()]
    return [[texts[k] for k in column] for column in number.reshape(-1, 3).T.tolist()]


def observations_table(
    network: Network, observations: PointObservations | CurveObservations, marks: IntArray | None = None
) -> str:
    """Table of image points in photo coordinates, mm; `marks` (n,) are written where there are any."""
    curves = isinstance(observations, CurveObservations)
    if isinstance(observations, CurveObservations):
        ids = [network.curves[i].id for i in observations.curve]
    else:
        ids = [network.points.ids[i] for i in observations.point]
    images = [network.images.ids[i] for i in observations.image]
    columns = ["image", "spline" if curves else "point", "x", "y", "sigma_x_mm", "sigma_y_mm"]
    fields: list[Sequence[str]] = [images, ids]
    for values in (observations.photo_xy, observations.sigma):
        fields += [[repr(v) for v in column] for column in values.T.tolist()]
    if isinstance(observations, CurveObservations):
        if np.isfinite(observations.location).any():
            columns.append("location")
            fields.append([number(v) for v in observations.location.tolist()])
        if (observations.segment >= 0).any():
            columns.append("segment")
            fields.append([str(v) if v >= 0 else "" for v in observations.segment.tolist()])
        if marks is not None:
            columns.append("mark")
            fields.append([str(v) for v in marks.tolist()])
    return csv_text(columns, zip(*fields, strict=True))


def marks_of(observations: CurveObservations) -> IntArray:
    """Numbers 1, 2, 3 … of the measured points of every image and spline, (n,)."""
    pair = observations.image * (int(observations.curve.max(initial=0)) + 1) + observations.curve
    order = np.argsort(pair, kind="stable")
    starts = np.concatenate([[0], np.cumsum(np.unique(pair, return_counts=True)[1])])
    out = np.empty(len(pair), dtype=np.int64)
    out[order] = np.arange(len(pair)) - np.repeat(starts[:-1], np.diff(starts)) + 1
    return out


def arc_lengths_table(network: Network, marks: IntArray, rows: IntArray) -> str:
    """Table of arc lengths, mm."""
    arcs, observed = network.arc_lengths, network.curve_observations
    lines = [
        [
            network.images.ids[observed.image[arcs.first[k]]],
            network.curves[observed.curve[arcs.first[k]]].id,
            str(marks[arcs.first[k]]),
            str(marks[arcs.second[k]]),
            number(arcs.length[k]),
            number(arcs.sigma[k]),
        ]
        for k in rows
    ]
    return csv_text(["image", "spline", "from", "to", "length", "sigma_mm"], lines)


def tangents_table(network: Network, marks: IntArray, rows: IntArray, angle_unit: str) -> str:
    """Table of tangents in the photo frame."""
    tangents, observed, unit = network.tangents, network.curve_observations, ANGLE_FACTORS[angle_unit]
    lines = [
        [
            network.images.ids[observed.image[tangents.point[k]]],
            network.curves[observed.curve[tangents.point[k]]].id,
            str(marks[tangents.point[k]]),
            number(tangents.direction[k] / unit),
            number(tangents.sigma[k] / unit),
        ]
        for k in rows
    ]
    return csv_text(["image", "spline", "at", "direction", "sigma"], lines)


def distances_table(network: Network, rows: IntArray) -> str:
    """Table of distances, m."""
    given = network.distances
    lines = []
    for k in rows:
        ends = [
            (network.images if image else network.points).ids[station]
            for image, station in zip(given.is_image[k], given.station[k], strict=True)
        ]
        lines.append([*ends, number(given.length[k]), number(given.sigma[k])])
    return csv_text(["from", "to", "length", "sigma_m"], lines)
