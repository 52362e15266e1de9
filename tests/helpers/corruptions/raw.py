"""A trace as plain data that can be corrupted, and what registers kinds of corruption."""

from __future__ import annotations

import copy
import gzip
import json
from collections.abc import Callable, Iterable
from itertools import combinations
from pathlib import Path
from typing import Any

from attrs import define

Line = dict[str, Any]
Where = Callable[[Line], bool]
STEPS = ((1, 0), (0, -1), (-1, 0), (0, 1))


class NotThereError(Exception):
    """A trace has nothing that could be corrupted so."""


@define(eq=False)
class Raw:
    """Lines of a trace file: the first line, those of events, the last one."""

    header: Line
    events: list[Line]
    end: Line

    @classmethod
    def read(cls, file: Path) -> Raw:
        with gzip.open(file, "rt", encoding="utf-8") as stream:
            header, *events, end = map(json.loads, stream)
        return cls(header, events, end)

    def write(self, file: Path) -> None:
        with gzip.open(file, "wt", encoding="utf-8", compresslevel=1) as stream:
            stream.writelines(json.dumps(line) + "\n" for line in (self.header, *self.events, self.end))

    def copy(self) -> Raw:
        return copy.deepcopy(self)

    # What is where

    def places(self, kind: str, where: Where = lambda _: True) -> list[int]:
        found = [i for i, line in enumerate(self.events) if line["e"] == kind and where(line)]
        if not found:
            raise NotThereError(kind)
        return found

    def place(self, kind: str, where: Where = lambda _: True, at: float = 0.5) -> int:
        found = self.places(kind, where)
        return found[min(int(at * len(found)), len(found) - 1)]

    def one(self, kind: str, where: Where = lambda _: True, at: float = 0.5) -> Line:
        return self.events[self.place(kind, where, at)]

    def move(self, i: int, to: int) -> None:
        line = self.events.pop(i)
        to -= to > i
        line["tick"] = self.events[min(to, len(self.events) - 1)]["tick"]
        self.events.insert(to, line)

    def alike(self, i: int, key: str) -> Where:
        return lambda line: bool(line[key] == self.events[i][key])

    def following(self, i: int, kind: str, where: Where = lambda _: True) -> int:
        return next_of(j for j in self.places(kind, where) if j > i)

    def preceding(self, i: int, kind: str, where: Where = lambda _: True) -> int:
        return next_of(j for j in reversed(self.places(kind, where)) if j < i)

    @property
    def scenario(self) -> Line:
        found: Line = self.header["scenario"]
        return found

    # Cells

    @property
    def width(self) -> int:
        return int(self.header["layout"]["width"])

    def cells(self, sign: str) -> list[int]:
        text = "".join(self.header["layout"]["kind"])
        return [cell for cell, found in enumerate(text) if found == sign]

    def visited(self) -> set[int]:
        found = {robot["cell"] for robot in self.header["robots"]}
        for line in self.events:
            if line["e"] == "robot_moved":
                step = self.step(line["heading"])
                found.update(line["origin"] + step * i for i in range(line["distance_m"] + 1))
        return found

    def step(self, heading: int) -> int:
        right, down = STEPS[heading]
        return right + down * self.width

    @property
    def free_location(self) -> int:
        taken = {*self.header["blocked"], *(pod["cell"] for pod in self.header["pods"])}
        taken |= {line["cell"] for line in self.events if line["e"] == "pod_stored"} | self.visited()
        return int(next_of(cell for cell in self.cells("2") if cell not in taken))

    def set_sign(self, grid: str, cell: int, sign: str) -> None:
        rows = self.header["layout"][grid]
        row, column = divmod(cell, self.width)
        rows[row] = rows[row][:column] + sign + rows[row][column + 1 :]

    def moves(self, cell: int) -> int:
        row, column = divmod(cell, self.width)
        return int(self.header["layout"]["moves"][row][column], 16)


