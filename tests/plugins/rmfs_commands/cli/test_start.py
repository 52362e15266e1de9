"""The first moments of the command line."""

from __future__ import annotations

import subprocess
import sys

FIRST = """
import sys
class Interrupting:
    def find_spec(self, name, path, target=None):
        if name == "rmfs_commands.cli.main":
            raise KeyboardInterrupt
from rmfs_commands.cli.start import main
sys.meta_path.insert(0, Interrupting())
main()
"""


def test_an_interrupt_while_it_is_imported() -> None:
    """One sentence, as later."""
    done = subprocess.run([sys.executable, "-c", FIRST], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "Interrupted.\n")


def test_it_calls_the_command_line() -> None:
    """With the words of the process."""
    call = [sys.executable, "-c", "from rmfs_commands.cli.start import main; main()", "--version"]
    assert subprocess.run(call, capture_output=True, text=True, check=True).stdout.startswith("-c, version ")
