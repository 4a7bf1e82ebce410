"""From the declaration of a table in the project to its columns under our names."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np

from splinebba_cli.core.network import IntArray
from splinebba_cli.project.diagnostics import Collector, Place, listing, suggestion
from splinebba_cli.project.file_content import NoContentError, TooLargeError, file_content, names_in
from splinebba_cli.project.model_tables import TableOptions, TableOrRows
from splinebba_cli.project.parquet_table import table_from_parquet
from splinebba_cli.project.regular_table import Shape, first_line, regular_columns
from splinebba_cli.project.scalars import is_parquet
from splinebba_cli.project.table import Table
from splinebba_cli.project.table_cells import cells_of, separator_of
from splinebba_cli.project.table_folders import folders_seen_from, lies_within
from splinebba_cli.project.tables import (
    TableUnreadableError,
    table_from_columns,
    table_from_rows,
    table_from_text,
)
from splinebba_cli.project.text_position import decoded, lines_of
from splinebba_cli.project.yaml_source import YamlPath, YamlSource

TEXTS = frozenset(
    [
        "image",
        "spline",
        "point",
        "camera",
        "rotation_sequence",
        "role",
        "mark",
        "chain",
        "from",
        "to",
        "at",
        "use",
    ]
)  # columns that hold no numbers


@dataclass(frozen=True)
class Wanted:
    """Columns that a table must and may have; `synonyms` are other names for them."""

    required: tuple[str, ...]
    optional: tuple[str, ...] = ()
    synonyms: dict[str, str] = field(default_factory=dict)

    @property
    def known(self) -> tuple[str, ...]:
        """All names that are understood."""
        return (*self.required, *self.optional)


@dataclass
class TableReader:
    """Reads the tables of one project, each file once; keeps the hashes of what it read."""

    source: YamlSource
    folder: Path
    collector: Collector
    folders: Sequence[str] = ()  # further ones in which tables may lie
    hashes: dict[str, str] = field(default_factory=dict)
    _contents: dict[str, bytes | None] = field(default_factory=dict)
    _tables: dict[str, Table | None] = field(default_factory=dict)
    _groups: dict[int, dict[str, IntArray]] = field(default_factory=dict)

    def read(
        self, spec: TableOrRows, path: YamlPath, wanted: Wanted, default_columns: Sequence[str] | None = None
    ) -> Table | None:
        """The table that `spec`, at `path` in the project, declares; None after an error.

        Parameters
        ----------
        default_columns : sequence of str or None
            Columns of rows in the project file that declare none.
        """
        key = (
            repr((spec.table, spec.columns, spec.header, spec.delimiter, wanted))
            if spec.table
            else repr(path)
        )
        if key not in self._tables:
            try:
                self._tables[key] = self._read(spec, path, wanted, default_columns)
            except TableUnreadableError:
                self._tables[key] = None
        return self._tables[key]

    def rows_by(self, table: Table, column: str) -> dict[str, IntArray]:
        """Rows of each identifier in a column, in the order of its first occurrence."""
        if id(table) not in self._groups:
            labels = table.labels(column)
            order = np.argsort(labels.number, kind="stable")
            counts = np.bincount(labels.number, minlength=len(labels.names))
            parts = np.split(order, np.cumsum(counts)[:-1])
            found = [(name, part) for name, part in zip(labels.names, parts, strict=True) if len(part)]
            found.sort(key=lambda item: int(item[1][0]))
            self._groups[id(table)] = dict(found)
        return self._groups[id(table)]

    def _read(
        self, spec: TableOrRows, path: YamlPath, wanted: Wanted, default_columns: Sequence[str] | None
    ) -> Table:
        at = self.source.place((*path, "table") if spec.table else path, key=spec.table is None)
        if (spec.table is None) == (spec.data is None):
            code, verb = ("SBB202", "neither") if spec.table is None else ("SBB209", "both")
            self.collector.error(code, f"{verb} `table` and `data` given", at, "give one of them")
            raise TableUnreadableError
        if isinstance(spec.columns, dict):
            self._check_mapping(spec.columns, path, wanted)
        if spec.table is not None:
            table = self._side_table(spec, path, at, wanted)
        else:
            table = self._inline(spec, path, at, wanted, default_columns)
        return self._named(table, spec, path, at, wanted)

    def _side_table(self, spec: TableOptions, path: YamlPath, at: Place, wanted: Wanted) -> Table:
        assert spec.table is not None
        name = spec.table
        file = self.folder / name
        columns = None
        if isinstance(spec.columns, tuple):
            columns = self._declared(spec.columns, path, wanted)
        if is_parquet(name):
            content = self._content(name, at)
            if columns is not None:
                help = "a Parquet table names its columns: give a mapping, or leave `columns` out"
                self.collector.error("SBB402", "a list of columns for a Parquet table", at, help)
                raise TableUnreadableError
            return table_from_parquet(content, file=str(file), collector=self.collector, declared_at=at)
        regular = self._regular(spec, name, columns, at, wanted)
        if regular is not None:
            return regular
        return table_from_text(
            self._text(name, at),
            file=str(file),
            collector=self.collector,
            columns=columns,
            header=spec.header,
            delimiter=spec.delimiter,
            declared_at=at,
        )

    def _regular(
        self, spec: TableOptions, name: str, columns: Sequence[str] | None, at: Place, wanted: Wanted
    ) -> Table | None:
        """A large table by compiled readers; None where it is to be read by rows."""
        content = self._bytes(name, at)
        first = first_line(content)
        separator = separator_of(first, spec.delimiter)
        if separator is None:
            return None
        names = columns if columns is not None else [cell.strip() for cell in cells_of(first, separator)]
        ours = {name: wanted.synonyms.get(name, name) for name in names}
        if isinstance(spec.columns, dict):
            ours = {theirs: wanted.synonyms.get(our, our) for our, theirs in spec.columns.items()}
        known = {name: our for name, our in ours.items() if our in wanted.known}
        if len(set(names)) < len(names) or not known:
            return None
        shape = Shape(
            names,
            frozenset(name for name, our in known.items() if our in TEXTS),
            frozenset(name for name, our in known.items() if our not in TEXTS),
            separator,
            columns is None if spec.header is None else spec.header,
        )
        found = regular_columns(self.folder / name, content, shape)
        if found is None:
            return None
        return table_from_columns(
            found,
            names,
            content,
            file=str(self.folder / name),
            collector=self.collector,
            header=shape.header,
            separator=separator,
            declared_at=at,
        )

    def _inline(
        self, spec: TableOrRows, path: YamlPath, at: Place, wanted: Wanted, default: Sequence[str] | None
    ) -> Table:
        columns: tuple[str, ...] | None = None
        if isinstance(spec.columns, tuple):
            columns = self._declared(spec.columns, path, wanted)
        elif default is not None and not spec.header and spec.columns is None:
            columns = self._default_columns(spec, default)
        data_path = (*path, "data") if (*path, "data") in self.source.values else path
        named_by_header = isinstance(spec.data, str) and (spec.header or isinstance(spec.columns, dict))
        if columns is None and not named_by_header:
            help = f"columns: [{', '.join(wanted.required)}]"
            self.collector.error("SBB402", "rows in the project file need `columns`", at, help)
            raise TableUnreadableError
        if isinstance(spec.data, str):
            return self._inline_text(spec, spec.data, data_path, at, columns)
        return table_from_rows(
            spec.data or (),
            file=self.source.file,
            collector=self.collector,
            columns=columns or (),
            place_of_cell=lambda row, cell: self.source.place(
                (*data_path, row) if cell is None else (*data_path, row, cell)
            ),
            declared_at=at,
        )

    def _inline_text(
        self, spec: TableOrRows, data: str, data_path: YamlPath, at: Place, columns: tuple[str, ...] | None
    ) -> Table:
        """Rows of a text; only those of a literal block stand line by line in the file."""
        if data_path in self.source.folded:
            place = self.source.place(data_path)
            self.collector.error("SBB203", "rows in a folded block: `>` joins lines", place, "write `|`")
            raise TableUnreadableError
        first = self.source.blocks.get(data_path)
        return table_from_text(
            data,
            file=self.source.file,
            collector=self.collector,
            columns=columns,
            header=spec.header,
            delimiter=spec.delimiter,
            first_line=first or 0,
            source_lines=self.source.lines if first is not None else None,
            declared_at=at,
            whole=None if first is not None else self.source.place(data_path),
        )

    def _default_columns(self, spec: TableOrRows, default: Sequence[str]) -> tuple[str, ...]:
        """The default columns, as many as the first row has (σ columns may be absent)."""
        if isinstance(spec.data, str):
            rows = [
                line for line in spec.data.splitlines() if line.strip() and not line.strip().startswith("#")
            ]
            width = len(rows[0].replace(",", " ").replace(";", " ").split()) if rows else 3
        else:
            width = len(spec.data[0]) if spec.data else 3
        return tuple(default) if width == len(default) else tuple(default[:3])

    def _declared(self, columns: tuple[str, ...], path: YamlPath, wanted: Wanted) -> tuple[str, ...]:
        out, unknown = [], False
        for number, name in enumerate(columns):
            name = wanted.synonyms.get(name, name)
            if name != "-" and name not in wanted.known:
                place = self.source.place((*path, "columns", number))
                help = (
                    suggestion(name, wanted.known)
                    or f"known: {listing(wanted.known, 20)}; `-` for one not used"
                )
                self.collector.error("SBB402", f"unknown column `{name}`", place, help)
                unknown = True
            out.append(name)
        if unknown:
            raise TableUnreadableError
        return tuple(out)

    def _check_mapping(self, columns: dict[str, str], path: YamlPath, wanted: Wanted) -> None:
        unknown = [name for name in columns if wanted.synonyms.get(name, name) not in wanted.known]
        for name in unknown:
            place = self.source.place((*path, "columns", name), key=True)
            help = suggestion(name, wanted.known) or f"known: {listing(wanted.known, 20)}"
            self.collector.error("SBB402", f"unknown column `{name}`", place, help)
        if unknown:
            raise TableUnreadableError

    def _named(self, table: Table, spec: TableOrRows, path: YamlPath, at: Place, wanted: Wanted) -> Table:
        """The table with its columns under our names."""
        ours, unused = {}, []
        if isinstance(spec.columns, dict):
            for name, theirs in spec.columns.items():
                if theirs in table.columns:
                    ours[wanted.synonyms.get(name, name)] = theirs
                else:
                    place = self.source.place((*path, "columns", name))
                    help = suggestion(theirs, table.columns) or f"the table has {listing(table.columns, 20)}"
                    self.collector.error("SBB402", f"`{table.file}` has no column `{theirs}`", place, help)
                    raise TableUnreadableError
        else:
            for theirs in table.columns:
                name = wanted.synonyms.get(theirs, theirs)
                if name in wanted.known:
                    ours[name] = theirs
                elif spec.columns is None:
                    unused.append(theirs)
        missing = [name for name in wanted.required if name not in ours]
        if missing:
            help = suggestion(missing[0], set(table.columns) - set(ours.values()))
            help = help or f"it has {listing(table.columns, 20)}"
            if spec.table is not None and spec.columns is None:
                named = ", ".join(f"{name}: …" for name in missing)
                end = "" if help.endswith("?") else ";"
                help += (
                    f"{end} `columns: {{{named}}}` tells its names of them, `columns: [...]` those of a table without "
                    "a header"
                )
            self.collector.error("SBB402", f"`{table.file}` has no column {listing(missing)}", at, help)
            raise TableUnreadableError
        for theirs in unused:
            help = suggestion(theirs, wanted.known) or f"known: {listing(wanted.known, 20)}"
            self.collector.warning("SBB402", f"column `{theirs}` of `{table.file}` is not used", at, help)
        place_of = table.place_of
        renamed = {name: table.columns[theirs] for name, theirs in ours.items()}
        return Table(
            table.file,
            renamed,
            table.rows,
            lambda row, name: place_of(row, ours.get(name, name)),
            self.collector,
            table.head,
        )

    def _content(self, name: str, at: Place) -> bytes:
        file = self.folder / name
        if not lies_within(file, self.folder, self.folders):
            real = Path(os.path.realpath(file)).parent
            folder = folders_seen_from(self.folder, real, ())[0] if name.startswith("..") else real
            help = f"copy it beside the project, or declare `table_folders: [{folder}]` in `project`"
            self.collector.error("SBB408", f"table `{name}` lies outside of the project's folder", at, help)
            raise TableUnreadableError
        try:
            content = file_content(file)
        except TooLargeError as reason:
            self.collector.error("SBB409", f"table `{name}` is too large: {reason}", at, "split the block")
            raise TableUnreadableError from None
        except NoContentError as reason:
            near = suggestion(file.name, names_in(file.parent))
            self.collector.error("SBB401", f"table `{name}` cannot be read: {reason}", at, near)
            raise TableUnreadableError from None
        self.hashes[name] = hashlib.sha256(content).hexdigest()
        return content

    def _bytes(self, name: str, at: Place) -> bytes:
        """The content of a file without a byte order mark, read once."""
        if name not in self._contents:
            self._contents[name] = None
            self._contents[name] = self._content(name, at).removeprefix(b"\xef\xbb\xbf")
        content = self._contents[name]
        if content is None:
            raise TableUnreadableError
        return content

    def _text(self, name: str, at: Place) -> str:
        content, file = self._bytes(name, at), str(self.folder / name)
        text = decoded(content, file, partial(self.collector.error, "SBB103"))
        if text is not None and "\0" in text:
            lines = lines_of(text[: text.index("\0") + 1])
            place = Place(file, len(lines), len(lines[-1]), 1, lines[-1])
            help = "it is no text: a table is CSV, or Parquet with a name that ends in .parquet"
            self.collector.error("SBB411", "a NUL character in the table", place, help)
            text = None
        if text is None:
            self._contents[name] = None
            raise TableUnreadableError
        return text
