"""YAML that remembers where everything stands, and keeps what people write.

Every scalar stays a text: the ids ``0101``, ``12:30``, ``no`` and ``1e-6`` survive, and the models convert
where a number is meant.  An empty value is None.  Duplicate keys, merge keys, tags and alias bombs are
diagnostics with positions.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import yaml

from splinebba_cli.project.diagnostics import Collector, Place, listing, suggestion
from splinebba_cli.project.file_content import (
    LARGEST_PROJECT_FILE,
    NoContentError,
    TooLargeError,
    file_content,
    names_in,
)
from splinebba_cli.project.text_position import decoded
from splinebba_cli.project.yaml_errors import report_syntax_error

if TYPE_CHECKING:
    Loader = yaml.SafeLoader
else:
    Loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

YamlPath = tuple[str | int, ...]

MAX_DEPTH = 64
HELP_FOR_BEGIN = "it begins with `version: 1`, `project:`, `cameras:`, `images:` …"
MAX_ALIASED = 100_000  # values that aliases may repeat; a long text counts as several
_LONG_TEXT = 100  # characters
_LINE_BREAK = re.compile("\r\n|[\n\r\x85\u2028\u2029]")  # YAML's
_TAGS = frozenset(
    f"tag:yaml.org,2002:{kind}"
    for kind in ("null", "bool", "int", "float", "str", "timestamp", "value", "merge", "seq", "map")
)


@dataclass(frozen=True)
class _Span:
    line: int  # from 0
    column: int  # from 0
    length: int


@dataclass
class YamlSource:
    """A YAML text as plain data (dict, list, str, None) with the position of every key and value."""

    file: str
    lines: list[str]
    data: Any = None
    keys: dict[YamlPath, _Span] = field(default_factory=dict)
    values: dict[YamlPath, _Span] = field(default_factory=dict)
    blocks: dict[YamlPath, int] = field(default_factory=dict)  # first line (from 0) of literal block scalars
    folded: set[YamlPath] = field(default_factory=set)  # folded block scalars
    refused: set[YamlPath] = field(default_factory=set)  # values that are reported already, and None

    def place(self, path: YamlPath, *, key: bool = False) -> Place:
        """Where a value stands, or its key; a path that does not exist gives its nearest parent."""
        while path:
            span = self.keys.get(path) if key else self.values.get(path)
            span = span or self.values.get(path)
            if span is not None:
                return self._place(span)
            path, key = path[:-1], True
        return Place(self.file, 1, 1, 1, self.lines[0] if self.lines else "")

    def at(self, line: int, column: int, length: int = 1) -> Place:
        """Place of a line and column, both from 0."""
        text = self.lines[line] if line < len(self.lines) else ""
        return Place(self.file, line + 1, column + 1, max(1, length), text)

    def within(self, position: tuple[int, int]) -> tuple[int, int]:
        """A position, or, of one behind the text, the end of its last line."""
        last = next((n for n in range(len(self.lines) - 1, -1, -1) if self.lines[n].strip()), 0)
        return position if position[0] <= last else (last, len(self.lines[last].rstrip()))

    def at_mark(self, mark: Any, length: int = 1) -> Place:
        """Place of a mark of the parser."""
        return self.at(mark.line, mark.column, length)

    def _place(self, span: _Span) -> Place:
        return self.at(span.line, span.column, span.length)

    def resolve(self, loc: tuple[str | int, ...]) -> YamlPath:
        """The longest part of `loc` that exists in the data; parts that name no child are passed over."""
        path: list[str | int] = []
        current = self.data
        for part in loc:
            in_list = isinstance(current, list) and isinstance(part, int) and part < len(current)
            if in_list or (isinstance(current, dict) and part in current):
                current = current[part]
                path.append(part)
        return tuple(path)


def read_yaml(path: Path, collector: Collector, file: str | None = None) -> YamlSource | None:
    """Read and parse a YAML file; None where it cannot be parsed (the collector then holds an error)."""
    name = file if file is not None else str(path)
    try:
        content = file_content(path, LARGEST_PROJECT_FILE)
    except TooLargeError as reason:
        help = "move the data to side tables (`table: file.csv`), which may be as large as the memory"
        collector.error("SBB109", f"`{name}` is no project file: {reason}", Place(name), help)
        return None
    except NoContentError as reason:
        names = names_in(path.parent)
        help = suggestion(path.name, names) or _other_projects(path.name, names)
        collector.error("SBB101", f"`{name}` cannot be read: {reason}", Place(name), help)
        return None
    return parse_yaml(content, name, collector)


def _other_projects(wanted: str, names: Iterable[str]) -> str:
    """A help line with the YAML files of a folder that holds nothing under the name looked for."""
    found = sorted(name for name in names if name.endswith((".yaml", ".yml")))
    if wanted in found:
        return ""
    return f"give the project file: the folder holds {listing(found)}" if found else ""


def parse_yaml(content: bytes | str, file: str, collector: Collector) -> YamlSource | None:
    """Parse YAML text; None where it is no YAML (the collector then holds an error)."""
    text = content if isinstance(content, str) else decoded(content, file, partial(collector.error, "SBB103"))
    if text is None:
        return None
    source = YamlSource(file, _LINE_BREAK.split(text))
    try:
        root = _composed(text, source, collector)
    except yaml.YAMLError as error:
        report_syntax_error(error, source, collector)
        return None
    if root is None:
        return None
    walker = _Walker(source, collector)
    source.data = walker.walk(root)
    return None if walker.exhausted else source


def _composed(text: str, source: YamlSource, collector: Collector) -> yaml.Node | None:
    """The node graph, after a look at the events: syntax, depth, number of documents."""
    depth = documents = 0
    for event in yaml.parse(text, Loader=Loader):
        if isinstance(event, yaml.CollectionStartEvent):
            depth += 1
            if depth > MAX_DEPTH:
                place = source.at_mark(event.start_mark)
                help = "brackets without their ends? A project has no more than ten levels"
                collector.error("SBB105", f"nested deeper than {MAX_DEPTH} levels", place, help)
                return None
        elif isinstance(event, yaml.CollectionEndEvent):
            depth -= 1
        elif isinstance(event, yaml.DocumentStartEvent):
            documents += 1
            if documents > 1:
                place = source.at_mark(event.start_mark, 3)
                collector.error("SBB102", "a second YAML document in the file", place, "one project a file")
                return None
    node = Loader(text).get_single_node()
    if node is None:
        collector.error("SBB106", "the file is empty", source.at(0, 0), HELP_FOR_BEGIN)
    return node


class _Walker:
    """Turns nodes into plain data, recording positions."""

    def __init__(self, source: YamlSource, collector: Collector) -> None:
        self.source = source
        self.collector = collector
        self.active: dict[int, YamlPath] = {}
        self.seen: set[int] = set()
        self.repeating = 0  # depth within collections that were met before
        self.aliased = 0
        self.exhausted = False

    def walk(self, node: yaml.Node, path: YamlPath = ()) -> Any:
        self._record(node, path)
        if self._refused(node, path):
            self.source.refused.add(path)
            return None
        if isinstance(node, yaml.ScalarNode):
            return self._scalar(node, path)
        again = id(node) in self.seen
        self.seen.add(id(node))
        self.repeating += again
        value = self._children(node, path)
        self.repeating -= again
        return value

    def _children(self, node: yaml.Node, path: YamlPath) -> Any:
        self.active[id(node)] = path
        if isinstance(node, yaml.SequenceNode):
            value: Any = [self.walk(child, (*path, i)) for i, child in enumerate(node.value)]
        else:
            value = self._mapping(node, path)
        del self.active[id(node)]
        return value

    def _record(self, node: yaml.Node, path: YamlPath) -> None:
        start, end = node.start_mark, node.end_mark
        length = end.column - start.column if end.line == start.line else 1
        self.source.values[path] = _Span(start.line, start.column, max(1, length))

    def _count(self, node: yaml.Node) -> None:
        """Add up what aliases repeat."""
        long = isinstance(node, yaml.ScalarNode) and len(node.value) > _LONG_TEXT
        if self.repeating or id(node) in self.seen:
            self.aliased += 1 + (len(node.value) // _LONG_TEXT if long else 0)
        if long:
            self.seen.add(id(node))

    def _refused(self, node: yaml.Node, path: YamlPath) -> bool:
        """Whether the node must not be entered: an alias cycle or bomb, or a tag."""
        place = self.source.at(node.start_mark.line, node.start_mark.column)
        if id(node) in self.active:
            whole = self.active[id(node)]
            self.source.refused.add(whole)
            help = "remove the alias `*…` from what its anchor `&…` names"
            self.collector.error("SBB105", "an alias that contains itself", self.source.place(whole), help)
            return True
        self._count(node)
        if self.aliased > MAX_ALIASED:
            if not self.exhausted:
                help = "write the data out, or use a side table"
                self.collector.error("SBB105", "aliases expand to too much", place, help)
            self.exhausted = True
        if self.exhausted:
            return True
        if node.tag not in _TAGS:
            message = f"the tag `{node.tag.replace('tag:yaml.org,2002:', '!!')}` is not supported"
            self.collector.error("SBB107", message, self.source.place(path), "remove the tag")
            return True
        return False

    def _scalar(self, node: yaml.ScalarNode, path: YamlPath) -> str | None:
        if node.style == "|":
            self.source.blocks[path] = node.start_mark.line + 1
        elif node.style == ">":
            self.source.folded.add(path)
        if node.value == "" and not node.style:
            return None
        return str(node.value)

    def _mapping(self, node: yaml.Node, path: YamlPath) -> dict[str, Any]:
        out: dict[str, Any] = {}
        first: dict[str, yaml.Node] = {}
        for key_node, value_node in node.value:
            mark = key_node.start_mark
            place = self.source.at(mark.line, mark.column, len(str(key_node.value)))
            if not isinstance(key_node, yaml.ScalarNode):
                self.collector.error("SBB108", "a key must be a text", self.source.at(mark.line, mark.column))
                continue
            key = str(key_node.value)
            if key_node.tag.endswith(":merge"):
                help = "repeat the keys; an alias for a whole value is fine"
                self.collector.error("SBB107", "merge keys `<<` are not supported", place, help)
                continue
            if key in first:
                before = first[key].start_mark
                help = f"first given at line {before.line + 1}, column {before.column + 1}"
                self.collector.error("SBB104", f"key `{key}` given twice", place, help)
                continue
            first[key] = key_node
            child = (*path, key)
            self.source.keys[child] = _Span(mark.line, mark.column, len(key))
            out[key] = self.walk(value_node, child)
        return out
