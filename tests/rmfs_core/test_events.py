"""Events: what observers, traces and other programs rely on."""

from __future__ import annotations

from typing import get_type_hints

import attrs
import pytest

from rmfs_core import events
from rmfs_core.events import Event, ItemPicked, OrderCompleted, PodLifted

KINDS = [kind for kind in vars(events).values() if isinstance(kind, type) and issubclass(kind, Event)]


def test_an_event_tells_its_time_in_seconds_too() -> None:
    """The tick is what is counted with, seconds are for people."""
    assert OrderCompleted(tick=12_345, order=0).time_s == 12.345


def test_nothing_changes_an_event() -> None:
    """The same object goes to every observer."""
    event = OrderCompleted(tick=1, order=0)
    with pytest.raises(attrs.exceptions.FrozenInstanceError):
        event.order = 1  # type: ignore[misc]
    assert event == OrderCompleted(tick=1, order=0)
    assert event != OrderCompleted(tick=1, order=1)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_every_event_holds_plain_values(kind: type[Event]) -> None:
    """Ids, times, texts and tuples of ids: an event can be kept, written and compared after the run."""
    plain = (int, int | None, str, bool, float, float | None, tuple[int, ...])
    assert attrs.fields(kind)[0].name == "tick"
    for name, type_ in get_type_hints(kind).items():
        assert type_ in plain, f"{kind.__name__}.{name}"


def test_what_took_time_tells_when_it_began() -> None:
    """The start comes right after the end, in every event that has both."""
    with_start = [kind for kind in KINDS if "start_tick" in attrs.fields_dict(kind)]
    assert {ItemPicked, PodLifted} <= set(with_start)
    assert all(attrs.fields(kind)[1].name == "start_tick" for kind in with_start)
