"""Copies of sample projects, changed so that their adjustments end as a test wants."""

from __future__ import annotations

import shutil
from pathlib import Path

SAMPLES = Path(__file__).parents[2] / "sample_projects"


def sample(folder: Path, name: str = "six_image_block", *, old: str = "", new: str = "") -> Path:
    """The project file of a copy in `folder`, in which `old` is `new`."""
    ignored = shutil.ignore_patterns("*.results", "expected", "README.md", "truth.json")
    shutil.copytree(SAMPLES / name, folder, ignore=ignored)
    project = folder / "project.yaml"
    text = project.read_text(encoding="utf-8")
    assert old in text, old
    project.write_text(text.replace(old, new) if old else text, encoding="utf-8", newline="\n")
    return project


def not_accepted(folder: Path) -> Path:
    """A project with a criterion that it does not meet."""
    return sample(folder, old="max_position_sigma_m: 0.1", new="max_position_sigma_m: 0.001")


def invalid(folder: Path) -> Path:
    """A project with an unknown key."""
    return sample(folder, old="acceptance:", new="acceptanze:")


def not_solvable(folder: Path) -> Path:
    """A project that is not determined."""
    return sample(folder, "table_5_7_one_control_segment")
