"""Exterior orientations, their correlations, and the cameras."""

from __future__ import annotations

from typing import Any

from splinebba_cli.report.blocks import Block, Cell, Column, Note, Section, Table
from splinebba_cli.report.figure_blocks import correlation_blocks
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.scale import angle_scale, length_scale, position_decimals

_ANGLES = (("ω", "omega"), ("φ", "phi"), ("κ", "kappa"))
_SYMBOLS = {"omega": "ω", "phi": "φ", "kappa": "κ", "X0": "X₀", "Y0": "Y₀", "Z0": "Z₀"}


def subjects_with_problems(data: ResultData, kind: str) -> frozenset[str]:
    """Ids of the images, splines or points that an error or a warning is about."""
    prefix = f"{kind} `"
    return frozenset(
        problem["subject"][len(prefix) : -1]
        for problem in data["problems"]
        if problem["subject"].startswith(prefix) and problem["severity"] != "info"
    )


def orientation_section(data: ResultData) -> Section:
    """Adjusted exterior orientations with standard deviations; strong correlations."""
    blocks: list[Block] = [orientation_table(data)]
    sequences = sorted({image["rotation_sequence"] for image in data["images"]})
    formulas = {
        "omega-phi-kappa": "R = R_x(ω) R_y(φ) R_z(κ)",
        "phi-omega-kappa": "R = R_y(φ) R_x(ω) R_z(κ)",
    }
    text = "; ".join(f"{sequence}: {formulas.get(sequence, '')}" for sequence in sequences)
    blocks.append(Note(f"Rotation {text}; R turns photo axes into object axes."))
    blocks.append(_correlations(data))
    blocks += correlation_blocks(data)
    return Section("orientation", "Exterior orientation", tuple(blocks))


def orientation_table(data: ResultData) -> Table:
    """One row an image: X, Y, Z in metres, ω, φ, κ in degrees, standard deviations in small units."""
    images = data["images"]
    position_sigma = [image["sigma"][axis] for image in images for axis in "xyz"]
    angle_sigma = [image["sigma"][key] for image in images for _, key in _ANGLES]
    length, angle = length_scale(position_sigma), angle_scale(angle_sigma)
    decimals = position_decimals(position_sigma)
    angle_decimals = max(position_decimals(angle_sigma), 4)
    columns = [Column("Image", numeric=False)]
    columns += [Column(axis, "m", decimals) for axis in "XYZ"]
    columns += [Column(symbol, "°", angle_decimals) for symbol, _ in _ANGLES]
    columns += [Column(f"σ {axis}", length.unit, length.decimals) for axis in "XYZ"]
    columns += [Column(f"σ {symbol}", angle.unit, angle.decimals) for symbol, _ in _ANGLES]
    rows = []
    for image in images:
        row: list[Cell] = [image["id"], *(image[axis] for axis in "xyz"), *(image[key] for _, key in _ANGLES)]
        row += [length.of(image["sigma"][axis]) for axis in "xyz"]
        row += [angle.of(image["sigma"][key]) for _, key in _ANGLES]
        rows.append(tuple(row))
    marked = subjects_with_problems(data, "image")
    return Table(
        "Adjusted exterior orientation and standard deviations",
        tuple(columns),
        tuple(rows),
        frozenset(i for i, image in enumerate(images) if image["id"] in marked),
        "exterior_orientation.csv",
        note="A standard deviation of 0 belongs to a value that was held fixed."
        if _any_fixed(images)
        else "",
    )


def _any_fixed(images: list[dict[str, Any]]) -> bool:
    return any(image["fixed"] for image in images)


def _correlations(data: ResultData) -> Block:
    threshold = (data.content.get("precision") or {}).get("correlation_threshold", 0.95)
    rows = [
        (image["id"], _SYMBOLS[pair["a"]], _SYMBOLS[pair["b"]], pair["r"])
        for image in data["images"]
        for pair in image["correlations"]
    ]
    if not rows:
        return Note(f"No two orientation parameters of an image are correlated by more than {threshold:g}.")
    rows.sort(key=lambda row: -abs(row[3]))
    columns = (
        Column("Image", numeric=False),
        Column("Parameter", numeric=False),
        Column("with", numeric=False),
        Column("r", decimals=4),
    )
    note = "Such parameters can hardly be told apart; their standard deviations are large together."
    return Table(
        f"Correlations beyond {threshold:g} inside an image",
        columns,
        tuple(rows),
        source="result.json",
        note=note,
    )


def cameras_section(data: ResultData) -> Section:
    """Interior orientations as used."""
    columns = (
        Column("Camera", numeric=False),
        Column("c", "mm", 4),
        Column("x₀", "mm", 4),
        Column("y₀", "mm", 4),
        Column("K1", "mm⁻²", None),
        Column("K2", "mm⁻⁴", None),
        Column("K3", "mm⁻⁶", None),
        Column("P1", "mm⁻¹", None),
        Column("P2", "mm⁻¹", None),
        Column("b1", "", None),
        Column("b2", "", None),
        Column("Pixel", "µm", 3),
        Column("Format", "mm", numeric=False),
    )
    rows = []
    for c in data["cameras"]:
        size = c["format_mm"]
        row: list[Cell] = [c["id"], c["principal_distance_mm"], *c["principal_point_mm"]]
        row += [*c["radial"], *c["decentring"], *c["affinity"]]
        row.append(None if c["pixel_size_mm"] is None else 1e3 * c["pixel_size_mm"])
        row.append(None if size is None else f"{size[0]:g} × {size[1]:g}")
        rows.append(tuple(row))
    note = (
        "Principal distance c, principal point, distortion (of measured coordinates), affinity; held fixed."
    )
    return Section("cameras", "Cameras", (Table("Interior orientation", columns, tuple(rows), note=note),))
