"""The last state of each warehouse, so that a change of it is enough to have the next."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rmfs_commands.states.patches import patched
from rmfs_commands.states.rebuilding import OpenState, open_state
from rmfs_commands.states.state_json import state_after, state_from_dict
from rmfs_core.errors import InputError
from rmfs_core.scenario.source import Source

MOST_KEPT = 16
"""Warehouses whose states are kept; of more, those that were asked of last."""


class StaleError(InputError):
    """A change starts from a state that is not the last one kept."""


class Warehouses:
    """States by the names of their warehouses, as JSON's objects."""

    def __init__(self) -> None:
        self._kept: dict[str, tuple[str, Mapping[str, Any], OpenState | None]] = {}

    def __contains__(self, name: str) -> bool:
        """Whether a state of a warehouse is kept."""
        return name in self._kept

    def keep(self, name: str, revision: str, state: Mapping[str, Any], opened: OpenState | None = None) -> None:
        """Take down the last state of a warehouse; the one that was not used for longest may be forgotten for it."""
        self._kept.pop(name, None)
        self._kept[name] = revision, state, opened
        if len(self._kept) > MOST_KEPT:
            del self._kept[next(iter(self._kept))]

    def opened(self, name: str, state: Mapping[str, Any]) -> OpenState:
        """Return the warehouse of a state, of which only what changed since the last state is read.

        Raises
        ------
        InputError
            As `state_from_dict` and `open_state`.
        """
        _, last, before = self._kept.get(name, ("", {}, None))
        if before is None:
            return open_state(state_from_dict(state))
        return open_state(state_after(state, last, before.state), before=before)

    def changed(self, name: str, base: str, change: Mapping[str, Any], revision: str) -> Mapping[str, Any]:
        """Return the state of a warehouse with a change applied, which is not kept yet.

        Parameters
        ----------
        name
            Of the warehouse.
        base
            Revision of the state that the change starts from.
        change
            A JSON merge patch.
        revision
            Of the state that it leads to. Where that is the last one kept, the same request has come again.

        Raises
        ------
        StaleError
            When the last state is another one, or none is kept.
        InputError
            When the change has a null that a merge patch cannot mean.
        """
        if name not in self._kept:
            raise StaleError("request, warehouse", f'no state of "{name}" is kept; expected the whole state first')
        last, state, _ = self._kept[name]
        if revision == last:
            return state
        if base != last:
            problem = f'found "{base}"; the last state is "{last}"; expected a change of that, or the whole state'
            raise StaleError("request, base", problem)
        _check_nulls(state, change)
        return patched(state, change)


def _check_nulls(state: Mapping[str, Any], change: Mapping[str, Any]) -> None:
    """Refuse nulls for SKUs that a pod does not have: in a whole state they would say that they never run out."""
    held, told = _table(state.get("pods")), _table(change.get("pods"))
    for pod, given in told.items():
        before = _table(_table(held.get(pod)).get("contents"))
        for sku, number in _table(_table(given).get("contents")).items():
            if number is None and sku not in before:
                place = Source("change").place_of(("pods", pod, "contents", sku))
                problem = "null removes a SKU, and the pod has none of it; only a whole state can make stock endless"
                raise InputError(place, problem)


def _table(value: object) -> Mapping[str, Any]:
    return value if isinstance(value, Mapping) else {}
