"""Machine code from numba's cache, loaded without what numba compiles with."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from textwrap import dedent

from numba.core import caching, environment

from rmfs_commands.cli.loading import loading_alone


def test_what_is_cached_loads_without_what_compiles(tmp_path: Path) -> None:
    """Machine code runs, and raises, without numba's library; code that needs more of it, or is new, gets it."""
    module = """
        from heapq import heappop, heappush
        import numba, numpy as np
        @numba.njit(cache=True)
        def least(n):
            if n < 1:
                raise ValueError("too few")
            numbers, queue = np.empty(n, np.int64), [(2, 0)]
            numbers.fill(n)
            heappush(queue, (1, 0))
            return (numbers * heappop(queue)[0]).min()
        @numba.njit(cache=True)
        def known(word):
            return hash(word) != -1
    """
    program = """
        import sys
        import numpy as np
        from rmfs_commands.cli.loading import loading_alone
        from searching import known, least
        library, problem = "numba.np.arraymath", ""
        with loading_alone():
            found, alone = least(3), library not in sys.modules
            try:
                least(0)
            except ValueError as error:
                problem = str(error)
            print(found, problem, alone, known("pod"), library in sys.modules)
            print(least(np.int8(3)) if "new" in sys.argv else "")
    """
    (tmp_path / "searching.py").write_text(dedent(module), encoding="utf-8")
    variables = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(tmp_path)}

    def run(*arguments: str) -> str:
        command = [sys.executable, "-c", dedent(program), *arguments]
        return subprocess.run(command, env=variables, capture_output=True, text=True, check=True).stdout.strip()

    assert run() == "3 too few False True True"
    assert run() == "3 too few True True True"
    assert run("new") == "3 too few True True True\n3"


def test_a_run_loads_no_library_that_compiles(tmp_path: Path) -> None:
    """What searches of a small run were compiled with needs no more than its name; the first run may compile."""
    program = """
        import sys
        from rmfs_commands.cli.main import main
        main(["run", "examples/small", "--quiet", "--out", sys.argv[1]])
        print("numba.np.arraymath" in sys.modules)
    """
    command = [sys.executable, "-c", dedent(program), str(tmp_path / "out")]
    printed = [subprocess.run(command, capture_output=True, text=True, check=True).stdout for _ in range(2)]
    assert printed[1] == "False\n"


def test_nothing_stays_changed() -> None:
    """Once the block is left numba loads as before, also where one such block is within another."""
    import rmfs_core.world.travel_search  # noqa: F401

    before = caching.Cache.load_overload, environment.importlib
    with loading_alone(), loading_alone():
        assert (caching.Cache.load_overload, environment.importlib) != before
    assert (caching.Cache.load_overload, environment.importlib) == before
