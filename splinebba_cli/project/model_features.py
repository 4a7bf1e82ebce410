"""Splines and points of the object."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag

from splinebba_cli.project.model_images import table_or_entry
from splinebba_cli.project.model_tables import KnotRows, TableOrRows
from splinebba_cli.project.scalars import (
    Continuity,
    Family,
    Id,
    Model,
    NonNegativeNumber,
    Number,
    Parameterization,
    PointRole,
    Role,
    SigmaXyz,
    TriplePosition,
)


class Held(Model):
    """Coefficients of a spline that are known."""

    knot: int = Field(ge=0, description="Number of the knot (or coefficient), from 0.")
    components: list[Literal["x", "y", "z"]] = Field(
        default=["x", "y", "z"], description="Which components are held.", min_length=1
    )


class SplineOptions(Model):
    """What all splines have."""

    role: Role = Field(
        description=(
            "control: known, with σ or fixed; partial: some coefficients known (`held` or σ); tie: unknown; "
            "check: unknown, compared with its given shape."
        )
    )
    family: Family = Field(
        default="natural_cubic",
        description=(
            "What the rows of `knots` are: natural_cubic, cardinal, catmull_rom: knots; bspline_d: control points; "
            "straight_line: two points; polynomial_d, free_cubic: the coefficient vectors of the powers 0 … d of t "
            "(free_cubic: 0 … 3), segment after segment; fourier: centre, then the vectors of cos u, sin u, cos 2u, "
            "sin 2u, …; conic, circle: centre and the vectors of cos u and sin u."
        ),
    )
    closed: bool = Field(
        default=False,
        description=(
            "Whether the spline is closed; the first knot is not repeated at the end. Fourier curves always are, "
            "conics and circles unless they are arcs (`knot_parameters`)."
        ),
    )
    parameterization: Parameterization = Field(
        default="chord_length",
        description=(
            "Knot parameters: chord_length (metres) or uniform (one unit a segment; polynomials always)."
        ),
    )
    continuity: Continuity = Field(
        default="C-1",
        description="How the segments of polynomial_d and free_cubic are joined: C-1: not; at most C(d − 1).",
    )
    natural_ends: bool = Field(
        default=False, description="Cubic segments joined C2: no curvature at both ends, as a natural spline."
    )
    tension: Number = Field(
        default=0.0, description="Of a cardinal spline, −1 ≤ tension < 1; 0 is a Catmull-Rom spline."
    )
    sigma: SigmaXyz | None = Field(
        default=None,
        description="σ of the given knots, m: a number, fixed, free, or three of these. Control needs it.",
    )


class Spline(SplineOptions):
    """A spline or another linear feature."""

    id: Id = Field(description="Id, always a text.")
    knots: KnotRows | None = Field(
        default=None,
        description=(
            "Given or approximate knots, m: rows x y z [sigma_x sigma_y sigma_z], or {table: file} with "
            "the columns spline, x, y, z [, sigma_x, sigma_y, sigma_z] for the rows of this spline."
        ),
    )
    held: list[Held] = Field(
        default_factory=list, description="Coefficients that are known and not estimated."
    )
    knot_parameters: list[Number] | None = Field(
        default=None,
        description=(
            "Parameters u of the knots (of the ends of the segments), increasing; closed: one more, the end of the "
            "last segment; conic, circle: first and last u of an arc, radians."
        ),
    )
    breaks: list[Annotated[int, Field(ge=0)]] = Field(
        default_factory=list, description="Numbers of knots where the curve has a corner, from 0."
    )
    reference_knots: KnotRows | None = Field(
        default=None,
        description="Reference values of the gauge conditions, m; default: the approximate knots.",
    )
    check_values: KnotRows | None = Field(
        default=None,
        description="Given points along a check spline, m, to compare with; default: its knots, or its given shape.",
    )
    check_sigma_m: NonNegativeNumber = Field(
        default=0.0, description="σ of the given points of a check spline in every direction across it, m."
    )


class SplineTable(TableOrRows, SplineOptions):
    """Many splines: columns spline, x, y, z [, sigma_x …] [, u] [, reference_x …], the rows of one spline in order.

    `u` is the parameter of the knot, `reference_x` … its reference value; see `knot_parameters` and `reference_knots`.
    """


class Point(Model):
    """A point of the object."""

    id: Id = Field(description="Id, always a text.")
    role: PointRole = Field(description="control: known, with σ or fixed; tie: unknown; check: compared.")
    xyz: TriplePosition | None = Field(
        default=None, description="Given or approximate coordinates, m: [x, y, z]."
    )
    sigma: SigmaXyz | None = Field(
        default=None,
        description="σ of the coordinates, m: a number, fixed, free, or three of these. Control needs it.",
    )


class PointTable(TableOrRows):
    """Many points: columns point (or id), x, y, z [, sigma_x, sigma_y, sigma_z] [, role]."""

    role: PointRole | None = Field(default=None, description="Role of all points (or column `role`).")
    sigma: SigmaXyz | None = Field(
        default=None, description="σ of the control and check points of the table, m (or columns sigma_x …)."
    )
    only: list[Id] | None = Field(default=None, description="Take these points of the table alone.")
    except_: list[Id] = Field(
        default_factory=list, alias="except", description="Leave these points of the table out."
    )


SplineEntry = Annotated[
    Annotated[Spline, Tag("<entry>")] | Annotated[SplineTable, Tag("<table>")], Discriminator(table_or_entry)
]
PointEntry = Annotated[
    Annotated[Point, Tag("<entry>")] | Annotated[PointTable, Tag("<table>")], Discriminator(table_or_entry)
]
