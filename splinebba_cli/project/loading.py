"""Load a project: read, validate, build the network, or report everything that is wrong."""

from __future__ import annotations

import hashlib
import logging
import os
from dataclasses import dataclass
from pathlib import Path

from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.network import Network
from splinebba_cli.errors import ProjectError
from splinebba_cli.project.build_context import FEATURES, Building, Purpose
from splinebba_cli.project.build_settings import match_settings_of
from splinebba_cli.project.diagnostics import Collector, Diagnostic
from splinebba_cli.project.file_content import PROJECT_FILE
from splinebba_cli.project.model import Project
from splinebba_cli.project.network_builder import build_network
from splinebba_cli.project.schema_errors import HOLD_WHEN_MENDED, validate
from splinebba_cli.project.table_reader import TableReader
from splinebba_cli.project.yaml_source import read_yaml

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class LoadedProject:
    """A valid project."""

    path: Path
    model: Project
    network: Network
    diagnostics: tuple[Diagnostic, ...]  # warnings
    source_hashes: dict[str, str]  # file, relative to the project's folder -> sha256

    @property
    def name(self) -> str:
        """Name of the project."""
        return self.model.project.name

    @property
    def match_settings(self) -> MatchSettings:
        """How its chains are matched."""
        return match_settings_of(self.model.matching)


def load_project(path: Path | str, purpose: Purpose = "adjustment") -> LoadedProject:
    """Read a project file and its tables.

    Parameters
    ----------
    path : Path or str
        The project file, or a folder that holds ``project.yaml``.
    purpose : {"adjustment", "simulation", "matching"}
        A project to be simulated needs no observations; those of splines or of points may be there alone.  One to be
        matched needs chains; its splines need no observations, its images no orientations.

    Returns
    -------
    LoadedProject
        The models, the network for the core, warnings, and hashes of all files read.

    Raises
    ------
    ProjectError
        If anything is wrong; carries every diagnostic.
    """
    path = Path(path)
    if os.path.isdir(path):  # a name that is too long is none
        path = path / PROJECT_FILE
    _log.info("reading %s", path)
    collector = Collector()
    source = read_yaml(path, collector)
    model, as_written = (None, False) if source is None else validate(source, collector)
    if source is None or model is None:
        raise ProjectError(collector.finished())
    found = collector if as_written else Collector()
    reader = TableReader(source, path.parent, found, model.project.table_folders)
    building = Building(model, source, reader, found, purpose)
    if any(item.code == "SBB210" or item.message.endswith("has no `id`") for item in collector.items):
        building.unread |= FEATURES  # references to ids that were mended would mislead
    network = build_network(building)
    if not as_written:
        collector.take(found, HOLD_WHEN_MENDED)
    if network is None or collector.has_errors:
        raise ProjectError(collector.finished())
    hashes = {path.name: hashlib.sha256(path.read_bytes()).hexdigest(), **dict(sorted(reader.hashes.items()))}
    return LoadedProject(path, model, network, collector.finished(), hashes)


def has_chains(path: Path) -> bool:
    """Whether a project file declares chains; False where it is invalid, which whoever loads it is told."""
    collector = Collector()
    source = read_yaml(path, collector)
    model, _ = (None, False) if source is None else validate(source, collector)
    return model is not None and bool(model.observations.chains)
