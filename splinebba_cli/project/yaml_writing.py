"""Plain data as the YAML of a project file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import yaml

if TYPE_CHECKING:
    Dumper = yaml.SafeDumper
else:
    Dumper = getattr(yaml, "CSafeDumper", yaml.SafeDumper)

# beside the project; `splinebba schema project > project.schema.json` writes it
FIRST_LINE = "# yaml-language-server: $schema=project.schema.json\n"


class _ProjectDumper(Dumper):
    """Short lists in one line, texts of several lines as block scalars."""


class _Section(dict[str, Any]):
    """A section of the file: its key always begins a line."""


def _text(dumper: Any, text: str) -> Any:
    style = "|" if "\n" in text else None
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, style=style)


def _sequence(dumper: Any, items: Any) -> Any:
    flat = all(not isinstance(item, (dict, list, tuple)) for item in items)
    return dumper.represent_sequence("tag:yaml.org,2002:seq", items, flow_style=flat)


def _mapping(dumper: Any, items: dict[str, Any]) -> Any:
    flat = len(items) <= 7 and all(
        not isinstance(v, (dict, list, tuple)) and "\n" not in str(v) for v in items.values()
    )
    short = sum(len(str(key)) + len(str(value)) + 4 for key, value in items.items()) < 70
    return dumper.represent_mapping("tag:yaml.org,2002:map", items.items(), flow_style=flat and short)


def _section(dumper: Any, items: dict[str, Any]) -> Any:
    return dumper.represent_mapping("tag:yaml.org,2002:map", items.items(), flow_style=False)


_ProjectDumper.add_representer(_Section, _section)
_ProjectDumper.add_representer(str, _text)
_ProjectDumper.add_representer(list, _sequence)
_ProjectDumper.add_representer(tuple, _sequence)
_ProjectDumper.add_representer(dict, _mapping)


def project_yaml(data: dict[str, Any], comment: str = "") -> str:
    """The text of a project file, one section after the other."""
    return FIRST_LINE + sections_yaml(data, comment)


def sections_yaml(data: dict[str, Any], comment: str = "") -> str:
    """The text of some sections of a project file, under a comment."""
    head = "".join(f"# {line}\n" for line in comment.splitlines())
    parts = [
        yaml.dump(
            _Section({key: value}), Dumper=_ProjectDumper, sort_keys=False, allow_unicode=True, width=110
        )
        for key, value in data.items()
    ]
    return head + "\n".join(parts)
