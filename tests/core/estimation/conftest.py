"""Both ways of computing: plain numpy and compiled kernels."""

from __future__ import annotations

import pytest

from splinebba_cli.core import speed


@pytest.fixture(params=["never", "always"])
def speed_mode(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Plain numpy, then compiled kernels; the second needs numba."""
    if request.param == "always":
        pytest.importorskip("numba")
    monkeypatch.setenv(speed.VARIABLE, request.param)
    return request.param
