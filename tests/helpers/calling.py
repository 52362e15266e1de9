"""The command line, called in this process."""

from __future__ import annotations

from rmfs_commands.cli.main import main


def exit_code(*arguments: str) -> int:
    """Run ``rmfs`` and return how it exits."""
    try:
        main(list(arguments))
    except SystemExit as stop:
        return int(stop.code or 0)
    return 0
