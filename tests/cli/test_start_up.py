"""Start-up is light; the package shows its functions without importing them."""

from __future__ import annotations

import subprocess
import sys

import pytest

HEAVY = ("numpy", "scipy", "yaml", "rich.console", "matplotlib", "jinja2", "pyarrow")


def run(code: str) -> str:
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout


@pytest.mark.parametrize(
    "arguments",
    [
        ["--help"],
        ["adjust", "--help"],
        ["match", "--help"],
        ["batch", "--help"],
        ["simulate", "--help"],
        ["--version"],
        ["explain", "SBB301"],
        ["init", "--list"],
    ],
)
def test_help_imports_nothing_heavy(arguments: list[str]) -> None:
    code = (
        "import sys\n"
        "from splinebba_cli.commands.app import app\n"
        f"try: app({arguments!r})\n"
        "except SystemExit: pass\n"
        f"print('LOADED', [m for m in {HEAVY!r} if m in sys.modules])\n"
    )
    assert run(code).strip().splitlines()[-1] == "LOADED []"


def test_public_functions_are_loaded_at_first_use() -> None:
    code = (
        "import sys, splinebba_cli\n"
        "assert 'numpy' not in sys.modules\n"
        "assert {'load_project', 'adjust', 'match', 'simulate'} <= set(dir(splinebba_cli))\n"
        "print(*(getattr(splinebba_cli, n).__name__ for n in ('load_project', 'adjust', 'match', 'simulate')))\n"
    )
    assert run(code).strip() == "load_project adjust match simulate"


def test_unknown_name_of_the_package() -> None:
    import splinebba_cli

    with pytest.raises(AttributeError, match="nothing_of_the_kind"):
        _ = splinebba_cli.nothing_of_the_kind


def test_adjusting_needs_no_matplotlib() -> None:
    code = (
        "import sys\n"
        "import splinebba_cli.core.adjustment, splinebba_cli.project.loading\n"
        "import splinebba_cli.output.result_folder\n"
        "print([m for m in ('matplotlib', 'jinja2', 'pyarrow') if m in sys.modules])\n"
    )
    assert run(code).strip() == "[]"
