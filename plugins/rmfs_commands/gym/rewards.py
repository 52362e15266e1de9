"""Rewards: what an action has cost until the next choice."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from types import MappingProxyType

from attrs import frozen

from rmfs_core.clock import TICKS_PER_S
from rmfs_core.errors import InputError
from rmfs_core.events import Event, OrderArrived, OrderCancelled, OrderCompleted, RobotMoved, VisitStarted
from rmfs_core.warehouse import WarehouseView
from rmfs_core.wording import shown_short


@frozen(eq=False)
class Step:
    """Events between two choices; the first one of a run begins with the run.

    Parameters
    ----------
    events
        All events, in the order in which they happened.
    warehouse
        The warehouse now, at the end.
    since_tick
        When it began, in ticks of 1 ms; it ends at ``warehouse.now_tick``.
    orders_open
        Orders that have arrived and are not complete, at the end.
    """

    events: tuple[Event, ...]
    warehouse: WarehouseView
    since_tick: int
    orders_open: int


Reward = Callable[[Step], float]


def visits(step: Step) -> float:
    """Minus the pod-station visits that began; bundles are stored at the stations behind those that count."""
    picking = len(step.warehouse.stations)
    return -float(sum(isinstance(event, VisitStarted) and event.station < picking for event in step.events))


def turnover(step: Step) -> float:
    """Minus the hours that orders were open, added up over the orders: those of a whole run are its turn-over times and
    what orders waited that were cancelled."""
    ticks = step.orders_open * (step.warehouse.now_tick - step.since_tick)
    for event in step.events:
        if isinstance(event, OrderCompleted | OrderCancelled):
            ticks += event.tick - step.since_tick
        elif isinstance(event, OrderArrived):
            ticks -= event.tick - step.since_tick
    return -ticks / (3600 * TICKS_PER_S)


def distance(step: Step) -> float:
    """Minus the kilometres that robots drove."""
    return -sum(event.distance_m for event in step.events if isinstance(event, RobotMoved)) / 1000


REWARDS: Mapping[str, Reward] = MappingProxyType({"visits": visits, "turnover": turnover, "distance": distance})
"""The rewards that have a name."""


def weighted(weights: Mapping[str | Reward, float]) -> Reward:
    """Return the sum of rewards, each times its weight."""
    parts = [(weight, REWARDS[reward] if isinstance(reward, str) else reward) for reward, weight in weights.items()]
    return lambda step: sum(weight * rewarded(reward, step) for weight, reward in parts)


def rewarded(reward: Reward, step: Step) -> float:
    """Return what a reward gives for a step, as a number.

    Raises
    ------
    InputError
        When it returns anything else, or a number that is not finite.
    """
    given = reward(step)
    with suppress(TypeError, ValueError, OverflowError):
        if not isinstance(given, str) and math.isfinite(number := float(given)):
            return number
    raise InputError("reward", f"returned {shown_short(given)}; expected a number, and a finite one")
