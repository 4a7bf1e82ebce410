"""Compiled kernels: used where numba is installed and the work is worth loading them.

A file ``name_compiled.py`` holds kernels that give the results of plain numpy in ``name.py`` beside it, to rounding.
It imports numba, so that nobody imports it but by :func:`compiled_kernels`.  The environment variable
SPLINEBBA_SPEED decides: ``auto`` (the default), ``always`` and ``never``.
"""

from __future__ import annotations

import os
from importlib import import_module
from importlib.util import find_spec
from typing import Any, Literal, cast

Mode = Literal["auto", "always", "never"]

VARIABLE = "SPLINEBBA_SPEED"


def mode() -> Mode:
    """What the environment asks for; anything unknown is ``auto``."""
    asked = os.environ.get(VARIABLE, "auto").lower()
    return cast(Mode, asked) if asked in ("always", "never") else "auto"


def compiled_kernels(module: str, *, worthwhile: bool) -> Any:
    """The module of compiled kernels, or None where plain numpy is to be used.

    Parameters
    ----------
    module : full name of the module, ``splinebba_cli.core...._compiled``
    worthwhile : whether the saving exceeds the time to import numba and to load the kernels from disk
    """
    wanted = mode()
    if wanted == "never" or (wanted == "auto" and not worthwhile) or find_spec("numba") is None:
        return None
    return import_module(module)
