"""What can be simulated: a kind of block by its name, or a project; and how a realization becomes a project."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from splinebba_cli.core.network import Network, UnlabelledPoints
from splinebba_cli.project.loading import LoadedProject, load_project
from splinebba_cli.project.model_simulation import Simulation
from splinebba_cli.project.writer import write_project
from splinebba_cli.simulation.assembly import NOMINAL_SIGMA_MM
from splinebba_cli.simulation.noise import Noise
from splinebba_cli.simulation.project_design import noise_of, project_design
from splinebba_cli.simulation.realization import Design, realize
from splinebba_cli.simulation.six_image_block import CHAINS, KINDS, MATCHING, START_SCALE, kind_design
from splinebba_cli.simulation.truth import Truth
from splinebba_cli.simulation.truth_file import TRUTH_FILE, truth_content, truth_text
from splinebba_cli.simulation.unlabelling import ChainStyle, unlabelled
from splinebba_cli.write_errors import cannot_write

BLOCK_NOISE = Noise(NOMINAL_SIGMA_MM, 3.0, float(np.radians(1.0)), 1.5)
PROJECT_SEED = 1


@dataclass(frozen=True)
class Target:
    """A design with its errors."""

    name: str
    design: Design
    noise: Noise
    seed: int  # where none is asked for
    inputs: dict[str, str] = field(default_factory=dict)  # file -> sha256
    left_out: tuple[str, ...] = ()
    loaded: LoadedProject | None = None  # None: a kind of block
    chains: ChainStyle | None = None  # how labels of curve points are taken away; None: they stay


def block_target(kind: str, changes: Mapping[str, Any]) -> Target:
    """A kind of block; `changes` are fields of :class:`Noise` other than its own.

    Raises
    ------
    KeyError
        If the kind is unknown; names the known ones.
    """
    scale = START_SCALE.get(kind, 1.0)
    noise = replace(BLOCK_NOISE, start_position_m=3.0 * scale, start_knots_m=1.5 * scale)
    noise = replace(noise, **changes)
    design = kind_design(kind, noise.image_mm or NOMINAL_SIGMA_MM)
    return Target(kind, design, noise, 0, chains=CHAINS.get(kind))


def project_target(loaded: LoadedProject, changes: Mapping[str, Any]) -> Target:
    """A project that was loaded for simulation; `changes` are fields of :class:`Noise` other than the project's.

    Raises
    ------
    SimulationError, NotSolvableError
        As :func:`.project_design.project_design`.
    """
    noise = replace(noise_of(loaded.model.simulation), **changes)
    made = project_design(loaded, changes.get("image_mm"))
    inputs = dict(loaded.source_hashes)
    if made.true_file:
        content = loaded.path.with_name(TRUTH_FILE).read_bytes()
        inputs[TRUTH_FILE] = hashlib.sha256(content).hexdigest()
    settings = loaded.model.simulation
    seed = PROJECT_SEED if settings is None or settings.seed is None else settings.seed
    return Target(loaded.name, made.design, noise, seed, inputs, made.left_out, loaded, chain_style(settings))


def chain_style(settings: Simulation | None) -> ChainStyle | None:
    """How a project wants labels to be taken away; None: not at all."""
    if settings is None or not settings.chains:
        return None
    return ChainStyle(settings.chain_points, settings.wrong_chain_share, settings.hidden_ties)


def simulate(
    target: LoadedProject | Path | str, seed: int | None = None, **changes: Any
) -> tuple[Network, Truth]:
    """A network to adjust, measured anew on a project or a kind of block, and its truth.

    Parameters
    ----------
    target : LoadedProject, Path or str
        A project (loaded, or its file or folder), or the name of a kind of block.
    seed : int, optional
        Of all errors; default: as the project says, else 1 (kinds of blocks: 0).
    **changes
        Fields of :class:`.noise.Noise`: ``image_mm``, ``start_position_m``, ``blunder_share`` ….

    Returns
    -------
    network : Network
    truth : Truth
        In the local frame of the network.

    Raises
    ------
    ProjectError, SimulationError, NotSolvableError
        If the project is invalid, or too little is known to simulate it.
    """
    if isinstance(target, str) and target in KINDS:
        chosen = block_target(target, changes)
    else:
        loaded = target if isinstance(target, LoadedProject) else load_project(target, "simulation")
        chosen = project_target(loaded, changes)
    made = realize(chosen.design, chosen.noise, chosen.seed if seed is None else seed)
    return made.network, made.truth


def write_target(target: Target, folder: Path, seed: int) -> Path:
    """Write one realization as a project, its truth beside it.

    Returns
    -------
    Path of the project file

    Raises
    ------
    OutputError
        SBB601, SBB604, SBB605, SBB607, if a file cannot be written.
    """
    made = realize(target.design, target.noise, seed)
    loaded = target.loaded
    network, labels = replace(made.network, unlabelled=UnlabelledPoints.none()), None
    chains: dict[str, Any] = {}
    if target.chains is not None:
        without = unlabelled(made.network, target.chains, seed)
        network, labels, chains = without.network, without.labels, _chain_settings(target.chains)
    if loaded is None:
        path = write_project(
            network,
            folder,
            name=target.name,
            description=KINDS[target.name],
            matching=MATCHING.get(target.name),
            simulation={"block": target.name, "seed": seed, **_settings(target.noise, BLOCK_NOISE), **chains},
        )
        noise_um = 1e3 * (target.noise.image_mm or 0.0)
        note: dict[str, Any] = {"kind": target.name, "seed": seed, "noise_um": noise_um}
    else:
        info, acceptance = loaded.model.project, loaded.model.acceptance
        path = write_project(
            network,
            folder,
            name=target.name,
            description=info.description or "",
            crs=info.crs or "",
            angle_unit=info.angle_unit or "deg",
            matching=loaded.model.matching.model_dump(mode="json", exclude_unset=True),
            acceptance=acceptance.model_dump(mode="json", exclude_unset=True),
            simulation={"seed": seed, **_settings(target.noise, Noise()), **chains},
        )
        note = {"project": target.name, "seed": seed}
    try:
        text = truth_text(truth_content(made.network, made.truth, note, labels))
        path.with_name(TRUTH_FILE).write_text(text, encoding="utf-8")
    except OSError as error:
        raise cannot_write(folder, error) from error
    return path


def _chain_settings(style: ChainStyle) -> dict[str, Any]:
    """What a simulation section says about chains."""
    return {
        "chains": True,
        "chain_points": style.points,
        "wrong_chain_share": style.wrong_share,
        "hidden_ties": style.hides_ties,
    }


def _settings(noise: Noise, usual: Noise) -> dict[str, Any]:
    """What a simulation section says about errors that are not the usual ones; the image σ always."""
    names = {
        "start_position_m": "start_position_m",
        "start_knots_m": "start_knots_m",
        "blunder_share": "blunder_share",
        "blunder_size": "blunder_size_sigma",
        "missing_point_share": "missing_point_share",
        "missing_pair_share": "missing_pair_share",
        "given_values": "given_errors",
    }
    own, other = asdict(noise), asdict(usual)
    found = {} if noise.image_mm is None else {"image_sigma_um": 1e3 * noise.image_mm}
    found |= {name: own[key] for key, name in names.items() if own[key] != other[key]}
    if noise.start_angle_rad is not None and noise.start_angle_rad != usual.start_angle_rad:
        found["start_angle_deg"] = float(np.degrees(noise.start_angle_rad))
    return found
