"""What pydantic finds, as diagnostics with a position, an error code and a suggestion."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from copy import deepcopy
from difflib import get_close_matches
from typing import Any, get_args

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from splinebba_cli.project.diagnostics import Collector, listing, suggestion
from splinebba_cli.project.model import FORMAT_VERSION, Project
from splinebba_cli.project.plain_text import brief
from splinebba_cli.project.schema_words import EXAMPLES, HELP_FOR_NAMES, words_of
from splinebba_cli.project.yaml_source import HELP_FOR_BEGIN, YamlPath, YamlSource

_CODES = {
    "extra_forbidden": "SBB201",
    "missing": "SBB202",
    "literal_error": "SBB204",
    "finite_number": "SBB207",
    "too_short": "SBB206",
    "too_long": "SBB206",
    "sigma_shape": "SBB206",
    "pair_shape": "SBB206",
    "rows": "SBB206",
    "string_too_short": "SBB202",
    "sigma": "SBB309",
    "bad_id": "SBB210",
    "bad_path": "SBB210",
    "too_large": "SBB205",
    "columns": "SBB402",
}
_RANGE = ("greater_than", "greater_than_equal", "less_than", "less_than_equal", "positive_pair")


#: Codes of the diagnostics of a mended project that still hold for the project as it stands.
HOLD_WHEN_MENDED = ("SBB202", "SBB301", "SBB302", "SBB4")


def validate(source: YamlSource, collector: Collector) -> tuple[Project | None, bool]:
    """The project model of YAML data, and whether it is as the user wrote it.

    Where the data do not fit, every error is in the collector, and the model is one with the bad values
    mended, so that references and tables can be looked at all the same; None where that is not possible.
    """
    if not isinstance(source.data, dict):
        collector.error("SBB106", "a project is a mapping of sections", source.place(()), HELP_FOR_BEGIN)
        return None, False
    try:
        return Project.model_validate(source.data), True
    except ValidationError as error:
        details = error.errors(include_url=False)
    for detail in details:
        refused = source.resolve(detail["loc"]) in source.refused
        if not refused and not _is_misspelt(detail, details, source):
            _add(detail, source, collector)
    return _mended(source, details), False


def _is_misspelt(detail: ErrorDetails, details: list[ErrorDetails], source: YamlSource) -> bool:
    """Whether a missing key is there under a misspelt name, which is reported."""
    if detail["type"] != "missing":
        return False
    owner = source.resolve(detail["loc"])
    unknown = [
        str(other["loc"][-1])
        for other in details
        if other["type"] == "extra_forbidden" and source.resolve(other["loc"])[:-1] == owner
    ]
    return bool(get_close_matches(str(detail["loc"][-1]), unknown, n=1))


def _mended(source: YamlSource, details: list[ErrorDetails]) -> Project | None:
    """The project with misspelt keys renamed, unknown ones removed, bad values made harmless."""
    data = deepcopy(source.data)
    missing = [detail["loc"] for detail in details if detail["type"] == "missing"]
    for detail in details:
        path = source.resolve(detail["loc"])
        parent = _value_at(data, path[:-1])
        if not path or parent is None or detail["type"] == "missing":
            continue
        if detail["type"] == "extra_forbidden":
            value = parent.pop(path[-1], None)
            absent = [key for key in known_keys(detail["loc"][:-1]) if key not in parent]
            found = get_close_matches(str(path[-1]), absent, n=1)
            if found:
                parent[found[0]] = value
        elif detail["type"] == "literal_error":
            parent[path[-1]] = str(detail["ctx"]["expected"]).split("'")[1]
        elif isinstance(_value_at(data, path), str) or _value_at(data, path) is None:
            parent[path[-1]] = "1"
    for loc in missing:
        owner = _value_at(data, source.resolve(loc))
        if isinstance(owner, dict) and loc[-1] not in owner:
            owner[loc[-1]] = _HARMLESS.get(str(loc[-1]), "1")
    try:
        return Project.model_validate(data)
    except ValidationError:
        return None


_HARMLESS: dict[str, Any] = {
    "role": "tie",
    "image_coordinates": "photo_mm",
    "project": {"name": "unnamed", "angle_unit": "deg", "rotation_sequence": "omega-phi-kappa"},
}


def _value_at(data: Any, path: YamlPath) -> Any:
    for part in path:
        if isinstance(data, dict):
            data = data.get(str(part))
        elif isinstance(data, list) and isinstance(part, int) and part < len(data):
            data = data[part]
        else:
            return None
    return data


def _add(detail: ErrorDetails, source: YamlSource, collector: Collector) -> None:
    loc, kind = detail["loc"], detail["type"]
    value = detail["input"]
    path = source.resolve(loc)
    if kind == "extra_forbidden":
        key = str(loc[-1])
        known = list(known_keys(loc[:-1]))
        near = _without_ending(key, known) or suggestion(key, known)
        help = near or _home_of(key) or f"known here: {listing(known, 20)}"
        where = f"`{_spelt(path[:-1])}`" if len(path) > 1 else "the project"
        collector.error("SBB201", f"unknown key `{key}` in {where}", source.place(path, key=True), help)
        return
    if kind == "missing" and isinstance(loc[-1], int):
        given = len(_value_at(source.data, path) or ())
        if loc[-1] == given:  # the first of those that are missing
            message = f"`{_spelt(path)}`: more values are expected than {given}"
            collector.error("SBB206", message, source.place(path), description_of(loc))
        return
    if kind == "missing":
        field = str(loc[-1])
        where = f"`{_spelt(path)}`" if path else "the project"
        collector.error(
            "SBB202",
            f"{where} has no `{field}`",
            source.place(path),
            EXAMPLES.get(field, "") or description_of(loc),
        )
        return
    message, help = _message(detail, path, value, loc)
    number = kind in ("number", "float_parsing") and "not a finite" in message
    code = "SBB207" if number else "SBB205" if kind in _RANGE else _CODES.get(kind, "SBB203")
    if kind == "sigma" and "is not a number" in message:
        code = "SBB203"
    collector.error(code, message, source.place(path), help, kind=f"{kind} in {path[:1]}")


def _message(detail: ErrorDetails, path: YamlPath, value: Any, loc: tuple[str | int, ...]) -> tuple[str, str]:
    name = f"`{_spelt(path)}`"
    kind, context = detail["type"], detail.get("ctx", {})
    help = description_of(loc)
    if value is None:
        return f"{name} has no value", help
    if kind == "literal_error":
        allowed = [word.strip("' ") for word in str(context["expected"]).replace(" or ", ",").split(",")]
        near = get_close_matches(str(value), allowed, n=2, cutoff=0.5)
        guess = f"did you mean `{near[0]}`? " if len(near) == 1 else ""
        return f"{name}: `{brief(str(value))}` is not allowed", f"{guess}allowed: {listing(allowed, 16)}"
    if path == ("version",) and kind != "int_parsing":
        return f"format version {value} is not known", f"this program reads version {FORMAT_VERSION}"
    if kind == "bad_id":
        help = HELP_FOR_NAMES
    if kind == "list_type" and isinstance(value, dict) and not isinstance(path[-1], int):
        help = f"a list may have one entry: `{path[-1]}: [{{…}}]`"
    return f"{name}: {words_of(detail, value)}", help


def _without_ending(key: str, known: list[str]) -> str:
    """A help line for a key whose ending, a unit mostly, is left out where several are possible."""
    longer = [word for word in known if word.startswith(f"{key}_")]
    if len(longer) < 2:
        return ""
    words = [f"`{word}`" for word in longer]
    return f"did you mean {', '.join(words[:-1])} or {words[-1]}?"


def _home_of(key: str) -> str:
    """The section that a key belongs to, for one that stands elsewhere."""
    homes = [section for section in Project.model_fields if key in known_keys((section,))]
    return f"`{key}` belongs into `{homes[0]}`" if len(homes) == 1 else ""


def _spelt(path: YamlPath) -> str:
    text = ""
    for part in path:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else str(part)
    return text or "project"


def description_of(loc: tuple[str | int, ...]) -> str:
    """The description of the field that a location names, empty where there is none."""
    parts = [part for part in loc if not (isinstance(part, str) and part.startswith("<"))]
    while parts and isinstance(parts[-1], int):
        parts.pop()
    for model in _models_at(loc[: _last_index(loc, parts[-1])] if parts else ()):
        for name, info in model.model_fields.items():
            if parts and (info.alias or name) == parts[-1]:
                return f"{parts[-1]}: {info.description}" if info.description else ""
    return ""


def _last_index(loc: tuple[str | int, ...], part: str | int) -> int:
    return max(i for i, item in enumerate(loc) if item == part)


def known_keys(loc: Iterable[str | int]) -> list[str]:
    """Keys that the model at a location knows."""
    return [
        info.alias or name for model in _models_at(tuple(loc)) for name, info in model.model_fields.items()
    ]


def _models_at(loc: tuple[str | int, ...]) -> list[type[BaseModel]]:
    """Models that may stand at a location: fields are followed, numbers and union tags narrow the choice."""
    current: list[type[BaseModel]] = [Project]
    for part in loc:
        if part in ("<table>", "<entry>"):
            wanted = part == "<table>"
            current = [model for model in current if model.__name__.endswith("Table") == wanted]
        elif isinstance(part, str):
            current = [
                inner
                for model in current
                for name, info in model.model_fields.items()
                if (info.alias or name) == part
                for inner in _inner_models(info.annotation)
            ]
    return current


def _inner_models(annotation: Any) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    else:
        for argument in get_args(annotation):
            yield from _inner_models(argument)
