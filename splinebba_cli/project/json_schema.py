"""JSON Schemas of the files that people and programs exchange with splinebba.

The project schema describes the YAML as editors read it, with native types: a number may also be written as a
text that holds one (YAML 1.1 reads ``1e-6`` as a text), an id may look like a number or a truth value.
"""

from __future__ import annotations

import json
from typing import Any

from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema

from splinebba_cli.project.campaign_schema import campaign_schema
from splinebba_cli.project.match_schema import match_schema
from splinebba_cli.project.model import Project
from splinebba_cli.project.result_schema import result_schema
from splinebba_cli.project.scalars import NUMBER_SCHEMA

SCHEMA_ID = "https://splinebba.org/schemas/project.schema.json"

WHOLE_NUMBER: dict[str, Any] = {
    "type": ["integer", "string"],
    "pattern": r"^[-+]?\d+$",
    "patternErrorMessage": "A whole number is expected.",
}
# YAML 1.2 reads `yes` as a text
TRUTH_VALUE: dict[str, Any] = {
    "type": ["boolean", "string"],
    "pattern": "^([Tt]rue|TRUE|[Ff]alse|FALSE|[Yy]es|YES|[Nn]o|NO|[Oo]n|ON|[Oo]ff|OFF)$",
    "patternErrorMessage": "true or false is expected.",
}


class _YamlSchema(GenerateJsonSchema):
    """Scalars as YAML gives them."""

    def float_schema(self, schema: core_schema.FloatSchema) -> JsonSchemaValue:
        return {**super().float_schema(schema), **NUMBER_SCHEMA}

    def int_schema(self, schema: core_schema.IntSchema) -> JsonSchemaValue:
        return {**super().int_schema(schema), **WHOLE_NUMBER}

    def bool_schema(self, schema: core_schema.BoolSchema) -> JsonSchemaValue:
        return dict(TRUTH_VALUE)

    def str_schema(self, schema: core_schema.StringSchema) -> JsonSchemaValue:
        return {**super().str_schema(schema), "type": ["string", "number", "boolean"]}

    def default_schema(self, schema: core_schema.WithDefaultSchema) -> JsonSchemaValue:
        """Defaults that are infinite or whole sections say nothing to an editor: leave them out."""
        out = super().default_schema(schema)
        default = out.get("default")
        if (
            default is None
            or isinstance(default, (dict, list))
            or default in (float("inf"), "Infinity", "free")
        ):
            out.pop("default", None)
        return out


def project_schema() -> dict[str, Any]:
    """The JSON Schema of project.yaml."""
    schema = Project.model_json_schema(schema_generator=_YamlSchema, mode="validation")
    schema = {"$schema": "https://json-schema.org/draft/2020-12/schema", "$id": SCHEMA_ID, **schema}
    cleaned: dict[str, Any] = _tidy(schema)
    return cleaned


def _tidy(node: Any) -> Any:
    """Without titles, which only repeat the key, and without alternatives inside of alternatives."""
    if isinstance(node, dict):
        return {
            key: (
                {name: _tidy(item) for name, item in value.items()}
                if key in ("properties", "$defs")
                else _flat(_tidy(value))
                if key == "anyOf"
                else _tidy(value)
            )
            for key, value in node.items()
            if not (key == "title" and isinstance(value, str))
        }
    if isinstance(node, list):
        return [_tidy(item) for item in node]
    return node


def _flat(alternatives: list[Any]) -> list[Any]:
    """Alternatives of alternatives in their place."""
    return [
        inner
        for alternative in alternatives
        for inner in (alternative["anyOf"] if list(alternative) == ["anyOf"] else [alternative])
    ]


def schema_text(which: str) -> str:
    """The schema of a ``project``, ``result``, ``campaign`` or ``match`` file as text."""
    schemas = {
        "project": project_schema,
        "result": result_schema,
        "campaign": campaign_schema,
        "match": match_schema,
    }
    schema = schemas[which]()
    return json.dumps(schema, indent=2, ensure_ascii=False) + "\n"
