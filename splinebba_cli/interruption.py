"""Ctrl-C and SIGTERM: the run ends in an orderly way, with a short message and exit code 128 + number of the signal.

The signal becomes an exception, so that every ``finally`` takes away what is half done.  While a few files take their
places, the signal waits (:func:`uninterrupted`).  A third signal ends the program at once; what it then leaves, the
next run takes away.  Standard library only: this is the first thing that the program imports.
"""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

_SHELL = 128  # what shells add to the number of a signal


class InterruptedRunError(KeyboardInterrupt):
    """Somebody wants the run to end.

    Parameters
    ----------
    number : int
        Of the signal.
    """

    code = "SBB901"

    def __init__(self, number: int = signal.SIGINT) -> None:
        super().__init__()
        self.number = number

    @property
    def exit_code(self) -> int:
        """130 after Ctrl-C, 143 after SIGTERM."""
        return _SHELL + self.number


def interruption_of(error: KeyboardInterrupt) -> InterruptedRunError:
    """The interruption as one of ours: libraries raise plain ones."""
    return error if isinstance(error, InterruptedRunError) else InterruptedRunError()


def interruption_text(error: InterruptedRunError) -> str:
    """One line for the console."""
    by = "Ctrl-C" if error.number == signal.SIGINT else signal.Signals(error.number).name
    return f"interrupted by {by}; files are as they were, or complete"


def watch_for_interruption() -> None:
    """From now on SIGINT and SIGTERM raise :class:`InterruptedRunError`, unless the caller has them ignored (``&``)."""
    for number in (signal.SIGINT, signal.SIGTERM):
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _interrupt)


def _interrupt(number: int, frame: FrameType | None) -> None:
    """The first signal asks for an orderly end."""
    for each in (signal.SIGINT, signal.SIGTERM):
        signal.signal(each, _leave_time)
    raise InterruptedRunError(number)


def _leave_time(number: int, frame: FrameType | None) -> None:
    """The second one does not disturb it: CI systems send both.  The third one ends the program at once."""
    for each in (signal.SIGINT, signal.SIGTERM):
        signal.signal(each, signal.SIG_DFL)


@contextmanager
def uninterrupted() -> Iterator[None]:
    """A few steps that belong together: a signal that comes meanwhile is delivered after them."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    waiting: list[int] = []
    before: dict[int, Any] = {}
    for each in (signal.SIGINT, signal.SIGTERM):
        before[each] = signal.signal(each, lambda got, _: waiting.append(got))
    try:
        yield
    finally:
        for number, handler in before.items():
            if handler is not None:  # set by something else than Python: not to be had back
                signal.signal(number, handler)
        for number in waiting[:1]:
            signal.raise_signal(number)
