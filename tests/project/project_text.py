"""A small valid project as a text, to be broken by tests."""

from __future__ import annotations

from pathlib import Path

PROJECT = """\
version: 1
project:
  name: example
  angle_unit: deg
  rotation_sequence: omega-phi-kappa
cameras:
  - id: 0101
    principal_distance_mm: 150
    image_coordinates: photo_mm
images:
  - {id: no, camera: 0101, orientation: {x: 0, y: 0, z: 1000, omega: 0, phi: 0, kappa: 0}, sigma: fixed}
  - {id: 12:30, camera: 0101, orientation: {x: 500, y: 0, z: 1000, omega: 1, phi: 2, kappa: 90}}
splines:
  - id: coast
    role: tie
    knots: |
      0 0 0
      100 10 5
      200 20 0
  - id: road
    role: partial
    knots: [[0, 100, 0], [100, 110, 5], [200, 120, 0]]
    held: [{knot: 0}, {knot: 2, components: [z]}]
points:
  - {id: 1e-6, role: control, xyz: [100, 100, 10], sigma: 0.02}
  - {id: t1, role: tie}
observations:
  spline_points:
    - name: traced
      sigma_um: 5
      columns: [image, spline, x, y]
      data: |
        # image spline x y
        no    coast 1.5 2

        12:30 coast 2.5 3
        no    road  1.5 2
        12:30 road  2.5 3
  points:
    - sigma_um: 5
      columns: [image, point, x, y]
      data: [[no, 1e-6, 1, 2], [no, t1, 1, 2], ["12:30", t1, 1, 2]]
"""


def written(folder: Path, text: str = PROJECT, **tables: str) -> Path:
    """The project file in a folder, with tables (name without .csv) beside it."""
    for name, content in tables.items():
        (folder / f"{name}.csv").write_text(content, encoding="utf-8")
    path = folder / "project.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def changed(old: str, new: str, text: str = PROJECT) -> str:
    """The project with one passage replaced."""
    assert text.count(old) == 1, (old, text.count(old))
    return text.replace(old, new)