Corruption = Callable[[Raw], object]
KINDS: dict[str, Corruption] = {}


def kind(corruption: Corruption) -> Corruption:
    KINDS[corruption.__name__.replace("_", " ")] = corruption
    return corruption


def made(name: str, corruption: Corruption) -> None:
    KINDS[name] = corruption


def next_of(found: Iterable[Any]) -> Any:
    for one in found:
        return one
    raise NotThereError


def some(found: Any) -> Any:
    """Return a list, table or number that is there and not empty."""
    if not found:
        raise NotThereError
    return found


def add(table: Line, **numbers: float) -> None:
    for key, number in numbers.items():
        table[key] += number


def changed(name: str, event: str, by: Callable[[Line], Line], where: Where = lambda _: True, at: float = 0.5) -> None:
    def corruption(raw: Raw) -> None:
        line = raw.one(event, where, at)
        line.update(by(line))

    KINDS[name] = corruption


def shifted(event: str, by: int, where: Where = lambda _: True, at: float = 0.5, **names: str) -> None:
    """Register for fields of an event, each with a name, the corruption that adds to it."""
    for key, name in names.items():
        changed(name, event, lambda line, key=key: {key: line[key] + by}, where, at)  # type: ignore[misc]


def others(event: str, at: float = 0.5, **names: str) -> None:
    """Register for ids in an event, each with a name, the corruption that puts a neighbouring id there."""
    for key, name in names.items():
        changed(name, event, lambda line, key=key: {key: line[key] ^ 1}, at=at)  # type: ignore[misc]


def dropped(name: str, event: str, where: Where = lambda _: True, at: float = 0.5) -> None:
    KINDS[name] = lambda raw: raw.events.pop(raw.place(event, where, at))


def doubled(name: str, event: str, where: Where = lambda _: True) -> None:
    def corruption(raw: Raw) -> None:
        i = raw.place(event, where)
        raw.events.insert(i, dict(raw.events[i]))

    KINDS[name] = corruption


def missaid(what: str, event: str) -> None:
    """Register what can be wrong with any event, such as ``a lift``: one or the last is dropped, one comes twice."""
    dropped(f"{what} dropped", event)
    dropped(f"the last {what.partition(' ')[2]} dropped", event, at=1.0)
    doubled(f"{what} twice", event)


def too_early(name: str, event: str, earlier: str, key: str | None = None) -> None:
    """Register the corruption that moves an event to before the last earlier one of a kind, of the same ``key``."""

    def corruption(raw: Raw) -> None:
        i = raw.place(event)
        raw.move(i, raw.preceding(i, earlier, raw.alike(i, key) if key else lambda _: True))

    KINDS[name] = corruption


def too_late(name: str, event: str, later: str, key: str) -> None:
    """Register the corruption that moves an event to after the next one of a kind, of the same ``key``."""

    def corruption(raw: Raw) -> None:
        i = raw.place(event)
        raw.move(i, raw.following(i, later, raw.alike(i, key)) + 1)

    KINDS[name] = corruption


def swapped(name: str, event: str, alike: tuple[str, ...], key: str) -> None:
    """Register the corruption that swaps a field of two events, the first that are alike in others."""

    def corruption(raw: Raw) -> None:
        pairs = combinations([raw.events[i] for i in raw.places(event)], 2)
        same = (pair for pair in pairs if all(pair[0][name] == pair[1][name] for name in alike))
        one, other = next_of(pair for pair in same if pair[0][key] != pair[1][key])
        one[key], other[key] = other[key], one[key]

    KINDS[name] = corruption


def scenario_says(name: str, section: str, key: str, by: Callable[[Any], Any], given: bool = True) -> None:
    """Register the corruption that changes a key of the scenario in the header."""

    def corruption(raw: Raw) -> None:
        table = raw.scenario.get(section, {}) if section else raw.scenario
        if given and key not in table:
            raise NotThereError(key)
        table[key] = by(table.get(key))

    KINDS[name] = corruption
