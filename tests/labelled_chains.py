"""A street whose chains have no labels, and the matching that knows the truth: for tests of what is around it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from splinebba_cli.core.matching.match import with_labels
from splinebba_cli.core.matching.matches import BuiltCurve, GateStep, Matches, MatchResult, Reason, WeakPart
from splinebba_cli.core.network import Network, Points
from splinebba_cli.core.result import Problem
from splinebba_cli.project.loading import LoadedProject
from splinebba_cli.simulation.catalogue import write
from splinebba_cli.simulation.truth_file import read_truth

NO_POINTS = Points((), (), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3)))
LOST = "3"  # an image in which nothing is matched


def street(folder: Path, extra: str = "") -> Path:
    """The project file of a street, without what `match` needs no search for; `extra` is added to it."""
    project = write("edge-chains", folder, 1)
    text = project.read_text(encoding="utf-8")
    project.write_text(f"{text}\n{extra}", encoding="utf-8", newline="\n")
    return project


def true_labels(project: Path, network: Network) -> np.ndarray:
    """The curve of every unlabelled point by truth.json, (n,); -1 where its spline is not in the project."""
    truth = json.loads(project.with_name("truth.json").read_text(encoding="utf-8"))
    number = {curve.id: k for k, curve in enumerate(network.curves)}
    of_chain = {
        f"{each['image']}/{each['chain']}": number.get(each["spline"], -1) for each in truth["chains"]
    }
    curve = np.array([of_chain[id] for id in network.unlabelled.chain_ids], dtype=np.int64)
    return curve[network.unlabelled.chain]


def known_matching(loaded: LoadedProject, lost: str = LOST) -> MatchResult:
    """What a perfect matching gives, but for one image in which it finds nothing."""
    network = loaded.network
    points, images = network.unlabelled, network.images
    curve = true_labels(loaded.path, network)
    if lost:
        curve = np.where(points.image == images.ids.index(lost), -1, curve)
    rest = np.where(points.chain % 2 == 0, int(Reason.FAR), int(Reason.CHAIN))
    reason = np.where(curve >= 0, int(Reason.MATCHED), rest)
    count = np.arange(len(points))
    distance = np.where(curve >= 0, 0.1 + 0.01 * (count % 100), np.inf)
    runner_up = np.where((curve >= 0) & (count % 3 == 0), 2.0, np.inf)
    location = np.full(len(points), np.nan)
    truth = read_truth(loaded.path.with_name("truth.json"), replace(network, points=NO_POINTS))
    turned = replace(images, rotation=truth.rotation, position=truth.eop[:, 3:])
    labelled = replace(with_labels(network, curve, location), images=turned)
    return MatchResult(
        network=labelled,
        given=network,
        matches=Matches(curve, location, distance, runner_up, reason),
        oriented=np.ones(len(images.ids), dtype=bool),
        eop_dispersion=np.full((len(images.ids), 6, 6), np.nan),
        history=(
            GateStep("known curves", 1, 30.0, 900, 900, float("nan"), 0.8, 0.01),
            GateStep("known curves", 2, 2.5, int((curve >= 0).sum()), 100, 0.98, 0.01, 1e-4),
        ),
        built=(
            BuiltCurve(
                7, np.array([1, 3]), np.array([0, 1, 2]), 80.0, 60.0, (WeakPart(1.0, 2.0, "epipolar", 0.2),)
            ),
        ),
        problems=(Problem("SBB534", "info", "a remark", "image `1`"),),
    )
