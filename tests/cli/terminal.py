"""A command in a pseudo-terminal, and what a person sees there in the end."""

from __future__ import annotations

import os
import re
import select
import signal
import struct
import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass

CONTROL = re.compile(r"\x1b\[([?\d;]*)([A-Za-z])")
LONGEST_S = 120.0


@dataclass(frozen=True)
class Session:
    """What came out of the terminal, and how the command ended."""

    raw: str
    code: int

    @property
    def screen(self) -> list[str]:
        """Lines as they stand in the end."""
        return screen_of(self.raw)

    @property
    def coloured(self) -> bool:
        """Whether anything was printed in a colour or in bold."""
        return any(end == "m" for _, end in CONTROL.findall(self.raw))


def screen_of(raw: str) -> list[str]:
    """Carriage returns, erased lines and movements upwards carried out; colours left out."""
    lines, row, column, at = [""], 0, 0, 0
    while at < len(raw):
        found = CONTROL.match(raw, at)
        if found:
            if found[2] == "K":
                lines[row] = "" if found[1] == "2" else lines[row][:column]
            elif found[2] == "A":
                row = max(0, row - int(found[1] or 1))
            at = found.end()
            continue
        letter, at = raw[at], at + 1
        if letter == "\r":
            column = 0
        elif letter == "\n":
            row += 1
            lines += [""] * (row + 1 - len(lines))
        else:
            lines[row] = lines[row][:column].ljust(column) + letter + lines[row][column + 1 :]
            column += 1
    return [line.rstrip() for line in lines]


def run_in_terminal(
    arguments: list[str],
    *,
    columns: int = 100,
    environment: Mapping[str, str | None] | None = None,
    interrupt_at: str = "",
    number: int = signal.SIGINT,
) -> Session:
    """Run ``splinebba``.

    Parameters
    ----------
    interrupt_at : when this has been printed, Ctrl-C is typed, or the signal `number` sent where it is another one
    environment : changes of the environment; None removes a variable
    """
    import fcntl
    import pty
    import termios

    process, terminal = pty.fork()
    if process == 0:
        usual = {"TERM": "xterm-256color", "NO_COLOR": None, "FORCE_COLOR": None, "COLUMNS": None}
        wanted = {**os.environ, **usual, **(environment or {})}
        kept = {name: value for name, value in wanted.items() if value is not None}
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # it may be ignored where tests run in the background
        os.execve(sys.executable, [sys.executable, "-m", "splinebba_cli", *arguments], kept)
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 50, columns, 0, 0))
    raw, waiting, end = b"", bool(interrupt_at), time.monotonic() + LONGEST_S
    while time.monotonic() < end:
        if not select.select([terminal], [], [], 0.2)[0]:
            continue
        try:
            piece = os.read(terminal, 65536)
        except OSError:  # the other end is closed
            break
        if not piece:
            break
        raw += piece
        if waiting and interrupt_at in raw.decode(errors="replace"):
            waiting = False
            if number == signal.SIGINT:
                os.write(terminal, b"\x03")
            else:
                os.kill(process, number)
    else:
        os.kill(process, signal.SIGKILL)
    os.close(terminal)
    return Session(raw.decode(), os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]))
