"""Ctrl-C while a command runs."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

CALL = (sys.executable, "-c", "from rmfs_commands.cli.start import main; main()")
DROPPING = """
import os, signal, time
from rmfs_commands.cli.interrupts import hear_interrupts
hear_interrupts()

class Finalized:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.1)

try:
    thing = Finalized()
    del thing
    time.sleep(20)
    print("lost")
except KeyboardInterrupt:
    print("heard")
"""


def test_an_interrupt_in_a_finalizer_is_heard() -> None:
    """Python would drop it there, with a traceback."""
    done = subprocess.run([sys.executable, "-c", DROPPING], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("heard\n", "")


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("arguments", [("run", "examples/small", "--out", "out"), ("compare", "small-rules", "--json")])
def test_an_interrupt_at_any_moment(arguments: tuple[str, ...], seed: int, tmp_path: Path) -> None:
    """Once or twice, to every process as a terminal sends it: 130 and one sentence, or done in time."""
    moment = random.Random(f"{arguments} {seed}")
    pipe = subprocess.PIPE
    with subprocess.Popen(
        [*CALL, *arguments], stdout=pipe, stderr=pipe, text=True, cwd=tmp_path, start_new_session=True
    ) as process:
        time.sleep(0.4 + 2 * moment.random() ** 2)
        os.killpg(process.pid, signal.SIGINT)
        if seed % 2:
            time.sleep(moment.choice((0.001, 0.01, 0.1)))
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGINT)
        _, err = process.communicate(timeout=60)
    assert process.returncode in (0, 130), err
    assert "Traceback" not in err
    assert "Exception ignored" not in err
    assert err.count("Interrupted.") == (process.returncode == 130)
