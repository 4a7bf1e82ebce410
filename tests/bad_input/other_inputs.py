"""Other things that a user may give: points for `fit`, result folders for `report` and `compare`."""

from __future__ import annotations

import json
import random
import re
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

from typer.testing import CliRunner

from splinebba_cli.commands.app import app
from splinebba_cli.errors import ExitCode
from tests.bad_input.cases import BASES
from tests.bad_input.mutations import ODD_VALUES, OF_BYTES, Files

BUG = re.compile(r"SBB970\].*")
LINES = {
    "points.csv": b"spline,x,y,z\n"
    + b"".join(b"a,%d,%d,%d\n" % (10 * k, k * k, 5 + k % 3) for k in range(12)),
    "points.geojson": json.dumps(
        {
            "type": "FeatureCollection",
            "features": [
                {
                    "type": "Feature",
                    "properties": {"id": f"a{n}"},
                    "geometry": {
                        "type": kind,
                        "coordinates": points if kind == "LineString" else [[*points, points[0]]],
                    },
                }
                for n, (kind, points) in enumerate(
                    (kind, [[1000.0 * k, 50.0 * k * k, 5 + k % 3] for k in range(9)])
                    for kind in ("LineString", "Polygon")
                )
            ],
        }
    ).encode(),
}


class CommandBugError(AssertionError):
    """A command ended with an unexpected error."""


def case_of_points(seed: int, number: int, folder: Path) -> str:
    """`fit` of broken points."""
    chance = random.Random(f"points {seed} {number}")
    name = chance.choice(sorted(LINES))
    content = LINES[name]
    if name.endswith("json") and chance.random() < 0.5:
        content = changed_json(content, chance)
    else:
        for _ in range(chance.randint(1, 3)):
            content = chance.choice(OF_BYTES)(content, chance)
    (folder / name).write_bytes(content)
    return ended("fit", folder / name, "--threshold-m", "0.5", "-o", folder / "fitted.yaml")


def case_of_results(seed: int, number: int, folder: Path) -> str:
    """`report` and `compare` of a broken result folder."""
    chance = random.Random(f"results {seed} {number}")
    files = dict(result_files())
    for _ in range(chance.randint(1, 2)):
        name = "result.json" if chance.random() < 0.5 else chance.choice(sorted(files))
        if name == "result.json" and chance.random() < 0.7:
            files[name] = changed_json(files[name], chance)
        elif chance.random() < 0.1:
            del files[name]
        else:
            files[name] = chance.choice(OF_BYTES)(files[name], chance)
    for name, content in files.items():
        (folder / name).write_bytes(content)
    whole = folder / "whole"
    whole.mkdir()
    for name, content in result_files().items():
        (whole / name).write_bytes(content)
    said = ended("report", folder, "--format", chance.choice(("text", "html")), "-o", folder / "out")
    other = ended("compare", whole, folder, "--format", chance.choice(("text", "json")))
    return f"report {said}, compare {other}"


@cache
def result_files() -> Files:
    """A result folder as `adjust` writes it."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "results"
        ended("adjust", BASES / "everything" / "project.yaml", "-o", out, "--no-html", "-q")
        return {path.name: path.read_bytes() for path in sorted(out.iterdir())}


def ended(*arguments: object) -> str:
    """Exit code of a command in words; CommandBugError for an unexpected error."""
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    if result.exit_code == ExitCode.BUG or (
        result.exception and not isinstance(result.exception, SystemExit)
    ):
        said = BUG.search(result.output)
        raise CommandBugError(f"{arguments[0]}: {said[0] if said else result.exception!r}")
    codes = re.findall(r"^error\[(SBB\d{3})\]", result.output, re.MULTILINE)
    return f"{result.exit_code} {codes[0] if codes else ''}".strip()


def changed_json(content: bytes, chance: random.Random) -> bytes:
    """Change, remove or add one value of JSON data."""
    try:
        data = json.loads(content)
    except ValueError:
        return content
    owner: Any = data
    for _ in range(chance.randint(0, 5)):
        children = list(owner.values() if isinstance(owner, dict) else owner)
        deeper = [child for child in children if isinstance(child, (dict, list)) and child]
        if not deeper:
            break
        owner = chance.choice(deeper)
    key = chance.choice(list(owner)) if isinstance(owner, dict) else chance.randrange(len(owner))
    if chance.random() < 0.3:
        del owner[key]
    else:
        owner[key] = chance.choice(ODD_VALUES)
    return json.dumps(data).encode()
