"""XML as a stream, from files that nobody vouches for.

The parser is expat, of the standard library. A file that declares a document type is refused: without one there are no
entities to be expanded, from the file itself or from elsewhere. Elements are handed on as they end and forgotten, so
that a file of a gigabyte takes no more memory than its largest record.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from xml.parsers import expat

from attrs import define, field

from rmfs_core.errors import InputError
from rmfs_core.wording import shown_short

MOST_BYTES, MOST_IN_ONE, MOST_NESTED, MOST_AT_ONCE = 2_000_000_000, 1_000_000, 30, 10_000_000
"""Bytes of a file; elements and signs of a record; elements in one another; bytes between two ends of tags."""
_CHUNK = 1 << 16
_WHOLE = re.compile(r"[+-]?[0-9]{1,12}")


@define
class Element:
    """An element: its values are attributes, or elements in it that hold text alone.

    Parameters
    ----------
    name, file, line
        Its name, and its first line.
    above
        Names of the elements around it, the outermost first.
    """

    name: str
    file: str
    line: int
    above: tuple[str, ...]
    attributes: dict[str, str] = field(factory=dict)
    inside: list[Element] = field(factory=list)
    text: str = ""

    @property
    def place(self) -> str:
        """Where it stands, for a message."""
        return f"{self.file}, line {self.line}"

    def part(self, name: str) -> Element | None:
        """Return the first element of a name in it."""
        return next((inner for inner in self.inside if inner.name == name), None)

    def value(self, name: str) -> str | None:
        """Return a value as text, None when it is not there or empty."""
        if (text := self.attributes.get(name)) is None and (inner := self.part(name)) is not None:
            text = inner.text
        return (text or "").strip() or None

    def number(self, name: str, default: float | None = None, least: float = -1e9, most: float = 1e9) -> float:
        """Return a value as a number; without a default, it has to be there."""
        text = self.value(name)
        if text is None and default is not None:
            return default
        try:
            number = float(text or "")
        except ValueError:
            number = math.nan
        if least <= number <= most:
            return number
        raise self.wrong(name, f"a number from {least:g} to {most:g}", text)

    def whole(self, name: str, default: int | None = None, least: int = 0, most: int = 1_000_000_000) -> int:
        """Return a value as a whole number; without a default, it has to be there."""
        text = self.value(name)
        if text is None and default is not None:
            return default
        if text is not None and _WHOLE.fullmatch(text) and least <= int(text) <= most:
            return int(text)
        raise self.wrong(name, f"a whole number from {least:,} to {most:,}", text)

    def truth(self, name: str, default: bool) -> bool:
        """Return a value that is true or false."""
        text = (self.value(name) or str(default)).lower()
        if text not in ("true", "false", "1", "0"):
            raise self.wrong(name, "true or false", text)
        return text in ("true", "1")

    def wrong(self, name: str, expected: str, text: str | None) -> InputError:
        """Return the error of a value."""
        inner = None if name in self.attributes else self.part(name)
        found = "nothing" if text is None else shown_short(text)
        return InputError((inner or self).place, f"expected {expected} as `{name}` of {self.name}, found {found}")


def document(path: Path) -> Element:
    """Return a whole file as its outermost element."""
    return next(elements(path, 0))


def elements(path: Path, depth: int) -> Iterator[Element]:
    """Yield the elements that have ``depth`` others around them, each when it ends.

    Raises
    ------
    InputError
        When the file cannot be read, is no XML, declares a document type, or goes beyond what is read.
    """
    reader = _Reader(str(path), depth)
    try:
        with path.open("rb") as stream:
            read = 0
            while chunk := stream.read(_CHUNK):
                read += len(chunk)
                if read > MOST_BYTES:
                    raise InputError(str(path), f"found more than {MOST_BYTES:,} bytes; expected at most that many")
                reader.parse(chunk)
                yield from reader.taken()
            reader.parse(b"", last=True)
            yield from reader.taken()
    except OSError as error:
        raise InputError(str(path), f"cannot be read: {error.strerror or error}") from error


def root_name(head: bytes) -> str | None:
    """Return the name of the outermost element of a file that begins so, None when it is no XML."""
    names: list[str] = []
    parser = expat.ParserCreate()
    parser.StartElementHandler = lambda name, _: names.append(name)
    with suppress(expat.ExpatError, ValueError, LookupError):
        parser.Parse(head)
    return names[0] if names else None


class _Reader:
    def __init__(self, file: str, depth: int) -> None:
        self.file, self.depth = file, depth
        self.open: list[Element] = []
        self.ended: list[Element] = []
        self.size = self.since = 0
        self.parser = expat.ParserCreate()
        self.parser.buffer_text = True
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.CharacterDataHandler = self._text
        self.parser.StartDoctypeDeclHandler = self._doctype

    def parse(self, chunk: bytes, *, last: bool = False) -> None:
        self.since += len(chunk)
        if self.since > MOST_AT_ONCE:
            raise self._wrong(f"found more than {MOST_AT_ONCE:,} bytes without an element; expected fewer")
        try:
            self.parser.Parse(chunk, last)
        except expat.ExpatError as error:
            reason = expat.ErrorString(error.code)
            raise InputError(f"{self.file}, line {error.lineno}", f"this is no valid XML: {reason}") from None
        except (ValueError, LookupError) as error:  # of an encoding that Python does not have
            raise InputError(self.file, f"this is no valid XML: {error}") from None

    def taken(self) -> list[Element]:
        ended, self.ended = self.ended, []
        return ended

    def _wrong(self, problem: str) -> InputError:
        return InputError(f"{self.file}, line {self.parser.CurrentLineNumber}", problem)

    def _grow(self, size: int) -> None:
        self.size += size
        if self.size > MOST_IN_ONE:
            raise self._wrong(f"found more than {MOST_IN_ONE:,} elements and signs in one element; expected fewer")

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        if len(self.open) >= MOST_NESTED:
            raise self._wrong(f"found more than {MOST_NESTED} elements in one another; expected fewer")
        self._grow(1)
        self.since = 0
        above = tuple(element.name for element in self.open)
        self.open.append(Element(name, self.file, self.parser.CurrentLineNumber, above, attributes))

    def _end(self, _: str) -> None:
        self.since = 0
        element = self.open.pop()
        level = len(self.open)
        if level == self.depth:
            self.ended.append(element)
        if level > self.depth:
            self.open[-1].inside.append(element)
        else:
            self.size = 0

    def _text(self, text: str) -> None:
        if text.strip():
            self._grow(len(text))
            self.open[-1].text += text

    def _doctype(self, *_: object) -> None:
        raise self._wrong("found a document type (DOCTYPE); expected none, since files of RAWSim-O have none")
