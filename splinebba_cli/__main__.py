"""``python -m splinebba_cli``."""

from splinebba_cli.commands.app import main

if __name__ == "__main__":
    main()
