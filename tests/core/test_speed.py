import numpy as np
import pytest

from splinebba_cli.core import speed, threads

MODULE = "splinebba_cli.core.threads"  # any module: what counts is whether it is handed out


@pytest.mark.parametrize(
    ("asked", "worthwhile", "given"),
    [
        ("never", True, False),
        ("always", False, True),
        ("auto", True, True),
        ("auto", False, False),
        ("nonsense", True, True),
        ("nonsense", False, False),
    ],
)
def test_who_gets_compiled_kernels(
    monkeypatch: pytest.MonkeyPatch, asked: str, worthwhile: bool, given: bool
) -> None:
    pytest.importorskip("numba")
    monkeypatch.setenv(speed.VARIABLE, asked)
    assert (speed.compiled_kernels(MODULE, worthwhile=worthwhile) is not None) == given


def test_without_numba_there_are_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(speed.VARIABLE, "always")
    monkeypatch.setattr(speed, "find_spec", lambda _: None)
    assert speed.compiled_kernels(MODULE, worthwhile=True) is None


@pytest.mark.parametrize("count", ["1", "2", "3"])
def test_parts_come_back_in_their_order(monkeypatch: pytest.MonkeyPatch, count: str) -> None:
    monkeypatch.setenv(threads.VARIABLE, count)
    parts = [np.full(5, k) for k in range(20)]
    assert threads.in_threads(lambda part: int(part.sum()), parts) == [5 * k for k in range(20)]


def test_an_error_of_a_part_is_raised(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(threads.VARIABLE, "2")

    def fail(part: int) -> int:
        if part == 1:
            raise ValueError("part 1")
        return part

    with pytest.raises(ValueError, match="part 1"):
        threads.in_threads(fail, [0, 1, 2])
