"""What all tests have in common."""

from __future__ import annotations

import signal


def pytest_configure() -> None:
    """Ctrl-C means something to the programs that tests start, in jobs in the background (``&``, CI) too.

    There it is ignored, which a program inherits from the one that starts it.
    """
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
