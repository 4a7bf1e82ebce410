"""Scalar types of the project file: what people may write, and what it becomes."""

from __future__ import annotations

import math
import re
from pathlib import PurePosixPath
from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PlainSerializer,
    PlainValidator,
    WithJsonSchema,
)
from pydantic_core import PydanticCustomError

from splinebba_cli.project.plain_text import brief, file_name_problem, id_problem, text_problem

AngleUnit = Literal["deg", "gon", "rad"]
RotationSequence = Literal["omega-phi-kappa", "phi-omega-kappa"]
ImageCoordinates = Literal["photo_mm", "photo_um", "pixel_corner", "pixel_centre", "pixel_one"]
Role = Literal["control", "partial", "tie", "check"]
PointRole = Literal["control", "tie", "check"]
Family = Literal[
    "straight_line",
    "polynomial_0",
    "polynomial_1",
    "polynomial_2",
    "polynomial_3",
    "free_cubic",
    "natural_cubic",
    "cardinal",
    "catmull_rom",
    "bspline_1",
    "bspline_2",
    "bspline_3",
    "fourier",
    "conic",
    "circle",
]
Continuity = Literal["C-1", "C0", "C1", "C2"]
Parameterization = Literal["uniform", "chord_length"]
Delimiter = Literal["auto", "comma", "semicolon", "tab", "space"]

NUMBER_PATTERN = r"^[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?$"
POSITIVE_PATTERN = r"^\+?(?=[0.]*[1-9])(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?$"
# patternErrorMessage: what editors say instead of showing the pattern
NUMBER_SCHEMA: dict[str, Any] = {
    "type": ["number", "string"],
    "pattern": NUMBER_PATTERN,
    "patternErrorMessage": "A number is expected, with a decimal point.",
}
POSITIVE_SCHEMA: dict[str, Any] = {
    "type": ["number", "string"],
    "exclusiveMinimum": 0,
    "pattern": POSITIVE_PATTERN,
    "patternErrorMessage": "A positive number is expected, with a decimal point.",
}


