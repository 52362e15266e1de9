"""The first moments of ``rmfs``, in which it is imported: Ctrl-C then is an interrupt like any other."""

from __future__ import annotations

import gc
import os
import sys

YOUNG = 50_000
"""Objects made between two collections of cycles; Python's 700 are far too few where a warehouse is made of objects."""


def main() -> None:
    """Import the command line and call it."""
    gc.set_threshold(YOUNG, 20, 50)
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # numpy starts them when it is imported: longer than they save
    try:
        from rmfs_commands.cli.interrupts import hear_interrupts

        hear_interrupts()
        from rmfs_core.jit import decide_later

        decide_later()
        from rmfs_commands.cli.main import main as call
    except KeyboardInterrupt:
        os.write(2, b"Interrupted.\n")
        sys.exit(130)
    call()
