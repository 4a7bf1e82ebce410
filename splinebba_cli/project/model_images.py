"""Images: camera, approximate exterior orientation, priors."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Discriminator, Field, Tag

from splinebba_cli.project.model_tables import TableOrRows
from splinebba_cli.project.scalars import AlsoJson, Id, Model, Number, RotationSequence, Sigma

EOP_KEYS = ("x", "y", "z", "omega", "phi", "kappa")


class Orientation(Model):
    """Exterior orientation: perspective centre and rotation, all six."""

    x: Number = Field(description="X of the perspective centre, m.")
    y: Number = Field(description="Y of the perspective centre, m.")
    z: Number = Field(description="Z of the perspective centre, m.")
    omega: Number = Field(description="Rotation ω, in project.angle_unit.")
    phi: Number = Field(description="Rotation φ, in project.angle_unit.")
    kappa: Number = Field(description="Rotation κ, in project.angle_unit.")


class PriorOrientation(Model):
    """Observed exterior orientation (GNSS, INS), where it differs from the approximate one."""

    x: Number | None = Field(default=None, description="Observed X of the perspective centre, m.")
    y: Number | None = Field(default=None, description="Observed Y of the perspective centre, m.")
    z: Number | None = Field(default=None, description="Observed Z of the perspective centre, m.")
    omega: Number | None = Field(default=None, description="Observed ω, in project.angle_unit.")
    phi: Number | None = Field(default=None, description="Observed φ, in project.angle_unit.")
    kappa: Number | None = Field(default=None, description="Observed κ, in project.angle_unit.")


class OrientationSigma(Model):
    """Standard deviations of the observed exterior orientation; `free` where there is none."""

    x: Sigma = Field(default=float("inf"), description="σ of X, m, or fixed, or free.")
    y: Sigma = Field(default=float("inf"), description="σ of Y, m, or fixed, or free.")
    z: Sigma = Field(default=float("inf"), description="σ of Z, m, or fixed, or free.")
    omega: Sigma = Field(
        default=float("inf"), description="σ of ω, in project.angle_unit, or fixed, or free."
    )
    phi: Sigma = Field(default=float("inf"), description="σ of φ, in project.angle_unit, or fixed, or free.")
    kappa: Sigma = Field(
        default=float("inf"), description="σ of κ, in project.angle_unit, or fixed, or free."
    )


def _all_alike(value: Any) -> Any:
    return dict.fromkeys(EOP_KEYS, value) if value in ("fixed", "free") else value


SigmaOfOrientation = Annotated[
    OrientationSigma,
    BeforeValidator(_all_alike),
    AlsoJson({"enum": ["fixed", "free"]}),
]


class Image(Model):
    """One image."""

    id: Id = Field(description="Id, always a text.")
    camera: Id = Field(description="Id of its camera.")
    rotation_sequence: RotationSequence | None = Field(
        default=None,
        description="Rotation sequence, as project.rotation_sequence, which is the default.",
    )
    orientation: Orientation | None = Field(
        default=None, description="Approximate exterior orientation; without it, it is found by resection."
    )
    prior: PriorOrientation | None = Field(
        default=None, description="Observed values, where they differ from the approximate orientation."
    )
    sigma: SigmaOfOrientation | None = Field(
        default=None,
        description="σ of the observed values (of `prior`, else of `orientation`); fixed for all six.",
    )
    fixed: bool = Field(
        default=False, description="Whether the whole exterior orientation is known and not estimated."
    )


class ImageTable(TableOrRows):
    """Many images: columns image (or id), camera, rotation_sequence, x … kappa, prior_x …, sigma_x …."""

    camera: Id | None = Field(
        default=None, description="Camera of all images of the table (or column `camera`)."
    )
    rotation_sequence: RotationSequence | None = Field(
        default=None, description="Rotation sequence of all images of the table."
    )
    sigma: SigmaOfOrientation | None = Field(default=None, description="σ of all images of the table.")
    fixed: bool = Field(
        default=False, description="Whether all exterior orientations of the table are fixed."
    )


def table_or_entry(value: Any) -> Literal["<table>", "<entry>"]:
    """Which model an entry of a list is meant for."""
    if isinstance(value, dict):
        return "<table>" if "id" not in value and ("table" in value or "data" in value) else "<entry>"
    return "<table>" if isinstance(value, TableOrRows) else "<entry>"


ImageEntry = Annotated[
    Annotated[Image, Tag("<entry>")] | Annotated[ImageTable, Tag("<table>")], Discriminator(table_or_entry)
]