class Model(BaseModel):
    """Base of all sections: no unknown keys, no change after reading."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, allow_inf_nan=False, validate_default=False, defer_build=True
    )


def _text(value: Any) -> Any:
    if isinstance(value, bool) or value is None or isinstance(value, (dict, list)):
        return value
    return str(value)


def _id(value: Any) -> Any:
    value = _text(value)
    if isinstance(value, str) and (problem := id_problem(value)):
        raise PydanticCustomError("bad_id", "an id {problem}", {"problem": problem})
    return value


def _name(value: Any) -> Any:
    value = _text(value)
    if isinstance(value, str) and (problem := id_problem(value)):
        raise PydanticCustomError("bad_id", "a name {problem}", {"problem": problem})
    return value


def _note(value: Any) -> Any:
    value = _text(value)
    if isinstance(value, str) and (problem := text_problem(value)):
        raise PydanticCustomError("bad_id", "a text {problem}", {"problem": problem})
    return value


LARGEST_NUMBER = 1e15  # beyond which a double has no millimetres of a metre, and squares overflow soon
SIGMA_RANGE = (1e-12, 1e12)
_DECIMAL_COMMA = re.compile(r"[-+]?\d+,\d+")
_THOUSANDS = re.compile(r"[-+]?\d{1,3}([ ,\u00a0\u202f'’]\d{3})+([.,]\d+)?")


class OutOfRangeError(ValueError):
    """A number that nothing measured can have."""


def _how_to_write(text: str) -> str:
    """What is wrong with a text that people take for a number."""
    if _DECIMAL_COMMA.fullmatch(text):
        return f"; decimals are written with a point: {text.replace(',', '.')}"
    if _THOUSANDS.fullmatch(text):
        return "; write it without marks between thousands"
    return ""


def parse_number(value: Any) -> float:
    """A finite number of a text or number; ValueError else."""
    if isinstance(value, bool) or value is None or isinstance(value, (dict, list)):
        raise ValueError("a number is expected")
    if isinstance(value, str) and "_" in value:
        raise ValueError(f"`{brief(value)}` is not a number")
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise ValueError(
            f"`{brief(str(value))}` is not a number{_how_to_write(str(value).strip())}"
        ) from None
    if not math.isfinite(number):
        raise ValueError(f"`{brief(str(value))}` is not a finite number")
    if abs(number) > LARGEST_NUMBER:
        raise OutOfRangeError(f"`{brief(str(value))}` is too large (more than {LARGEST_NUMBER:.0e})")
    return number


def parse_sigma(value: Any) -> float:
    """A standard deviation: a positive number, ``fixed`` (0) or ``free`` (infinity); ValueError else."""
    if value == "fixed":
        return 0.0
    if value == "free":
        return math.inf
    try:
        number = parse_number(value)
    except OutOfRangeError:
        raise
    except ValueError as error:
        raise ValueError(f"{error}; a sigma is a positive number, `fixed` or `free`") from None
    if number <= 0.0:
        raise ValueError(f"sigma {value} is not positive; write `fixed` for a value that is not estimated")
    least, largest = SIGMA_RANGE
    if not least <= number <= largest:
        help = "`fixed` says that a value is not estimated, `free` that nothing is known of it"
        raise OutOfRangeError(f"sigma {value} is not between {least:g} and {largest:g}; {help}")
    return number


def _sigma(value: Any) -> float:
    if isinstance(value, float) and value in (0.0, math.inf):
        return value  # already read
    try:
        return parse_sigma(value)
    except OutOfRangeError as error:
        raise PydanticCustomError("too_large", "{reason}", {"reason": str(error)}) from None
    except ValueError as error:
        raise PydanticCustomError("sigma", "{reason}", {"reason": str(error)}) from None


def _sigma_triple(value: Any) -> tuple[float, float, float]:
    if isinstance(value, (list, tuple)):
        if len(value) != 3:
            raise PydanticCustomError(
                "sigma_shape", "one sigma, or three [x, y, z], not {n}", {"n": len(value)}
            )
        return (_sigma(value[0]), _sigma(value[1]), _sigma(value[2]))
    one = _sigma(value)
    return (one, one, one)


def sigma_as_written(sigma: float) -> float | str:
    """The text of a sigma in a project file."""
    return "fixed" if sigma == 0.0 else "free" if math.isinf(sigma) else sigma


def _number(value: Any) -> float:
    try:
        return parse_number(value)
    except OutOfRangeError as error:
        raise PydanticCustomError("too_large", "{reason}", {"reason": str(error)}) from None
    except ValueError as error:
        raise PydanticCustomError("number", "{reason}", {"reason": str(error)}) from None


def _number_not_tiny(value: Any) -> float:
    number = _number(value)
    if 0.0 < number < SIGMA_RANGE[0]:
        reason = f"`{brief(str(value))}` is too small (less than {SIGMA_RANGE[0]:g})"
        raise PydanticCustomError("too_large", "{reason}", {"reason": reason})
    return number


def _pair(value: Any) -> tuple[float, float]:
    if isinstance(value, (list, tuple)):
        if len(value) != 2:
            raise PydanticCustomError("pair_shape", "one number, or two [x, y], not {n}", {"n": len(value)})
        return (_number(value[0]), _number(value[1]))
    one = _number(value)
    return (one, one)


def _positive_pair(value: Any) -> tuple[float, float]:
    pair = _pair(value)
    if min(pair) <= 0.0:
        raise PydanticCustomError("positive_pair", "must be greater than 0")
    return (_number_not_tiny(pair[0]), _number_not_tiny(pair[1]))


def _plain_path(value: Any) -> Any:
    value = _text(value)
    if isinstance(value, str) and (problem := file_name_problem(value)):
        raise PydanticCustomError("bad_path", "{problem}", {"problem": problem})
    return value


class AlsoJson:
    """Further forms of a value in the published schema: what a before-validator turns into the inner form."""

    def __init__(self, *alternatives: dict[str, Any]) -> None:
        self.alternatives = alternatives

    def __get_pydantic_json_schema__(self, core: Any, handler: Any) -> dict[str, Any]:
        return {"anyOf": [handler(core), *self.alternatives]}


class OrItsTable:
    """A list of entries and tables may also be one table alone."""

    def __get_pydantic_json_schema__(self, core: Any, handler: Any) -> dict[str, Any]:
        inner = handler(core)
        return {"anyOf": [inner, inner["items"]["oneOf"][1]]}


_SIGMA_NUMBER = {
    **POSITIVE_SCHEMA,
    "patternErrorMessage": "A σ is a positive number, `fixed` (known, not estimated) or `free` (no prior).",
}
_SIGMA_SCHEMA: dict[str, Any] = {"anyOf": [_SIGMA_NUMBER, {"enum": ["fixed", "free"]}]}
_PAIR_SCHEMA: dict[str, Any] = {
    "anyOf": [
        POSITIVE_SCHEMA,
        {"type": "array", "items": POSITIVE_SCHEMA, "minItems": 2, "maxItems": 2},
    ]
}

Text = Annotated[str, BeforeValidator(_text)]
Note = Annotated[str, BeforeValidator(_note)]
Name = Annotated[str, BeforeValidator(_name)]
Id = Annotated[str, BeforeValidator(_id)]
Number = Annotated[float, BeforeValidator(_number)]
PositiveNumber = Annotated[float, Field(gt=0), BeforeValidator(_number_not_tiny)]
NonNegativeNumber = Annotated[float, Field(ge=0), BeforeValidator(_number)]
Share = Annotated[float, Field(ge=0, lt=1), BeforeValidator(_number)]
Sigma = Annotated[
    float,
    PlainValidator(_sigma),
    PlainSerializer(sigma_as_written, return_type=float | str),
    WithJsonSchema(_SIGMA_SCHEMA),
]
SigmaXyz = Annotated[
    tuple[float, float, float],
    PlainValidator(_sigma_triple),
    PlainSerializer(lambda triple: [sigma_as_written(s) for s in triple], return_type=list[float | str]),
    WithJsonSchema(
        {
            "anyOf": [
                *_SIGMA_SCHEMA["anyOf"],
                {"type": "array", "items": _SIGMA_SCHEMA, "minItems": 3, "maxItems": 3},
            ]
        }
    ),
]
Pair = Annotated[tuple[Number, Number], Field()]
ScalePair = Annotated[tuple[float, float], BeforeValidator(_positive_pair), WithJsonSchema(_PAIR_SCHEMA)]
TriplePosition = tuple[Number, Number, Number]
FileName = Annotated[str, BeforeValidator(_plain_path)]


def is_parquet(name: str) -> bool:
    """Whether a table's name says Parquet."""
    return PurePosixPath(name.lower()).suffix in (".parquet", ".pq")
