"""Where a scenario's values came from, to say where a wrong one stands."""

from __future__ import annotations

from attrs import frozen

from rmfs_core.entrypoints import format_module

KeyPath = tuple[str | int, ...]


@frozen
class Source:
    """A scenario file as it was read.

    Parameters
    ----------
    name
        The file as the user named it.
    text
        Its text.
    overrides
        Text and keys of each ``--set``.
    """

    name: str
    text: str = ""
    overrides: tuple[tuple[str, tuple[str, ...]], ...] = ()

    def place_of(self, path: KeyPath) -> str:
        """Return the place of a key for a message: the ``--set`` that gave it, or else file, line and key."""
        if not path:
            return self.name
        for text, keys in reversed(self.overrides):
            if keys == path:
                return f"--set {text}"
            # Around the value, or within the table that is wrong as a whole: naming the key as well makes it clear.
            if keys == path[: len(keys)] or path == keys[: len(path)]:
                return f"--set {text}, {dotted(path)}"
        line = format_module("toml").line_of(self.text, path)
        return ", ".join([self.name, *([f"line {line}"] if line else []), dotted(path)])


def dotted(path: KeyPath) -> str:
    """Return keys as one text: ``rules.filters[0]``."""
    text = ""
    for part in path:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else part
    return text


def undotted(text: str) -> KeyPath:
    """Return the keys that `dotted` joined."""
    parts: list[str | int] = []
    for piece in text.split("."):
        name, *positions = piece.split("[")
        parts += [name, *(int(p.rstrip("]")) if p.rstrip("]").isdecimal() else p for p in positions)]
    return tuple(parts)
