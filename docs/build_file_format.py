"""Write docs/file-format.md from the models of the project file.

python -m docs.build_file_format
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from splinebba_cli.project.json_schema import project_schema

PAGE = Path(__file__).with_name("file-format.md")
INTRODUCTION = Path(__file__).with_name("file-format.intro.md")
ORDER = (
    "ProjectInfo", "Camera", "Distortion", "Affinity", "Image", "Orientation", "PriorOrientation",
    "OrientationSigma", "ImageTable", "Spline", "Held", "NumberTable", "SplineTable", "Point", "PointTable",
    "Observations", "SplineGroup", "PointGroup", "ChainGroup", "ArcLengthGroup", "TangentGroup", "DistanceGroup",
    "Adjustment", "DatumFeatures", "Knots",
    "LocalTests",
    "Outliers", "Matching", "Acceptance", "Simulation",
)  # fmt: skip

Schema = dict[str, Any]


def page() -> str:
    """The whole page."""
    schema = project_schema()
    definitions: dict[str, Schema] = schema["$defs"]
    if set(ORDER) != set(definitions):
        raise ValueError(f"ORDER and the models differ: {sorted(set(ORDER) ^ set(definitions))}")
    parts = [INTRODUCTION.read_text(encoding="utf-8").rstrip(), _section("Project", schema)]
    parts += [_section(name, definitions[name]) for name in ORDER]
    return "\n\n".join(parts) + "\n"


def _section(name: str, model: Schema) -> str:
    lines = [f"### {name}", "", model.get("description", "").replace("\n", " "), ""]
    lines += ["| key | value | default | meaning |", "|---|---|---|---|"]
    required = model.get("required", [])
    for key, field in model["properties"].items():
        default = "**needed**" if key in required else _default(field.get("default"))
        cells = (f"`{key}`", type_text(field), default, field["description"])
        lines.append("| " + " | ".join(cell.replace("|", "\\|").replace("\n", " ") for cell in cells) + " |")
    return "\n".join(lines)


def _default(value: Any) -> str:
    if value is None:
        return ""
    return f"`{str(value).lower() if isinstance(value, bool) else value}`"


def type_text(field: Schema) -> str:
    """What may stand there, in words."""
    if "$ref" in field:
        name = field["$ref"].rsplit("/", 1)[1]
        return f"[{name}](#{name.lower()})"
    for key in ("anyOf", "oneOf"):
        if key in field:
            texts = [type_text(option) for option in field[key] if option.get("type") != "null"]
            return " or ".join(dict.fromkeys(texts))
    if "const" in field:
        return f"`{field['const']}`"
    if "enum" in field:
        return ", ".join(f"`{value}`" for value in field["enum"])
    if field.get("type") == "array":
        return _array_text(field)
    if field.get("type") == "object":
        return "mapping"
    kinds = field.get("type", "text")
    kinds = [kinds] if isinstance(kinds, str) else kinds
    if "boolean" in kinds and "number" not in kinds:
        return "`true` or `false`"
    return "whole number" if "integer" in kinds else "number" if kinds == ["number", "string"] else "text"


def _array_text(field: Schema) -> str:
    items = field.get("prefixItems") or [field.get("items", {})]
    item = type_text(items[0])
    if field.get("minItems") == field.get("maxItems") is not None:
        return f"list of {field['minItems']}: {item}"
    if item.startswith("list"):
        return "rows"
    return f"list of ({item})" if " or " in item else f"list of {item}"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8", newline="\n")
    print(PAGE.name)
