"""The first moments of ``rmfs``, in which it is imported: Ctrl-C then is an interrupt like any other."""

from __future__ import annotations

import gc
import os
import sys

YOUNG = 50_000
"""Objects made between two collections of cycles; Python's 700 are far too few where a warehouse is made of objects."""
BLAS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Variables that numpy's linear algebra takes its number of threads from. It starts them when it is imported, which
takes longer than they would save: no command multiplies large matrices. One thread, unless the environment says more,
also adds up in the same order on every machine."""


def main() -> None:
    """Import the command line and call it."""
    gc.set_threshold(YOUNG, 20, 50)
    for name in BLAS:
        os.environ.setdefault(name, "1")
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
