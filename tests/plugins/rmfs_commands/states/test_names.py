"""The names in a state and the ids they stand for."""

from __future__ import annotations

from typing import Any

import pytest

from rmfs_commands.states.names import Names
from rmfs_commands.states.state_json import state_from_dict
from rmfs_core.errors import InputError


def names(content: dict[str, Any]) -> Names:
    """Return the names of a state."""
    return Names(state_from_dict(content, "state.json"), "state.json")


def test_ids_are_places_in_the_lists(by_hand: dict[str, Any]) -> None:
    """SKUs as pods and then orders name them first, unless the state lists them."""
    found = names(by_hand)
    assert (found.pods, found.stations) == ({"P1": 0, "P2": 1}, {"north": 0})
    assert found.skus == {"milk": 0, "tea": 1, "jam": 2}
    assert names(by_hand | {"skus": ["jam", "tea", "milk", "rye"]}).skus == {"jam": 0, "tea": 1, "milk": 2, "rye": 3}


def test_orders_are_numbered_by_arrival(by_hand: dict[str, Any]) -> None:
    """Those of the same time as they are listed."""
    orders = {"A": by_hand["orders"]["A"] | {"arrival_s": 9}, "B": by_hand["orders"]["B"], "C": {"lines": {"tea": 1}}}
    assert names(by_hand | {"orders": orders}).orders == {"B": 0, "C": 1, "A": 2}


def test_names_that_are_not_listed_are_refused(by_hand: dict[str, Any]) -> None:
    """With the place, the kind and the nearest name."""
    found = names(by_hand)
    assert (found.pod("P2"), found.station("north"), found.order("B"), found.sku("jam")) == (1, 0, 1, 2)
    with pytest.raises(InputError) as caught:
        found.sku("mlk", "orders", "A", "lines", "mlk")
    assert "state.json" in str(caught.value)
    assert 'names SKU "mlk", which the state does not list (did you mean `milk`?)' in str(caught.value)
    for find, kind in ((found.pod, "pod"), (found.station, "station"), (found.order, "order")):
        with pytest.raises(InputError, match=f'names {kind} "nobody", which the state does not list'):
            find("nobody", "waiting", 0)


def test_skus_listed_twice_are_refused(by_hand: dict[str, Any]) -> None:
    """Each has one id."""
    with pytest.raises(InputError, match="skus: found a name twice; expected each once"):
        names(by_hand | {"skus": ["milk", "tea", "jam", "tea"]})


def test_paths_have_names_instead_of_ids(at_work: dict[str, Any]) -> None:
    """For messages about a warehouse made of a state."""
    found = names(at_work)
    assert found.path(("pods", 1, "cell")) == ("pods", "P2", "cell")
    assert found.path(("robots", 0)) == ("robots", "r1")
    assert found.path(("waiting",)) == ("waiting",)
