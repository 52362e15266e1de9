"""Decisions that rules return. Plain frozen values; the kernel checks each before it applies it."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import starmap
from typing import Any

import numpy as np
from attrs import field, frozen, validators
from numpy.typing import NDArray

Rows = NDArray[np.int64]


def _as_tuple(values: Iterable[Any]) -> tuple[Any, ...]:
    """Accept any sequence; what is none is found and named by the kernel's checks."""
    return tuple(values) if isinstance(values, (list, tuple, Iterable)) else (values,)


def _as_ends(values: Any) -> Any:
    """Accept an array of ends and waits as it is."""
    ends = isinstance(values, np.ndarray) and values.shape[1:] == (2,) and values.dtype == np.int64
    return values if ends else _as_tuple(values)


def _a_number(_instance: object, attribute: Any, value: object) -> None:
    if not (value is None or isinstance(value, float) or (type(value) is int and abs(value) < 1 << 63)):
        raise TypeError(f"{attribute.name} is {value!r}; expected a number or None")


@frozen
class OrderAssignment:
    """POA: the open lines of an order, or some of them, are to be picked at a station.

    Parameters
    ----------
    order, station
        Their ids.
    skus
        Ids of the SKUs whose lines are assigned. None assigns every open line of the order.
    """

    order: int
    station: int
    skus: tuple[int, ...] | None = None


@frozen
class PodTrip:
    """PPS: a pod is to visit a station (ids)."""

    pod: int
    station: int


@frozen
class SolveReport:
    """How an optimising rule arrived at its decision.

    Parameters
    ----------
    status
        For example ``"optimal"``, ``"effort"`` when its budget of work was used up, ``"stopped"`` for other limits.
    objective, bound
        Objective value of the decision and the best proven bound, in the rule's own unit.
    stopped_early
        Whether a limit ended the solve before the proof.
    """

    status: str = field(validator=validators.instance_of(str))
    objective: float | None = field(default=None, validator=_a_number)
    bound: float | None = field(default=None, validator=_a_number)
    stopped_early: bool = field(default=False, validator=validators.instance_of(bool))


@frozen
class JointDecision:
    """POA and PPS decided together."""

    assignments: tuple[OrderAssignment, ...] = field(default=(), converter=_as_tuple)
    trips: tuple[PodTrip, ...] = field(default=(), converter=_as_tuple)
    report: SolveReport | None = None


@frozen
class BundleAssignment:
    """ROA: a bundle is to be stored at a replenishment station (ids)."""

    bundle: int
    station: int


@frozen
class StoreBundle:
    """RPS: a bundle is to be stored on a pod (ids), which visits the bundle's station for it."""

    bundle: int
    pod: int


@frozen
class BundleDecision:
    """ROA and RPS decided together."""

    assignments: tuple[BundleAssignment, ...] = field(default=(), converter=_as_tuple)
    stores: tuple[StoreBundle, ...] = field(default=(), converter=_as_tuple)
    report: SolveReport | None = None


@frozen
class TaskAssignment:
    """TA: an idle robot is to fetch a waiting pod (ids) and carry it along all stations it is bound for."""

    robot: int
    pod: int


@frozen
class RobotMove:
    """A robot without a task is to drive to a cell, without a pod, and rest there (ids).

    Parameters
    ----------
    robot, cell
        Which robot, and where it goes: one of ``warehouse.free_rest_cells``.
    charge
        At a charger: it takes no task until its battery is so full, a share up to 1. None: full enough for one.
    """

    robot: int
    cell: int
    charge: float | None = field(default=None, validator=_a_number)


@frozen
class PodMove:
    """A stored pod is to be carried to a free storage location (a cell) by an idle robot, without a visit (ids)."""

    pod: int
    cell: int


@frozen
class Leg:
    """One straight run of a path: wait, turn on the spot towards ``to``, drive there and stop.

    Parameters
    ----------
    to
        Cell index the run ends at; the robot's own cell for a leg that only waits.
    wait_ticks
        Ticks to stand still before the turn.
    """

    to: int
    wait_ticks: int = 0


def _legs_of(given: Any) -> tuple[Leg, ...]:
    """Return the legs of a path, however they were given."""
    return given if isinstance(given, tuple) else tuple(starmap(Leg, given.tolist()))


@frozen(repr=False)
class Path:
    """PP: the legs a robot drives, at least one. A path may end before the goal: PP is asked again there.

    Parameters
    ----------
    legs
        The legs; or end and wait of each as an array of int64, shape (legs, 2), which is not changed any more.
    """

    given: Any = field(default=(), converter=_as_ends, alias="legs", eq=_legs_of)

    @property
    def legs(self) -> tuple[Leg, ...]:
        """The legs."""
        return _legs_of(self.given)

    def __repr__(self) -> str:
        return f"Path(legs={self.legs!r})"


def ends_of(legs: Iterable[Leg]) -> Rows:
    """Return cell and wait of each leg. Shape (legs, 2)."""
    flat: list[int] = []
    for leg in legs:
        flat += leg.to, leg.wait_ticks
    return np.array(flat, np.int64).reshape(-1, 2)
