"""Doing cases: in a process of its own, used for many, with a limit of time and of memory for each."""

from __future__ import annotations

import contextlib
import faulthandler
import io
import os
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Iterator, Sequence
from multiprocessing.connection import Connection, Pipe
from pathlib import Path
from typing import Any

from attrs import frozen

from fuzzing.surfaces import FOLDER, LOOP, Case

MOST_CPU_S, MOST_WALL_S, MOST_MEMORY = 10, 60, 2 * 1024**3
SHOWS_WHERE = "RMFS_TRACEBACK"
BROKEN = 99
"""Exit code of a worker that failed by itself."""

Call = Callable[[list[str]], None]


@frozen
class Outcome:
    """Outcome of a case.

    Parameters
    ----------
    code
        Exit code, or None where the process ended, or had to be ended.
    output, errors
        Text written to each.
    trace
        The traceback of an error that no one expected; where the process ended, what it did then.
    left
        Files that are there afterwards and were not before.
    cpu_s
        CPU time.
    ended_by
        The signal that ended the process.
    """

    code: int | None
    output: str = ""
    errors: str = ""
    trace: str = ""
    left: tuple[str, ...] = ()
    cpu_s: float = 0.0
    ended_by: str = ""


def outcomes(numbers: Sequence[int], make: Callable[[int], Case], call: Call) -> Iterator[tuple[int, Case, Outcome]]:
    """Do cases one after another; yield number, case and outcome of each. One that ends the process ends no other.

    A case that takes too long is done once more: it may have compiled what is kept from then on.
    """
    left, again = [*numbers], -1
    with tempfile.TemporaryDirectory(prefix="rmfs-fuzz-") as name:
        while left:
            for outcome in _worker([*left], make, call, Path(name)):
                if outcome.ended_by == "SIGXCPU" and left[0] != again:
                    again = left[0]
                    break
                number = left.pop(0)
                yield number, make(number), outcome


def _worker(numbers: Sequence[int], make: Callable[[int], Case], call: Call, folder: Path) -> Iterator[Outcome]:
    """Yield the outcomes of as many cases as one process does."""
    reading, writing = Pipe(duplex=False)
    sys.stdout.flush()
    sys.stderr.flush()
    process = os.fork()
    if process == 0:
        try:
            reading.close()
            os.setsid()
            _work(numbers, make, call, folder, writing)
        except BaseException:
            os.write(2, traceback.format_exc().encode())
            os._exit(BROKEN)
        os._exit(0)
    writing.close()
    done = 0
    silent = False
    try:
        while done < len(numbers):
            if not reading.poll(MOST_WALL_S):
                silent = True
                os.kill(process, signal.SIGXCPU)  # it writes down where it is, and ends
            try:
                outcome = reading.recv()
            except EOFError:
                break
            done += 1
            yield outcome
    finally:
        reading.close()
        with contextlib.suppress(OSError):
            os.killpg(process, signal.SIGKILL)
        _, status = os.waitpid(process, 0)
    if os.WIFEXITED(status) and os.WEXITSTATUS(status) == BROKEN:
        raise RuntimeError("the fuzzer itself is broken; see above")
    if done < len(numbers):
        number = os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0
        how = "no answer" if silent else signal.Signals(number).name if number else "os._exit"
        yield Outcome(None, trace=(folder / "where").read_text("utf-8", "replace"), ended_by=how)


def _work(numbers: Sequence[int], make: Callable[[int], Case], call: Call, folder: Path, told: Connection) -> None:
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    memory = pages * resource.getpagesize() + MOST_MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (memory, resource.RLIM_INFINITY))
    os.environ["COLUMNS"] = "80"
    with (folder / "where").open("w+b") as where:
        faulthandler.enable(where, all_threads=False)
        faulthandler.register(signal.SIGXCPU, where, all_threads=False, chain=True)
        for number in numbers:
            where.truncate(0)
            told.send(_done(make(number), call, folder))


def _done(case: Case, call: Call, folder: Path) -> Outcome:
    began = time.process_time()
    resource.setrlimit(resource.RLIMIT_CPU, (int(began) + MOST_CPU_S + 1, resource.RLIM_INFINITY))
    outcome = _called(case, call, folder)
    cpu_s = time.process_time() - began
    if not outcome.trace and (SHOWS_WHERE in outcome.errors or " raised " in outcome.errors):
        os.environ[SHOWS_WHERE] = "1"
        shown = _called(case, call, folder).errors
        del os.environ[SHOWS_WHERE]
        outcome = Outcome(outcome.code, outcome.output, outcome.errors, shown, outcome.left)
    return Outcome(outcome.code, outcome.output, outcome.errors, outcome.trace, outcome.left, cpu_s)


def _called(case: Case, call: Call, folder: Path) -> Outcome:
    """Call once, in a folder with the case's files alone."""
    work = folder / "work"
    current = work / "of" / "case"
    shutil.rmtree(work, ignore_errors=True)  # of a worker that was ended
    current.mkdir(parents=True)
    write_files(case, current)
    os.chdir(current)
    code, trace = 0, ""
    with _captured(folder) as written, warnings.catch_warnings():
        warnings.simplefilter("always")
        try:
            call([*case.arguments])
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else 1 if end.code else 0
        except BaseException:
            code, trace = 1, traceback.format_exc()
    os.chdir(folder)
    left = sorted(path.relative_to(current).as_posix() for path in current.rglob("*") if not path.is_dir())
    shutil.rmtree(work)
    return Outcome(code, written["out"], written["err"], trace, tuple(name for name in left if name not in case.files))


def write_files(case: Case, folder: Path) -> None:
    """Write a case's files."""
    for name, data in case.files.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        if data == FOLDER:
            file.mkdir()
        elif data == LOOP:
            file.symlink_to(file.name)
        else:
            file.write_bytes(data)


@contextlib.contextmanager
def _captured(folder: Path) -> Iterator[dict[str, str]]:
    """Lead standard output and standard error to files, as a shell would; yield what comes to be in them."""
    written: dict[str, str] = {}
    before = sys.stdout, sys.stderr
    streams: dict[str, io.TextIOWrapper[Any]] = {}
    for descriptor, (name, errors) in enumerate((("out", "strict"), ("err", "backslashreplace")), 1):
        with (folder / name).open("wb") as file:
            os.dup2(file.fileno(), descriptor)
        streams[name] = io.TextIOWrapper(io.FileIO(descriptor, "w", closefd=False), "utf-8", errors)
    sys.stdout, sys.stderr = streams["out"], streams["err"]
    try:
        yield written
    finally:
        sys.stdout, sys.stderr = before
        for name, stream in streams.items():
            with contextlib.suppress(OSError, ValueError):
                stream.flush()
            written[name] = (folder / name).read_bytes().decode("utf-8", "backslashreplace")
