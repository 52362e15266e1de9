"""Which format files have: what they begin with says it."""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Mapping, Sequence
from pathlib import Path

from rmfs_commands.import_.xml_reading import MOST_NESTED, elements, root_name
from rmfs_core.errors import InputError
from rmfs_core.wording import listed

FORMATS = {"rawsim-o": "RAWSim-O", "rhcr": "RHCR", "lorr": "the League of Robot Runners", "movingai": "MovingAI"}
RAWSIMO = (
    "Instance",
    "LayoutConfiguration",
    "SettingConfiguration",
    "OrderList",
    "SimpleItemGeneratorConfiguration",
    "ControlConfiguration",
)
"""Outermost elements of RAWSim-O's files."""
_HEAD = 1 << 16


def kind_of(path: Path) -> str:
    """Return what a file is: an outermost element of RAWSim-O, ``kiva``, ``grid``, ``problem``, ``octile``, ``scen``.

    Raises
    ------
    InputError
        When it cannot be read, or is none of these.
    """
    try:
        with path.open("rb") as stream:
            head = stream.read(_HEAD)
    except (OSError, ValueError) as error:  # ValueError: of a name that no file can have
        raise InputError(str(path), f"cannot be read: {getattr(error, 'strerror', error)}") from None
    if (name := root_name(head)) in RAWSIMO:
        return str(name)
    text = head.decode("utf-8-sig", errors="replace").lstrip()
    for kind, begins in (
        ("problem", r"\{"),
        ("octile", r"type\b"),
        ("scen", r"version\b"),
        ("grid", r"(?i:grid size)"),
        ("kiva", r"[0-9]+\s*,\s*[0-9]+\s*\n"),
    ):
        if re.match(begins, text):
            return kind
    if name is None and text.startswith("<"):
        deque(elements(path, MOST_NESTED), maxlen=0)  # which say what is wrong with it
    expected = "RAWSim-O's .xinst, .xlayo, .xsett, .xitem or .xgenc, a .map, .grid or .scen, or a problem in JSON"
    found = f"an XML file of {name}" if name else "none of these"
    raise InputError(str(path), f"expected {expected}; found {found}")


def sorted_out(paths: Sequence[Path], asked: str | None) -> tuple[str, Mapping[str, Path]]:
    """Return the format of files, and each of them by what it is.

    Parameters
    ----------
    paths
        The files.
    asked
        The format that they shall have, or None: the one that they look like. A map that both MovingAI and the League
        of Robot Runners could have is MovingAI's, unless it has emitters (``E``).
    """
    found: dict[str, Path] = {}
    for path in paths:
        kind = kind_of(path)
        if kind in found:
            raise InputError(str(path), f"found {found[kind]}, too, which is of the same kind; expected one of them")
        found[kind] = path
    fitting = [name for name in FORMATS if _fits(name, found)]
    if asked is not None and asked not in fitting:
        fits = f"; they look like {listed((FORMATS[name] for name in fitting), 'or')}" if fitting else ""
        raise InputError("--format", f"found files that {FORMATS[asked]} does not have together{fits}")
    if not fitting:
        kinds = listed(sorted(path.name for path in paths))
        raise InputError(kinds, "found files of different formats, or one missing; expected those of one instance")
    if asked is None and fitting == ["lorr", "movingai"]:
        asked = "lorr" if _has_emitters(found["octile"]) else "movingai"
    return asked or fitting[0], found


def _fits(name: str, found: Mapping[str, Path]) -> bool:
    kinds = set(found)
    match name:
        case "rawsim-o":
            return kinds <= set(RAWSIMO)
        case "rhcr":
            return kinds in ({"kiva"}, {"grid"})
        case "lorr":
            return kinds in ({"problem"}, {"octile"})
        case _:
            return kinds in ({"octile"}, {"octile", "scen"})


def _has_emitters(path: Path) -> bool:
    with path.open("rb") as stream:
        return any(b"E" in line for number, line in enumerate(stream) if 4 <= number < 2_000)
