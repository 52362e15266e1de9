"""The names in a state and the ids they stand for: positions in the state's lists, orders by their arrival."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NoReturn

from rmfs_commands.states.state import State
from rmfs_core.errors import InputError
from rmfs_core.scenario.source import KeyPath, Source
from rmfs_core.wording import did_you_mean


class Names:
    """Finds ids by name, and says where a state goes wrong.

    Parameters
    ----------
    state
        The state.
    source
        Name of the source in messages.
    """

    def __init__(self, state: State, source: str) -> None:
        self.source = source
        arrivals = sorted(state.orders, key=lambda order: state.orders[order].arrival_s)
        skus = state.skus
        if skus is None:
            held = [sku for pod in state.pods.values() for sku in pod.contents]
            wanted = (sku for order in arrivals for sku in state.orders[order].lines)
            skus = tuple(dict.fromkeys([*held, *wanted, *(bundle.sku for bundle in state.bundles or ())]))
        self._state = state
        self.pods = _positions(state.pods)
        self.stations = _positions(state.stations)
        self.orders = {order: i for i, order in enumerate(arrivals)}
        self.skus = {sku: i for i, sku in enumerate(skus)}
        if len(self.skus) < len(skus):
            self.wrong(("skus",), "found a name twice; expected each once")

    @property
    def tells_robots(self) -> bool:
        """Whether the state lists its robots."""
        return self._state.robots is not None

    def wrong(self, path: KeyPath, problem: str) -> NoReturn:
        """Say what is wrong with the state, and where."""
        raise InputError(Source(self.source).place_of(path), problem)

    def path(self, by_ids: KeyPath) -> KeyPath:
        """Return the path of a key with the name that the state has for an order, pod, station or robot, not its id."""
        section, *rest = by_ids
        if rest and section not in ("bundles", "packing"):  # a list
            tables = {
                "orders": self.orders,
                "pods": self.pods,
                "stations": self.stations,
                "robots": self._state.robots or {},
            }
            rest[0] = list(tables[str(section)])[int(rest[0])]
        return (section, *rest)

    def pod(self, name: str, *path: str | int) -> int:
        """Return the id of a pod that is named at a path."""
        return self._id("pod", name, self.pods, path)

    def station(self, name: str, *path: str | int) -> int:
        """Return the id of a station that is named at a path."""
        return self._id("station", name, self.stations, path)

    def order(self, name: str, *path: str | int) -> int:
        """Return the id of an order that is named at a path."""
        return self._id("order", name, self.orders, path)

    def packing(self, name: str, *path: str | int) -> int:
        """Return the id of a packing station that is named at a path, by its number from 1."""
        number = 0 if self._state.packing is None else len(self._state.packing.stations)
        if name not in (known := [str(at + 1) for at in range(number)]):
            self.wrong(path, f'names packing station "{name}"; the state has {number}')
        return known.index(name)

    def sku(self, name: str, *path: str | int) -> int:
        """Return the id of a SKU that is named at a path."""
        return self._id("SKU", name, self.skus, path)

    def _id(self, kind: str, name: str, ids: Mapping[str, int], path: KeyPath) -> int:
        if name not in ids:
            self.wrong(path, f'names {kind} "{name}", which the state does not list{did_you_mean(name, ids)}')
        return ids[name]


def _positions(table: Mapping[str, object]) -> dict[str, int]:
    return {name: i for i, name in enumerate(table)}
