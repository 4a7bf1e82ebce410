"""The program: ``splinebba`` and ``python -m splinebba_cli``.

Little is imported before signals are watched for: Ctrl-C ends with a message from the first moment on.
"""

import gc
import sys

from splinebba_cli.interruption import InterruptedRunError, interruption_text, watch_for_interruption

COLLECT_AFTER = 100_000  # new objects


def main() -> None:
    """Entry point of the console script.

    The collector of cyclic garbage looks rarely: a run makes many objects that it keeps, and hardly any cycles.  At the
    end it does not look at all of them once more.
    """
    try:
        watch_for_interruption()
        gc.set_threshold(COLLECT_AFTER, 20, 50)
        from splinebba_cli.commands.app import app
        from splinebba_cli.commands.streams import prepare_streams

        prepare_streams()
        app(prog_name="splinebba")
    except InterruptedRunError as error:
        print(interruption_text(error), file=sys.stderr)
        sys.exit(error.exit_code)
    finally:
        gc.freeze()


if __name__ == "__main__":
    main()
