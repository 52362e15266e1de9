"""The standard streams belong to the command: what plugins print or read must not get between it and its caller."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout, suppress
from typing import IO, TYPE_CHECKING, BinaryIO, cast

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer as Buffer

_answers: list[BinaryIO] = []
_inputs: list[BinaryIO] = []


class _Call:
    """State of the output in this call of ``rmfs``."""

    kept = answered = False


def begin() -> None:
    """Begin a call of ``rmfs``: nothing has happened to its output yet."""
    _Call.kept = _Call.answered = False


def kept() -> bool:
    """Whether the output of this call was kept for answers, so that nothing else may reach it, not even at the end."""
    return _Call.kept


def answered() -> bool:
    """Whether this call has answered."""
    return _Call.answered


def open_all() -> None:
    """Open what the caller has closed (`>&-`), for nothing: the next file that is opened would get its number."""
    for descriptor in (0, 1, 2):
        try:
            os.fstat(descriptor)
        except OSError:
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)  # the lowest that is free
    if sys.stdout is None:
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: PTH123, SIM115 (open to the end)


@contextmanager
def kept_output() -> Iterator[BinaryIO]:
    """Keep the standard output for the command's own answers, and yield it.

    Whatever else is printed meanwhile, by a rule, a plugin or a library, in Python or below it, goes to standard error.
    """
    if _answers:
        yield _answers[-1]
        return
    printed = sys.stdout
    with suppress(OSError):
        printed.flush()
    own = os.dup(1)
    os.dup2(2, 1)
    # A caller within this process may have put something else instead of the output.
    stream: BinaryIO = os.fdopen(os.dup(own), "wb") if _is_file(printed, 1) else _bytes_to(printed)
    _answers.append(stream)
    try:
        with _errors() as errors, redirect_stdout(errors):
            yield stream
            stream.flush()
    finally:
        _answers.pop()
        if stream is not getattr(printed, "buffer", None):
            with suppress(OSError):
                stream.close()
            with suppress(OSError, ValueError):
                printed.flush()  # while what a plugin has written there on its own still goes to standard error
        os.dup2(own, 1)
        os.close(own)


def keep_output() -> BinaryIO:
    """Keep the standard output for the command that is called, until its end and that of the process; return it."""
    import click

    _Call.kept = True
    return click.get_current_context().with_resource(kept_output())


def leave_output() -> None:
    """Let whatever is printed from now on, at the end of the process, go to standard error."""
    os.dup2(2, 1)
    sys.stdout = sys.stderr


def answer(text: str) -> None:
    """Write a line to the command's output."""
    _Call.kept = _Call.answered = True
    if _answers:
        _answers[-1].write(f"{text}\n".encode("utf-8", "backslashreplace"))
        _answers[-1].flush()
    else:
        import click

        click.echo(text)


@contextmanager
def no_input() -> Iterator[None]:
    """Let plugins that read the standard input find its end; `own_input` still returns it."""
    if _inputs:
        yield
        return
    given = sys.stdin
    own, nothing = _copied(0), os.open(os.devnull, os.O_RDONLY)
    if nothing:
        os.dup2(nothing, 0)
    if given is None:  # closed by who calls (`<&-`)
        _inputs.append(io.BytesIO())
    elif own is not None and _is_file(given, 0):
        _inputs.append(os.fdopen(own, "rb", closefd=False))
    else:
        _inputs.append(_bytes_from(given))
    try:
        with open(os.devnull, encoding="utf-8") as sys.stdin:  # noqa: PTH123 (a name of the system, no path)
            yield
    finally:
        _inputs.pop()
        sys.stdin = given
        if own is not None:
            os.dup2(own, 0)
            os.close(own)
        if nothing:
            os.close(nothing)


def own_input() -> BinaryIO:
    """Return the standard input for the command itself: empty where it is closed."""
    if _inputs:
        return _inputs[-1]
    return io.BytesIO() if sys.stdin is None else _bytes_from(sys.stdin)


@contextmanager
def _errors() -> Iterator[IO[str] | None]:
    """Yield a text stream to standard error that a plugin may close."""
    if sys.stderr is None or not _is_file(sys.stderr, 2):
        yield sys.stderr
        return
    stream = os.fdopen(os.dup(2), "w", buffering=1, encoding=sys.stderr.encoding, errors="backslashreplace")
    try:
        yield stream
    finally:
        with suppress(OSError, ValueError):
            stream.close()


class _TextAlone(io.RawIOBase):
    """Takes bytes for a text stream that has none below it, such as the output of a notebook."""

    def __init__(self, text: IO[str]) -> None:
        self._text = text

    def writable(self) -> bool:
        return True

    def write(self, data: Buffer) -> int:
        self._text.write(str(data, "utf-8", "replace"))
        return memoryview(data).nbytes

    def flush(self) -> None:
        if not self.closed:
            self._text.flush()


def _bytes_to(stream: IO[str]) -> BinaryIO:
    return cast(BinaryIO, getattr(stream, "buffer", None) or _TextAlone(stream))


def _bytes_from(stream: IO[str]) -> BinaryIO:
    return cast(BinaryIO, getattr(stream, "buffer", None) or io.BytesIO(stream.read().encode()))


def _copied(descriptor: int) -> int | None:
    try:
        return os.dup(descriptor)
    except OSError:  # it is closed
        return None


def _is_file(stream: IO[str], descriptor: int) -> bool:
    with suppress(OSError, ValueError, AttributeError):
        return stream.fileno() == descriptor
    return False
