"""Load the decision service as a warehouse would, and far beyond: rate, time to answer, memory.

``python tools/load.py [--requests N] [--rule RULE] [--state STATE.json]`` starts `rmfs serve` on one core and asks it
by hey (https://github.com/rakyll/hey, Debian's package `hey`): `RATE` requests a second for `PACED_S` seconds, of which
99 % have to be answered within `MOST_P99_S`; then N requests as fast as they are answered, which have to be at least
`RATE` a second, while the memory of the service and of the rules' process grows by no more than `MOST_MB`. Exit code 1
when something is not so.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.request import urlopen

from attrs import frozen

from rmfs_commands.serve.service import SMALL

RATE, CLIENTS = 200, 4
PACED_S = 20
MOST_P99_S = 0.02
MOST_MB = 5.0
"""Growth that is allowed from a tenth of the requests to all of them."""
START = "from rmfs_commands.cli.main import main; main()"


@frozen
class Measured:
    """Measurements of hey.

    Parameters
    ----------
    rate
        Answers a second.
    median_s, p99_s
        Half and 99 of 100 were there within these times.
    statuses
        Answers by status.
    """

    rate: float
    median_s: float
    p99_s: float
    statuses: dict[str, int]

    @classmethod
    def of(cls, text: str) -> Measured:
        """Read what hey prints."""
        rate = re.search(r"Requests/sec:\s+([\d.]+)", text)
        shares = dict(re.findall(r"(\d+)%+ in ([\d.]+) secs", text))
        statuses = {status: int(number) for status, number in re.findall(r"\[(\d+)\]\s+(\d+) responses", text)}
        assert rate is not None, text
        if "Error distribution" in text:
            statuses["none"] = 1
        return cls(float(rate[1]), float(shares["50"]), float(shares["99"]), statuses)

    def __str__(self) -> str:
        times = f"half within {1000 * self.median_s:.1f} ms, 99 % within {1000 * self.p99_s:.1f} ms"
        return f"{self.rate:,.0f} answers a second, {times}, by status {self.statuses}"


@contextmanager
def service(rule: str, core: int) -> Iterator[str]:
    """Yield the address of a service whose processes run on one core."""
    command = (sys.executable, "-c", START, "serve", "--rule", rule, "--port", "0")
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {core})  # what is started inherits it
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    os.sched_setaffinity(0, before)
    assert process.stdout is not None
    try:
        yield process.stdout.readline().partition(" at ")[2].partition(";")[0]
    finally:
        process.terminate()
        process.wait()


def memory_mb(address: str) -> tuple[float, float]:
    """Return the resident memory of the service and of the rules' process, as its metrics have it."""
    with urlopen(f"{address}/metrics") as answer:
        text = answer.read().decode()
    found = dict(re.findall(r"^(rmfs_rules_)?process_resident_memory_bytes (\S+)$", text, re.MULTILINE))
    return float(found[""]) / 1e6, float(found["rmfs_rules_"]) / 1e6


def hey(address: str, state: Path, *options: str) -> Measured:
    """Send requests."""
    command = ("hey", *options, "-c", str(CLIENTS), "-m", "POST", "-T", "application/json", "-D", str(state))
    done = subprocess.run((*command, f"{address}/decide"), capture_output=True, text=True, check=True)
    return Measured.of(done.stdout)


def main() -> int:
    """Do it; return the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n\n")[0])
    parser.add_argument("--requests", type=int, default=100_000)
    parser.add_argument("--rule", default="first-come")
    parser.add_argument("--state", type=Path, metavar="STATE.json", help="what is asked; left out: a small state")
    given = parser.parse_args()
    if shutil.which("hey") is None:
        print("Error: hey is not installed; expected `apt-get install hey`.", file=sys.stderr)
        return 2
    content: Any = SMALL if given.state is None else json.loads(given.state.read_text(encoding="utf-8"))
    core = min(os.sched_getaffinity(0))
    with tempfile.TemporaryDirectory() as folder, service(given.rule, core) as address:
        state = Path(folder) / "state.json"
        state.write_text(json.dumps(content), encoding="utf-8")
        paced = hey(address, state, "-z", f"{PACED_S}s", "-q", str(RATE // CLIENTS))
        print(f"{RATE} requests a second: {paced}", flush=True)
        tenth = hey(address, state, "-n", str(given.requests // 10))
        before = memory_mb(address)
        rest = hey(address, state, "-n", str(given.requests - given.requests // 10))
        after = memory_mb(address)
    print(f"As many as are answered: {tenth}", flush=True)
    print(f"And on: {rest}", flush=True)
    grown = [late - early for early, late in zip(before, after, strict=True)]
    shown = [f"{early:.1f} to {late:.1f} MB" for early, late in zip(before, after, strict=True)]
    print(
        f"Memory after {given.requests // 10:,} and {given.requests:,} requests: service {shown[0]}, rules {shown[1]}"
    )
    kept = {
        f"99 % within {1000 * MOST_P99_S:.0f} ms at {RATE} a second": paced.p99_s < MOST_P99_S,
        f"{RATE} answers a second": min(paced.rate, tenth.rate, rest.rate) > 0.98 * RATE,
        "every answer a decision": all(measured.statuses.keys() == {"200"} for measured in (paced, tenth, rest)),
        f"no growth by more than {MOST_MB:g} MB": max(grown) <= MOST_MB,
    }
    for what, holds in kept.items():
        print(f"{'ok' if holds else 'NOT SO'}: {what}")
    return int(not all(kept.values()))


if __name__ == "__main__":
    sys.exit(main())
