"""A trace as plain data that can be corrupted, and what registers kinds of corruption."""

from __future__ import annotations

import copy
import gzip
import json
from collections.abc import Callable, Iterator
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

    def drop(self, kind: str, where: Where = lambda _: True, at: float = 0.5) -> None:
        del self.events[self.place(kind, where, at)]

    def twice(self, kind: str, where: Where = lambda _: True) -> None:
        i = self.place(kind, where)
        self.events.insert(i, dict(self.events[i]))

    def move(self, i: int, to: int) -> None:
        line = self.events.pop(i)
        to -= to > i
        line["tick"] = self.events[min(to, len(self.events) - 1)]["tick"]
        self.events.insert(to, line)

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
                right, down = STEPS[line["heading"]]
                step = right + down * self.width
                found.update(line["origin"] + step * i for i in range(line["distance_m"] + 1))
        return found

    def free_locations(self) -> list[int]:
        taken = {*self.header["blocked"], *(pod["cell"] for pod in self.header["pods"])}
        stored = {line["cell"] for line in self.events if line["e"] == "pod_stored"}
        return [cell for cell in self.cells("2") if cell not in taken | stored | self.visited()]

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


def made(name: str, corruption: Callable[[Raw], object]) -> None:
    KINDS[name] = corruption


def next_of(found: Iterator[Any] | list[Any]) -> Any:
    for one in found:
        return one
    raise NotThereError


def changed(name: str, event: str, by: Callable[[Line], Line], where: Where = lambda _: True, at: float = 0.5) -> None:
    def corruption(raw: Raw) -> None:
        line = raw.one(event, where, at)
        line.update(by(line))

    KINDS[name] = corruption


def dropped(name: str, event: str, where: Where = lambda _: True, at: float = 0.5) -> None:
    KINDS[name] = lambda raw: raw.drop(event, where, at)


def doubled(name: str, event: str, where: Where = lambda _: True) -> None:
    KINDS[name] = lambda raw: raw.twice(event, where)


def scenario_says(name: str, section: str, key: str, by: Callable[[Any], Any], given: bool = True) -> None:
    """Register the corruption that changes a key of the scenario in the header."""

    def corruption(raw: Raw) -> None:
        table = raw.scenario.get(section, {}) if section else raw.scenario
        if given and key not in table:
            raise NotThereError(key)
        table[key] = by(table.get(key))

    KINDS[name] = corruption
