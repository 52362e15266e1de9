"""The first moments of ``rmfs``, in which it is imported: Ctrl-C then is an interrupt like any other."""

from __future__ import annotations

import os
import sys


def main() -> None:
    """Import the command line and call it."""
    try:
        from rmfs_commands.cli.interrupts import hear_interrupts

        hear_interrupts()
        from rmfs_commands.cli.main import main as call
    except KeyboardInterrupt:
        os.write(2, b"Interrupted.\n")
        sys.exit(130)
    call()
